import io
import threading
from dataclasses import dataclass, field, fields, replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree

from tests.conftest import make_trajectory
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import relative, to_local, to_world
from tutorial_lib.learning import training
from tutorial_lib.learning.batches import Batch, Source, batches, clutter
from tutorial_lib.learning.losses import action_loss, context_loss, position_loss, waypoint_loss
from tutorial_lib.learning.networks import ENCODERS, Architecture, LocalNetwork
from tutorial_lib.learning.training import Progress, Settings, train
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.reading.checksums import sealed, unsealed
from tutorial_lib.world.sensors import Camera, Laser
from tutorial_lib.world.visibility import mutual_overlap

torch.set_num_threads(1)  # so small are they here that two threads are slower
ARRAYS = [field.name for field in fields(Batch)]
TINY = Architecture(1, "pair")
SETTINGS = Settings(max_steps=20, targets=4, warmup_steps=5, eval_interval=4)


@pytest.fixture(scope="module")
def worlds(recorded, pillars):
    """An office and a room with pillars."""
    trajectory = make_trajectory([(1.0, 1.0), (9.0, 1.0), (9.0, 5.5), (2.0, 5.5)])
    return [recorded, RecordedWorld(pillars, [trajectory])]


@pytest.fixture(scope="module")
def source(worlds):
    """Blocks of 2 x 7 targets, so that batches of 4 do not fill a block."""
    return Source(worlds, TINY, worlds=2, targets=7, starts=2)


@pytest.fixture(scope="module")
def validation(source):
    return [source.block([9, i]) for i in range(2)]


def same(one, two):
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in ARRAYS)


# Blocks and batches.


@dataclass(frozen=True)
class PoseView:
    """Shows where a picture was taken, in place of the picture."""

    name: str = "poses"
    size: tuple[int, int, int] = (1, 1, 3)
    camera: Camera = field(default_factory=Camera)

    def render(self, scene, poses, discs=None):
        return poses[..., None, :, None].copy()

    def vary(self, pictures, rng):
        """Marks what was varied, the current and all other pictures of a group alike."""
        turn = 10.0 * rng.integers(1, 1000, len(pictures[0]))
        mark = [np.stack([0 * turn, 0 * turn, 2 * np.pi * turn], axis=1) for _ in pictures]
        return [
            p + m.reshape(len(m), *[1] * (p.ndim - 3), 3, 1)
            for p, m in zip(pictures, mark, strict=True)
        ]


class Echo:
    """A controller whose actions depend on what it was shown."""

    def act(self, observations, waypoints):
        return np.stack([observations.laser[:, 5], waypoints[:, 0] + observations.speed], axis=1)


@pytest.fixture
def block(worlds, monkeypatch):
    monkeypatch.setitem(VIEWS, "poses", PoseView())
    architecture = Architecture(2, "pair", "poses")
    shown = Source(worlds, architecture, Echo(), worlds=5, targets=8, starts=3, vary=False)
    return shown.block([3, 4])


def poses_in(block):
    """Poses (N, 3) of the current pictures, and (N, 2k+1, 3) of their targets' contexts."""
    return block.current[:, 0, :, 0], np.repeat(block.contexts[:, :, 0, :, 0], 3, axis=0)


def world_of(worlds, contexts):
    """(N,) in which world the targets were recorded."""
    return np.array([cKDTree(worlds[0].poses).query(c)[0].max() > 1e-9 for c in contexts], int)


def test_labels_of_a_block_stay_with_their_pictures(block):
    starts, contexts = poses_in(block)
    seen = relative(starts[:, None], contexts)
    turn = np.stack([np.cos(seen[..., 2]), np.sin(seen[..., 2])], axis=-1)
    assert block.context_poses[..., :2] == pytest.approx(seen[..., :2], abs=1e-5)
    assert block.context_poses[..., 2:] == pytest.approx(turn, abs=1e-5)
    assert block.turn == pytest.approx(turn[:, 2], abs=1e-5)
    assert len(np.unique(starts, axis=0)) == 120
    assert set(block.weight) == {0.0, 1.0} or block.weight.all()


