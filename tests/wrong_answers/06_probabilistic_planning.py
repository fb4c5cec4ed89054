"""Answers to notebook 06: the docstring of a wrong one is what the check must say of it."""

import heapq
import math
from collections import Counter, defaultdict
from dataclasses import replace
from itertools import pairwise

from tutorial_lib.checks.nb06 import check_navigate
from tutorial_lib.checks.nb06.join_ends import join_ends

HERE, GOAL = -1, -2


def most_probable_path__takes_the_fewest_steps(graph, start, goal):
    """that is the path of the fewest steps"""
    paths, seen = [[start]], {start}
    while paths:
        path = paths.pop(0)
        if path[-1] == goal:
            return path, _product(graph, path)
        for other in graph[path[-1]]:
            if other not in seen:
                seen.add(other)
                paths.append([*path, other])
    return [], 0.0


def most_probable_path__goes_back_in_a_circle(graph, start, goal):
    """The loop back along the predecessors must end at the start"""
    least, before, heap, done = {start: 0.0}, {start: None}, [(0.0, start)], set()
    while heap:
        length, vertex = heapq.heappop(heap)
        if vertex in done:
            continue
        done.add(vertex)
        if vertex == goal:
            path = []
            while vertex is not None:
                path.append(vertex)
                vertex = before[vertex]
            return path[::-1], 1.0
        for other, p in graph[vertex].items():
            if length - p < least.get(other, math.inf):
                least[other], before[other] = length - p, vertex
                heapq.heappush(heap, (length - p, other))
    return [], 0.0


def most_probable_path__minds_only_the_weakest_edge(graph, start, goal):
    """the path whose weakest edge is strongest"""
    best, before, heap, done = {start: 1.0}, {start: start}, [(-1.0, 0, start)], set()
    count = 0
    while heap:
        weakest, _, vertex = heapq.heappop(heap)
        if vertex in done:
            continue
        done.add(vertex)
        for other, p in graph[vertex].items():
            through = min(-weakest, p)
            if other not in done and through > best.get(other, 0.0):
                count += 1
                best[other], before[other] = through, vertex
                heapq.heappush(heap, (-through, count, other))
    return _back(graph, before, start, goal)


def most_probable_path__settles_too_early(graph, start, goal):
    """not when it is put there"""
    before, heap = {start: start}, [(0.0, start)]
    while heap:
        cost, vertex = heapq.heappop(heap)
        for other, p in graph[vertex].items():
            if other not in before:
                before[other] = vertex
                heapq.heappush(heap, (cost - math.log(p), other))
    return _back(graph, before, start, goal)


def most_probable_path__finds_no_predecessor(graph, start, goal):
    """a goal that cannot be reached has no predecessor"""
    if start == goal:
        return [start], 1.0
    path, p = _best(graph, start, goal)
    return path, {True: p}[bool(path)]


def most_probable_path__removes_what_is_settled(graph, start, goal):
    """your function changes the graph"""
    answer = _best(graph, start, goal)
    graph.pop(start)
    return answer


def most_probable_path__gives_only_the_path(graph, start, goal):
    """return the path and its probability"""
    return _best(graph, start, goal)[0]


def most_probable_path__right_by_products(graph, start, goal):
    best, before, left = {start: 1.0}, {start: start}, set(graph)
    while left:
        vertex = max(left, key=lambda v: best.get(v, 0.0))
        left.remove(vertex)
        if vertex not in best:
            break
        for other, p in graph[vertex].items():
            if other in left and best[vertex] * p > best.get(other, 0.0):
                best[other], before[other] = best[vertex] * p, vertex
    return _back(graph, before, start, goal)


def most_probable_path__right_by_bellman_and_ford(graph, start, goal):
    least, before = {start: 0.0}, {start: start}
    for _ in graph:
        for v in list(graph):
            for w, p in graph[v].items():
                if v in least and least[v] - math.log(p) < least.get(w, math.inf) - 1e-12:
                    least[w], before[w] = least[v] - math.log(p), v
    path, _ = _back(graph, before, start, goal)
    return path, math.exp(-least[goal]) if path else 0.0


