"""Answers to notebook 04: the docstring of a wrong one is what the check must say of it."""

import math

import numpy as np

from tutorial_lib.checks.nb04 import check_transition
from tutorial_lib.geometry import to_local, to_world
from tutorial_lib.topology.following.transitions import State


def choose_anchors__never_gets_on(reach, threshold):
    """has not ended after"""
    anchors = [0]
    while anchors[-1] < len(reach) - 1:
        i = anchors[-1]
        j = i
        while j + 1 < len(reach) and reach[i, j + 1] > threshold:
            j += 1
        if j > i:
            anchors.append(j)
    return anchors


def choose_anchors__has_a_threshold_of_its_own(reach, threshold):
    """after anchor"""
    return _greedy(lambda i, k: reach[i, k] > 0.85, len(reach))


def choose_anchors__counts_them(reach, threshold):
    """return the indices of the frames"""
    return len(_greedy(lambda i, k: reach[i, k] > threshold, len(reach)))


def choose_anchors__marks_them(reach, threshold):
    """a flat list of frames is needed"""
    anchors = _greedy(lambda i, k: reach[i, k] > threshold, len(reach))
    return np.eye(len(reach))[anchors]


def choose_anchors__runs_over_the_end(reach, threshold):
    """look whether j + 1 is a frame first"""
    anchors = [0]
    while anchors[-1] < len(reach) - 1:
        i = j = anchors[-1]
        while reach[i, j + 1] > threshold:
            j += 1
        anchors.append(max(j, i + 1))
    return anchors


def choose_anchors__goes_on_one_by_one(reach, threshold):
    """after anchor 0 comes 3, not 2"""
    return _greedy(lambda i, k: reach[i, k] > threshold and k <= i + 2, len(reach))


def choose_anchors__returns_a_set(reach, threshold):
    """a set came back"""
    return set(_greedy(lambda i, k: reach[i, k] > threshold, len(reach)))


def choose_anchors__cuts_the_table(reach, threshold):
    """your function changes its argument reach"""
    reach[reach <= threshold] = 0.0
    return _greedy(lambda i, k: reach[i, k] > threshold, len(reach))


def choose_anchors__right_with_argmin(reach, threshold):
    anchors = [0]
    while anchors[-1] < len(reach) - 1:
        i = anchors[-1]
        holds = np.append(reach[i, i + 1 :] > threshold, False)
        anchors.append(i + max(int(holds.argmin()), 1))
    return np.array(anchors)


def choose_anchors__right_frame_by_frame(reach, threshold):
    anchors, last = [0], len(reach) - 1
    for k in range(1, last + 1):
        if reach[anchors[-1], k] > threshold:
            continue
        if anchors[-1] < k - 1:
            anchors.append(k - 1)
        if not reach[k - 1, k] > threshold:
            anchors.append(k)
    return anchors if anchors[-1] == last else [*anchors, last]


def frames_to_keep__gives_the_number(anchors, total, k):
    """not how many there are"""
    return len(frames_to_keep__right_as_a_set(anchors, total, k))


def frames_to_keep__keeps_them_apart(anchors, total, k):
    """a flat list of frames is needed"""
    return np.clip(anchors[:, None] + 3 * np.arange(-k, k + 1), 0, total - 1)


def frames_to_keep__steps_by_two(anchors, total, k):
    """is missing: anchor 0"""
    return np.unique(np.clip(anchors[:, None] + 2 * np.arange(-k, k + 1), 0, total - 1))


def frames_to_keep__forgets_the_last_anchor(anchors, total, k):
    """is missing: anchor 39"""
    return frames_to_keep__right_as_a_set(anchors[:-1], total, k)


def frames_to_keep__adds_without_a_column(anchors, total, k):
    """anchors[:, None] is a column"""
    return np.unique(np.clip(anchors + 3 * np.arange(-k, k + 1), 0, total - 1))


def frames_to_keep__returns_a_mask(anchors, total, k):
    """return the indices, as np.flatnonzero gives them"""
    return np.isin(np.arange(total), list(frames_to_keep__right_as_a_set(anchors, total, k)))


def frames_to_keep__right_as_a_set(anchors, total, k):
    kept = set()
    for anchor in anchors:
        for step in range(-k, k + 1):
            kept.add(min(max(int(anchor) + 3 * step, 0), total - 1))
    return kept