def test_waypoints_and_overlaps_of_a_block_are_those_of_its_world(worlds, block):
    starts, contexts = poses_in(block)
    world = world_of(worlds, contexts)
    places = to_world(starts, block.waypoint.astype(float))
    assert 0 < world.sum() < len(world)
    for number, recorded in enumerate(worlds):
        mine = world == number
        assert cKDTree(recorded.poses[:, :2]).query(places[mine])[0].max() < 1e-5
        overlap = mutual_overlap(recorded.scene.caster, starts[mine], contexts[mine, 2])
        assert block.overlap[mine] == pytest.approx(overlap, abs=1e-6)


def test_actions_of_a_block_are_the_driver_s_where_its_pairs_start(worlds, block):
    starts, contexts = poses_in(block)
    world = world_of(worlds, contexts)
    for number, recorded in enumerate(worlds):
        mine = world == number
        beam = Laser().scan(recorded.scene, starts[mine])[:, 5]
        assert block.action[mine, 0] == pytest.approx(beam, abs=1e-5)
    speed = block.action[:, 1] - block.waypoint[:, 0]
    assert speed[world == 1] == pytest.approx(0.0, abs=1e-6)  # recorded standing
    assert worlds[0].speed.min() - 1e-6 <= speed.min()
    assert speed.max() > 0.3


def test_targets_of_one_world_do_not_lie_together(worlds, block):
    _, contexts = poses_in(block)
    world = world_of(worlds, contexts)[::3]
    assert (np.diff(world) != 0).sum() > 5


def test_all_pictures_of_a_target_are_varied_alike(worlds, monkeypatch):
    monkeypatch.setitem(VIEWS, "poses", PoseView())
    architecture = Architecture(2, "pair", "poses")
    varied = Source(worlds, architecture, worlds=2, targets=8, starts=3).block([0])
    marks = [
        np.rint(part[..., 0, 2, 0] / (20 * np.pi)) for part in (varied.current, varied.contexts)
    ]
    assert (marks[0].reshape(16, 3) == marks[1][:, :1]).all()
    assert (marks[1] == marks[1][:, :1]).all()
    assert len(np.unique(marks[1])) > 10


def test_clutter_stands_before_its_robot():
    rng = np.random.default_rng(0)
    poses = rng.uniform(-3, 3, (400, 3))
    some = clutter(poses, 0.3, rng)
    with_some = np.unique(some.owners)
    assert len(with_some) == pytest.approx(120, abs=30)
    assert set(np.bincount(some.owners)) == {0, 1, 2}
    ahead = to_local(poses[some.owners], some.circles[:, :2])
    assert ahead[:, 0].min() > 0
    assert 0.5 <= np.hypot(*ahead.T).min() < np.hypot(*ahead.T).max() <= 2.5
    assert len(clutter(poses, 0.0, rng).owners) == 0


def test_clutter_is_in_the_current_picture_and_never_in_the_target_s(worlds):
    alone = Source(worlds[:1], TINY, worlds=1, targets=1, starts=30, clutter=0.0, vary=False)
    empty, crowded = alone.block([0]), replace(alone, clutter=1.0).block([0])
    assert (empty.contexts == crowded.contexts).all()
    changed = (empty.current != crowded.current).any(axis=(1, 2, 3))
    assert changed.mean() > 0.4  # others are hidden by walls
    for name in ("waypoint", "turn", "overlap", "context_poses", "weight"):
        assert (getattr(empty, name) == getattr(crowded, name)).all()


def test_without_a_driver_there_are_no_actions(source):
    block = source.block([0])
    assert block.action.shape == (28, 0)
    assert block.current.shape == (28, 16, 64, 3)
    assert block.contexts.shape == (14, 3, 16, 64, 3)
    for name in ARRAYS[2:]:
        assert getattr(block, name).dtype == np.float32


def test_the_same_seed_makes_the_same_block(source):
    assert same(source.block([1, 2]), source.block([1, 2]))
    assert not same(source.block([1, 2]), source.block([1, 3]))
    assert not same(source.block([1, 2]), source.block([2, 2]))


@pytest.mark.parametrize("groups", [slice(2, 5), np.array([6, 0, 6]), np.arange(40) % 3 == 0])
def test_some_targets_keep_their_starts(block, groups):
    some, picked = block.targets(groups), np.arange(40)[groups]
    rows = (3 * picked[:, None] + np.arange(3)).ravel()
    assert (some.contexts == block.contexts[picked]).all()
    for name in set(ARRAYS) - {"contexts"}:
        assert (getattr(some, name) == getattr(block, name)[rows]).all()