def join_ends__changes_the_map(graph, from_here, to_goals, p_here, p_goal):
    """your function changes its argument graph"""
    graph[HERE] = {v: p for v, p in from_here.items() if p > p_here}
    graph[GOAL] = {}
    return graph


def join_ends__copies_only_the_outside(graph, from_here, to_goals, p_here, p_goal):
    """the copy shares its inner dictionaries with the map"""
    joined = dict(graph)
    joined[HERE], joined[GOAL] = {v: p for v, p in from_here.items() if p > p_here}, {}
    for image in to_goals:
        for v, p in image.items():
            if p > p_goal and v in joined:
                joined[v][GOAL] = p
    return joined


def join_ends__takes_the_threshold_itself(graph, from_here, to_goals, p_here, p_goal):
    """greater than the threshold, not equal to it"""
    return _joined(graph, from_here, to_goals, p_here - 1e-12, p_goal - 1e-12)


def join_ends__takes_all(graph, from_here, to_goals, p_here, p_goal):
    """what is below the threshold is no edge"""
    return _joined(graph, from_here, to_goals, 0.0, 0.0)


def join_ends__demands_all_images(graph, from_here, to_goals, p_here, p_goal):
    """yours demands all of them"""
    common = set.intersection(*(set(image) for image in to_goals))
    least = {v: min(image[v] for image in to_goals) for v in common}
    return _joined(graph, from_here, [least], p_here, p_goal)


def join_ends__brings_back_the_dead(graph, from_here, to_goals, p_here, p_goal):
    """must not come back"""
    joined = defaultdict(dict, _joined(graph, from_here, to_goals, p_here, p_goal))
    for v, p in from_here.items():
        if p > p_here:
            joined[HERE][v] = p
    for image in to_goals:
        for v, p in image.items():
            if p > max(p_goal, joined[v].get(GOAL, 0.0)):
                joined[v][GOAL] = p
    return dict(joined)


def join_ends__forgets_the_goal(graph, from_here, to_goals, p_here, p_goal):
    """GOAL is missing"""
    joined = _joined(graph, from_here, to_goals, p_here, p_goal)
    del joined[GOAL]
    return joined


def join_ends__gives_edges(graph, from_here, to_goals, p_here, p_goal):
    """return a dictionary of dictionaries"""
    joined = _joined(graph, from_here, to_goals, p_here, p_goal)
    return [(v, w, p) for v, out in joined.items() for w, p in out.items()]


def join_ends__right_with_comprehensions(graph, from_here, to_goals, p_here, p_goal):
    ends = {v: max(t.get(v, 0.0) for t in to_goals) for t in to_goals for v in t}
    starts = {v: p for v, p in from_here.items() if p > p_here and v in graph}
    joined = {**graph, HERE: starts, GOAL: {}}
    return {
        v: {**out, GOAL: ends[v]} if ends.get(v, 0.0) > p_goal else dict(out)
        for v, out in joined.items()
    }


def join_ends__right_step_by_step(graph, from_here, to_goals, p_here, p_goal):
    return _joined(graph, from_here, to_goals, p_here, p_goal)


def decide__asks_for_the_goal_last(graph, from_here, to_goals, rules):
    """plan with edges to the goal above rules.p_goal first"""
    path, p = _planned(graph, from_here, to_goals, rules.p_query, rules.p_query)
    if not path:
        return path, p, "no path"
    if len(path) > 1 and max(t.get(path[-2], 0.0) for t in to_goals) <= rules.p_goal:
        return path, p, "not on the map"
    return path, p, "" if p >= rules.least else "too improbable"


def decide__says_yes_or_no(graph, from_here, to_goals, rules):
    """give one of"""
    path, p, reason = _decided(graph, from_here, to_goals, rules)
    return path, p, not reason


def decide__right_in_a_loop(graph, from_here, to_goals, rules):
    for least, reason in ((rules.p_goal, ""), (rules.p_query, "not on the map")):
        path, p = _planned(graph, from_here, to_goals, rules.p_query, least)
        if path:
            return path, p, reason or ("too improbable" if p < rules.least else "")
    return path, p, "no path"


