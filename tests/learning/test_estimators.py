from dataclasses import replace

import numpy as np
import pytest
import torch

from tutorial_lib.driving.control.composed import ComposedController, RandomWaypoints
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import LocalController, Observation, WaypointPredictor
from tutorial_lib.learning.estimators import (
    DirectNetwork,
    EncodedTargets,
    ReachabilityNetwork,
    RelativeNetwork,
    WaypointNetwork,
)
from tutorial_lib.learning.networks import ENCODERS, Architecture, LocalNetwork
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation

torch.set_num_threads(1)  # so small are they here that two threads are slower
CLOSE = {"rel": 1e-4, "abs": 1e-5}


def network_of(architecture, seed=0):
    torch.manual_seed(seed)
    return LocalNetwork(architecture).eval()


def predictor_of(encoder="matching", k=1, view="camera16", seed=0):
    return WaypointNetwork(network_of(Architecture(k, encoder, view), seed))


@pytest.fixture(scope="module")
def starts(recorded):
    return recorded.poses[np.arange(6) * 40]


@pytest.fixture(scope="module")
def seen(recorded, starts):
    """What six robots of an office see."""
    return Simulation(recorded.scene, starts).observe()


def targets_of(recorded, predictor, count=6, first=20):
    """Contexts (count, 2k+1, H, W, C) of frames, as the network's view shows them."""
    frames = first + 40 * np.arange(count)
    poses = recorded.poses[recorded.context(frames, predictor.architecture.k)]
    return predictor.view.render(recorded.scene, poses)


def test_everything_fits_its_seam():
    predictor = predictor_of()
    direct = DirectNetwork(network_of(Architecture(1, "pair", outputs="action")))
    guess = RandomWaypoints(np.random.default_rng(0))
    for fits in (predictor, guess):
        assert isinstance(fits, WaypointPredictor)
    for fits in (direct, ComposedController(predictor, RMPController())):
        assert isinstance(fits, LocalController)
    assert not isinstance(direct, WaypointPredictor)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("encoder", ENCODERS)
def test_predictions_are_the_network_s_outputs(recorded, starts, encoder, view):
    predictor = predictor_of(encoder, view=view)
    camera = Camera(rows=64 if view == "camera64" else 16)
    sensors = Sensors(camera=camera, with_depth=True)
    seen = Simulation(recorded.scene, starts, sensors=sensors).observe()
    contexts = targets_of(recorded, predictor)
    waypoints, overlaps = predictor.predict(seen, contexts)
    with torch.inference_mode():
        shown = predictor.view.render(recorded.scene, starts)
        numbers = predictor.view.numbers
        wanted = predictor.network(numbers(shown), numbers(contexts)).numpy()
    assert waypoints.shape == overlaps.shape == (6, 2)
    assert waypoints.dtype == overlaps.dtype == np.float64
    assert waypoints == pytest.approx(wanted[:, :2], **CLOSE)
    assert overlaps == pytest.approx(1 / (1 + np.exp(-wanted[:, 4:])), **CLOSE)
    plainly = np.array(predictor.predict_uncached(seen, contexts))
    assert plainly == pytest.approx(np.array([waypoints, overlaps]), **CLOSE)


def test_actions_are_the_network_s_outputs(recorded, seen):
    direct = DirectNetwork(network_of(Architecture(1, "pair", outputs="action")))
    contexts = targets_of(recorded, direct)
    with torch.inference_mode():
        numbers = direct.view.numbers
        wanted = direct.network(numbers(seen.image), numbers(contexts)).numpy()
    actions = direct.act(seen, direct.prepare(contexts))
    assert actions.shape == (6, 2)
    assert actions == pytest.approx(wanted, **CLOSE)


@pytest.mark.parametrize("encoder", ENCODERS)
def test_some_encoded_targets_are_as_if_encoded_alone(recorded, seen, encoder):
    predictor = predictor_of(encoder)
    contexts = targets_of(recorded, predictor)
    kept = predictor.prepare(contexts)
    assert len(kept) == 6
    choices = [
        np.array([4, 1, 1]),
        np.array([True, False, True, True, False, False]),
        slice(2, None, 2),
        [5, 0],
        3,
        np.int64(2),
        np.array([], dtype=int),
    ]
    for index in choices:
        alone = contexts[[index] if np.ndim(index) == 0 and np.isscalar(index) else index]
        some = kept[index]
        assert isinstance(some, EncodedTargets)
        assert len(some) == len(alone)
        mine = predictor.predict(seen[: len(alone)], some)
        theirs = predictor.predict(seen[: len(alone)], alone)
        assert np.array(mine) == pytest.approx(np.array(theirs), **CLOSE)