def test_a_batch_depends_on_its_number_alone(source):
    wanted = list(islice(batches(source, 5, 0, 4), 8))  # three to a block
    for first in range(7):
        assert same(next(batches(source, 5, first, 4)), wanted[first])
    later = list(islice(batches(source, 5, 2, 4), 3))
    assert all(same(*pair) for pair in zip(later, wanted[2:5], strict=True))
    assert not same(next(batches(source, 6, 0, 4)), wanted[0])


def test_batches_are_the_parts_of_blocks(source):
    coming = list(islice(batches(source, 5, 0, 4), 6))
    for number in range(2):
        block = source.block([5, number])
        for part in range(3):
            batch = coming[3 * number + part]
            assert same(batch, block.targets(slice(4 * part, 4 * part + 4)))
            assert len(batch.contexts) == 4


@pytest.mark.parametrize("size", [0, 15])
def test_batches_larger_than_a_block_are_refused(source, size):
    with pytest.raises(InputError, match=f"{size} targets.* 1 to 14"):
        next(batches(source, 0, 0, size))


def test_nobody_goes_on_making_blocks_when_batches_are_closed(source):
    before = threading.active_count()
    coming = batches(source, 0, 0, 4)
    next(coming)
    assert threading.active_count() == before + 1
    coming.close()
    assert threading.active_count() == before


# Losses.


def perfect(block):
    """Outputs and context poses that are right about a block."""
    sure = torch.logit(block.tensor("overlap"))
    right = torch.cat([block.tensor("waypoint"), block.tensor("turn"), sure], dim=1)
    return right, block.tensor("context_poses")


def test_nothing_is_better_than_being_right(block):
    block = replace(
        block, overlap=block.overlap.clip(0.05, 0.95)
    )  # else nobody is ever sure enough
    right, poses = perfect(block)
    loss = waypoint_loss(right, block)
    assert loss.shape == (120,)
    for column in range(6):
        for change in (-0.3, 0.3):
            wrong = right.clone()
            wrong[:, column] += change
            assert (waypoint_loss(wrong, block) > loss).all()
    assert context_loss(poses, block).abs().max() < 1e-6
    assert (context_loss(poses + 0.1, block) > 0.01).all()
    assert action_loss(block.tensor("action"), block).abs().max() == 0
    assert (action_loss(block.tensor("action") + 0.1, block) > 0.01).all()


def test_an_error_costs_more_the_larger_it_is_and_the_nearer_the_place():
    places = torch.tensor([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [3.0, 0.0]])
    error = torch.tensor([[0.0, 0.2]])
    costs = position_loss(places + error, places)
    assert (costs.diff() < 0).all()
    assert (position_loss(places + 2 * error, places) > 1.5 * costs).all()
    assert position_loss(places, places).abs().max() < 1e-6


def test_an_error_costs_the_same_to_whichever_side_it_is():
    places = torch.tensor([[0.0, 0.0], [1.0, 0.0], [0.0, -2.0]])
    error = torch.tensor([[0.8, -0.6]])
    costs = position_loss(places + error, places)
    assert torch.allclose(costs, position_loss(places - error, places))
    assert torch.allclose(costs, costs[0] / torch.tensor([1.0, 2.0, 3.0]))


def test_a_position_that_is_right_has_a_gradient():
    places = torch.zeros(2, 2, requires_grad=True)
    position_loss(places, torch.zeros(2, 2)).sum().backward()
    assert places.grad.isfinite().all()


def test_pairs_that_cannot_be_learnt_from_do_not_count(source):
    block, network = source.block([0]), LocalNetwork(TINY)
    weight = (np.arange(28) % 3 > 0).astype(np.float32)
    waypoint = np.where(weight[:, None] > 0, block.waypoint, 99.0).astype(np.float32)
    with torch.inference_mode():
        one = training.total_loss(network, replace(block, weight=weight))
        two = training.total_loss(network, replace(block, weight=weight, waypoint=waypoint))
        nothing = training.total_loss(network, replace(block, weight=0 * weight))
        all_of_them = training.total_loss(
            network, replace(block, waypoint=waypoint, weight=weight + 1)
        )
    assert one == two
    assert nothing == 0
    assert all_of_them > one + 0.1
    measured = training.validate(network, [replace(block, weight=weight, waypoint=waypoint)])
    assert measured["mean"] < 10


