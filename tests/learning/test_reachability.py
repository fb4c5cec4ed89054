"""Reachability behind its interface: encoded once, calibrated; and searched for its mistakes."""

import json
from dataclasses import asdict, replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from tests.conftest import make_box, make_trajectory
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Reachability
from tutorial_lib.learning import estimators, mining
from tutorial_lib.learning.calibration import Calibration, sigmoid
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.mining import OWN, HardNegativeMining, all_logits
from tutorial_lib.learning.networks import ENCODERS, Architecture, LocalNetwork
from tutorial_lib.learning.policies import encoded
from tutorial_lib.learning.views import VIEWS, CameraView
from tutorial_lib.learning.weights import Card, digest_of, load_card, load_network, save_network
from tutorial_lib.reading.checksums import with_checksum, without_checksum
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation
from tutorial_lib.world.visibility import mutual_overlap

torch.set_num_threads(1)  # so small are they here that two threads are slower
CLOSE = {"rel": 1e-4, "abs": 1e-5}
MEND = Calibration((-20.0, 0.0, 30.0), (-4.0, 0.5, 2.0))


def network_of(encoder="pair", k=1, view="camera16", seed=0):
    torch.manual_seed(seed)
    network = LocalNetwork(Architecture(k, encoder, view, "reachability")).eval()
    size = network.architecture.looks_at.size
    with torch.no_grad():
        network.heads.weight *= 300.0  # or else it would say nearly the same about all
        noise = 2.0 * torch.rand(16, *size) - 1.0
        network.heads.bias -= network(noise, noise[:, None].repeat(1, 2 * k + 1, 1, 1, 1)).mean()
    return network


def estimator_of(*arguments, calibration=None, **choices):
    return ReachabilityNetwork(network_of(*arguments, **choices), calibration)


def observed(recorded, view, frames):
    camera = Camera(rows=64 if view == "camera64" else 16)
    return Simulation(
        recorded.scene, recorded.poses[frames], sensors=Sensors(camera=camera, with_depth=True)
    ).observe()


def contexts_of(recorded, estimator, frames):
    poses = recorded.poses[recorded.context(frames, estimator.architecture.k)]
    return estimator.view.render(recorded.scene, poses)


FRAMES = np.array([0, 40, 80, 120, 160, 200])
SHOWN = FRAMES + 15


@pytest.fixture(scope="module")
def seen(recorded):
    return observed(recorded, "camera16", FRAMES)


def counted(estimator, monkeypatch):
    """How many pictures are encoded as current ones, and as targets, call by call."""
    counts = {"current": [], "targets": []}
    for half in counts:
        encode = getattr(estimator.network, f"encode_{half}")

        def noting(pictures, half=half, encode=encode):
            counts[half].append(len(pictures))
            return encode(pictures)

        monkeypatch.setattr(estimator.network, f"encode_{half}", noting)
    return counts


# Behind the seam.


def test_it_fits_its_seam_and_no_other_network_does():
    assert isinstance(estimator_of(), Reachability)
    with pytest.raises(InputError, match="predicts 'waypoint' where 'reachability' is needed"):
        ReachabilityNetwork(LocalNetwork(Architecture(1, "pair")))
    with pytest.raises(InputError, match="predicts 'reachability' where 'waypoint' is needed"):
        WaypointNetwork(network_of())


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("encoder", ENCODERS)
def test_logits_are_the_network_s_outputs_with_and_without_encoding(recorded, encoder, view):
    estimator = estimator_of(encoder, view=view)
    seen, contexts = observed(recorded, view, FRAMES), contexts_of(recorded, estimator, SHOWN)
    logits = estimator.logits(seen, estimator.prepare(contexts))
    with torch.inference_mode():
        numbers = estimator.view.numbers
        shown = estimator.view.render(recorded.scene, recorded.poses[FRAMES])
        wanted = estimator.network(numbers(shown), numbers(contexts)).numpy()
    assert logits.shape == (6,)
    assert logits.dtype == np.float64
    assert np.ptp(logits) > 0.01
    assert logits == pytest.approx(wanted[:, 0], **CLOSE)
    assert estimator.logits(seen, contexts) == pytest.approx(logits, **CLOSE)
    assert estimator.outputs_uncached(seen, contexts)[:, 0] == pytest.approx(logits, **CLOSE)


