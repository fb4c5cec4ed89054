"""Answers to the exercises of notebook 08 that are no edits of the rule; see the other files.

The check must say the docstring; answers called right must pass.
"""

import heapq
import math
import random
from itertools import pairwise

import networkx as nx
import numpy as np
from scipy.linalg import logm

# length


def length__right_by_the_matrix_logarithm(waypoints):
    found = []
    for x, y, turn in waypoints.reshape(-1, 3):
        c, s = math.cos(turn), math.sin(turn)
        found.append(np.linalg.norm(logm(np.array([[c, -s, x], [s, c, y], [0, 0, 1]]))))
    return np.array(found).reshape(waypoints.shape[:-1])


def length__right_with_a_case(waypoints):
    chord, turn = np.linalg.norm(waypoints[..., :2], axis=-1), waypoints[..., 2]
    half = np.where(np.abs(turn) < 1e-9, 1.0, turn / 2)
    arc = np.where(np.abs(turn) < 1e-9, chord, chord * half / np.sin(half))
    return np.hypot(arc, math.sqrt(2) * turn)


def length__straight(waypoints):
    """a turn in place counts sqrt(2) times its angle (0"""
    return np.linalg.norm(waypoints[..., :2], axis=-1)


def length__of_the_vector(waypoints):
    """sqrt(2) times its angle"""
    return np.linalg.norm(waypoints, axis=-1)


def length__divides_by_zero(waypoints):
    """is something divided by zero?"""
    chord, turn = np.linalg.norm(waypoints[..., :2], axis=-1), waypoints[..., 2]
    return np.sqrt((chord * turn / 2 / np.sin(turn / 2)) ** 2 + 2 * turn**2)


def length__in_degrees(waypoints):
    """a turn in place counts sqrt(2) times its angle"""
    chord, turn = np.linalg.norm(waypoints[..., :2], axis=-1), waypoints[..., 2]
    return np.sqrt((chord / np.sinc(turn / (2 * np.pi))) ** 2 + 2 * np.rad2deg(turn) ** 2)


def length__of_one(waypoints):
    """return a numpy array"""
    return float(np.hypot(waypoints[0, 0], waypoints[0, 1]))


# build_map


def build_map__right_with_arrays(reachable, lengths, order, merge, connect):
    reachable, lengths = np.array(reachable), np.array(lengths)
    close, near = reachable & (lengths < merge), reachable & (lengths < connect)
    vertices, edges, left = [order[0]], [], order[1:]
    while True:
        later, grew = [], False
        for image in left:
            now = np.array(vertices)
            if close[now, image].any() or close[image, now].any():
                continue
            into, out = now[near[now, image]], now[near[image, now]]
            if not (into.size or out.size):
                later.append(image)
                continue
            edges.extend((int(v), image) for v in into)
            edges.extend((image, int(v)) for v in out)
            vertices.append(image)
            grew = True
        if not grew:
            return vertices, edges
        left = later


def build_map__right_as_tuples(reachable, lengths, order, merge, connect):
    vertices, edges = build_map__right_with_arrays(reachable, lengths, order, merge, connect)
    return tuple(vertices), {tuple(edge) for edge in edges}


def build_map__first_in_order_again(reachable, lengths, order, merge, connect):
    """images are tried in their order"""
    vertices, edges, left = [order[0]], [], list(order[1:])
    again = True
    while again:
        again = False
        for image in list(left):
            close = [(v, image) for v in vertices] + [(image, v) for v in vertices]
            if any(reachable[pair] and lengths[pair] < merge for pair in close):
                left.remove(image)
                continue
            new = [(v, image) for v in vertices if reachable[v, image]]
            new += [(image, v) for v in vertices if reachable[image, v]]
            new = [edge for edge in new if lengths[edge] < connect]
            if new:
                vertices.append(image)
                edges += new
                left.remove(image)
                again = True
                break
    return vertices, edges