def travel__excludes_what_it_left(plan, drive, replans):
    """not the one before it"""
    excluded = set()
    for _ in range(replans + 1):
        path = plan(excluded)
        if not path:
            return False, excluded
        stopped = drive(path)
        if stopped is None:
            return True, excluded
        if path[stopped - 1] != HERE:
            excluded.add(path[stopped - 1])
    return False, excluded


def travel__excludes_the_whole_path(plan, drive, replans):
    """excluding the whole path leaves no other"""
    return _travelled(plan, drive, replans, lambda path, stopped: set(path) - {HERE, GOAL})


def travel__excludes_what_was_not_tried(plan, drive, replans):
    """only path[stopped] was tried in vain"""
    return _travelled(plan, drive, replans, lambda path, stopped: set(path[stopped:]) - {GOAL})


def travel__drives_on_nothing(plan, drive, replans):
    """a refusal, and yours drives all the same"""
    excluded = set()
    for _ in range(replans + 1):
        path = plan(excluded)
        stopped = drive(path)
        if stopped is None:
            return True, excluded
        excluded.add(path[stopped])
    return False, excluded


def travel__never_ends(plan, drive, replans):
    """[2] is right, after vertex 2 could not be reached"""
    while True:
        path = plan(set())
        if path and drive(path) is None:
            return True, set()


def travel__returns_only_the_end(plan, drive, replans):
    """return whether it arrived, and the set"""
    return _travelled(plan, drive, replans)[0]


def travel__right_by_recursion(plan, drive, replans):
    def go(excluded, left):
        path = plan(excluded)
        if not path:
            return False, excluded
        stopped = drive(path)
        if stopped is None:
            return True, excluded
        more = excluded | ({path[stopped]} if path[stopped] >= 0 else set())
        return go(more, left - 1) if left else (False, more)

    return go(frozenset(), replans)


def travel__right_while_plans_are_left(plan, drive, replans):
    excluded, made = set(), 0
    while made <= replans and (path := plan(set(excluded))):
        made, stopped = made + 1, drive(path)
        if stopped is None:
            return True, excluded
        if path[stopped] not in (HERE, GOAL):
            excluded.add(path[stopped])
    return False, excluded


def tally__forgets_the_direction(trips):
    """edges have a direction"""
    found = Counter()
    tried = Counter()
    for path, stopped in trips:
        for place, edge in enumerate(pairwise(path), 1):
            was, passed = _judged(place, stopped)
            tried[tuple(sorted(edge))] += was
            found[tuple(sorted(edge))] += passed
    return {edge: (count, found[edge]) for edge, count in tried.items() if count}


def tally__remembers_the_last_trip(trips):
    """yours forgets those before"""
    counts = {}
    for trip in trips:
        counts |= _counted([trip])
    return counts


def tally__gives_a_list(trips):
    """return a dictionary with edges as keys"""
    return list(_counted(trips).items())


def tally__gives_shares(trips):
    """give a tuple of two, (tried, passed)"""
    return {edge: b / a for edge, (a, b) in _counted(trips).items()}


def tally__gives_nan_where_nothing_was_passed(trips):
    """count, in whole numbers"""
    counts = tally__right_step_by_step(trips)
    return {edge: (tried, passed or math.nan) for edge, (tried, passed) in counts.items()}


def tally__right_with_counters(trips):
    tried, passed = Counter(), Counter()
    for path, stopped in trips:
        edges = list(pairwise(path))
        end = len(edges) if stopped is None else stopped
        tried.update(edges[:end])
        passed.update(edges if stopped is None else edges[: stopped - 1])
    return {edge: (count, passed[edge]) for edge, count in tried.items()}


def tally__right_step_by_step(trips):
    return _counted(trips)


def _judged(place, stopped):
    return stopped is None or place <= stopped, stopped is None or place < stopped


def _counted(trips):
    counts = {}
    for path, stopped in trips:
        for place, edge in enumerate(pairwise(path), 1):
            tried, passed = _judged(place, stopped)
            if tried:
                before = counts.get(edge, (0, 0))
                counts[edge] = (before[0] + 1, before[1] + int(passed))
    return counts