def move_on__falls_back(active, visited, reach, overlap, at, rules):
    """lets the active anchor fall back"""
    visited = _seen(active, visited, overlap, at, rules)
    last = len(reach) - 1
    if active == last:
        return active, visited
    if reach[active + 1] > rules.p_follow and overlap[active + 1] > rules.near:
        return active + 1, visited
    return min(visited + 1, last), visited


def move_on__goes_beyond_the_end(active, visited, reach, overlap, at, rules):
    """after the last anchor there is none"""
    visited = _seen(active, visited, overlap, at, rules)
    ready = reach[active + 1] > rules.p_follow and overlap[active + 1] > rules.near
    return active + int(ready or visited >= active), visited


def move_on__leaps_over_the_next(active, visited, reach, overlap, at, rules):
    """not to visited + 1"""
    visited, last = _seen(active, visited, overlap, at, rules), len(reach) - 1
    if active == last:
        return active, visited
    if visited >= active:
        return min(visited + 1, last), visited
    return active + _ready(active, visited, reach, overlap, rules), visited


def move_on__gives_only_one(active, visited, reach, overlap, at, rules):
    """return active, visited"""
    return active + 1


def move_on__returns_the_old_visited(active, visited, reach, overlap, at, rules):
    """visited 1 is right"""
    seen = _seen(active, visited, overlap, at, rules)
    return _onward(active, seen, reach, overlap, rules)[0], visited


def move_on__returns_floats(active, visited, reach, overlap, at, rules):
    """two whole numbers"""
    new = _onward(active, _seen(active, visited, overlap, at, rules), reach, overlap, rules)
    return float(new[0]), float(new[1])


def move_on__right_in_one_go(active, visited, reach, overlap, at, rules):
    first = max(active - 1, 0)
    few = np.asarray(overlap)[first : active + 2]
    if few.max() > rules.visited:
        visited = max(visited, first + int(few.argmax()))
    if at:
        visited = max(visited, active)
    following = active + 1
    if following == len(reach):
        return active, visited
    if active <= visited:
        return following, visited
    if reach[following] > rules.p_follow and overlap[following] > rules.near:
        return following, visited
    return active, visited


def move_on__right_with_lists(active, visited, reach, overlap, at, rules):
    candidates = [j for j in range(len(overlap)) if abs(j - active) <= 1]
    best = sorted(candidates, key=lambda j: overlap[j])[-1]
    been = [visited]
    if overlap[best] > rules.visited:
        been.append(best)
    if at:
        been.append(active)
    has_next = active + 1 < len(reach)
    ready = has_next and reach[active + 1] > rules.p_follow and overlap[active + 1] > rules.near
    return active + int(has_next and bool(ready or max(been) >= active)), max(been)


def transition__has_a_timeout_of_its_own(state, active, visited, reach, overlap, at, waited, rules):
    """Dead reckoning for long, other rules"""
    if state == State.DEAD_RECKONING and reach[active] <= rules.p_follow:
        return State.LOST if waited > 4.0 else state, active, visited
    return _right(state, active, visited, reach, overlap, at, waited, rules)


def transition__forgets_the_state(state, active, visited, reach, overlap, at, waited, rules):
    """return state, active, visited"""
    return _right(state, active, visited, reach, overlap, at, waited, rules)[1:]


def transition__names_the_state(state, active, visited, reach, overlap, at, waited, rules):
    """a State and whole numbers"""
    found = _right(state, active, visited, reach, overlap, at, waited, rules)
    return (found[0].name, *found[1:])


def transition__right_with_a_table(state, active, visited, reach, overlap, at, waited, rules):
    last, sure = len(reach) - 1, reach > rules.p_follow

    def search():
        best = int(reach.argmax())
        return (1, best, best - 1) if reach[best] > rules.p_search else (3, -1, -1)

    def follow():
        if at and active == last:
            return 4, active, visited
        moved, seen = move_on__right_in_one_go(active, visited, reach, overlap, at, rules)
        return 1 if reach[moved] > rules.p_lose else 2, moved, seen

    def dead_reckoning():
        if sure[active]:
            return 1, active, visited
        return 3 if waited > rules.timeout else 2, active, visited

    return (search, follow, dead_reckoning)[state]()


def transition__right_step_by_step(state, active, visited, reach, overlap, at, waited, rules):
    return _right(state, active, visited, reach, overlap, at, waited, rules)