def build_map__sorted(reachable, lengths, order, merge, connect):
    """images are tried in their order"""
    vertices, edges = build_map__right_with_arrays(reachable, lengths, order, merge, connect)
    return sorted(vertices), edges


def build_map__all_of_them(reachable, lengths, order, merge, connect):
    """is no vertex"""
    edges = np.argwhere(reachable & (lengths < connect))
    return order, [tuple(edge) for edge in edges.tolist()]


def build_map__no_edges(reachable, lengths, order, merge, connect):
    """return two lists"""
    return build_map__right_with_arrays(reachable, lengths, order, merge, connect)[0]


def build_map__spoils_the_order(reachable, lengths, order, merge, connect):
    """order"""
    first = order.pop(0)
    return build_map__right_with_arrays(reachable, lengths, [first, *order], merge, connect)


# bayes


def bayes__right_by_odds(prior, succeeds, deceives, success):
    if prior in (0.0, 1.0):
        return prior
    ratio = succeeds / deceives if success else (1 - succeeds) / (1 - deceives)
    odds = prior / (1 - prior) * ratio
    return odds / (1 + odds)


def bayes__right_in_a_table(prior, succeeds, deceives, success):
    table = np.array([[1 - deceives, deceives], [1 - succeeds, succeeds]])
    joint = np.array([1 - prior, prior]) * table[:, int(success)]
    return joint[1] / joint.sum()


def bayes__moving_average(prior, succeeds, deceives, success):
    """prior x likelihood"""
    return 0.7 * prior + 0.3 * success


def bayes__product(prior, succeeds, deceives, success):
    """divide by p(s)"""
    return prior * (succeeds if success else 1 - succeeds)


def bayes__prints(prior, succeeds, deceives, success):
    """returned nothing"""
    print(prior * succeeds)


def bayes__odds(prior, succeeds, deceives, success):
    """a probability lies between 0 and 1"""
    ratio = succeeds / deceives if success else (1 - succeeds) / (1 - deceives)
    return prior / max(1 - prior, 1e-12) * ratio


# gaussian


def gaussian__right_by_precision(mean, variance, measured, noise):
    precision = 1 / variance + 1 / noise
    return (mean / variance + measured / noise) / precision, 1 / precision


def gaussian__right_as_a_list(mean, variance, measured, noise):
    gain = variance / (variance + noise)
    return [mean + gain * (measured - mean), (1 - gain) * variance]


def gaussian__mean_only(mean, variance, measured, noise):
    """return two numbers"""
    return mean + variance / (variance + noise) * (measured - mean)


def gaussian__running_mean(mean, variance, measured, noise):
    """the mean moves towards what was measured"""
    return 0.9 * mean + 0.1 * measured, variance * noise / (variance + noise)


def gaussian__smaller_of_both(mean, variance, measured, noise):
    """the variance: 1 / new"""
    gain = variance / (variance + noise)
    return mean + gain * (measured - mean), min(variance, noise)


# expand


def expand__right_by_search(graph, unused, joins, here, goal):
    ahead = {v: set(graph.successors(v)) for v in graph}
    for image in unused:
        for source, target in joins[image]:
            ahead.setdefault(source, set()).add(target)
        before, queue = {here: None}, [here]
        for vertex in queue:
            for other in sorted(ahead.get(vertex, ())):
                if other not in before:
                    before[other] = vertex
                    queue.append(other)
        if goal in before:
            path = [goal]
            while before[path[-1]] is not None:
                path.append(before[path[-1]])
            return [v for v in path[::-1] if v not in graph]
    return []


def expand__right_as_a_set(graph, unused, joins, here, goal):
    return set(expand__right_by_search(graph, unused, joins, here, goal))


def expand__changes_the_map(graph, unused, joins, here, goal):
    """graph"""
    found = expand__right_by_search(graph, unused, joins, here, goal)
    for image in found:
        graph.add_edges_from(joins[image])
    return found


def expand__the_nearest(graph, unused, joins, here, goal):
    """kept are those images that are on the first path"""
    return [image for image in unused if len(joins[image]) > 1]


