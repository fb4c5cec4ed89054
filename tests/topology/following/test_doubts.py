"""A follower whose view changes at once doubts, and is lost where it does not recover in time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.topology.following.test_follower import FOLLOW, LOST, CorridorReachability, go, make
from tutorial_lib.topology.following.state import FollowerState
from tutorial_lib.topology.following.transitions import FollowerSettings, State
from tutorial_lib.world.simulation import STEP


def believing(level):
    """Reachability of every anchor is `level`."""
    return lambda probabilities, targets: np.full(np.shape(probabilities), level)


def under_way(**settings):
    reachability = CorridorReachability(far=9.0)
    corridor, follower = make(anchors=range(40), reachability=reachability, **settings)
    go(corridor, follower, 15)
    return corridor, follower, reachability


def test_a_view_that_changed_at_once_must_come_back_in_time():
    corridor, follower, reachability = under_way(timeout=2.0)
    reachability.arranged = believing(0.7)  # far above p_lose: it drives on
    go(corridor, follower, 19)
    assert follower.memory.state[0] == FOLLOW
    go(corridor, follower, 1)
    assert follower.memory.state[0] == LOST


def test_it_may_change_little_by_little():
    corridor, follower, reachability = under_way()
    for level in (0.9, 0.8, 0.7):
        reachability.arranged = believing(level)
        go(corridor, follower, 1)
    go(corridor, follower, 60)
    assert follower.memory.state[0] == FOLLOW


def test_a_doubt_ends_where_the_anchor_is_seen_as_before():
    corridor, follower, reachability = under_way(timeout=2.0)
    for _ in range(3):
        reachability.arranged = believing(0.7)
        go(corridor, follower, 19)
        reachability.arranged = believing(0.93)
        go(corridor, follower, 1)
        assert follower.memory.doubted[0] == 0.0
    assert follower.memory.state[0] == FOLLOW


@pytest.mark.parametrize(("level", "lost"), [(0.91, True), (0.93, False)])
def test_as_before_means_above_p_follow(level, lost):
    corridor, follower, reachability = under_way()
    reachability.arranged = believing(0.6)
    go(corridor, follower, 1)
    reachability.arranged = believing(level)
    go(corridor, follower, 60)
    assert follower.memory.lost[0] == lost


def test_without_doubts_it_drives_on():
    corridor, follower, reachability = under_way(fall=1.0)
    reachability.arranged = believing(0.7)
    go(corridor, follower, 60)
    assert follower.memory.state[0] == FOLLOW


def test_another_path_begins_without_doubts():
    corridor, follower, reachability = under_way(timeout=2.0)
    reachability.arranged = believing(0.7)
    go(corridor, follower, 15)
    follower.assign(0, np.arange(20))
    go(corridor, follower, 30)
    assert follower.memory.state[0] == FOLLOW


def corridor_of_two_beliefs(ahead, behind=0.99, switch=2):
    """RE of anchors before `switch` is `behind`, of the others `ahead`."""
    return lambda probabilities, targets: np.where(np.asarray(targets) < switch, behind, ahead)


def test_the_next_anchor_begins_with_its_own_reachability():
    """It was below p_follow all the time: that the one before was above it does not matter."""
    corridor, follower = make(anchors=range(40), reachability=CorridorReachability(far=9.0))
    follower.reachability.arranged = corridor_of_two_beliefs(0.6)
    go(corridor, follower, 60)
    assert follower.memory.active[0] >= 2
    assert follower.memory.doubted[0] == 0.0


def test_a_view_that_changes_just_after_the_next_anchor_became_active_counts():
    corridor, follower, reachability = under_way(timeout=2.0)
    active = follower.memory.active[0]
    while follower.memory.active[0] == active:
        go(corridor, follower, 1)
    reachability.arranged = believing(0.7)
    go(corridor, follower, 20)
    assert follower.memory.state[0] == LOST


def test_a_doubt_lasts_when_the_next_anchor_becomes_active():
    corridor, follower, reachability = under_way()
    active = follower.memory.active[0]
    reachability.arranged = believing(0.7)
    go(corridor, follower, 39)
    assert follower.memory.active[0] > active
    go(corridor, follower, 1)
    assert follower.memory.state[0] == LOST


def test_the_first_anchor_of_another_path_is_not_compared_with_the_last():
    corridor, follower, reachability = under_way()
    follower.assign(0, np.arange(10, 20))
    reachability.arranged = believing(0.6)
    go(corridor, follower, 1)
    assert follower.memory.doubted[0] == 0.0


def test_a_doubt_goes_on_through_dead_reckoning():
    corridor, follower, reachability = under_way()
    reachability.arranged = believing(0.3)
    go(corridor, follower, 10)
    assert follower.memory.state[0] == State.DEAD_RECKONING
    reachability.arranged = believing(0.7)
    go(corridor, follower, 29)
    assert not follower.memory.lost[0]
    go(corridor, follower, 1)
    assert follower.memory.lost[0]


def test_a_robot_that_is_back_on_its_path_has_no_doubts_left():
    memory, robot = after([0.99, 0.2, 0.2], FollowerSettings()), np.zeros(1, int)
    memory.go_on(robot, np.ones(1, int))
    assert memory.doubted[0] == 0.0
    memory.doubt(robot, np.array([0.5]), FollowerSettings())
    assert memory.doubted[0] == 0.0


def after(probabilities, settings, states=State.FOLLOW):
    """The memory of a robot that saw its anchor with these probabilities, step by step."""
    memory, robot = FollowerState.at(np.zeros(1, int)), np.zeros(1, int)
    for probability, state in np.broadcast(probabilities, states):
        memory.state[0] = state
        memory.doubt(robot, np.array([probability]), settings)
    return memory


def test_a_fall_from_below_p_follow_is_no_reason_for_a_doubt():
    assert after([0.91, 0.1], FollowerSettings()).doubted[0] == 0.0
    assert after([0.93, 0.1], FollowerSettings()).doubted[0] == STEP


def test_two_anchors_are_not_compared():
    memory, robot = after([0.99], FollowerSettings()), np.zeros(1, int)
    memory.aim(robot)
    memory.doubt(robot, np.array([0.5]), FollowerSettings())
    assert memory.doubted[0] == 0.0


def test_a_robot_that_turns_has_no_doubts():
    settings = FollowerSettings()
    states = [State.FOLLOW, State.TURN, State.TURN, State.FOLLOW]
    assert after([0.99, 0.99, 0.2, 0.2], settings, states).doubted[0] == 0.0
    memory = after([0.99, 0.2], settings)
    memory.turn(np.zeros(1, int), 4)
    assert memory.doubted[0] == 0.0


@given(
    st.lists(st.sampled_from([0.3, 0.75, 0.93, 0.99, np.nan]), min_size=1, max_size=12),
    st.sampled_from([State.FOLLOW, State.DEAD_RECKONING]),
)
def test_robots_doubt_each_for_itself_and_as_long_as_it_takes(levels, state):
    """Against a plain loop over the steps; a second robot sees its anchor all the time."""
    settings, seconds, before = FollowerSettings(timeout=0.5), 0.0, np.nan
    memory = FollowerState.at(np.zeros(2, int))
    memory.state[:] = state
    for level in levels:
        memory.doubt(np.arange(2), np.array([level, 0.99]), settings)
        if level > 0.92:
            seconds = 0.0
        elif seconds > 0 or (before > 0.92 and before - level > 0.2):
            seconds += STEP
        before = level
        assert memory.doubted == pytest.approx([seconds, 0.0])
        assert memory.lost.tolist() == [seconds > 0.45, False]
        if memory.lost[0]:
            return