def follow_step__hangs_a_carrot(memory, reach, overlap, waypoints, odometry, rules):
    """the point to drive to is"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    if target is None:
        return new, None
    return new, _into(memory.place if new.waited else odometry, new.place) + 0.01


def follow_step__keeps_the_robots_frame(memory, reach, overlap, waypoints, odometry, rules):
    """place is the waypoint in the robot's frame"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new._replace(place=waypoints[new.active]), target


def follow_step__drives_in_the_odometers_frame(memory, reach, overlap, waypoints, odometry, rules):
    """the point is in the odometer's frame"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new, None if target is None else new.place


def follow_step__only_shifts(memory, reach, overlap, waypoints, odometry, rules):
    """shifted, but not turned into the robot's frame"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new, None if target is None else new.place - odometry[:2]


def follow_step__only_shifts_the_waypoint(memory, reach, overlap, waypoints, odometry, rules):
    """it does not only shift it"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new._replace(place=odometry[:2] + waypoints[new.active]), target


def follow_step__takes_new_waypoints_when_blind(memory, reach, overlap, waypoints, odometry, rules):
    """no new waypoint is taken in dead reckoning"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    if target is None:
        return new, None
    return new._replace(place=_out_of(odometry, waypoints[new.active])), waypoints[new.active]


def follow_step__takes_waypoints_in_follow_only(memory, reach, overlap, waypoints, odometry, rules):
    """whenever the active anchor has changed"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    if new.state == State.DEAD_RECKONING:
        target = _into(odometry, memory.place)
        new = new._replace(place=memory.place)
    return new, target


def follow_step__takes_the_old_anchors_waypoint(memory, reach, overlap, waypoints, odometry, rules):
    """that of the new one"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    if target is None or memory.active < 0 or new.state != State.FOLLOW:
        return new, target
    return new._replace(place=_out_of(odometry, waypoints[memory.active])), target


def follow_step__never_arrives(memory, reach, overlap, waypoints, odometry, rules):
    """with RE above rules.p_lose; state, active and visited"""
    return _step(memory, reach, overlap, waypoints, odometry, rules, at=False)


def follow_step__has_a_distance_of_its_own(memory, reach, overlap, waypoints, odometry, rules):
    """the waypoint of anchor 0 is 0.05 m away (rules.at = 0.01)"""
    near = np.linalg.norm(waypoints[memory.active]) < 0.25 and reach[memory.active] > rules.p_lose
    return _step(memory, reach, overlap, waypoints, odometry, rules, at=bool(near))


def follow_step__counts_steps(memory, reach, overlap, waypoints, odometry, rules):
    """a step lasts 0.1 s, not 1 s"""
    return _step(memory, reach, overlap, waypoints, odometry, rules, tick=1.0)


def follow_step__never_resets_the_clock(memory, reach, overlap, waypoints, odometry, rules):
    """the state has changed, so the clock starts again at 0"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new._replace(waited=memory.waited + 0.1), target


def follow_step__resets_the_clock_by_the_state_alone(
    memory, reach, overlap, waypoints, odometry, rules
):
    """it came nearer by more than 0.05 m, so the clock starts again at 0"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    changed = new[:2] != memory[:2]
    return new._replace(waited=0.0 if changed else memory.waited + 0.1), target


def follow_step__goes_on_when_the_anchor_changes(
    memory, reach, overlap, waypoints, odometry, rules
):
    """the active anchor has changed, so the clock starts again at 0"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    same = new.state == memory.state and new.active != memory.active
    return new._replace(waited=memory.waited + 0.1 if same else new.waited), target


def follow_step__resets_the_clock_in_the_dark(memory, reach, overlap, waypoints, odometry, rules):
    """in dead reckoning the clock runs"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new._replace(waited=0.0) if new.state == State.DEAD_RECKONING else new, target


def follow_step__keeps_the_least_distance_always(
    memory, reach, overlap, waypoints, odometry, rules
):
    """whenever the clock starts again, it is the distance to the point"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new._replace(nearest=min(memory.nearest, new.nearest)), target


def follow_step__lowers_the_least_distance_at_each_step(
    memory, reach, overlap, waypoints, odometry, rules
):
    """would never count"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    if target is None:
        return new, target
    return new._replace(nearest=min(new.nearest, float(np.linalg.norm(target)))), target


def follow_step__drives_on_when_lost(memory, reach, overlap, waypoints, odometry, rules):
    """return None in place of a point"""
    new, _ = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new, _into(odometry, new.place)


