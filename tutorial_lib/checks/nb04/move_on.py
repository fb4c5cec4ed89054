"""The check of how a follower moves on along its path of anchors, in notebook 04."""

from typing import Any

from tutorial_lib.checks.engine import exercise, parts
from tutorial_lib.checks.nb04.forms import INVOKE, came_back, demand, whole
from tutorial_lib.checks.nb04.observations import OBSERVATIONS, random_observations
from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.transitions import FollowerSettings


def move_on(
    active: int, visited: int, reach: Array, overlap: Array, at: bool, rules: FollowerSettings
) -> tuple[int, int]:
    """Active and last visited anchor, by `last_visited` and `next_active`; see the exercise."""
    last = len(reach) - 1
    around = range(max(active - 1, 0), min(active + 1, last) + 1)
    closest = max(around, key=lambda place: overlap[place])
    if overlap[closest] > rules.visited:
        visited = max(visited, closest)
    if at:
        visited = max(visited, active)
    if active < last and (
        visited >= active
        or (reach[active + 1] > rules.p_follow and overlap[active + 1] > rules.near)
    ):
        active += 1
    return active, visited


CASES = OBSERVATIONS | random_observations(80, 1)
MISTAKES = """
an overlap of exactly rules.visited is not enough: above
    > rules.visited -> >= rules.visited
an RE of exactly rules.p_follow is not enough: above
    > rules.p_follow -> >= rules.p_follow
an overlap of exactly rules.near is not enough: above
    > rules.near -> >= rules.near
one anchor at a step: if, not while
    if active < last -> while active < last
return the last visited anchor as it is after this step, not as it was
    last = len(reach) - 1 -> last = len(reach) - 1; before = visited if active < last else None
    return active, visited -> return active, visited if before is None else before
at the last anchor, too, the last visited one may change; only the active one stays
    if overlap[closest] > -> if active < last and overlap[closest] >
    if at: -> if active < last and at:
compare the overlap of three anchors only; active - 2 is too far back
    active - 1 -> active - 2
the last visited anchor never goes back to an earlier one: max
    max(visited, closest) -> closest
the closest anchor counts as visited only if its overlap is above rules.visited
    overlap[closest] > rules.visited -> True
look only at the anchors before, at and after the active one; one far along the path may look alike
    range(max(active - 1, 0), min(active + 1, last) + 1) -> range(last + 1)
compare no overlaps beyond that of the next anchor, active + 1; active + 2 is too far
    min(active + 1, last) -> min(active + 2, last)
of several neighbours above rules.visited only the closest counts, not the farthest
    max(visited, closest)
        -> max(visited, *[place for place in around if overlap[place] > rules.visited])
before the first anchor there is none; overlap[-1] is the last one of the path
    max(active - 1, 0) -> active - 1
before the first anchor there is none; yours compares overlap[-1], that of the last one
    max(active - 1, 0) -> active - 1
    overlap[place]) -> overlap[place]) % (last + 1)
the anchor before the active one may be the closest, too
    max(active - 1, 0) -> active
the anchor after the active one may be the closest, too
    min(active + 1, last) -> active
the closest anchor is the one with the largest overlap, not with the highest RE
    overlap[place] -> reach[place]
at does not take the last visited anchor back to the active one: max
    max(visited, active) -> active
after the last anchor there is none: it stays active
    active < last and ( -> visited >= active or active < last and (
return first the active anchor, then the one last visited
    return active, visited -> return visited, active
to be near, the overlap of the next anchor counts, overlap[active + 1], not that of the active one
    overlap[active + 1] -> overlap[active]
the next anchor must be reachable and near; one of them is not enough
    rules.p_follow and -> rules.p_follow or
an anchor is reachable above rules.p_follow, not above rules.p_lose
    rules.p_follow -> rules.p_lose
an anchor counts as visited above rules.visited, not above rules.near
    > rules.visited -> > rules.near
an anchor is near above rules.near, not above rules.visited
    > rules.near -> > rules.visited
the thresholds stand in rules, and are not always the same
    last = len(reach) - 1 -> last, rules = len(reach) - 1, FollowerSettings()
the next anchor must be near, too: its overlap above rules.near
    overlap[active + 1] > rules.near -> True
the next anchor must be reachable, too: its RE above rules.p_follow
    reach[active + 1] > rules.p_follow -> True
a robot at the active anchor has visited it, whatever the overlap
    if at: -> if False:
at means at the active anchor: that one was visited, not the closest
    max(visited, active) -> max(visited, closest)
check at whether or not the closest anchor was visited: if, not elif
    if at: -> elif at:
remember that the active anchor was visited: at
    last = len(reach) - 1 -> last, before = len(reach) - 1, visited
    return active, visited -> return active, before if at else visited
once the active anchor was visited, the robot must move on
    visited >= active -> False
a robot that has visited the next anchor has passed the active one, too: visited >= active
    visited >= active -> visited == active
move on by one anchor at a time, to active + 1, not to visited + 1
    active += 1 -> active = max(active, visited) + 1
once the active anchor was visited, the robot must move on, whatever the RE of the next one
    visited >= active -> False
    overlap[active + 1] > rules.near -> (visited >= active or overlap[active + 1] > rules.near)
update the last visited anchor first, then check whether the active one was visited
    last = len(reach) - 1 -> last, before = len(reach) - 1, visited
    visited >= active -> before >= active
the RE of the next anchor counts, reach[active + 1], not that of the active one
    reach[active + 1] -> reach[active]
one of two reasons to move on is enough, or: the active anchor was visited, or the next one is
reachable and near
    or (reach -> and (reach
the active anchor never moves on
    active += 1 -> pass
the paper's visited + 1 lets the active anchor fall back as soon as the next one is in doubt; here
it stays
    last = len(reach) - 1 -> last, before = len(reach) - 1, active
    visited >= active -> False
    return active, visited -> return visited + 1 if active == before < last else active, visited
"""