@pytest.mark.parametrize("encoder", ENCODERS)
@torch.inference_mode()
def test_each_start_is_compared_with_its_own_target(source, encoder):
    block, network = source.block([0]), LocalNetwork(Architecture(1, encoder))
    outputs, poses = training.outputs_of(network, block)
    view = TINY.looks_at
    own = np.repeat(block.contexts, 2, axis=0)
    wanted = network(view.numbers(block.current), view.numbers(own))
    torch.testing.assert_close(outputs, wanted, rtol=1e-5, atol=1e-5)
    assert poses.shape[:1] == (28,)


def test_validation_measures_metres(source):
    class Still(LocalNetwork):
        def compare(self, current, targets):
            return torch.zeros(len(current), 6), torch.zeros(len(current), 3, 4)

    blocks = [source.block([0]), source.block([1])]
    measured = training.validate(Still(TINY), blocks)
    kept = np.concatenate([np.hypot(*block.waypoint[block.weight > 0].T) for block in blocks])
    assert measured["mean"] == pytest.approx(kept.mean(), rel=1e-5)
    assert kept.min() <= measured["median"] <= kept.max()
    assert (kept <= measured["median"]).mean() == pytest.approx(0.5, abs=0.05)


# Training.


def weights_of(network):
    return {name: value.clone() for name, value in network.state_dict().items()}


def equal(one, two):
    one, two = one.state_dict(), two.state_dict()
    return all(torch.equal(one[name], two[name]) for name in one)


class Killed(BaseException):
    """As unexpected as a power cut."""


def killed_after(steps, monkeypatch):
    """Let training end in the middle of what comes after so many steps."""
    learn, done = training._State.learn, []

    def mortal(self, batch):
        if len(done) == steps:
            raise Killed
        done.append(learn(self, batch))

    monkeypatch.setattr(training._State, "learn", mortal)


def killed_when_saved(monkeypatch):
    """Let training end after each checkpoint."""
    save = training._State.save

    def mortal(self, path):
        save(self, path)
        raise Killed

    monkeypatch.setattr(training._State, "save", mortal)


@pytest.fixture(scope="module")
def finished(source, validation):
    return train(TINY, source, validation, SETTINGS)


def test_the_learning_rate_rises_and_falls():
    settings = Settings(max_steps=1000, learning_rate=0.01, warmup_steps=100)
    rates = [settings.learning_rate_at(step) for step in range(1000)]
    assert rates[0] == pytest.approx(0.01 / 100, rel=0.02)
    assert max(rates) == pytest.approx(0.01, rel=0.05)
    assert 90 <= int(np.argmax(rates)) <= 100
    assert (np.diff(rates[100:]) < 0).all()
    assert 0 < rates[-1] < 0.01 * 0.01


def test_the_same_seed_trains_the_same_weights(source, validation, finished):
    network, progress = train(TINY, source, validation, SETTINGS)
    assert equal(network, finished[0])
    assert progress == finished[1]
    assert not network.training
    other, _ = train(TINY, source, validation, replace(SETTINGS, seed=1))
    assert not equal(other, network)


def test_the_seed_draws_the_initial_weights_too(source, validation):
    # At a rate of zero nothing is learnt.
    still = replace(SETTINGS, max_steps=1, learning_rate=0.0)
    first, again, other = (
        train(TINY, source, validation, replace(still, seed=seed))[0] for seed in (3, 3, 4)
    )
    assert equal(first, again)
    assert not equal(first, other)


def test_evaluations_come_at_the_interval_and_at_the_end(source, validation, finished):
    assert [evaluation["step"] for evaluation in finished[1].history] == [4, 8, 12, 16, 20]
    for evaluation in finished[1].history:
        assert set(evaluation) == {"step", "training", "validation", "median", "mean"}
    uneven = replace(SETTINGS, max_steps=7)
    progress = train(TINY, source, validation, uneven)[1]
    assert [evaluation["step"] for evaluation in progress.history] == [4, 7]


@pytest.mark.parametrize("steps", [2, 4, 19])
def test_a_killed_training_goes_on_to_the_same_weights(
    source, validation, finished, tmp_path, monkeypatch, steps
):
    checkpoint = tmp_path / "tiny.pt"
    with monkeypatch.context() as patched:
        killed_after(steps, patched)
        with pytest.raises(Killed):
            train(TINY, source, validation, SETTINGS, checkpoint)
    assert checkpoint.exists() == (steps >= 4)
    torch.manual_seed(123)  # as another process would stand elsewhere
    network, progress = train(TINY, source, validation, SETTINGS, checkpoint)
    assert equal(network, finished[0])
    assert progress == finished[1]
    assert list(tmp_path.iterdir()) == [checkpoint]