@pytest.mark.parametrize("encoder", ENCODERS)
def test_each_robot_has_a_prediction_for_its_own_target(recorded, seen, encoder):
    predictor = predictor_of(encoder)
    kept = predictor.prepare(targets_of(recorded, predictor))
    together = np.array(predictor.predict(seen, kept))
    order = np.array([3, 5, 0, 2])
    some = np.array(predictor.predict(seen[order], kept[order]))
    assert some == pytest.approx(together[:, order], **CLOSE)
    for robot in range(6):
        alone = np.array(predictor.predict(seen[robot], kept[robot]))
        assert alone == pytest.approx(together[:, [robot]], **CLOSE)


def test_without_robots_predictions_are_empty(recorded, seen):
    predictor = predictor_of()
    kept = predictor.prepare(targets_of(recorded, predictor))
    nobody = np.array([], dtype=int)
    waypoints, overlaps = predictor.predict(seen[nobody], kept[nobody])
    assert waypoints.shape == overlaps.shape == (0, 2)
    assert len(predictor.prepare(targets_of(recorded, predictor, count=0))) == 0


def test_pictures_are_only_looked_at(recorded, seen):
    predictor = predictor_of()
    contexts = targets_of(recorded, predictor)
    before = contexts.copy(), seen.image.copy(), seen.laser.copy()
    first = predictor.predict(seen, contexts)
    again = predictor.predict(seen, contexts)
    assert np.array_equal(first, again)
    for mine, theirs in zip((contexts, seen.image, seen.laser), before, strict=True):
        assert (mine == theirs).all()
    assert not predictor.prepare(contexts).encoded.requires_grad


def test_overlaps_are_shares_however_sure_the_network_is(recorded, seen):
    predictor = predictor_of()
    with torch.no_grad():
        predictor.network.heads.bias[4:] = torch.tensor([-200.0, 200.0])
    contexts = targets_of(recorded, predictor)
    with np.errstate(all="raise", under="ignore"):
        overlaps = predictor.predict(seen, contexts)[1]
    assert overlaps == pytest.approx(np.tile([0.0, 1.0], (6, 1)))


# What does not fit.


@pytest.mark.parametrize("k", [0, 2])
def test_another_context_is_refused(recorded, seen, k):
    predictor, contexts = predictor_of(k=1), targets_of(recorded, predictor_of(k=k))
    for ask in (lambda: predictor.prepare(contexts), lambda: predictor.predict(seen, contexts)):
        with pytest.raises(InputError, match=r"k = 1: give \(M, 3, H, W, C\)"):
            ask()


def test_an_image_alone_stands_for_all_of_its_context(recorded, seen):
    model = RelativeNetwork(network_of(Architecture(1, outputs="relative")))
    alone = targets_of(recorded, model)[:, 1:2]
    for one, all_of_them in zip(
        model.predict(seen, alone), model.predict(seen, np.repeat(alone, 3, axis=1)), strict=True
    ):
        assert one == pytest.approx(all_of_them, **CLOSE)


def test_targets_without_a_context_s_axis_are_refused(recorded):
    predictor = predictor_of(k=0)
    with pytest.raises(InputError, match=r"\(M, 1, H, W, C\)"):
        predictor.prepare(targets_of(recorded, predictor)[:, 0])


def test_targets_prepared_by_another_network_are_refused(recorded, seen):
    predictor = predictor_of(k=1)
    for other in (predictor_of(k=2), predictor_of("pair", k=1), predictor_of(k=1, view="laser")):
        kept = other.prepare(targets_of(recorded, other))
        with pytest.raises(InputError, match="another network"):
            predictor.predict(seen, kept)


def test_pictures_of_another_size_are_refused(recorded, starts, seen):
    predictor = predictor_of()
    contexts = targets_of(recorded, predictor)
    tall = Simulation(recorded.scene, starts, sensors=Sensors(camera=Camera(rows=64))).observe()
    with pytest.raises(InputError, match=r"rows=64.*this network learned with Camera\(rows=16"):
        predictor.predict(tall, contexts)
    with pytest.raises(InputError, match=r"\(6, 64, 64, 3\).* 16, 64, 3\)"):
        predictor.predict(replace(tall, camera=None), contexts)
    with pytest.raises(InputError, match=r"64, 64, 3\).* 16, 64, 3\)"):
        predictor.prepare(targets_of(recorded, predictor_of(view="camera64")))
    with pytest.raises(InputError, match="float64"):
        predictor.prepare(contexts / 255.0)