def follow_step__stops_in_the_dark(memory, reach, overlap, waypoints, odometry, rules):
    """so the robot drives on; return a point"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return new, None if new.state == State.DEAD_RECKONING else target


def follow_step__writes_to_the_memory(memory, reach, overlap, waypoints, odometry, rules):
    """is not written to: make a new one"""
    memory.waited = 0.0
    return _step(memory, reach, overlap, waypoints, odometry, rules)


def follow_step__writes_to_the_place(memory, reach, overlap, waypoints, odometry, rules):
    """changes memory.place"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    memory.place[:] = new.place
    return new, target


def follow_step__returns_a_tuple(memory, reach, overlap, waypoints, odometry, rules):
    """the first thing that came back is a tuple"""
    new, target = _step(memory, reach, overlap, waypoints, odometry, rules)
    return tuple(new), target


def follow_step__forgets_the_point(memory, reach, overlap, waypoints, odometry, rules):
    """return memory, target"""
    return _step(memory, reach, overlap, waypoints, odometry, rules)[0]


def follow_step__right_with_replace(memory, reach, overlap, waypoints, odometry, rules):
    return _step(memory, reach, overlap, waypoints, odometry, rules)


def follow_step__right_by_matrices(memory, reach, overlap, waypoints, odometry, rules):
    old_state, old, visited, place, waited, nearest = memory
    at = old >= 0 and math.hypot(*waypoints[old]) < rules.at and reach[old] > rules.p_lose
    state, active, visited = _right(old_state, old, visited, reach, overlap, at, waited, rules)
    stays = active == old
    if state == State.FOLLOW or not stays:
        x, y = waypoints[max(active, 0)]
        place = (_matrix(odometry) @ [x, y, 1.0])[:2]
    x, y, _ = np.linalg.inv(_matrix(odometry)) @ [*place, 1.0]
    gap = math.hypot(x, y)
    if stays and state == old_state and (state != State.FOLLOW or gap >= nearest - 0.05):
        waited += 0.1
    else:
        waited, nearest = 0.0, gap
    if state == State.FOLLOW and waited > rules.effort:
        state = State.LOST
    stops = state in (State.LOST, State.DONE)
    new = type(memory)(state, active, visited, place, waited, nearest)
    return new, None if stops else [x, y]


def _step(memory, reach, overlap, waypoints, odometry, rules, at=None, tick=0.1):
    """The follower's step, and what may be wrong with it."""
    if at is None:
        near = np.linalg.norm(waypoints[memory.active]) < rules.at
        at = bool(near and reach[memory.active] > rules.p_lose)
    state, active, visited = _right(*memory[:3], reach, overlap, at, memory.waited, rules)
    new = memory._replace(state=state, active=active, visited=visited)
    if state in (State.LOST, State.DONE):
        return new, None
    if state == State.FOLLOW or active != memory.active:
        new = new._replace(place=_out_of(odometry, waypoints[active]))
    target = _into(odometry, new.place)
    gap = float(np.linalg.norm(target))
    progress = state != memory.state or active != memory.active
    progress |= state == State.FOLLOW and gap < memory.nearest - 0.05
    if progress:
        new = new._replace(waited=0.0, nearest=gap)
    else:
        new = new._replace(waited=memory.waited + tick)
    if state == State.FOLLOW and new.waited > rules.effort:
        return new._replace(state=State.LOST), None
    return new, target


def _greedy(holds, frames):
    anchors = [0]
    while anchors[-1] < frames - 1:
        i = j = anchors[-1]
        while j + 1 < frames and holds(i, j + 1):
            j += 1
        anchors.append(max(j, i + 1))
    return anchors


def _closest(active, overlap):
    places = range(max(active - 1, 0), min(active + 2, len(overlap)))
    return max(places, key=lambda place: overlap[place])


def _seen(active, visited, overlap, at, rules):
    closest = _closest(active, overlap)
    visited = max(visited, active) if at else visited
    return max(visited, closest) if overlap[closest] > rules.visited else visited


def _onward(active, visited, reach, overlap, rules):
    last = len(reach) - 1
    if active == last:
        return active, visited
    return active + int(
        visited >= active or _ready(active, visited, reach, overlap, rules)
    ), visited


def _ready(active, visited, reach, overlap, rules):
    if active == len(reach) - 1:
        return 0
    ready = reach[active + 1] > rules.p_follow and overlap[active + 1] > rules.near
    return int(ready or visited >= active)