def test_probabilities_are_calibrated_logits(recorded, seen):
    estimator = estimator_of(calibration=MEND)
    prepared = estimator.prepare(contexts_of(recorded, estimator, SHOWN))
    probability, logits = estimator.probability(seen, prepared), estimator.logits(seen, prepared)
    assert probability == pytest.approx(MEND(logits))
    plain = estimator_of().probability(seen, contexts_of(recorded, estimator, SHOWN))
    assert plain == pytest.approx(sigmoid(logits), **CLOSE)
    assert np.abs(plain - probability).max() > 0.05


# Rows that repeat.

REPEATED = [
    [0, 0, 0, 1, 1, 2],
    [0, 1, 0, 1, 0, 0],
    [3],
    [4, 4],
    [5, 4, 3, 2, 1, 0],
    list(np.repeat(np.arange(6), 40)),  # more than are compared at once
]


@pytest.mark.parametrize("view", ["camera16", "laser"])
@pytest.mark.parametrize("rows", REPEATED, ids=lambda rows: f"{len(rows)} rows")
def test_rows_that_repeat_are_encoded_once_and_answered_alike(recorded, monkeypatch, rows, view):
    estimator, rows = estimator_of(view=view), np.array(rows)
    seen = observed(recorded, view, FRAMES)[rows]
    shown = SHOWN[np.random.default_rng(0).integers(6, size=len(rows))]
    contexts = contexts_of(recorded, estimator, shown)
    plainly = estimator.outputs_uncached(seen, contexts)
    counts = counted(estimator, monkeypatch)
    assert estimator.outputs(seen, contexts) == pytest.approx(plainly, **CLOSE)
    assert counts["current"] == [1 + np.count_nonzero(np.diff(rows))]


def test_nothing_to_ask_has_no_answer(recorded, seen):
    estimator = estimator_of()
    prepared = estimator.prepare(contexts_of(recorded, estimator, SHOWN))
    none = np.array([], dtype=int)
    assert estimator.probability(seen[none], prepared[none]).shape == (0,)


def test_what_was_encoded_can_be_compared_with_any_target(recorded, seen):
    estimator = estimator_of("matching", k=2)
    prepared = estimator.prepare(contexts_of(recorded, estimator, SHOWN))
    rows, columns = (pairs.ravel() for pairs in np.indices((6, 6)))
    table = estimator.compare(estimator.encode(seen)[rows], prepared[columns])[:, 0]
    for row, column, logit in zip(rows, columns, table, strict=True):
        assert estimator.logits(seen[row], prepared[column]) == pytest.approx(logit, **CLOSE)


def test_recorded_frames_are_encoded_once_each(recorded, monkeypatch):
    estimator, frames = estimator_of(k=2), np.array([90, 10, 90, 90, 55, 10])
    alone = estimator.prepare(contexts_of(recorded, estimator, frames)).encoded
    counts = counted(estimator, monkeypatch)
    assert encoded(estimator, recorded, frames).encoded.numpy() == pytest.approx(
        alone.numpy(), **CLOSE
    )
    assert counts["targets"] == [3 * 5]  # pictures


# Shipped with a calibration.


@pytest.fixture
def shipped(tmp_path, monkeypatch):
    """A network that is shipped in a folder of the test's, with its calibration."""
    network = network_of()
    card = Card("some", "train reachability --k 9", network.architecture)
    save_network(network, replace(card, calibration=asdict(MEND)), tmp_path)
    monkeypatch.setattr(estimators, "load_card", partial(load_card, folder=tmp_path))
    monkeypatch.setattr(estimators, "load_network", partial(load_network, folder=tmp_path))
    return tmp_path