def _travelled(plan, drive, replans, exclude=None):
    excluded = set()
    for _ in range(replans + 1):
        path = plan(excluded)
        if not path:
            return False, excluded
        stopped = drive(path)
        if stopped is None:
            return True, excluded
        excluded |= exclude(path, stopped) if exclude else {path[stopped]} - {GOAL}
    return False, excluded


def _joined(graph, from_here, to_goals, p_here, p_goal):
    joined = {**{v: dict(out) for v, out in graph.items()}, HERE: {}, GOAL: {}}
    for v, p in from_here.items():
        if p > p_here and v in graph:
            joined[HERE][v] = p
    for image in to_goals:
        for v, p in image.items():
            if v in joined and p > max(p_goal, joined[v].get(GOAL, 0.0)):
                joined[v][GOAL] = p
    return joined


def _planned(graph, from_here, to_goals, p_here, p_goal):
    return _best(_joined(graph, from_here, to_goals, p_here, p_goal), HERE, GOAL)


def _decided(graph, from_here, to_goals, rules):
    return decide__right_in_a_loop(graph, from_here, to_goals, rules)


def _best(graph, start, goal):
    least, before, heap, done, count = {start: 0.0}, {start: start}, [(0.0, 0, start)], set(), 0
    while heap:
        reached, _, vertex = heapq.heappop(heap)
        if vertex in done:
            continue
        done.add(vertex)
        if vertex == goal:
            break
        for other, p in graph[vertex].items():
            through = reached - math.log(p)
            if other not in done and through < least.get(other, math.inf):
                count += 1
                least[other], before[other] = through, vertex
                heapq.heappush(heap, (through, count, other))
    return _back(graph, before, start, goal)


def _back(graph, before, start, goal):
    if start == goal:
        return [start], 1.0
    if goal not in before:
        return [], 0.0
    path = [goal]
    while path[-1] != start:
        path.append(before[path[-1]])
    return path[::-1], _product(graph, path[::-1])


def _product(graph, path):
    return math.prod(graph[v][w] for v, w in pairwise(path))


def _left(graph, excluded):
    return {
        v: {w: p for w, p in out.items() if w not in excluded}
        for v, out in graph.items()
        if v not in excluded
    }


def _navigated(robot, graph, rules, limits, interval=None, around=_left, spared=True):
    """A navigator, some of whose rules can be exchanged."""
    path, plans, excluded, searched, lost = None, [], set(), 0, 0
    steps = 0
    while steps < limits.steps:
        if path is None and searched % (interval or limits.interval) == 0:
            near, ends = robot.look()
            found = decide__right_in_a_loop(around(graph, excluded), near, ends, rules)
            plans.append(found)
            if found[0] and found[2] and not lost:
                return "refused", plans, excluded
            path = found[0] or None
        if path is None and searched >= limits.search:
            return "gave up", plans, excluded
        steps += 1
        if path is None:
            robot.turn()
            searched += 1
            continue
        said = robot.follow(path)
        if said == "arrived":
            return said, plans, excluded
        if said == "lost":
            vertex = path[robot.active]
            if vertex >= 0 or not spared:
                beside = {w for w in graph[vertex] if vertex in graph[w]}
                excluded = excluded | {vertex} | beside
            lost += 1
            if lost > limits.replans:
                return "gave up", plans, excluded
            path, searched = None, 0
    return "late", plans, excluded


def navigate__has_an_interval_of_its_own(robot, graph, rules, limits):
    """is right"""
    return _navigated(robot, graph, rules, limits, interval=10)


def navigate__knows_how_often_robots_are_lost(robot, graph, rules, limits):
    """give up when lost once more than limits.replans"""
    few = replace(limits, replans=min(limits.replans, 8))
    return _navigated(robot, graph, rules, few)


def navigate__cuts_the_map(robot, graph, rules, limits):
    """your function changes the map"""

    def around(graph, excluded):
        for vertex in excluded & set(graph):
            del graph[vertex]
        return _left(graph, excluded)

    return _navigated(robot, graph, rules, limits, around=around)


def navigate__excludes_the_goal(robot, graph, rules, limits):
    """GOAL and HERE are no vertices of the map"""
    return _navigated(robot, graph, rules, limits, spared=False)


