"""The follower's transitions with fakes in a corridor of numbers; see also test_follower_worlds."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Controller, Observation, Reachability, WaypointPredictor
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.heading_search import HeadingSearch
from tutorial_lib.topology.following.transitions import (
    FollowerSettings,
    State,
    found_again,
    last_visited,
    next_active,
)

SEARCH, FOLLOW, RECKON, LOST, DONE, TURN = State


class Corridor:
    """Robots on a line. Each knows where it is, which its depth holds, and sees nothing else."""

    def __init__(self, starts):
        self.x = np.array(starts, dtype=float)
        self.odometer, self.speed = np.zeros(len(self.x)), np.zeros(len(self.x))

    def observe(self, robots):
        count, nothing = len(robots), np.zeros(len(robots))
        odometry = np.column_stack([self.odometer[robots], nothing, nothing])
        image, laser = np.zeros((count, 1, 1, 3), np.uint8), np.ones((count, 4))
        depth = self.x[robots, None]
        return Observation(image, depth, laser, odometry, self.speed[robots], nothing)

    def step(self, actions, robots):
        self.speed[:] = 0.0
        self.speed[robots] = actions[:, 0]
        self.x += 0.1 * self.speed
        self.odometer += 0.1 * self.speed


class CorridorPredictor:
    """Predicts the waypoint at an anchor, a place in the corridor; its overlap fades over 3 m."""

    view, k = None, 0

    def __init__(self):
        self.queries = 0

    def prepare(self, contexts):
        return contexts

    def predict(self, observations, targets):
        self.queries += len(targets)
        gap = targets - observations.depth[:, 0]
        overlap = np.clip(1 - np.abs(gap) / 3, 0, 1)
        return np.column_stack([gap, 0 * gap]), np.column_stack([overlap, overlap])


class CorridorReachability:
    """Sure within `far` metres, unless something else is arranged."""

    def __init__(self, far=2.0):
        self.far, self.queries, self.arranged = far, 0, lambda probabilities, targets: probabilities

    def prepare(self, targets):
        return targets

    def probability(self, observations, prepared):
        self.queries += len(prepared)
        gap = np.abs(prepared - observations.depth[:, 0])
        return self.arranged(np.where(gap < self.far, 0.99, 0.01), prepared)


class CorridorController:
    """Half a metre a second towards the waypoint."""

    def act(self, observations, waypoints):
        assert len(waypoints) == len(observations)
        return np.column_stack([np.clip(5 * waypoints[:, 0], -0.5, 0.5), 0 * waypoints[:, 1]])


def make(anchors=range(9), starts=(0.0,), reachability=None, first=0, paths=None, **settings):
    """A corridor, and a follower in which every robot follows the same anchors."""
    anchors = np.array(anchors, dtype=float)
    reachability = CorridorReachability() if reachability is None else reachability
    settings = FollowerSettings(**settings)
    parts = CorridorPredictor(), CorridorController(), reachability, settings
    paths = [np.arange(len(anchors))] * len(starts) if paths is None else paths
    firsts = None if first is None else np.full(len(starts), first)
    paths = AnchorPaths(anchors, reachability.prepare(anchors), paths)
    follower = Follower(paths, *parts, firsts)
    return Corridor(starts), follower


def go(corridor, follower, steps, robots=None):
    robots = np.arange(len(corridor.x)) if robots is None else np.array(robots)
    for _ in range(steps):
        corridor.step(follower.act(corridor.observe(robots), robots), robots)


def states(follower, robot=0):
    """The states that a robot went through, each once in a row."""
    found = follower.log().state[:, robot]
    return [State(found[0])] + [State(b) for a, b in pairwise(found) if a != b]


def test_the_fakes_fit_the_seams():
    assert isinstance(CorridorPredictor(), WaypointPredictor)
    assert isinstance(CorridorReachability(), Reachability)
    assert isinstance(CorridorController(), Controller)


# Search.


@pytest.mark.parametrize(("start", "best"), [(0.1, 0), (3.4, 3), (8.0, 8)])
def test_search_takes_the_anchor_that_is_reached_most_surely(start, best):
    reachability = CorridorReachability()
    reachability.arranged = lambda p, targets: np.where(np.abs(targets - start) < 0.5, 0.995, p)
    corridor, follower = make(starts=[start], reachability=reachability, first=None)
    assert follower.memory.state[0] == SEARCH
    go(corridor, follower, 1)
    assert follower.memory.state[0] == FOLLOW
    assert follower.memory.active[0] in (best, best + 1)


def test_search_gives_up_where_nothing_can_be_reached():
    corridor, follower = make(starts=[20.0], first=None)
    go(corridor, follower, 30)
    assert follower.memory.lost.tolist() == [True]
    assert corridor.x[0] == 20.0
    assert states(follower) == [LOST]


def test_p_search_is_what_it_takes():
    for p_search, found in ((0.98, True), (0.99, False)):
        corridor, follower = make(first=None, p_search=p_search)
        go(corridor, follower, 1)
        assert follower.memory.lost[0] != found


def test_a_known_start_is_not_searched_for():
    corridor, follower = make(starts=[4.6], first=5)
    assert (follower.memory.state[0], follower.memory.active[0], follower.memory.visited[0]) == (
        FOLLOW,
        5,
        4,
    )
    go(corridor, follower, 100)
    assert follower.memory.done[0]
    assert SEARCH not in states(follower)


# Follow.


def test_it_follows_to_the_end_and_says_so():
    corridor, follower = make()
    go(corridor, follower, 200)
    assert follower.memory.done.tolist() == [True]
    assert not follower.memory.lost[0]
    assert corridor.x[0] == pytest.approx(8.0, abs=0.25)
    assert states(follower) == [FOLLOW, DONE]
    record = follower.log()
    assert (np.diff(record.active[:, 0]) >= 0).all()
    assert (np.diff(record.visited[:, 0]) >= 0).all()
    assert record.visited[-1, 0] == 8


def test_a_robot_that_has_arrived_stands_still():
    corridor, follower = make()
    go(corridor, follower, 200)
    there = corridor.x[0]
    go(corridor, follower, 20)
    assert corridor.x[0] == there


def test_a_moment_at_the_goal_is_not_yet_an_arrival():
    corridor, follower = make(anchors=[0.0, 0.1], starts=[0.0], first=1, confirm=4)
    go(corridor, follower, 3)
    assert not follower.memory.done[0]
    go(corridor, follower, 1)
    assert follower.memory.done[0]


def test_one_anchor_is_a_path():
    corridor, follower = make(anchors=[1.5])
    go(corridor, follower, 80)
    assert follower.memory.done[0]
    assert corridor.x[0] == pytest.approx(1.5, abs=0.25)


def test_it_drives_backwards_if_that_is_where_the_anchor_is():
    corridor, follower = make(anchors=[-1.5], starts=[0.0])
    go(corridor, follower, 80)
    assert follower.memory.done[0]


def test_at_an_anchor_one_gets_on_though_the_next_one_is_out_of_reach():
    corridor, follower = make(anchors=[0.0, 2.5, 5.0])
    go(corridor, follower, 200)
    assert follower.memory.done[0]
    assert RECKON not in states(follower) or corridor.x[0] == pytest.approx(5.0, abs=0.25)


def test_a_waypoint_that_is_followed_is_kept_in_the_odometer_s_frame():
    corridor, follower = make(anchors=[0.0, 1.5, 3.0], starts=[0.0])
    corridor.odometer[:] = 7.0
    go(corridor, follower, 5)
    assert follower.log().waypoint[-1, 0] == pytest.approx([7.0 + 1.5, 0.0])


# Dead reckoning.


def blind(reachability, targets=None):
    """Let RE predict low probabilities for all anchors, or for those given."""
    reachability.arranged = lambda p, t: np.where(
        np.isin(t, targets) if targets is not None else True, 0.05, p
    )


def test_dead_reckoning_drives_to_the_last_waypoint_and_no_farther():
    reachability = CorridorReachability()
    corridor, follower = make(anchors=[0.0, 1.9, 3.8], reachability=reachability)
    go(corridor, follower, 8)
    active = follower.memory.active[0]
    assert active == 1
    blind(reachability)
    go(corridor, follower, 35)
    assert follower.memory.state[0] == RECKON
    assert follower.memory.active[0] == active
    assert corridor.x[0] == pytest.approx(1.9, abs=0.01)


def test_it_goes_by_the_odometer_alone():
    reachability = CorridorReachability()
    corridor, follower = make(anchors=[0.0, 1.9, 3.8], reachability=reachability)
    go(corridor, follower, 8)
    blind(reachability)
    go(corridor, follower, 1)
    corridor.x += 0.3  # pushed, which no odometer notices
    go(corridor, follower, 35)
    assert corridor.x[0] == pytest.approx(2.2, abs=0.01)


def test_out_of_time_it_is_lost_and_stops():
    reachability = CorridorReachability()
    corridor, follower = make(reachability=reachability, timeout=2.0)
    go(corridor, follower, 15)
    blind(reachability)
    go(corridor, follower, 19)
    assert follower.memory.state[0] == RECKON
    go(corridor, follower, 1)
    assert follower.memory.lost[0]
    there = corridor.x[0]
    reachability.arranged = lambda p, t: p
    go(corridor, follower, 30)
    assert follower.memory.lost[0]
    assert corridor.x[0] == there
    assert states(follower) == [FOLLOW, RECKON, LOST]


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_it_is_back_after_enough_good_steps_in_a_row(steps):
    reachability = CorridorReachability()
    corridor, follower = make(reachability=reachability, confirm=steps)
    go(corridor, follower, 8)
    blind(reachability)
    go(corridor, follower, 4)
    reachability.arranged = lambda p, t: p
    go(corridor, follower, steps - 1)
    assert follower.memory.state[0] == RECKON
    go(corridor, follower, 1)
    assert follower.memory.state[0] == FOLLOW
    go(corridor, follower, 200)
    assert follower.memory.done[0]


def test_good_steps_that_are_not_in_a_row_do_not_count():
    reachability = CorridorReachability()
    corridor, follower = make(reachability=reachability)
    go(corridor, follower, 8)
    blind(reachability)
    go(corridor, follower, 2)
    for _ in range(6):
        reachability.arranged = lambda p, t: p
        go(corridor, follower, 2)
        blind(reachability)
        go(corridor, follower, 2)
    assert set(states(follower)[1:]) == {RECKON}


def test_anchors_far_apart_that_look_reachable_by_chance_do_not_count():
    reachability = CorridorReachability()
    corridor, follower = make(
        anchors=np.arange(0, 12, 1.2), reachability=reachability, starts=[5.0]
    )
    follower.memory.active[:], follower.memory.visited[:] = 5, 4
    go(corridor, follower, 2)
    active = int(follower.memory.active[0])
    for step in range(36):
        # Now two behind the active one, now three ahead of it.
        chance = 1.2 * (active + (3 if step % 2 else -1))
        reachability.arranged = lambda p, t, c=chance: np.where(np.isclose(t, c), 0.99, 0.05)
        go(corridor, follower, 1)
    assert follower.memory.state[0] == RECKON


def test_the_lookout_widens_by_an_anchor_a_step_and_leaves_out_what_was_visited():
    reachability = CorridorReachability()
    corridor, follower = make(
        anchors=np.arange(0, 6, 0.5), reachability=reachability, widest=3, visited=0.95
    )
    follower.memory.active[:], follower.memory.visited[:] = 5, 2
    corridor.x[:] = 1.75
    go(corridor, follower, 1)
    queried = []

    def watch(p, targets):
        queried.append(sorted((2 * targets).astype(int).tolist()))
        return np.full(len(p), 0.05)

    reachability.arranged = watch
    before = int(follower.memory.active[0])
    go(corridor, follower, 1)
    assert queried.pop() == [before, before + 1]
    active, visited = int(follower.memory.active[0]), int(follower.memory.visited[0])
    assert visited < active - 1
    go(corridor, follower, 5)
    for width, anchors in zip([0, 1, 2, 3, 3], queried, strict=True):
        first = max(visited + 1, active - width)
        wanted = range(first, active + max(width, 1) + 1)
        assert anchors == list(wanted)


def test_pushed_ahead_it_goes_on_from_where_it_is():
    corridor, follower = make(anchors=np.arange(0, 12, 1.2))
    go(corridor, follower, 10)
    corridor.x += 3.6
    go(corridor, follower, 250)
    assert follower.memory.done[0]
    assert RECKON in states(follower)


def test_stalled_time_is_forgotten_only_after_a_calm():
    reachability = CorridorReachability()
    corridor, follower = make(anchors=range(30), reachability=reachability, timeout=2.0, calm=1.0)
    for _ in range(3):
        go(corridor, follower, 20)
        blind(reachability)
        go(corridor, follower, 12)
        reachability.arranged = lambda p, t: p
        go(corridor, follower, 5)
        assert follower.memory.state[0] == FOLLOW
    # With hardly a moment in Follow between them they add up.
    for _ in range(3):
        blind(reachability)
        go(corridor, follower, 8)
        reachability.arranged = lambda p, t: p
        go(corridor, follower, 4)
    assert follower.memory.lost[0]


def test_a_moment_in_follow_is_no_calm():
    reachability = CorridorReachability()
    settings = {"timeout": 2.5, "calm": 1.0, "confirm": 2}
    corridor, follower = make(anchors=range(30), reachability=reachability, **settings)
    go(corridor, follower, 20)
    found = []
    for _ in range(3):  # each time 1 s of doubts, and half a second without
        blind(reachability)
        go(corridor, follower, 8)
        reachability.arranged = lambda p, t: p
        go(corridor, follower, 6)
        found.append(State(follower.memory.state[0]))
    assert found == [FOLLOW, FOLLOW, LOST]


def test_between_p_lose_and_p_follow_it_drives_on_by_sight():
    reachability = CorridorReachability()
    corridor, follower = make(reachability=reachability, p_lose=0.4)
    go(corridor, follower, 5)
    active = follower.memory.active[0]
    reachability.arranged = lambda p, t: np.minimum(p, 0.5)
    go(corridor, follower, 4)
    assert follower.memory.state[0] == FOLLOW
    assert follower.memory.active[0] == active
    reachability.arranged = lambda p, t: np.minimum(p, 0.35)
    go(corridor, follower, 1)
    assert follower.memory.state[0] == RECKON


@pytest.mark.parametrize(("probability", "place"), [(0.3, 2.0), (0.1, 1.2)])
def test_at_the_end_of_dead_reckoning_it_tries_what_may_be_reached(probability, place):
    reachability = CorridorReachability()
    settings = {"p_lose": 0.4, "p_try": 0.2, "timeout": 7.0}
    corridor, follower = make([2.0, 6.0], reachability=reachability, **settings)
    go(corridor, follower, 10)
    reachability.arranged = lambda p, t: np.full_like(p, probability)
    go(corridor, follower, 1)
    assert follower.memory.state[0] == RECKON
    corridor.x -= 0.8  # pushed back, which no odometer notices
    go(corridor, follower, 80)
    assert follower.memory.lost[0]  # all the same
    assert corridor.x[0] == pytest.approx(place, abs=0.06)


class Stuck(CorridorController):
    """Does not move."""

    def act(self, observations, waypoints):
        return 0.0 * super().act(observations, waypoints)


@pytest.mark.parametrize("shape", [(2,), (1, 2), (2, 3)])
def test_actions_of_another_shape_are_refused(shape):
    corridor, follower = make(starts=[0.0, 1.0])
    follower.controller = SimpleNamespace(act=lambda *_: np.zeros(shape))
    with pytest.raises(InputError, match=r"actions: shape .*; give real numbers of shape \(2, 2\)"):
        go(corridor, follower, 1)


def test_an_anchor_that_comes_no_nearer_is_left_as_it_is():
    corridor, follower = make(anchors=[1.0, 1.5, 9.0], effort=2.0)
    follower.controller = Stuck()
    go(corridor, follower, 20)
    assert follower.memory.active[0] == 0
    go(corridor, follower, 3)
    assert follower.memory.active[0] == 1


def test_a_robot_that_is_stuck_is_lost_in_the_end():
    corridor, follower = make(anchors=[1.0], effort=2.0, timeout=3.0)
    follower.controller = Stuck()
    go(corridor, follower, 48)
    assert follower.memory.state[0] == FOLLOW
    go(corridor, follower, 4)
    assert follower.memory.lost[0]


# Turning.


class Turntable(Corridor):
    """Robots that stand and only turn, at half a rad a second; depth holds their headings."""

    def step(self, actions, robots):
        self.x[robots] += 0.05 * np.sign(actions[:, 1])


class TurntablePredictor:
    """All anchors are about here, and are seen the less, the more they look elsewhere."""

    def predict(self, observations, targets):
        off = targets - observations.depth[:, 0]
        overlap = np.clip(1 - 0.4 * np.abs(off), 0, 1)
        aside = np.column_stack([np.zeros(len(off)), 0.05 * np.sign(off)])
        return aside, np.column_stack([overlap, overlap])


class TurntableReachability(CorridorReachability):
    """Whoever is there has reached an anchor; of others it must see something."""

    def __init__(self, hidden=()):
        super().__init__()
        self.hidden = hidden

    def probability(self, observations, prepared):
        off = np.abs(prepared - observations.depth[:, 0])
        return np.where(np.isin(prepared, self.hidden) & (off > 2.4), 0.01, 0.99)


class Steering:
    """Turns to the side on which the waypoint is."""

    def act(self, observations, waypoints):
        assert len(observations) == len(waypoints)
        return np.column_stack([np.zeros(len(waypoints)), waypoints[:, 1]])


def make_turntable(anchors, hidden, start=0.0, **settings):
    anchors = np.array(anchors, dtype=float)
    parts = TurntablePredictor(), Steering(), TurntableReachability(hidden)
    paths = AnchorPaths(anchors, anchors, [range(len(anchors))])
    return Turntable([start]), Follower(paths, *parts, FollowerSettings(**settings), [0])


@pytest.mark.parametrize("heading", [1.3, -1.3])
def test_at_an_anchor_it_turns_to_where_the_next_one_can_be_seen(heading):
    table, follower = make_turntable([0.0, heading, 1.9 * heading], hidden=[1.9 * heading])
    go(table, follower, 80)
    assert follower.memory.done[0]
    assert table.x[0] == pytest.approx(1.9 * heading, abs=0.9)
    assert states(follower) == [FOLLOW, DONE]
    assert follower.log().waypoint[1, 0].tolist() == [0.0, np.sign(heading)]


def test_whoever_sees_the_next_anchor_need_not_turn():
    table, follower = make_turntable([0.0, 1.3, 0.0], hidden=[])
    go(table, follower, 10)
    assert follower.memory.done[0]
    assert table.x[0] == 0.0


def test_at_the_goal_it_turns_to_the_heading_of_the_goal():
    table, follower = make_turntable([0.0, 1.4], hidden=[])
    go(table, follower, 60)
    assert follower.memory.done[0]
    assert table.x[0] == pytest.approx(1.4, abs=0.9)


def test_turning_that_does_not_help_comes_to_an_end():
    table, follower = make_turntable([0.0, 1.3, 2.6], hidden=[2.6], effort=1.5)
    table.step = lambda actions, robots: None  # it cannot
    go(table, follower, 14)
    assert follower.memory.active[0] == 1
    go(table, follower, 4)
    assert follower.memory.active[0] == 2


def turn(turning, overlap, at=True, gap=0.0, wants=True, first=1):
    """One step of one robot; the side to which it turns."""
    row = [np.array([value]) for value in (wants, at, float(gap), overlap, first)]
    turning.decide(np.array([0]), *row)
    return int(turning.side[0])


def test_it_turns_back_when_the_overlap_shrinks():
    turning = HeadingSearch(1)
    assert [turn(turning, overlap) for overlap in (0.5, 0.48, 0.45)] == [1, 1, 1]
    assert turn(turning, 0.41) == -1
    assert [turn(turning, overlap) for overlap in (0.36, 0.45, 0.6)] == [-1, -1, -1]
    assert turn(turning, 0.7, wants=False) == 0


def test_it_begins_at_the_anchor_and_goes_on_near_it():
    turning = HeadingSearch(1)
    assert turn(turning, 0.5, at=False, gap=0.4) == 0
    assert turn(turning, 0.5, first=-1) == -1
    assert turn(turning, 0.5, at=False, gap=0.4) == -1
    assert turn(turning, 0.5, at=False, gap=1.0) == 0


def test_only_coming_nearer_is_getting_on():
    turning = HeadingSearch(1)
    for gap in (1.0, 0.9, 0.8):
        turn(turning, 0.5, gap=gap, at=False, wants=False)
    assert turning.tried[0] == 0.0
    for gap in (0.79, 0.9, 0.79):
        turn(turning, 0.5, gap=gap, at=False, wants=False)
    assert turning.tried[0] == pytest.approx(0.3)
    turning.begin(np.array([0]))
    assert turning.tried[0] == 0.0


def test_a_robot_that_turns_gets_a_waypoint_beside_it():
    turning = HeadingSearch(3)
    turning.side[:] = [0, 1, -1]
    waypoints = turning.waypoints(np.array([2, 0, 1]), np.full((3, 2), 7.0))
    assert waypoints.tolist() == [[0.0, -1.0], [7.0, 7.0], [0.0, 1.0]]


# Fleets.


def flickering(probabilities, targets):
    """RE with wrong predictions for some anchors, which depend on the pair alone."""
    return np.where(np.sin(91.0 * targets + 1e3 * probabilities) > 0.9, 0.1, probabilities)


def fleet(**extra):
    rng = np.random.default_rng(3)
    paths = [np.arange(first, 12) for first in rng.integers(0, 6, 8)]
    starts = np.array([path[0] for path in paths]) + rng.uniform(-0.5, 0.5, 8)
    reachability = CorridorReachability()
    reachability.arranged = flickering
    return make(np.arange(12) * 1.0, starts, reachability, paths=paths, first=None, **extra), paths


def test_a_fleet_does_as_each_robot_alone():
    (corridor, follower), paths = fleet()
    go(corridor, follower, 120)
    together = follower.log()
    for robot, path in enumerate(paths):
        (many, _), _ = fleet()
        reachability = CorridorReachability()
        reachability.arranged = flickering
        one, alone = make(np.arange(12.0), [many.x[robot]], reachability, paths=[path], first=None)
        go(one, alone, 120)
        assert one.x[0] == corridor.x[robot]
        record = alone.log()
        for name in ("state", "active", "visited", "probability", "overlap", "waypoint"):
            theirs = getattr(together, name)[:, robot]
            assert np.array_equal(getattr(record, name)[:, 0], theirs, equal_nan=name > "b")


def test_the_same_run_twice_is_the_same():
    records = []
    for _ in range(2):
        (corridor, follower), _ = fleet()
        go(corridor, follower, 60)
        records.append(follower.log())
    assert all(
        getattr(records[0], name).tobytes() == getattr(records[1], name).tobytes()
        for name in ("state", "active", "probability", "waypoint")
    )


def test_only_given_robots_go_on():
    corridor, follower = make(starts=[0.0, 0.0, 0.0])
    go(corridor, follower, 10, robots=[0, 2])
    assert corridor.x[1] == 0.0
    assert corridor.x[0] == corridor.x[2] > 0.3
    assert (follower.log().active[:, 1] == 0).all()
    assert np.isnan(follower.log().probability[:, 1]).all()
    go(corridor, follower, 200, robots=[1])
    assert follower.memory.done.tolist() == [False, True, False]


def test_no_robot_under_way_is_no_trouble():
    corridor, follower = make()
    assert follower.act(
        corridor.observe(np.array([], dtype=int)), np.array([], dtype=int)
    ).shape == (
        0,
        2,
    )
    assert len(follower.log()) == 1


def test_a_step_takes_few_questions():
    corridor, follower = make(starts=np.zeros(5), anchors=range(40))
    go(corridor, follower, 10)
    before = follower.predictor.queries, follower.reachability.queries
    go(corridor, follower, 100)
    assert (follower.memory.state == FOLLOW).all()
    assert (follower.predictor.queries - before[0]) / 500 <= 3
    assert (follower.reachability.queries - before[1]) / 500 <= 2


def test_robots_may_share_anchors_and_visit_them_in_any_order():
    paths = [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [2], [1, 2, 1, 2, 3]]
    corridor, follower = make(np.arange(5) * 1.0, [0.0, 4.0, 2.5, 1.0], paths=paths)
    go(corridor, follower, 250)
    assert follower.memory.done.all()
    assert corridor.x == pytest.approx([4.0, 0.0, 2.0, 3.0], abs=0.25)


def test_paths_lie_end_to_end():
    paths = AnchorPaths.end_to_end(np.zeros(7), np.zeros(7), [2, 4, 1])
    assert [list(path) for path in paths.paths] == [[0, 1], [2, 3, 4, 5], [6]]
    assert paths.lengths.tolist() == [2, 4, 1]
    assert len(paths) == 3


# Setting out anew.


def test_a_robot_that_was_lost_starts_on_another_path():
    reachability = CorridorReachability()
    corridor, follower = make(reachability=reachability, timeout=2.0)
    go(corridor, follower, 15)
    blind(reachability)
    go(corridor, follower, 25)
    assert follower.memory.lost[0]
    reachability.arranged = lambda p, t: p
    follower.assign(0, [1, 0])
    assert (follower.memory.state[0], follower.memory.active[0], follower.memory.visited[0]) == (
        FOLLOW,
        0,
        -1,
    )
    go(corridor, follower, 100)
    assert follower.memory.done[0]
    assert corridor.x[0] == pytest.approx(0.0, abs=0.25)
    assert states(follower) == [FOLLOW, RECKON, LOST, FOLLOW, DONE]


def test_a_robot_that_has_arrived_starts_again():
    corridor, follower = make(anchors=range(5), paths=[[1, 2]])
    go(corridor, follower, 60)
    assert follower.memory.done[0]
    follower.assign(0, np.array([3, 4]))
    assert not follower.memory.over[0]
    go(corridor, follower, 100)
    assert follower.memory.done[0]
    assert corridor.x[0] == pytest.approx(4.0, abs=0.25)


def test_only_the_one_that_sets_out_is_concerned():
    (together, follower), (alone, other) = (make(starts=[0.0, 0.0, 0.0]) for _ in range(2))
    for corridor, some in ((together, follower), (alone, other)):
        go(corridor, some, 20)
    follower.assign(1, [4, 3, 2, 1, 0])
    for corridor, some in ((together, follower), (alone, other)):
        go(corridor, some, 150)
    assert together.x[[0, 2]].tolist() == alone.x[[0, 2]].tolist()
    assert together.x[1] == pytest.approx(0.0, abs=0.25)
    assert follower.paths.lengths.tolist() == [9, 5, 9]
    one, two = follower.log(), other.log()
    assert (one.active[:, [0, 2]] == two.active[:, [0, 2]]).all()
    assert np.array_equal(one.waypoint[:, [0, 2]], two.waypoint[:, [0, 2]], equal_nan=True)


def test_stalled_time_is_left_behind_when_one_sets_out_anew():
    reachability = CorridorReachability()
    corridor, follower = make(anchors=range(30), reachability=reachability, timeout=2.0)
    for _ in range(4):  # each time all but lost
        go(corridor, follower, 10)
        blind(reachability)
        go(corridor, follower, 16)
        assert follower.memory.state[0] == RECKON
        reachability.arranged = lambda p, t: p
        follower.assign(0, np.arange(round(corridor.x[0]), 30))
        assert follower.memory.state[0] == FOLLOW
    go(corridor, follower, 10)
    assert not follower.memory.lost[0]


def test_the_old_waypoint_is_forgotten():
    # Dead reckoning begins at once; what it drives to must belong to the new path.
    reachability = CorridorReachability()
    corridor, follower = make(anchors=[0.0, 1.5, -1.5], paths=[[1]], reachability=reachability)
    go(corridor, follower, 8)
    assert corridor.x[0] > 0.2
    follower.assign(0, [2])
    blind(reachability)
    go(corridor, follower, 10)
    assert follower.log().waypoint[-1, 0, 0] == pytest.approx(-1.5)
    assert corridor.speed[0] < 0


@pytest.mark.parametrize("path", [[9], [-1], [], [0.5], [[0]]])
@pytest.mark.few(2)
def test_a_path_beyond_the_anchors_is_refused_and_changes_nothing(path):
    corridor, follower = make(starts=[0.0, 0.0])
    go(corridor, follower, 10)
    before = follower.memory.active.copy(), follower.paths
    with pytest.raises(InputError, match="paths: path 1 is"):
        follower.assign(1, path)
    assert (follower.memory.active == before[0]).all()
    assert follower.paths is before[1]
    go(corridor, follower, 200)
    assert follower.memory.done.all()


# The rules one by one.


def test_what_was_visited_never_goes_back():
    overlaps = [[0.9, 0.1, 0.1], [0.1, 0.9, 0.1], [0.1, 0.1, 0.9], [np.nan, 0.7, np.nan]]
    at = np.zeros(4, bool)
    found = last_visited(np.array([3, 3, 3, 3]), np.array([4, 4, 4, 4]), overlaps, at, 0.8)
    assert found.tolist() == [3, 4, 5, 3]
    assert last_visited(np.array([9]), np.array([4]), overlaps[1:2], at[:1], 0.8).tolist() == [9]


def test_no_robot_goes_beyond_the_last_anchor():
    settings = FollowerSettings()
    assert next_active([4], [4], [np.nan], [np.nan], settings).tolist() == [4]
    assert next_active([4], [4], [0.0], [0.0], settings).tolist() == [5]


def test_the_nearest_anchor_wins_and_of_two_the_one_ahead():
    row = [np.nan, 0.95, 0.2, 0.95, 0.99]
    assert found_again(np.array([7]), [row], 0.92).tolist() == [8]
    assert found_again(np.array([7]), [[0.99, 0.2, 0.1, 0.2, 0.99]], 0.92).tolist() == [9]
    assert found_again(np.array([7]), [[0.99, 0.95, 0.93, 0.99, 0.99]], 0.92).tolist() == [7]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"p_follow": 1.0}, "p_follow = 1.0; give a number between 0 and 1"),
        ({"p_search": 0.0}, "p_search = 0.0; give a number between"),
        ({"near": np.nan}, "near: nan; give one real number"),
        ({"confirm": 0}, "confirm: 0; give one whole number from 1 on"),
        ({"confirm": 2.5}, "confirm: 2.5; give one whole number"),
        ({"widest": -1}, "widest: -1; give one whole number"),
        ({"timeout": -1.0}, "timeout = -1.0; give a finite number"),
        ({"timeout": np.inf}, "timeout: inf; give one real number"),
        ({"fall": 0.0}, "fall = 0.0; give a number above 0, at most 1"),
        ({"fall": 1.1}, "fall = 1.1; give"),
        ({"p_lose": 0.95}, "p_lose = 0.95, p_follow = 0.92"),
    ],
)
def test_settings_that_make_no_sense_are_refused(values, words):
    with pytest.raises(InputError, match=words):
        FollowerSettings(**values)


# What can go wrong.


@pytest.mark.parametrize(
    ("targets", "prepared", "paths", "words"),
    [
        (np.zeros(3), np.zeros(2), [[0]], "3 targets but 2 prepared"),
        (np.zeros(3), np.zeros(3), [], "none; give one path"),
        (np.zeros(3), np.zeros(3), [[0], []], "path 1 is .*L >= 1"),
        (np.zeros(3), np.zeros(3), [[0, 3]], "path 0 is .0 3.; anchors are 0 to 2"),
        (np.zeros(3), np.zeros(3), [[-1]], "anchors are 0 to 2"),
        (np.zeros(3), np.zeros(3), [[0.5]], "give .L,. indices"),
        (np.zeros(3), np.zeros(3), [[[0]]], "give .L,. indices"),
    ],
)
def test_paths_that_lead_nowhere_are_refused(targets, prepared, paths, words):
    with pytest.raises(InputError, match=f"paths: .*{words}"):
        AnchorPaths(targets, prepared, paths)


@pytest.mark.parametrize("starts", [[9], [-2], [0, 0], [0.5], [[0]]])
def test_starts_beyond_the_path_are_refused(starts):
    parts = CorridorPredictor(), CorridorController(), CorridorReachability()
    with pytest.raises(
        InputError, match=r"starts: .*give (.N,. anchors of 1 paths|whole numbers of shape .N,.)"
    ):
        Follower(AnchorPaths(np.zeros(9), np.zeros(9), [range(9)]), *parts, None, starts)


def test_observations_and_numbers_must_fit():
    corridor, follower = make(starts=[0.0, 0.0])
    with pytest.raises(InputError, match="follower: 2 observations but robots"):
        follower.act(corridor.observe(np.array([0, 1])), np.array([0]))


class Wrong:
    """Tells what is given instead of what the inner one would."""

    def __init__(self, waypoints=None, overlaps=None):
        self.waypoints, self.overlaps = waypoints, overlaps

    def predict(self, observations, targets):
        waypoints, overlaps = CorridorPredictor().predict(observations, targets)
        return (
            waypoints if self.waypoints is None else self.waypoints(waypoints),
            overlaps if self.overlaps is None else self.overlaps(overlaps),
        )


@pytest.mark.parametrize(
    ("predictor", "words"),
    [
        (Wrong(waypoints=lambda w: w[:, :1]), "waypoints: .*shape .N, 2."),
        (Wrong(waypoints=lambda w: w * np.nan), "waypoints: .*finite"),
        (Wrong(overlaps=lambda o: o.mean(axis=1)), "overlaps: .*finite .N, 2."),
        (Wrong(overlaps=lambda o: o + np.nan), "overlaps: .*finite"),
    ],
)
def test_a_predictor_that_tells_nonsense_is_found_out(predictor, words):
    corridor, follower = make()
    follower.predictor = predictor
    with pytest.raises(InputError, match=words):
        go(corridor, follower, 1)


@pytest.mark.parametrize("returned", [np.nan, 1.5, -0.5])
def test_a_reachability_that_returns_nonsense_is_found_out(returned):
    reachability = CorridorReachability()
    reachability.arranged = lambda p, t: np.full(len(p), returned)
    for first in (0, None):
        corridor, follower = make(reachability=reachability, first=first)
        with pytest.raises(InputError, match="reachability: "):
            go(corridor, follower, 1)


def test_of_two_overlaps_their_mean_counts():
    found = []
    for shares in ([1.0, 1.0], [0.5, 1.0], [1.0, 0.5]):
        corridor, follower = make(anchors=[0.0, 1.5, 3.0])
        follower.predictor = Wrong(overlaps=lambda o, shares=shares: o * shares)
        go(corridor, follower, 1)
        found.append(follower.log().overlap[0, 0])
    assert found == pytest.approx([found[0], 0.75 * found[0], 0.75 * found[0]])


# What is kept.


def test_there_is_a_row_for_each_step():
    (corridor, follower), _ = fleet()
    go(corridor, follower, 40)
    record = follower.log()
    assert len(record) == 40
    for name in ("state", "active", "visited", "probability", "overlap", "waypoint"):
        assert getattr(record, name).shape == ((40, 8, 2) if name == "waypoint" else (40, 8))


def test_of_a_run_that_has_not_begun_there_are_no_rows():
    _, follower = make(starts=[0.0, 1.0])
    assert follower.log().state.shape == (0, 2)


def test_what_was_recorded_stays_as_it_was():
    corridor, follower = make()
    go(corridor, follower, 5)
    before = follower.log()
    kept = before.active.copy(), before.waypoint.copy()
    go(corridor, follower, 50)
    assert (before.active == kept[0]).all()
    assert np.array_equal(before.waypoint, kept[1])