def test_a_card_keeps_the_calibration_of_its_network(shipped, recorded, seen):
    kept = ReachabilityNetwork("some")
    contexts = contexts_of(recorded, kept, SHOWN)
    logits = kept.logits(seen, contexts)
    assert kept.probability(seen, contexts) == pytest.approx(MEND(logits))
    many = np.linspace(-50.0, 50.0, 100)
    assert kept.calibration(many).tolist() == MEND(many).tolist()
    other = ReachabilityNetwork("some", Calibration())
    assert other.probability(seen, contexts) == pytest.approx(sigmoid(logits))
    assert ReachabilityNetwork(kept.network).calibration == Calibration()


@pytest.mark.parametrize("wrong", [{"raw": [1, 0], "mended": [0, 1]}, {"raw": [0], "mended": [0]}])
def test_a_card_with_knots_that_do_not_rise_is_refused(shipped, wrong):
    card = shipped / "some.json"
    said = without_checksum(json.loads(card.read_text())) | {"calibration": wrong}
    card.write_text(json.dumps(with_checksum(said)))
    with pytest.raises(InputError, match="rising"):
        ReachabilityNetwork("some")


def test_weights_are_known_by_their_digest():
    assert digest_of(network_of()) == digest_of(network_of())
    other = network_of()
    with torch.no_grad():
        other.heads.bias += 1e-6
    assert digest_of(other) != digest_of(network_of())


# Searching for mistakes.


@pytest.mark.parametrize("view", ["camera16", "laser", "camera64"])
def test_asking_about_all_pairs_is_asking_pair_by_pair(recorded, monkeypatch, view):
    monkeypatch.setattr(mining, "_AT_ONCE", 16)
    estimator, rng = estimator_of("matching", k=2, view=view), np.random.default_rng(0)
    frames, targets = FRAMES[rng.integers(6, size=40)], SHOWN[rng.integers(6, size=40)]
    logits = all_logits(estimator, recorded, recorded.poses[frames], targets)
    assert logits.shape == (40,)
    for frame, target, logit in list(zip(frames, targets, logits, strict=True))[::4]:
        seen = observed(recorded, view, np.array([frame]))
        contexts = contexts_of(recorded, estimator, np.array([target]))
        assert estimator.outputs_uncached(seen, contexts)[0, 0] == pytest.approx(logit, **CLOSE)


def test_each_view_and_each_target_is_encoded_once_for_all_pairs(recorded, monkeypatch):
    estimator = estimator_of()
    counts = counted(estimator, monkeypatch)
    rows, columns = (pairs.ravel() for pairs in np.indices((6, 6)))
    all_logits(estimator, recorded, recorded.poses[FRAMES[rows]], SHOWN[columns])
    assert sum(counts["current"]) == 6
    assert sum(counts["targets"]) == 6 * (2 * estimator.architecture.k + 1)  # pictures


@pytest.fixture(scope="module")
def two_trajectories():
    lines = [(1.0, 1.0), (9.0, 1.0), (9.0, 9.0)], [(1.0, 9.0), (8.0, 9.0), (8.0, 2.0)]
    return RecordedWorld(Scene(make_box()), [make_trajectory(line) for line in lines])


@pytest.fixture
def oracle(monkeypatch):
    """Logits that depend on the distance of a pair alone; records its queries."""
    queries = []

    def logits(reachability, recorded, starts, targets):
        goals = recorded.poses[targets]
        queries.append((starts.copy(), targets.copy()))
        return 4.0 - np.hypot(*(starts - goals)[:, :2].T)

    monkeypatch.setattr(mining, "all_logits", logits)
    return SimpleNamespace(calibration=Calibration(), view=VIEWS["camera16"], queries=queries)


def probability_by_distance(recorded, pairs):
    gap = np.hypot(*(pairs.starts - recorded.poses[pairs.targets])[:, :2].T)
    return sigmoid(4.0 - gap)


def find(oracle, recorded, search, seed=0):
    paths = GridPaths(recorded.scene.clearance)
    return search.find(oracle, recorded, paths, np.random.default_rng(seed))


def frame_of(recorded, poses):
    return np.array([np.flatnonzero((recorded.poses == pose).all(axis=1))[0] for pose in poses])