def test_another_field_of_view_is_refused_by_the_network_s_name(recorded, starts):
    predictor = WaypointNetwork("waypoint_k2")
    contexts = targets_of(recorded, predictor)
    narrow = Camera(field_of_view=1.57)
    seen = Simulation(recorded.scene, starts, sensors=Sensors(camera=narrow)).observe()
    assert seen.image.shape[1:] == (16, 64, 3)  # which does not tell
    with pytest.raises(InputError, match=r"field_of_view=1\.57.*, and waypoint_k2 learned with"):
        predictor.predict(seen, contexts)
    goals = recorded.goals(np.array([40]), 2, narrow)[0].observations
    with pytest.raises(InputError, match="waypoint_k2 learned with"):
        predictor.predict(goals, contexts[:1])
    # A laser is no camera.
    laser = predictor_of(view="laser")
    assert len(laser.predict(seen, targets_of(recorded, laser))[0]) == len(seen)


def test_another_laser_is_refused(recorded, seen):
    predictor = predictor_of(view="laser")
    contexts = targets_of(recorded, predictor)
    with pytest.raises(InputError, match="48 beams; give 96"):
        predictor.predict(replace(seen, laser=seen.laser[:, ::2]), contexts)


@pytest.mark.parametrize("count", [1, 5])
def test_as_many_targets_as_robots_are_needed(recorded, seen, count):
    predictor = predictor_of()
    contexts = targets_of(recorded, predictor, count=count)
    for targets in (contexts, predictor.prepare(contexts)):
        with pytest.raises(InputError, match=f"{count} for 6 robots"):
            predictor.predict(seen, targets)


def test_a_network_that_tells_something_else_is_refused():
    with pytest.raises(InputError, match="predicts 'action' where 'waypoint' is needed"):
        WaypointNetwork(network_of(Architecture(1, "pair", outputs="action")))
    with pytest.raises(InputError, match="predicts 'waypoint' where 'action' is needed"):
        DirectNetwork(network_of(Architecture(1, "pair")))


def test_weights_that_do_not_exist_are_named():
    with pytest.raises(InputError, match=r"waypoint_k99\.json"):
        WaypointNetwork("waypoint_k99")


# C = C_RMP after C_WP.


class Noting:
    """A controller that records its queries and answers with numbers of its own."""

    def __init__(self):
        self.queries = []

    def act(self, observations, waypoints):
        self.queries.append((observations, waypoints))
        return waypoints * [0.1, 0.3]


def test_composed_control_predicts_and_then_acts(recorded, seen):
    predictor, controller = predictor_of(), Noting()
    kept = predictor.prepare(targets_of(recorded, predictor))
    actions = ComposedController(predictor, controller).act(seen, kept)
    waypoints, _ = predictor.predict(seen, kept)
    assert len(controller.queries) == 1
    assert controller.queries[0][0] is seen
    assert (controller.queries[0][1] == waypoints).all()
    assert (actions == waypoints * [0.1, 0.3]).all()
    composed = ComposedController(predictor, RMPController()).act(seen, kept)
    assert (composed == RMPController().act(seen, waypoints)).all()


def test_any_predictor_can_be_composed(seen):
    class Left:
        def predict(self, observations, targets):
            return np.tile([0.0, 1.0], (len(observations), 1)) * targets, np.zeros((6, 2))

    actions = ComposedController(Left(), Noting()).act(seen, 2.0)
    assert (actions == [0.0, 0.6]).all()


def many(count):
    nothing = np.zeros(count)
    picture = np.zeros((count, 1, 1, 3), np.uint8)
    return Observation(picture, None, np.zeros((count, 4)), np.zeros((count, 3)), nothing, nothing)


def test_random_waypoints_lie_anywhere_from_behind_to_ahead():
    waypoints, overlaps = RandomWaypoints(np.random.default_rng(0)).predict(many(5000), None)
    assert waypoints.min(axis=0) == pytest.approx([-1.0, -1.5], abs=0.05)
    assert waypoints.max(axis=0) == pytest.approx([3.0, 1.5], abs=0.05)
    assert waypoints.mean(axis=0) == pytest.approx([1.0, 0.0], abs=0.1)
    assert overlaps.shape == (5000, 2)
    assert set(overlaps.ravel()) == {0.5}


def test_agents_can_ask_random_waypoints_what_they_look_at(seen):
    guess = RandomWaypoints(np.random.default_rng(0))
    assert guess.view.of(seen) is seen.image


def test_random_waypoints_are_drawn_by_their_seed_and_do_not_look(seen):
    one, two, other = (RandomWaypoints(np.random.default_rng(seed)) for seed in (3, 3, 4))
    first = one.predict(seen, None)[0]
    assert (first == two.predict(many(6), "anything")[0]).all()
    assert (first != other.predict(seen, None)[0]).all()
    assert (first != one.predict(seen, None)[0]).all()


# Maps: targets that share pictures, targets end to end, and what looks alike.


def reachability_of(encoder="matching", k=1, seed=0):
    return ReachabilityNetwork(network_of(Architecture(k, encoder, outputs="reachability"), seed))