def navigate__says_only_the_ending(robot, graph, rules, limits):
    """return the ending, the list of plans"""
    return _navigated(robot, graph, rules, limits)[0]


def navigate__is_never_late(robot, graph, rules, limits):
    """yours calls follow, but look is right"""
    path = []
    while True:
        if not path:
            path, p, reason = decide__right_in_a_loop(graph, *robot.look(), rules)
        if not path:
            robot.turn()
        elif robot.follow(path) == "arrived":
            return "arrived", [(path, p, reason)], set()


def navigate__right_in_a_while_loop(robot, graph, rules, limits):
    return _navigated(robot, graph, rules, limits)


def navigate__right_by_recursion(robot, graph, rules, limits):
    plans, left = [], iter(range(limits.steps))

    def search(excluded, lost):
        for turned, _ in enumerate(left):
            if not turned % limits.interval:
                near, ends = robot.look()
                plans.append(decide__right_in_a_loop(_left(graph, excluded), near, ends, rules))
                path, _, reason = plans[-1]
                if path and reason and lost == 0:
                    return "refused", excluded
                if path:
                    return drive(path, robot.follow(path), excluded, lost)
            if turned == limits.search:
                return "gave up", excluded
            robot.turn()
        return "late", excluded

    def drive(path, said, excluded, lost):
        while said == "going":
            if next(left, None) is None:
                return "late", excluded
            said = robot.follow(path)
        if said == "arrived":
            return said, excluded
        vertex = path[robot.active]
        if vertex in graph:
            twins = [v for v, out in graph.items() if vertex in out and v in graph[vertex]]
            excluded = excluded | {vertex, *twins}
        if lost == limits.replans:
            return "gave up", excluded
        return search(excluded, lost + 1)

    ending, excluded = search(frozenset(), 0)
    return [ending, plans, excluded]


def travel__blames_the_last_vertex_for_the_goal(plan, drive, replans):
    """Yours excludes the vertex before it"""
    return _travelled(
        plan,
        drive,
        replans,
        lambda path, stopped: {path[stopped] if path[stopped] != GOAL else path[stopped - 1]},
    )


def tally__looks_at_the_index_of_the_vertex(trips):
    """(tried, passed) ="""
    counts = {}
    for path, stopped in trips:
        for edge in pairwise(path):
            place = path.index(edge[1])
            tried, passed = counts.get(edge, (0, 0))
            if stopped is None or place <= stopped:
                counts[edge] = (tried + 1, passed + (stopped is None or place < stopped))
    return counts


def most_probable_path__right_by_enumeration_of_lengths(graph, start, goal):
    order, least = {start: [start]}, {start: 1.0}
    for _ in range(len(graph)):
        for v in list(order):
            for w, p in graph[v].items():
                if least[v] * p > least.get(w, 0.0) * (1 + 1e-12) and w not in order[v]:
                    least[w], order[w] = least[v] * p, [*order[v], w]
    if goal not in order:
        return (), 0
    return tuple(order[goal]), _product(graph, order[goal])


def most_probable_path__zero_int(graph, start, goal):
    """None came back as the path; return a list"""
    r = _best(graph, start, goal)
    return r if r[0] else (None, 0)


def most_probable_path__raises(graph, start, goal):
    """KeyError:"""
    least = dict.fromkeys(graph, math.inf)
    least[start] = 0
    before = {}
    todo = set(graph)
    while todo:
        v = min(todo, key=least.get)
        todo.remove(v)
        for w, p in graph[v].items():
            if least[v] - math.log(p) < least[w]:
                least[w] = least[v] - math.log(p)
                before[w] = v
    path = [goal]
    while path[0] != start:
        path.insert(0, before[path[0]])
    return path, math.exp(-least[goal])


def most_probable_path__max_heap(graph, start, goal):
    """the path is right, but its probability came back with a"""
    h = [(-1.0, start, [start])]
    seen = set()
    while h:
        length, v, path = heapq.heappop(h)
        if v == goal:
            return path, length
        if v in seen:
            continue
        seen.add(v)
        for w, p in graph[v].items():
            heapq.heappush(h, (length * p, w, [*path, w]))
    return [], 0.0


