"""Localization on made-up maps; the filter against the sum over all histories."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.made_up_maps import sensed, table_map
from tutorial_lib.errors import InputError
from tutorial_lib.topology.localization import (
    OFF_MAP,
    BayesFilter,
    FilterSettings,
    argmax,
    localized,
    match_sequence,
    normalize,
    predict,
    update,
)
from tutorial_lib.topology.motion_model import MotionModel, motion_model, moved, neighbourhoods


@st.composite
def small_worlds(draw):
    """A motion model of few states, motions, likelihoods, and a belief to begin with."""
    count, steps = draw(st.integers(1, 3)) + 1, draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    onward = rng.random((count, count)) * (rng.random((count, count)) < 0.6) + 1e-3
    model = MotionModel(rng.uniform(0.2, 3.0, count), onward / onward.sum(axis=1, keepdims=True))
    motions = rng.choice([0.0, 0.1, 0.5, 2.0], steps)
    likelihoods = rng.choice([0.0, 0.02, 0.5, 1.0], (steps, count)) * rng.uniform(0.5, 1, count)
    belief = rng.random(count) + 1e-3
    return model, motions, likelihoods, belief / belief.sum()


def summed_over_histories(model, motions, likelihoods, belief):
    """The belief by its definition: each sequence of states counts with its probability."""
    count, total = len(belief), np.zeros(len(belief))
    for states in product(range(count), repeat=len(motions) + 1):
        weight = belief[states[0]]
        steps = zip(states, states[1:], motions, likelihoods, strict=False)
        for here, there, motion, likelihood in steps:
            leaves = 1 - np.exp(-motion / model.lengths[here])
            weight *= (here == there) * (1 - leaves) + leaves * model.onward[here, there]
            weight *= likelihood[there]
        total[states[-1]] += weight
    return total / total.sum() if total.sum() > 0 else np.eye(count)[-1]


@settings(max_examples=150, deadline=None)
@given(small_worlds())
def test_the_filter_sums_over_all_histories(world):
    model, motions, likelihoods, start = world
    belief = start[None]
    possible = True
    for motion, likelihood in zip(motions, likelihoods, strict=True):
        prior = predict(belief, [motion], model)
        assert prior.min() >= 0
        assert prior.sum() == pytest.approx(1)
        possible &= (prior[0] * likelihood).sum() > 0
        belief = update(prior, likelihood[None])
        assert belief.min() >= 0
        assert belief.sum() == pytest.approx(1)
    if possible:
        assert np.allclose(belief[0], summed_over_histories(*world), atol=1e-9)


@settings(max_examples=80, deadline=None)
@given(small_worlds())
def test_without_motion_and_with_a_flat_likelihood_nothing_changes(world):
    model, _, _, start = world
    belief = start[None]
    assert np.array_equal(predict(belief, [0.0], model), belief)
    assert np.allclose(update(belief, np.full((1, len(start)), 0.3)), belief, atol=1e-15)


@settings(max_examples=80, deadline=None)
@given(small_worlds())
def test_a_batch_is_as_its_robots_one_by_one(world):
    model, motions, likelihoods, start = world
    beliefs = normalize(start + np.arange(len(motions))[:, None])
    together = update(predict(beliefs, motions, model), likelihoods)
    for row, (motion, likelihood) in enumerate(zip(motions, likelihoods, strict=True)):
        alone = update(predict(beliefs[[row]], [motion], model), likelihood[None])
        assert np.allclose(together[row], alone[0], atol=1e-15)


def test_the_farther_a_robot_goes_the_more_belief_moves_on():
    model = MotionModel(np.array([1.0, 1.0, 1.0]), np.eye(3)[[1, 2, 2]])
    priors = predict(np.tile([1.0, 0.0, 0.0], (3, 1)), [0.0, 0.5, 1.0], model)
    assert np.allclose(priors[:, 0], np.exp([0.0, -0.5, -1.0]))
    assert np.allclose(priors[:, 1], 1 - np.exp([0.0, -0.5, -1.0]))


def test_a_robot_for_which_nothing_is_possible_is_off_the_map():
    assert update(np.array([[1.0, 0.0, 0.0]]), [[0.0, 1.0, 1.0]]).tolist() == [[0, 0, 1]]


def test_argmax_takes_the_most_likely_vertex_and_never_off_the_map():
    assert argmax([[0.1, 0.3, 0.2], [0.0, 0.0, 0.0]]).tolist() == [[0, 1, 0, 0], [1, 0, 0, 0]]


# Sequences.


def by_all_alignments(likelihoods, before):
    """The best mean log over all ways to stay or come along, one by one."""
    count, found = likelihoods.shape[1], np.zeros(likelihoods.shape[1])
    for end in range(count):
        for moves in product([0, 1], repeat=len(likelihoods) - 1):
            vertex, value = end, likelihoods[-1, end]
            for step, move in enumerate(moves):
                vertex = before[vertex] if move and vertex >= 0 else vertex
                value *= likelihoods[-2 - step, vertex] if vertex >= 0 else 0.0
            found[end] = max(found[end], value ** (1 / len(likelihoods)))
    return found


@settings(max_examples=80, deadline=None)
@given(st.integers(1, 4), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_of_all_alignments_the_best_one_counts(looks, count, seed):
    rng = np.random.default_rng(seed)
    before = np.array([rng.integers(-1, i) if i else -1 for i in range(count)])
    likelihoods = rng.choice([0.0, 0.1, 0.5, 0.9], (looks, count))
    found = match_sequence(likelihoods, before)
    assert np.allclose(found, by_all_alignments(likelihoods, before), atol=1e-9)


def test_a_sequence_tells_twins_apart_that_one_view_cannot():
    before = np.array([-1, 0, -1, 2])
    looks = np.array([[0.9, 0.0, 0.1, 0.0], [0.1, 0.8, 0.1, 0.8]])
    assert match_sequence(looks[1:], before).round(3).tolist() == [0.1, 0.8, 0.1, 0.8]
    assert match_sequence(looks, before).argmax() == 1


# The motion model of a map.


def chain(length=1.0, count=4):
    """A map of vertices in a row, so many metres apart, each joined to the next."""
    topomap = table_map(np.ones((count, count)), count)
    topomap.vertices.observations = sensed([[length * i, 0.0, 0.0] for i in range(count)])
    for v in range(count - 1):
        topomap.connect(v, v + 1, 0.9)
    return topomap


def test_edges_have_the_lengths_that_odometry_measured():
    model = motion_model(chain(2.0))
    assert np.allclose(model.lengths[:4], 2.0)
    ahead = model.onward[1]
    assert ahead[2] > 4 * ahead[0] > 0
    assert ahead[2] > 10 * ahead[4] > 0
    assert ahead[3] == 0
    # At the end of the row nothing is ahead.
    assert model.onward[3, 4] > 0.5
    assert np.allclose(model.onward[4], [0.25, 0.25, 0.25, 0.25, 0.0])


def test_between_two_drives_an_edge_has_the_usual_length():
    """The second drive's odometry begins elsewhere: it tells nothing of the first one's."""
    topomap = table_map(np.ones((4, 4)), 4, paths=[[0, 1], [2, 3]])
    x = [0.0, 2.0, 70.0, 72.0]
    topomap.vertices.observations = sensed([[place, 0.0, 0.0] for place in x])
    for edge in ((0, 1), (2, 3), (1, 2)):
        topomap.connect(*edge, 0.9)
    assert np.allclose(motion_model(topomap).lengths[:4], 2.0)


def test_removed_vertices_have_no_column():
    topomap = chain(1.0)
    topomap.remove([1])
    model = motion_model(topomap)
    assert model.onward.shape == (4, 4)
    assert neighbourhoods(topomap, 1).tolist() == [
        [True, False, False],
        [False, True, True],
        [False, True, True],
    ]


def test_an_edge_on_which_a_robot_turns_carries_no_belief():
    topomap, turned = chain(1.0, 8), chain(1.0, 8)
    assert turned.connect_by_turn(1, 6, 0.95, np.pi)
    plain, model = motion_model(topomap), motion_model(turned)
    assert (model.onward == plain.onward).all()
    assert (model.lengths == plain.lengths).all()
    assert (neighbourhoods(turned, 2) == neighbourhoods(topomap, 2)).all()


def test_a_turn_counts_as_a_motion():
    assert moved(np.array([[0.0, 0.0, np.pi]])) == pytest.approx(np.pi / 2)


@pytest.mark.parametrize(
    ("lengths", "onward", "words"),
    [
        ([1.0, 1.0], np.eye(3), "lengths: 2, onward: 3; give as many"),
        ([1.0, 0.0], np.eye(2), "a length is not positive"),
        ([1.0, 1.0], np.ones((2, 2)), "does not sum to one"),
        ([1.0, 1.0], np.array([[2.0, -1.0], [0.0, 1.0]]), "does not sum to one"),
    ],
)
def test_a_wrong_motion_model_is_refused(lengths, onward, words):
    with pytest.raises(InputError, match=words):
        MotionModel(np.array(lengths), onward)


@pytest.mark.parametrize("wrong", [{"stride": 0.0}, {"unknown": 1.0}, {"least": np.nan}])
def test_wrong_settings_are_refused(wrong):
    with pytest.raises(InputError, match=f"filter: {next(iter(wrong))}( =|:) "):
        FilterSettings(**wrong)


# The filter of a fleet.


class Corridor:
    """Vertices a metre apart; the likelihood falls with the distance that the image shows."""

    def __init__(self, twins=(), noise=0.0):
        self.twins, self.rng, self.noise, self.looks = (
            dict(twins),
            np.random.default_rng(0),
            noise,
            0,
        )

    def __call__(self, observations):
        self.looks += len(observations)
        x = observations.image[:, 0, 0, :1]
        places = np.array([self.twins.get(i, i) for i in range(8)], dtype=float)
        clear = np.exp(-np.abs(x - places)) * (x >= -1)
        return np.clip(clear + self.noise * self.rng.normal(size=clear.shape), 0, 1)


def drive(robot_filter, places, odometry, robot=0):
    """What the filter believes at each step."""
    found = []
    for x, pose in zip(places, odometry, strict=True):
        seen = sensed([[x, 0, 0]])
        object.__setattr__(seen, "odometry", np.array([pose], dtype=float))
        robot_filter.observe(seen, np.array([robot]))
        found.append((robot_filter.vertex[robot], robot_filter.belief[robot].copy()))
    return found


def along(*x):
    return [[value, 0.0, 0.0] for value in x]


def test_a_drive_along_the_row_is_followed():
    robot = BayesFilter(2, motion_model(chain(1.0, 8)), Corridor())
    x = np.arange(0.0, 6.0, 0.1)
    found = drive(robot, x, along(*x), robot=1)
    # Between two vertices it keeps to the one behind until the other is clearly more probable.
    gap = x - np.array([vertex for vertex, _ in found])
    assert (gap[3:] > -0.6).all()
    assert (gap[3:] < 1.2).all()
    assert np.allclose(robot.belief[0], 1 / 9)
    assert robot.vertex[0] == OFF_MAP


def test_at_standstill_nothing_flickers_and_no_evidence_counts_twice():
    robot = BayesFilter(1, motion_model(chain(1.0, 8)), Corridor(noise=0.02))
    x = np.arange(0.0, 3.0, 0.1)
    drive(robot, x, along(*x))
    settled = robot.belief[0].max()
    found = drive(robot, np.full(600, 2.5), along(*np.full(600, 2.9)))
    changes = np.count_nonzero(np.diff([vertex for vertex, _ in found]))
    assert changes <= 1
    assert max(belief.max() for _, belief in found) < max(settled, 0.5) + 0.35
    assert robot.sensor.looks > 30


def test_twins_share_the_belief_until_something_else_is_seen():
    robot = BayesFilter(1, motion_model(chain(1.0, 8)), Corridor({5: 1}))
    belief = drive(robot, [1.0], along(0.0))[-1][1]
    assert belief[1] == pytest.approx(belief[5])
    x = np.arange(1.0, 3.0, 0.1)
    vertex, belief = drive(robot, x, along(*(x - 1)))[-1]
    assert vertex in (2, 3)
    assert belief[5:8].sum() < 0.1


def test_a_kidnapped_robot_is_noticed_off_the_map_and_found_again():
    robot = BayesFilter(1, motion_model(chain(1.0, 8)), Corridor())
    x = np.arange(0.0, 2.0, 0.1)
    assert drive(robot, x, along(*x))[-1][0] in (1, 2)
    # Something that no vertex shows.
    odometry = 2.0 + np.arange(0.1, 2.0, 0.1)
    found = drive(robot, np.full(len(odometry), -2.0), along(*odometry))
    assert found[-1][0] == OFF_MAP
    assert found[-1][1][OFF_MAP] > 0.8
    back = np.arange(5.0, 7.0, 0.1)
    assert drive(robot, back, along(*(4 + back - 5.0)))[-1][0] in (6, 7)


def test_localized_waits_for_a_clear_lead():
    belief = np.array([[0.45, 0.5, 0.05], [0.1, 0.2, 0.7], [0.3, 0.5, 0.2]])
    assert localized(belief, np.array([0, 0, OFF_MAP]), 0.8).tolist() == [0, OFF_MAP, 1]


def test_no_view_excludes_a_vertex():
    """What shows one vertex, and nothing of the others, leaves each of those the least."""
    settings = FilterSettings(least=0.05, sharpness=2.0, unknown=0.5)
    sensor = lambda observations: np.eye(8)[[7]]  # noqa: E731
    robot = BayesFilter(1, motion_model(chain(1.0, 8)), sensor, settings)
    belief = drive(robot, [1.0], along(0.0))[-1][1]
    assert np.allclose(belief[:7] / belief[7], 0.05**2)
    assert belief[OFF_MAP] / belief[7] == pytest.approx(0.5**2)


def dues(robot_filter, odometry):
    """At which steps the belief of one robot is new."""
    steps = []
    for number, pose in enumerate(odometry):
        seen = sensed([pose])
        if robot_filter.observe(seen, np.array([0]))[0]:
            steps.append(number)
    return steps


def test_a_slow_robot_is_predicted_each_time_that_it_went_a_stride():
    """Eighths of a metre are exact: two of them are a stride, not less."""
    settings = FilterSettings(stride=0.25, interval=1000)
    robot = BayesFilter(1, motion_model(chain(1.0, 8)), Corridor(), settings)
    assert dues(robot, along(*np.arange(0.0, 1.01, 0.125))) == [0, 2, 4, 6, 8]


def test_a_robot_that_stands_still_looks_again_after_just_the_interval():
    robot = BayesFilter(1, motion_model(chain(1.0, 8)), Corridor(), FilterSettings(interval=3))
    assert dues(robot, along(*np.zeros(8))) == [0, 3, 6]


def test_localized_leaves_a_vertex_that_falls_below_the_share_not_at_it():
    belief = np.array([[0.25, 0.5, 0.25], [0.25, 0.625, 0.125]])
    assert localized(belief, np.array([0, 0]), 0.5).tolist() == [0, 1]