def _formed(what: str, got: Any, *_: object) -> tuple[int, ...]:  # noqa: ANN401 - students' answers
    words = "active, visited"
    answer = parts(what, got, 2, f"return {words}")
    demand(all(map(whole, answer)), what, got, f"{words}: two whole numbers")
    return tuple(int(number) for number in answer)


def _broken(got: tuple[int, ...], want: tuple[int, ...], *case: Any) -> str:  # noqa: ANN401
    """Which part of the rule an answer breaks."""
    if got[1] != want[1]:
        at = "at makes the active anchor the one last visited, unless a later one was"
        closest = "of the three anchors around the active one the closest counts, by its overlap"
        return at if case[4] else f"{closest}, if that is above rules.visited; never an earlier one"
    if got[0] > want[0]:
        return (
            "stay: advance by one at most, if the next one is both reachable and near, or if the "
            "active one was visited"
        )
    if got[0] < case[0]:
        return "the active anchor never falls back: where the next one is in doubt, it stays"
    if want[1] >= case[0]:
        return "once the active anchor was visited, now or earlier, the robot moves on"
    return "the next anchor is above both of the thresholds in rules: that is enough to move on"


def why_moved(
    active: int, visited: int, reach: Array, overlap: Array, at: bool, rules: FollowerSettings
) -> str:
    """What moves a follower on, or does not."""
    last = len(reach) - 1
    near = range(max(active - 1, 0), min(active + 1, last) + 1)
    closest = max(near, key=lambda place: overlap[place])
    above = "above" if overlap[closest] > rules.visited else "not above"
    words = f"of {near[0]} to {near[-1]} the closest is {closest}, its overlap {overlap[closest]:g}"
    words += f" is {above} rules.visited = {rules.visited:g}"
    words += f"; the robot is at {active}" if at else ""
    if active == last:
        return f"{words}; {active} is the last anchor, so it stays active"
    words += f"; the next one has RE {reach[active + 1]:g} (rules.p_follow = {rules.p_follow:g})"
    return f"{words} and overlap {overlap[active + 1]:g} (rules.near = {rules.near:g})"


check_move_on = exercise(
    move_on,
    CASES,
    MISTAKES,
    about="Under way, near, at an anchor, at both ends, exactly at thresholds, and 80 at random.",
    example=OBSERVATIONS["the next one reachable and near"],
    invoke=INVOKE,
    form=_formed,
    difference=lambda got, want, *case: came_back(got, want, why_moved(*case)),
    broken=_broken,
)