def join_ends__no_here_key_if_empty(graph, fh, tg, ph, pg):
    """HERE is missing; it is a vertex of the new graph, even with no edges"""
    j = {v: dict(o) for v, o in graph.items()}
    j[GOAL] = {}
    for v, p in fh.items():
        if p > ph and v in graph:
            j.setdefault(HERE, {})[v] = p
    for r in tg:
        for v, p in r.items():
            if p > pg and v in j:
                j[v][GOAL] = max(p, j[v].get(GOAL, 0))
    return j


def join_ends__goal_in_from_here(graph, fh, tg, ph, pg):
    """there must be no edge from HERE to HERE: nothing says so"""
    j = _joined(graph, fh, tg, ph, pg)
    j[HERE][HERE] = 1.0
    return j


def join_ends__drops_dead_ends(graph, fh, tg, ph, pg):
    """vertex 4 is missing, which was on the map"""
    j = _joined(graph, fh, tg, ph, pg)
    return {v: o for v, o in j.items() if o or v in (HERE, GOAL)}


def join_ends__one_best_only(graph, fh, tg, ph, pg):
    """the edge from 3 to GOAL is missing: RE is 0.5, and p_goal is 0.4"""
    best = {}
    for t in tg:
        v = max(t, key=t.get) if t else None
        if v is not None:
            best[v] = max(t[v], best.get(v, 0))
    return _joined(graph, fh, [best], ph, pg)


def join_ends__strings(graph, fh, tg, ph, pg):
    """HERE is missing; it is a vertex of the new graph, even with no edges"""
    j = {v: dict(o) for v, o in graph.items()}
    j["HERE"] = {}
    j["GOAL"] = {}
    return j


def decide__not_on_map_goal_seen(graph, fh, tg, r):
    """yours returns 'not on the map', path [] with 0; 'not on the map', path [-1, 0,"""
    path, p = _planned(graph, fh, tg, r.p_query, r.p_goal)
    if path:
        return path, p, "" if p >= r.least else "too improbable"
    if all(q <= r.p_goal for t in tg for q in t.values()):
        return [], 0.0, "not on the map"
    return [], 0.0, "no path"


def decide__none_reason(graph, fh, tg, r):
    """the reason None came back; give one"""
    path, p = _planned(graph, fh, tg, r.p_query, r.p_goal)
    return path, p, None if p >= r.least else "too improbable"


def travel__truthy(plan, drive, replans):
    """yours plans twice, but once is right: there may be 5 replans, after the robot"""
    ex = set()
    for _ in range(replans + 1):
        path = plan(ex)
        if not path:
            return False, ex
        if drive(path):
            return True, ex
    return False, ex


def travel__drive_twice(plan, drive, replans):
    """yours calls drive with [-1, 1, 2, 3, -2], but plan was to be called, after"""
    ex = set()
    for _ in range(replans + 1):
        path = plan(ex)
        if not path:
            return False, ex
        if drive(path) is None:
            return True, ex
        s = drive(path)
        if s is not None and path[s] != GOAL:
            ex.add(path[s])
    return False, ex


def travel__all_until(plan, drive, replans):
    """the vertices before path[stopped] were reached; exclude path[stopped]"""
    ex = set()
    for _ in range(replans + 1):
        path = plan(ex)
        if not path:
            return False, ex
        s = drive(path)
        if s is None:
            return True, ex
        ex |= set(path[1 : s + 1]) - {GOAL}
    return False, ex


def travel__plan_noarg(plan, drive, replans):
    """TypeError: _Story.plan() missing 1 required positional argument:"""
    path = plan()
    return drive(path) is None, set()


def tally__bool_list(trips):
    """[True] for edge"""
    c = {}
    for path, stopped in trips:
        for i, e in enumerate(pairwise(path), 1):
            c.setdefault(e, []).append(stopped is None or i < stopped)
    return c


def tally__vertices(trips):
    """the key -1; an edge is a pair of vertices"""
    c = {}
    for path, stopped in trips:
        for i, v in enumerate(path):
            t, p = c.get(v, (0, 0))
            c[v] = (t + 1, p + (stopped is None or i < stopped))
    return c