def neighbours_of(recorded, predictor, count=9):
    """Contexts of frames that lie three apart on one trajectory, so that they share images."""
    frames = 30 + 3 * np.arange(count)
    poses = recorded.poses[recorded.context(frames, predictor.architecture.k)]
    return predictor.view.render(recorded.scene, poses)


@pytest.mark.parametrize("encoder", ENCODERS)
@pytest.mark.few(2)
def test_targets_that_share_pictures_are_encoded_as_if_alone(recorded, seen, encoder):
    predictor = predictor_of(encoder, k=2)
    contexts = neighbours_of(recorded, predictor)
    kept = predictor.prepare(contexts)
    assert len(kept) == 9
    for number in range(9):
        alone = predictor.prepare(contexts[number : number + 1])
        assert kept[number].encoded.numpy() == pytest.approx(alone.encoded.numpy(), **CLOSE)
    wanted = predictor.network.encode_targets(predictor.view.numbers(contexts)).detach()
    assert kept.encoded.numpy() == pytest.approx(wanted.numpy(), **CLOSE)


@pytest.mark.parametrize("encoder", ENCODERS)
def test_each_picture_is_encoded_once(recorded, monkeypatch, encoder):
    predictor = predictor_of(encoder, k=2)
    contexts = neighbours_of(recorded, predictor)
    whole, encoded = predictor.network.encode_targets, []

    def noting(pictures):
        encoded.append(len(pictures))
        return whole(pictures)

    monkeypatch.setattr(predictor.network, "encode_targets", noting)
    predictor.prepare(contexts)
    # Of 45 pictures, 13 differ.
    assert len(np.unique(contexts.reshape(45, -1), axis=0)) == 13
    assert encoded == [13]


@pytest.mark.parametrize("encoder", ENCODERS)
def test_encoded_targets_are_put_end_to_end(recorded, seen, encoder):
    reachability = reachability_of(encoder)
    contexts = targets_of(recorded, reachability)
    parts = [
        reachability.prepare(contexts[some]) for some in (slice(0, 2), slice(2, 3), slice(3, 6))
    ]
    whole = EncodedTargets.joined(parts)
    assert len(whole) == 6
    assert whole.network is reachability.network
    assert reachability.logits(seen, whole) == pytest.approx(
        reachability.logits(seen, reachability.prepare(contexts)), **CLOSE
    )
    assert len(EncodedTargets.joined([parts[0][[]], parts[2]])) == 3


@pytest.mark.parametrize("encoder", ENCODERS)
@pytest.mark.parametrize("k", [0, 2])
def test_embeddings_are_directions_of_what_is_seen(recorded, seen, encoder, k):
    reachability = reachability_of(encoder, k)
    embedded = reachability.embed(seen)
    assert embedded.shape[0] == 6
    assert embedded.shape[1] == (16 if encoder == "matching" else 1)
    assert embedded.dtype == np.float32
    assert np.linalg.norm(embedded, axis=-1) == pytest.approx(1.0, abs=1e-4)
    order = np.array([3, 0, 3])
    assert reachability.embed(seen[order]) == pytest.approx(embedded[order], **CLOSE)
    prepared = reachability.prepare(targets_of(recorded, reachability))
    shown = reachability.embed_targets(prepared)
    pictures = 1 if k == 0 else 2
    assert shown.shape == (6, pictures, *embedded.shape[1:])
    assert np.linalg.norm(shown, axis=-1) == pytest.approx(1.0, abs=1e-4)
    assert reachability.embed_targets(prepared[order]) == pytest.approx(shown[order], **CLOSE)


def test_a_target_shows_its_first_picture_and_the_middle_one(recorded):
    reachability = reachability_of(k=2)
    contexts = targets_of(recorded, reachability)
    shown = reachability.embed_targets(reachability.prepare(contexts))
    for place, picture in enumerate((0, 2)):
        alike = np.repeat(contexts[:, picture : picture + 1], 5, axis=1)
        alone = reachability.embed_targets(reachability.prepare(alike))
        assert shown[:, place] == pytest.approx(alone[:, 0], **CLOSE)
        assert shown[:, 1 - place] != pytest.approx(alone[:, 0], abs=1e-3)


def test_what_is_seen_where_a_target_was_taken_looks_most_like_it(recorded, seen, starts):
    reachability = reachability_of(k=0)
    contexts = reachability.view.render(recorded.scene, starts[:, None])
    shown = reachability.embed_targets(reachability.prepare(contexts))[:, 0]
    embedded = reachability.embed(seen)
    cosines = np.einsum("nrd,msd->nmrs", embedded, shown)
    alike = cosines.max(axis=3).mean(axis=2) + cosines.max(axis=2).mean(axis=2)
    assert (alike.argmax(axis=1) == np.arange(6)).all()
    assert np.diag(alike) == pytest.approx(2.0, abs=1e-4)