def _right(state, active, visited, reach, overlap, at, waited, rules):
    if state == State.SEARCH:
        best = int(np.argmax(reach))
        found = reach[best] > rules.p_search
        return (State.FOLLOW, best, best - 1) if found else (State.LOST, active, visited)
    if state == State.FOLLOW:
        if at and active == len(reach) - 1:
            return State.DONE, active, visited
        active, visited = move_on__right_in_one_go(active, visited, reach, overlap, at, rules)
        here = State.FOLLOW if reach[active] > rules.p_lose else State.DEAD_RECKONING
        return here, active, visited
    if reach[active] > rules.p_follow:
        return State.FOLLOW, active, visited
    return State.LOST if waited > rules.timeout else state, active, visited


def _turned(points, angle):
    spun = (points[..., 0] + 1j * points[..., 1]) * np.exp(1j * angle)
    return np.stack([spun.real, spun.imag], axis=-1)


def _out_of(pose, point):
    return pose[..., :2] + _turned(point, pose[..., 2])


def _into(pose, point):
    return _turned(point - pose[..., :2], -pose[..., 2])


def _matrix(pose):
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[cos, -sin, pose[0]], [sin, cos, pose[1]], [0.0, 0.0, 1.0]])


def frames_to_keep__floats(anchors, total, k):
    """these are floats, which select nothing from an array"""
    frames = anchors[:, None] + np.linspace(-3 * k, 3 * k, 2 * k + 1)
    return np.unique(np.clip(frames, 0, total - 1))


def _looped(memory, reach, overlap, waypoints, odometry, rules, *, nearer):
    """The loop with another rule of progress."""
    old = memory
    gap = np.hypot(*waypoints[old.active])
    at = bool(gap < rules.at and reach[old.active] > rules.p_lose)
    before = old.state, old.active, old.visited
    state, active, visited = check_transition.reference(
        *before, reach, overlap, at, old.waited, rules
    )
    if state in (State.LOST, State.DONE):
        return old._replace(state=state, active=active, visited=visited), None
    place = old.place
    if state == State.FOLLOW or active != old.active:
        place = to_world(odometry, waypoints[active])
    point = to_local(odometry, place)
    far, waited, nearest = float(np.hypot(*point)), old.waited + 0.1, old.nearest
    changed = state != old.state or active != old.active
    if changed or (state == State.FOLLOW and nearer(far, nearest)):
        waited, nearest = 0.0, far
    new = old._replace(state=state, active=active, visited=visited)
    new = new._replace(place=place, waited=waited, nearest=nearest)
    if state == State.FOLLOW and waited > rules.effort:
        return new._replace(state=State.LOST), None
    return new, point


def follow_step__right_by_the_difference(*step):
    """Progress as a difference above 0.05 m."""
    return _looped(*step, nearer=lambda far, nearest: nearest - far > 0.05)


def follow_step__right_by_the_sum(*step):
    """Progress as a sum below the nearest."""
    return _looped(*step, nearer=lambda far, nearest: far + 0.05 < nearest)


def choose_anchors__looks_five_ahead(reach, threshold):
    """however many those are"""
    return _greedy(lambda i, k: k <= i + 5 and reach[i, k] > threshold, len(reach))


def frames_to_keep__keeps_both_ends(anchors, total, k):
    """the ends of the trajectory are no exception"""
    return {0, total - 1} | frames_to_keep__right_as_a_set(anchors, total, k)


def move_on__counts_the_next_as_reached(active, visited, reach, overlap, at, rules):
    """at makes the active anchor the one last visited"""
    reached = min(active + at, len(reach) - 1)
    visited = max(_seen(active, visited, overlap, False, rules), reached if at else visited)
    return _onward(active, visited, reach, overlap, rules)


def transition__is_done_once_the_last_was_visited(
    state, active, visited, reach, overlap, at, waited, rules
):
    """visited alone is not at"""
    if state == State.FOLLOW and visited == len(reach) - 1:
        return State.DONE, active, visited
    return _right(state, active, visited, reach, overlap, at, waited, rules)


def transition__searches_by_overlap(state, active, visited, reach, overlap, at, waited, rules):
    """in Search RE alone decides"""
    seen = overlap if state == State.SEARCH else reach
    return _right(state, active, visited, seen, overlap, at, waited, rules)
