"""LTVN's model: its label, images with depth, loss, and the shipped networks."""

import numpy as np
import pytest
import torch

from tests.conftest import make_box, needs
from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.errors import InputError
from tutorial_lib.learning.analytic_label import AnalyticLabel
from tutorial_lib.learning.batches import Batch
from tutorial_lib.learning.estimators import RelativeNetwork
from tutorial_lib.learning.losses import relative_loss
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.relative_recipes import with_depth_row
from tutorial_lib.learning.views import DepthView, depth_of, with_depth
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import compose
from tutorial_lib.world import generate
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.visibility import mutual_overlap

VIEW = DepthView()


@pytest.fixture(scope="module")
def room():
    return Scene(make_box(12.0, 8.0, [(6.0, 4.0, 0.75)]))  # a pillar in the middle


def judged(room, start, goal, label=None, geodesic=None):
    starts, goals = np.array([start], float), np.array([goal], float)
    overlap = mutual_overlap(room.caster, starts, goals)
    straight = np.hypot(*(goals - starts)[0, :2]) if geodesic is None else geodesic
    pairs = ReachabilityPairs(starts, np.zeros(1, int), overlap, np.array([straight]))
    label = AnalyticLabel() if label is None else label
    terms = label.terms(room.caster, pairs, goals)
    assert label(room.caster, pairs, goals)[0] == all(held[0] for held in terms.values())
    return {name for name, held in terms.items() if not held[0]}


def test_each_condition_of_the_label(room):
    here = (2.0, 2.0, 0.0)
    assert judged(room, here, (4.0, 2.0, 0.0)) == set()
    assert judged(room, here, (4.0, 2.0, 1.2)) == {"yaw"}
    assert judged(room, here, (0.8, 2.0, 0.0)) == {"bearing"}
    assert judged(room, here, (1.8, 2.0, 0.0)) == set()  # it is there already
    assert "distance" in judged(room, here, (5.5, 2.0, 0.0))
    assert judged(room, here, (4.0, 2.0, 0.0), geodesic=4.0) == {"ratio"}
    assert "sight" in judged(room, (4.6, 4.0, 0.0), (7.4, 4.0, 0.0))
    stricter = AnalyticLabel(arc=0.7)
    assert judged(room, here, (4.0, 2.0, 0.9), stricter) == {"arc"}
    assert judged(room, here, compose(here, (2.0, 1.0, 0.93)), stricter) == set()
    apart = AnalyticLabel(yaw=np.pi, bearing=np.pi)
    assert "overlap" in judged(room, (2.0, 2.0, np.pi), (3.0, 2.0, 0.0), apart)


@pytest.mark.parametrize("name", ["overlap", "ratio", "distance", "yaw", "bearing", "arc"])
def test_thresholds_of_the_label_are_checked(name):
    with pytest.raises(InputError, match=f"^{name}"):
        AnalyticLabel(**{name: -1.0})


def images(count=6):
    scene = Scene(generate("apartment", 1))
    rng = np.random.default_rng(0)
    free = np.argwhere(scene.clearance.clearance > 0.4)
    places = scene.clearance.centres(free[rng.choice(len(free), count)])
    poses = np.column_stack([places, rng.uniform(-np.pi, np.pi, count)])
    return scene, poses, *Camera().look(scene, poses)


def test_depth_is_kept_to_the_millimetre():
    scene, poses, image, depth = images()
    both = VIEW.render(scene, poses)
    np.testing.assert_array_equal(both, with_depth(image, depth))
    np.testing.assert_array_equal(both[:, :-1], image)
    np.testing.assert_allclose(depth_of(both), depth, atol=6e-4)
    none = np.zeros(len(image))
    seen = Observation(image, depth, none[:, None], poses, none, none)
    np.testing.assert_array_equal(VIEW.of(seen), both)
    numbers = VIEW.numbers(both)
    assert numbers.shape == (6, 3, 17, 64)
    assert numbers.abs().max() < 4
    with pytest.raises(InputError, match="depth: none"):
        VIEW.of(Observation(image, None, none[:, None], poses, none, none))


def test_other_colours_leave_depth_as_it_is():
    scene, poses, *_ = images()
    both = VIEW.render(scene, poses)
    (varied,) = VIEW.vary([both], np.random.default_rng(0))
    np.testing.assert_array_equal(varied[:, -1], both[:, -1])
    assert (varied[:, :-1] != both[:, :-1]).any()


def test_a_network_with_a_row_for_depth_begins_as_the_one_without():
    torch.manual_seed(0)
    plain = LocalNetwork(Architecture(1)).eval()
    deep = with_depth_row(plain, Architecture(1, view="rgbd16", outputs="relative")).eval()
    scene, poses, image, _ = images()
    both = VIEW.numbers(VIEW.render(scene, poses))
    colours = plain.architecture.looks_at.numbers(image)
    contexts = [some[:, None].expand(-1, 3, -1, -1, -1) for some in (both, colours)]
    with torch.inference_mode():
        one, other = deep(both, contexts[0]), plain(colours, contexts[1])
    torch.testing.assert_close(one, other)


def batch(reached):
    count, zero = len(reached), np.zeros((len(reached), 2), np.float32)
    ones = np.ones(count, np.float32)
    turn = np.tile(np.array([1.0, 0.0], np.float32), (count, 1))
    poses = np.zeros((count, 1, 4), np.float32)
    rest = (zero, poses, zero[:, :0], np.asarray(reached, np.float32), ones, ones)
    return Batch(zero, zero, zero, turn, *rest)


def test_only_reachable_pairs_teach_where_a_target_is():
    outputs = torch.randn(2, 5, requires_grad=True)
    relative_loss(outputs, batch([1.0, 0.0])).sum().backward()
    assert (outputs.grad[0] != 0).all()
    assert outputs.grad[1, 0] != 0
    assert (outputs.grad[1, 1:] == 0).all()


@needs("relative_5")
def test_the_shipped_model_knows_near_from_far_and_where():
    scene, poses, *_ = images(40)
    ahead = compose(poses, np.tile([0.6, 0.05, 0.2], (40, 1)))
    free = scene.clearance.at(ahead[:, :2]) > 0.3
    poses, ahead = poses[free], ahead[free]
    model, none = RelativeNetwork("relative_5"), np.zeros(len(poses))
    seen = Observation(*Camera().look(scene, poses), none[:, None], poses, none, none)
    targets = model.prepare(np.repeat(VIEW.render(scene, ahead)[:, None], 11, axis=1))
    near, waypoints = model.predict(seen, targets)
    far, _ = model.predict(seen, targets[np.roll(np.arange(len(poses)), 5)])
    assert np.median(near) > 0.9
    assert np.median(far) < 0.05
    off = np.hypot(waypoints[:, 0] - 0.6, waypoints[:, 1] - 0.05)
    assert np.median(off) < 0.1
    assert np.median(np.abs(waypoints[:, 2] - 0.2)) < np.deg2rad(5)