def test_all_pairs_are_queried_but_those_close_on_one_trajectory(two_trajectories, oracle):
    _, queries = find(oracle, two_trajectories, HardNegativeMining(frames=30))
    ((starts, targets),) = oracle.queries
    frames = frame_of(two_trajectories, starts)
    anchors = np.unique(targets)
    assert len(anchors) == 30
    wanted = {
        (one, two)
        for one in anchors
        for two in anchors
        if two_trajectories.first[one] != two_trajectories.first[two]
        or abs(two_trajectories.arc[one] - two_trajectories.arc[two]) > OWN
    }
    assert set(zip(frames.tolist(), targets.tolist(), strict=True)) == wanted
    assert queries == len(wanted) == len(starts)


def test_what_the_network_is_sure_of_is_found_with_its_measures(two_trajectories, oracle):
    pairs, _ = find(
        oracle, two_trajectories, HardNegativeMining(frames=40, pairs=10**6, threshold=0.6)
    )
    probability = probability_by_distance(two_trajectories, pairs)
    assert probability.min() > 0.6
    ((starts, targets),) = oracle.queries
    gap = np.hypot(*(starts - two_trajectories.poses[targets])[:, :2].T)
    assert len(pairs) == (sigmoid(4.0 - gap) > 0.6).sum()  # all of them
    assert (np.diff(pairs.targets) >= 0).all()
    assert pairs.geodesic == pytest.approx(
        np.hypot(*(pairs.starts - two_trajectories.poses[pairs.targets])[:, :2].T),
        rel=0.05,
        abs=0.3,
    )


def test_overlaps_of_what_is_found_are_those_of_the_network_s_camera(two_trajectories, oracle):
    caster, found = two_trajectories.scene.caster, []
    for degrees in (90, 120):
        oracle.view = CameraView(degrees=degrees)
        pairs, _ = find(oracle, two_trajectories, HardNegativeMining(frames=20, pairs=10**6))
        goals, angle = two_trajectories.poses[pairs.targets], np.deg2rad(float(degrees))
        rows = pairs.starts, goals
        assert (pairs.overlap == mutual_overlap(caster, *rows, field_of_view=angle)).all()
        found.append(pairs.overlap.mean())
    assert found[0] != found[1]


def test_of_too_many_some_are_drawn(two_trajectories, oracle):
    pairs, _ = find(
        oracle, two_trajectories, HardNegativeMining(frames=60, pairs=40, far_occluded=3)
    )
    probability = probability_by_distance(two_trajectories, pairs)
    assert (~pairs.far_and_occluded).sum() == 40
    assert pairs.far_and_occluded.sum() <= 3
    assert probability.min() > 0.5
    frames = frame_of(two_trajectories, pairs.starts)
    distinct = set(zip(frames.tolist(), pairs.targets.tolist(), strict=True))
    assert len(distinct) == len(pairs)


def test_a_calibration_decides_what_the_network_is_sure_of(two_trajectories, oracle):
    oracle.calibration = Calibration((-1.0, 1.0), (-10.0, -9.0))  # never sure
    pairs, queries = find(oracle, two_trajectories, HardNegativeMining(frames=20))
    assert len(pairs) == 0
    assert queries > 100


def test_the_same_seed_finds_the_same_pairs(two_trajectories, oracle):
    search = HardNegativeMining(frames=30, pairs=20)
    found = [find(oracle, two_trajectories, search, seed)[0] for seed in (3, 3, 4)]
    assert np.array_equal(found[0].starts, found[1].starts)
    assert np.array_equal(found[0].targets, found[1].targets)
    assert not np.array_equal(found[0].targets, found[2].targets)


def test_a_network_is_searched_as_well_as_an_oracle(two_trajectories):
    estimator = estimator_of("matching")
    paths = GridPaths(two_trajectories.scene.clearance)
    pairs, queries = HardNegativeMining(frames=12, pairs=30, threshold=0.3).find(
        estimator, two_trajectories, paths, np.random.default_rng(0)
    )
    assert 60 <= queries < 144
    logits = all_logits(estimator, two_trajectories, pairs.starts, pairs.targets)
    assert (sigmoid(logits) > 0.3).all()
