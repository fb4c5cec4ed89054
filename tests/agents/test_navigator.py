"""What a robot does that waits, or looks around, on a line."""

import pytest

from tests.agents.line import Line, Plans, goals_at, navigation_along, sure
from tutorial_lib.agents.blockades import WAIT
from tutorial_lib.agents.navigator import LOOK_TIME
from tutorial_lib.interfaces import HERE, Plan
from tutorial_lib.world.simulation import STEP

AHEAD, BACK = sure((7, 8), 0), sure((5, 4), 1)  # vertex v is at v - 4
PATIENT = 60.0  # seconds after which the follower alone is lost


@pytest.mark.parametrize(("seen", "plans"), [(2.5, 2), (50.0, 1)])
def test_a_robot_that_waited_for_what_it_sees_in_its_way_replans(seen, plans):
    planned = Plans(AHEAD, BACK)
    goals = [goals_at(5, -1)]
    navigation = navigation_along(planned, goals, wall=2.2, timeout=PATIENT)
    line = Line([2.0], wall=2.2, seen=seen)
    steps = round(WAIT / STEP)
    line.go(navigation, steps - 2)
    assert len(planned.queries) == 1
    line.go(navigation, 30)
    assert len(planned.queries) == plans
    if plans == 2:
        excluded = planned.queries[1][2]
        assert (HERE, 7) in excluded
        line.go(navigation, 200)
        assert navigation.arrived[0]


def test_a_robot_that_found_no_plan_for_ten_seconds_may_begin_anywhere():
    planned = Plans(sure((5, 6, 7, 8), 0), *[Plan(refusal="no path")] * 30)
    navigation = navigation_along(planned, [goals_at(5, -3)], wall=2.4)
    line = Line([0.0], wall=2.4)
    while len(planned.queries) < 2:
        line.go(navigation, 1)
    line.go(navigation, round(1.5 * LOOK_TIME / STEP))
    starts = [{v for u, v in excluded if u == HERE} for _, _, excluded in planned.queries[1:]]
    first, later = starts[: round(LOOK_TIME)], starts[round(LOOK_TIME) :]
    # It visited 6 last, and could not reach what lies ahead; nothing is said of other vertices.
    elsewhere = set(range(13)) - {6, 7, 8}
    assert len(later) > 3
    assert all(elsewhere <= excluded for excluded in first)
    assert not any(elsewhere & excluded for excluded in later)
    assert all(7 in excluded for excluded in starts)