def expand__asks_for_a_path(graph, unused, joins, here, goal):
    """ask nx.has_path before you ask for a path"""
    trial = graph.copy()
    for image in unused:
        trial.add_edges_from(joins[image])
        path = nx.shortest_path(trial, here, goal)
        if path:
            return [v for v in path if v not in graph]
    return []


# live


def live__right_with_a_heap(graph, queries, drive, update, prune):
    answers = []
    for start, goal in queries:
        here, failed = start, []
        while here != goal:
            best, heap, before = {here: 0.0}, [(0.0, here)], {}
            while heap:
                metres, vertex = heapq.heappop(heap)
                for other in graph.successors(vertex):
                    further = metres + graph.edges[vertex, other]["length"]
                    if (vertex, other) not in failed and further < best.get(other, math.inf):
                        best[other], before[other] = further, vertex
                        heapq.heappush(heap, (further, other))
            if goal not in best:
                break
            ahead = goal
            while before[ahead] != here:
                ahead = before[ahead]
            success = drive(here, ahead)
            p = update(graph.edges[here, ahead]["probability"], success)
            graph.edges[here, ahead]["probability"] = p
            if success:
                here = ahead
                continue
            failed.append((here, ahead))
            if p < prune:
                graph.remove_edge(here, ahead)
        answers.append(here == goal)
    return answers


def _lives(graph, queries, drive, update, prune, both=False, whole=False, other=False):
    answers = []
    for start, goal in queries:
        here, failed = start, set()
        while here != goal:
            left = nx.restricted_view(graph, [], [e for e in failed if graph.has_edge(*e)])
            if not nx.has_path(left, here, goal):
                break
            path = nx.dijkstra_path(left, here, goal, weight="length")
            for a, b in pairwise(path) if whole else [path[:2]]:
                success = drive(a, b)
                for edge in ((a, b), (b, a)) if both else [(a, b)]:
                    if graph.has_edge(*edge):
                        before = graph.edges[edge]["probability"]
                        graph.edges[edge]["probability"] = update(before, success)
                if not success:
                    failed.add((a, b))
                    if graph.edges[a, b]["probability"] < prune:
                        if other and graph.has_edge(b, a):
                            graph.remove_edge(b, a)
                        graph.remove_edge(a, b)
                    break
                here = b
        answers.append(here == goal)
    return answers


def live__right_whole_paths(graph, queries, drive, update, prune):
    return _lives(graph, queries, drive, update, prune, whole=True)


def live__both_directions(graph, queries, drive, update, prune):
    """each traversal updates its own edge once, and no other"""
    return _lives(graph, queries, drive, update, prune, both=True)


def live__prunes_both_directions(graph, queries, drive, update, prune):
    """after a failure an edge below R_p is taken out, and no other"""
    return _lives(graph, queries, drive, update, prune, other=True)


def live__works_on_a_copy(graph, queries, drive, update, prune):
    """the graph that you are given has to learn"""
    return _lives(graph.copy(), queries, drive, update, prune)


def live__tries_for_ever(graph, queries, drive, update, prune):
    """over the edges that have not failed"""
    for start, goal in queries:
        here = start
        while here != goal and nx.has_path(graph, here, goal):
            ahead = nx.dijkstra_path(graph, here, goal, weight="length")[1]
            success, edge = drive(here, ahead), graph.edges[here, ahead]
            edge["probability"] = max(update(edge["probability"], success), 0.1)
            if success:
                here = ahead
    return [True] * len(queries)


def live__by_chance(graph, queries, drive, update, prune):
    """drive the first edge of the shortest path"""
    rng, answers = random.Random(0), []
    for start, goal in queries:
        here = start
        for _ in range(6):
            if here == goal or not list(graph.successors(here)):
                break
            ahead = rng.choice(list(graph.successors(here)))
            if drive(here, ahead):
                here = ahead
        answers.append(here == goal)
    return answers


def live__nothing_back(graph, queries, drive, update, prune):
    """returned nothing"""
    _lives(graph, queries, drive, update, prune)