def test_a_training_killed_at_every_look_goes_on_to_the_same_weights(
    source, validation, finished, tmp_path, monkeypatch
):
    killed_when_saved(monkeypatch)
    checkpoint = tmp_path / "tiny.pt"
    for _ in range(5):
        with pytest.raises(Killed):
            train(TINY, source, validation, SETTINGS, checkpoint)
    network, progress = train(TINY, source, validation, SETTINGS, checkpoint)
    assert equal(network, finished[0])
    assert progress == finished[1]


def test_a_killed_save_leaves_the_last_checkpoint(
    source, validation, finished, tmp_path, monkeypatch
):
    checkpoint, write, written = tmp_path / "tiny.pt", Path.write_bytes, []

    def half(path, data):
        written.append(path)
        write(path, data if len(written) < 3 else data[: len(data) // 2])
        if len(written) == 3:
            raise Killed

    with monkeypatch.context() as patched:
        patched.setattr(Path, "write_bytes", half)
        with pytest.raises(Killed):
            train(TINY, source, validation, SETTINGS, checkpoint)
    assert list(tmp_path.iterdir()) == [checkpoint]
    network, _ = train(TINY, source, validation, SETTINGS, checkpoint)
    assert equal(network, finished[0])


def scripted(monkeypatch, losses):
    """Let the evaluations return these losses, one by one, and keep the weights they were given."""
    shown = []

    def measure(network, validation):
        shown.append(weights_of(network))
        return {"validation": losses[len(shown) - 1]}

    monkeypatch.setattr(training, "validate", measure)
    return shown


def test_the_weights_of_the_best_evaluation_are_returned(source, monkeypatch):
    shown = scripted(monkeypatch, [3.0, 1.0, 2.0, 1.0, 1.5])
    network, progress = train(TINY, source, [], SETTINGS)
    assert progress.best == 1  # the first of two that are as good
    assert len(progress.history) == 5
    best, last = shown[1], shown[4]
    assert all(torch.equal(value, best[name]) for name, value in network.state_dict().items())
    assert any(not torch.equal(best[name], last[name]) for name in best)


def test_training_ends_when_it_gets_no_better(source, monkeypatch, tmp_path):
    losses = [3.0, 1.0, 2.0, 1.0, 0.5]
    impatient = replace(SETTINGS, patience=2)
    shown = scripted(monkeypatch, losses)
    network, progress = train(TINY, source, [], impatient, tmp_path / "tiny.pt")
    assert progress.step == 16
    assert len(shown) == 4
    assert all(torch.equal(value, shown[1][name]) for name, value in network.state_dict().items())
    # What has ended has ended: nothing more is learnt, and the result is the same.
    killed_after(0, monkeypatch)
    again, there = train(TINY, source, [], impatient, tmp_path / "tiny.pt")
    assert equal(again, network)
    assert there == progress


@pytest.mark.parametrize("steps", [7, 14])
def test_a_killed_training_ends_as_early(source, monkeypatch, tmp_path, steps):
    impatient, losses = replace(SETTINGS, patience=2), [3.0, 1.0, 2.0, 1.0, 0.5]
    scripted(monkeypatch, losses)
    network, progress = train(TINY, source, [], impatient)
    with monkeypatch.context() as patched:
        scripted(patched, losses)
        killed_after(steps, patched)
        with pytest.raises(Killed):
            train(TINY, source, [], impatient, tmp_path / "tiny.pt")
    scripted(monkeypatch, losses[steps // 4 :])
    again, there = train(TINY, source, [], impatient, tmp_path / "tiny.pt")
    assert equal(again, network)
    assert there == progress


def test_progress_knows_when_it_is_over():
    def after(*losses):
        return Progress(len(losses), [{"validation": loss} for loss in losses])

    assert not Progress().is_over(1)
    assert not after(1.0).is_over(1)
    assert after(1.0, 1.0).is_over(1)
    assert not after(2.0, 1.0, 3.0).is_over(2)
    assert after(2.0, 1.0, 3.0, 1.5).is_over(2)


@pytest.fixture(scope="module")
def saved(source, validation, tmp_path_factory):
    """The checkpoint of a training that has ended."""
    path = tmp_path_factory.mktemp("saved") / "tiny.pt"
    train(TINY, source, validation, replace(SETTINGS, eval_interval=20), path)
    return path.read_bytes()


@pytest.fixture
def checkpoint(saved, tmp_path):
    path = tmp_path / "tiny.pt"
    path.write_bytes(saved)
    return path


@pytest.mark.parametrize("other", ["seed", "architecture", "vary", "drives"])
def test_a_checkpoint_of_another_training_is_refused(source, validation, checkpoint, other):
    before = checkpoint.read_bytes()
    settings, architecture = replace(SETTINGS, eval_interval=20), TINY
    if other == "seed":
        settings = replace(settings, seed=1)
    elif other == "architecture":
        architecture = Architecture(1, "matching")
    elif other == "vary":
        source = replace(source, vary=False)
    else:
        source = replace(source, recorded_worlds=source.recorded_worlds[:1])
    with pytest.raises(InputError, match=r"tiny\.pt.*another training.*delete it"):
        train(architecture, source, validation, settings, checkpoint)
    assert checkpoint.read_bytes() == before


def test_a_checkpoint_cut_off_anywhere_is_refused(source, validation, checkpoint):
    whole = checkpoint.read_bytes()
    for size in (0, 1, 30, 1000, len(whole) // 2, len(whole) - 200, len(whole) - 1):
        checkpoint.write_bytes(whole[:size])
        with pytest.raises(InputError, match=r"tiny\.pt.*damaged.*delete it") as caught:
            train(TINY, source, validation, replace(SETTINGS, eval_interval=20), checkpoint)
        assert "\n" not in str(caught.value)
        assert checkpoint.read_bytes() == whole[:size]


def write_sealed(path, state):
    """A checkpoint that holds anything, whose checksum is right."""
    buffer = io.BytesIO()
    torch.save(state, buffer)
    path.write_bytes(sealed(buffer.getvalue()))


def test_a_checkpoint_in_which_a_single_bit_fell_over_is_refused(source, validation, checkpoint):
    whole = checkpoint.read_bytes()
    for place in np.linspace(0, 8 * len(whole) - 1, 41).astype(int).tolist():
        changed = bytearray(whole)
        changed[place // 8] ^= 1 << place % 8
        checkpoint.write_bytes(changed)
        with pytest.raises(InputError, match=r"tiny\.pt: a damaged .*checksum.*delete it"):
            train(TINY, source, validation, replace(SETTINGS, eval_interval=20), checkpoint)


def test_a_checkpoint_of_an_older_version_is_refused(source, validation, checkpoint):
    checkpoint.write_bytes(unsealed(checkpoint.read_bytes()))
    with pytest.raises(InputError, match=r"without a checksum: .*older version.*; delete it"):
        train(TINY, source, validation, replace(SETTINGS, eval_interval=20), checkpoint)


@pytest.mark.parametrize("content", [b"hello", {"step": 1}, [1, 2], "missing"])
def test_what_is_no_checkpoint_is_refused(source, validation, checkpoint, content):
    if content == "missing":
        state = torch.load(io.BytesIO(unsealed(checkpoint.read_bytes())), weights_only=True)
        del state["optimizer"]
        write_sealed(checkpoint, state)
    elif isinstance(content, bytes):
        checkpoint.write_bytes(content)
    else:
        write_sealed(checkpoint, content)
    with pytest.raises(InputError, match=r"tiny\.pt.*damaged.*delete it"):
        train(TINY, source, validation, replace(SETTINGS, eval_interval=20), checkpoint)


def moments(key, change):
    """A checkpoint in which something else stands for what Adam keeps of one parameter."""

    def alter(state):
        kept = state["optimizer"]["state"][3]
        kept[key] = change(kept[key])

    return alter


def replaced(*path, value):
    """A checkpoint in which something else stands at a place."""

    def alter(state):
        for key in path[:-1]:
            state = state[key]
        state[path[-1]] = value(state[path[-1]]) if callable(value) else value

    return alter


UNFIT = {
    "moment_shape": (moments("exp_avg", lambda value: value[..., None]), "tensor exp_avg: shape"),
    "square_shape": (moments("exp_avg_sq", lambda _: torch.zeros(2)), "tensor exp_avg_sq: shape"),
    "moment_nan": (moments("exp_avg", lambda value: value * np.nan), "exp_avg: holds what is no"),
    "square_negative": (moments("exp_avg_sq", lambda value: value - 1), "negative square"),
    "moment_kind": (moments("exp_avg", lambda value: value.to(torch.int32)), "another kind"),
    "moment_number": (moments("exp_avg", lambda _: 0.5), "what is no tensor"),
    "moment_step": (moments("step", lambda value: value + 100), "another number of steps"),
    "moment_missing": (lambda s: s["optimizer"]["state"][3].pop("exp_avg"), "optimizer: .* has"),
    "no_moments": (replaced("optimizer", "state", value={}), "other parameters"),
    "more_moments": (lambda s: s["optimizer"]["state"].update({999: {}}), "other parameters"),
    "betas": (replaced("optimizer", "param_groups", 0, "betas", value=(0.5, 0.9)), "settings"),
    "groups": (lambda s: s["optimizer"]["param_groups"].append({}), "other settings"),
    "weights_nan": (replaced("network", "heads.bias", value=lambda v: v * np.nan), "heads.bias"),
    "best_nan": (replaced("best", "heads.bias", value=lambda v: v / 0), "heads.bias"),
    "best_shape": (replaced("best", "heads.bias", value=lambda v: v[:1]), "heads.bias: shape"),
    "best_kind": (replaced("best", "heads.bias", value=lambda v: v.half()), "best: .*heads.bias"),
    "best_missing": (lambda s: s["best"].pop("heads.bias"), "best: other tensors"),
    "best_list": (replaced("best", value=[1]), "best: other tensors"),
    "step_large": (replaced("step", value=10**9), "step: 1000000000 of 20"),
    "step_negative": (replaced("step", value=-1), "step: -1"),
    "step_half": (replaced("step", value=1.5), "step: 1.5"),
    "seconds": (replaced("seconds", value=float("nan")), "seconds: nan"),
    "history_none": (replaced("history", value=None), "history: not a list"),
    "history_text": (replaced("history", 0, "validation", value="low"), "history: "),
    "history_nan": (replaced("history", 0, "validation", value=float("nan")), "validation nan"),
    "history_key": (lambda s: s["history"][0].pop("validation"), "history: "),
    "history_twice": (lambda s: s["history"].append(s["history"][0]), "evaluations at steps"),
    "history_later": (replaced("history", 0, "step", value=21), "evaluations at steps"),
}


@pytest.mark.parametrize("fault", UNFIT)
def test_a_checkpoint_that_does_not_fit_its_network_is_refused(
    source, validation, checkpoint, fault
):
    state = torch.load(io.BytesIO(unsealed(checkpoint.read_bytes())), weights_only=True)
    alter, words = UNFIT[fault]
    alter(state)
    write_sealed(checkpoint, state)
    before = checkpoint.read_bytes()
    with pytest.raises(InputError, match=rf"tiny\.pt: a damaged .*{words}.*; delete it") as caught:
        train(TINY, source, validation, replace(SETTINGS, eval_interval=20), checkpoint)
    assert "\n" not in str(caught.value)
    assert checkpoint.read_bytes() == before


class Fixed(Source):
    """The same block again and again."""

    def block(self, seed):
        return super().block([0])


@pytest.mark.parametrize("encoder", ["matching", pytest.param("pair", marks=pytest.mark.full)])
@pytest.mark.few(1)
def test_a_tiny_problem_is_learnt(worlds, encoder):
    architecture = Architecture(0, encoder)
    fixed = Fixed(worlds[:1], architecture, worlds=1, targets=8, vary=False)
    settings = Settings(
        max_steps=100, targets=8, learning_rate=3e-3, warmup_steps=10, eval_interval=10
    )
    block = fixed.block([])
    network, progress = train(architecture, fixed, [block], settings)
    first, last = progress.history[0], progress.history[progress.best]
    assert last["training"] < 0.4 * first["training"]
    outputs, _ = training.outputs_of(network, block)
    kept = block.weight > 0
    error = np.hypot(*(outputs[:, :2].detach().numpy() - block.waypoint)[kept].T)
    assert error.mean() < 0.3 * np.hypot(*block.waypoint[kept].T).mean()
    assert error.mean() == pytest.approx(last["mean"], rel=1e-3)