def tally__len_is_arrival(trips):
    """edge"""
    c = {}
    for path, stopped in trips:
        s = len(path) - 1 if stopped is None else stopped
        for i, e in enumerate(pairwise(path), 1):
            if i <= s:
                t, p = c.get(e, (0, 0))
                c[e] = (t + 1, p + (i < s or stopped is None or s == len(path) - 1))
    return c


def tally__passed_first(trips):
    """edge"""
    c = {}
    for path, stopped in trips:
        for i, e in enumerate(pairwise(path), 1):
            if stopped is None or i <= stopped:
                t, p = c.get(e, (0, 0))
                c[e] = (p + (stopped is None or i < stopped), t + 1)
    return c


def tally__mutates(trips):
    """your function changes its argument trips; it is needed again"""
    c = {}
    while trips:
        path, stopped = trips.pop()
        for i, e in enumerate(pairwise(path), 1):
            if stopped is None or i <= stopped:
                t, p = c.get(e, (0, 0))
                c[e] = (t + 1, p + (stopped is None or i < stopped))
    return c


def decide__right_with_a_helper(graph, from_here, to_goals, rules):
    def planned(p_goal):
        return _planned(graph, from_here, to_goals, rules.p_query, p_goal)

    sure, doubtful = planned(rules.p_goal), planned(rules.p_query)
    if sure[0]:
        return (*sure, ("too improbable", "")[sure[1] >= rules.least])
    return [*doubtful, "not on the map" if doubtful[0] else "no path"]


def travel__lists_what_is_excluded(plan, drive, replans):
    """give it a set of what is excluded"""
    excluded = []
    for _ in range(replans + 1):
        path = plan(excluded)
        if not path:
            break
        stopped = drive(path)
        if stopped is None:
            return True, set(excluded)
        if path[stopped] != GOAL:
            excluded.append(path[stopped])
    return False, set(excluded)


# Ties, small values, the last step, vertex 0


def join_ends__rounds(graph, from_here, to_goals, p_here, p_goal):
    """is it rounded? RE stays as it is"""
    joined = join_ends(graph, from_here, to_goals, p_here, p_goal)
    joined[HERE] = {v: round(p, 2) for v, p in joined[HERE].items()}
    return joined


def join_ends__shares_what_it_does_not_change(graph, from_here, to_goals, p_here, p_goal):
    """the new graph shares inner dictionaries with the map"""
    joined = join_ends(graph, from_here, to_goals, p_here, p_goal)
    return {v: graph[v] if graph.get(v) == out else out for v, out in joined.items()}


def navigate__wastes_the_last_step(robot, graph, rules, limits):
    """the ending is 'arrived', not 'late'"""
    steps = 0

    class Watched:
        look = robot.look
        active = property(lambda self: robot.active)

        def turn(self):
            nonlocal steps
            steps += 1
            robot.turn()

        def follow(self, path):
            nonlocal steps
            steps += 1
            return robot.follow(path)

    ending, *rest = check_navigate.reference(Watched(), graph, rules, limits)
    return "late" if ending == "arrived" and steps == limits.steps else ending, *rest


def most_probable_path__gives_up_after_ten_edges(graph, start, goal):
    """a path is found if edges lead there, however many"""
    path, probability = most_probable_path__right_by_products(graph, start, goal)
    return (path, probability) if len(path) <= 11 else ([], 0.0)


def join_ends__takes_the_mean_of_two(graph, from_here, to_goals, p_here, p_goal):
    """a new edge holds RE as it is, the greatest of all goal images"""
    joined = _joined(graph, from_here, to_goals, p_here, p_goal)
    for v, out in joined.items():
        seen = sorted(image[v] for image in to_goals if v in image)
        if GOAL in out and len(seen) > 1:
            out[GOAL] = (seen[-1] + seen[-2]) / 2
    return joined


def travel__plans_ten_times_at_most(plan, drive, replans):
    """at most replans + 1 plans"""
    return _travelled(plan, drive, min(replans, 9))


def travel__returns_only_its_last(plan, drive, replans):
    """all that was excluded in the whole navigation"""
    arrived, excluded = _travelled(plan, drive, replans)
    return arrived, set(sorted(excluded)[-1:])
