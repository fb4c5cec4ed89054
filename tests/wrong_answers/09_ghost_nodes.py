"""Answers to the exercises of notebook 09: wrong ones, with words of their message, and right ones.

The check must say the docstring; answers called right must pass.
"""

import heapq
import math

import networkx as nx
import numpy as np

from tutorial_lib.checks.nb09 import CELL, path_lengths
from tutorial_lib.checks.nb09.add_ghosts import add_ghosts as added
from tutorial_lib.checks.nb09.global_policy import global_policy as chosen
from tutorial_lib.geometry import inverse, to_local

# explorable


def explorable__right_in_a_loop(free, radius):
    lengths, middle, found = path_lengths(free), len(free) // 2, []
    for k in range(12):
        row = middle + round(radius / CELL * math.sin(math.radians(30 * k)))
        column = middle + round(radius / CELL * math.cos(math.radians(30 * k)))
        found.append(lengths[row, column] <= 1.05 * radius)
    return np.array(found)


def explorable__right_with_complex_numbers(free, radius):
    points = radius / CELL * np.exp(2j * np.pi * np.arange(12) / 12) + (1 + 1j) * (len(free) // 2)
    cells = np.rint(points.imag).astype(int), np.rint(points.real).astype(int)
    return path_lengths(free)[cells] / radius <= 1.05


def _lengths_at(free, radius, turn=1):
    bearings, middle, reach = turn * np.arange(12) * np.pi / 6, len(free) // 2, radius / CELL
    columns = middle + np.rint(reach * np.cos(bearings)).astype(int)
    rows = middle + np.rint(reach * np.sin(bearings)).astype(int)
    return path_lengths(free)[rows, columns], rows, columns


def explorable__only_the_point(free, radius):
    """it may be free and lie behind a wall"""
    _, rows, columns = _lengths_at(free, radius)
    return free[rows, columns]


def explorable__clockwise(free, radius):
    """directions go counter-clockwise"""
    return _lengths_at(free, radius, turn=-1)[0] <= 1.05 * radius


def explorable__lengths(free, radius):
    """return True or False for each"""
    return _lengths_at(free, radius)[0]


def explorable__not_whole(free, radius):
    """an index is a whole number"""
    return path_lengths(free)[len(free) // 2 + np.cos(np.arange(12)), 0] <= radius


# add_ghosts


def add_ghosts__right_with_bins_in_degrees(ghosts, node, explorable, beside):
    gone = set()
    for other, pose in beside.items():
        back = to_local(pose, np.zeros(2))
        there = np.degrees(math.atan2(pose[1], pose[0]))
        gone.add((node, int((there % 360 + 15) // 30) % 12))
        gone.add((other, int((np.degrees(math.atan2(back[1], back[0])) % 360 + 15) // 30) % 12))
    return (ghosts | {(node, int(k)) for k in np.flatnonzero(explorable)}) - gone


def add_ghosts__right_by_the_nearest_direction(ghosts, node, explorable, beside):
    centres = np.exp(1j * np.pi / 6 * np.arange(12))

    def nearest(pose):
        return int((centres.conj() * complex(*pose[:2])).real.argmax())

    closed = {(node, nearest(pose)) for pose in beside.values()}
    closed |= {(other, nearest(inverse(pose))) for other, pose in beside.items()}
    own = {(node, k) for k, good in enumerate(explorable) if good}
    return {ghost for ghost in {*ghosts, *own} if ghost not in closed}


def _bin(x, y, _):
    return round(np.arctan2(y, x) * 6 / np.pi) % 12


def add_ghosts__in_place(ghosts, node, explorable, beside):
    """your function changes its argument ghosts"""
    ghosts |= {(node, k) for k in range(12) if explorable[k]}
    return added(ghosts, node, explorable, beside)


def add_ghosts__remove(ghosts, node, explorable, beside):
    """.discard does not"""
    grown = set(ghosts) | {(node, k) for k in range(12) if explorable[k]}
    for other, pose in beside.items():
        grown.remove((other, _bin(*inverse(pose))))
        grown.discard((node, _bin(*pose)))
    return grown


def add_ghosts__list(*case):
    """a list came back"""
    return list(added(*case))


def add_ghosts__floats(ghosts, node, explorable, beside):
    """node and direction are whole numbers"""
    return {(node, float(k)) for k in range(12)}


def add_ghosts__right_as_a_frozenset(ghosts, node, explorable, beside):
    return frozenset(added(ghosts, node, explorable, beside))


# global_policy


def global_policy__right_by_hand(graph, here, ghosts, scores, goal=None, weight=0.0):
    metres, before, waiting = {}, {here: here}, [(0.0, here, here)]
    while waiting:
        far, node, last = heapq.heappop(waiting)
        if node not in metres:
            metres[node], before[node] = far, last
            for other, edge in graph[node].items():
                heapq.heappush(waiting, (far + edge["metres"], other, node))
    ghost, end = None, goal
    if end is None:
        values = {g: scores[g] - weight * metres[g[0]] / 20 for g in ghosts}
        if not values:
            return here, None
        ghost = sorted(values, key=values.get)[-1]
        end = ghost[0]
    while before[end] != here and end != here:
        end = before[end]
    return end, ghost


def global_policy__right_by_all_paths(graph, here, ghosts, scores, goal=None, weight=0.0):
    metres, paths = nx.single_source_dijkstra(graph, here, weight="metres")
    if goal is not None:
        return (*paths[goal], goal)[min(1, len(paths[goal]) - 1)], None
    ranked = sorted((weight * metres[g[0]] / 20 - scores[g], g) for g in ghosts)
    if not ranked:
        return (here, None)
    path = paths[ranked[0][1][0]]
    return (path[1] if len(path) > 1 else here), ranked[0][1]


def global_policy__of_nothing(graph, here, ghosts, scores, goal=None, weight=0.0):
    """there may be no ghost left"""
    ghost = None if goal is not None else max(ghosts, key=lambda g: scores[g])
    return chosen(graph, here, ghosts, scores, goal, weight)[0], ghost


def global_policy__next_index(graph, here, ghosts, scores, goal=None, weight=0.0):
    """the path has one node"""
    ghost = None
    if goal is None and ghosts:
        metres = nx.single_source_dijkstra_path_length(graph, here, weight="metres")
        ghost = max(sorted(ghosts), key=lambda g: scores[g] - weight * metres[g[0]] / 20)
    elif goal is None:
        goal = here
    path = nx.shortest_path(graph, here, ghost[0] if ghost else goal, weight="metres")
    return path[1], ghost


def global_policy__changes_the_graph(graph, here, ghosts, scores, goal=None, weight=0.0):
    """your function changes its argument graph"""
    graph.add_node(99)
    return chosen(graph, here, ghosts, scores, goal, weight)


def global_policy__node_only(graph, here, ghosts, scores, goal=None, weight=0.0):
    """return the next node, and the ghost or None"""
    return chosen(graph, here, ghosts, scores, goal, weight)[0]


def global_policy__whole_metres(graph, here, ghosts, scores, goal=None, weight=0.0):
    """a fraction of a metre decides"""
    if goal is not None or not ghosts:
        return chosen(graph, here, ghosts, scores, goal, weight)
    metres = nx.single_source_dijkstra_path_length(graph, here, weight="metres")
    best = max(sorted(ghosts), key=lambda g: scores[g] - weight * int(metres[g[0]]) / 20)
    path = nx.shortest_path(graph, here, best[0], weight="metres")
    return path[min(1, len(path) - 1)], best


def global_policy__cost_among_the_two_best(graph, here, ghosts, scores, goal=None, weight=0.0):
    """the third best score is here"""
    best = set(sorted(ghosts, key=scores.get)[-2:])
    return chosen(graph, here, best, scores, goal, weight)


# spl


def spl__right_with_a_small_number(success, shortest, travelled):
    return (success * shortest / (np.maximum(shortest, travelled) + 1e-8)).mean()


def spl__right_in_single_precision(success, shortest, travelled):
    shortest, travelled = np.float32(shortest), np.float32(travelled)
    return np.mean(success * shortest / np.maximum(shortest, travelled), dtype=np.float32)


def spl__divides_by_nothing(success, shortest, travelled):
    """a robot that does not move and fails"""
    return np.mean(np.minimum(success * shortest / travelled, 1))


def spl__as_text(success, shortest, travelled):
    """isn't a number"""
    return str(np.mean(success * shortest / np.maximum(shortest, travelled)))


def spl__right_in_a_loop(success, shortest, travelled):
    total = 0.0
    for done, least, metres in zip(success, shortest, travelled, strict=True):
        if done:
            total += least / max(least, metres)
    return total / len(success)


def spl__right_with_a_minimum(success, shortest, travelled):
    with np.errstate(divide="ignore"):
        return float(np.where(success, np.minimum(shortest / travelled, 1), 0).mean())


def spl__each_episode(success, shortest, travelled):
    """shape (1,), but () is needed"""
    return success * shortest / np.maximum(shortest, travelled)


def spl__python_s_max(success, shortest, travelled):
    """of arrays they are &, |, ~, np.maximum"""
    return np.mean(success * shortest / max(shortest, travelled))


# explore


def explore__right_with_a_queue_of_what_is_known(robot):
    graph, ghosts, scores = nx.Graph(), set(), {}
    reached, fresh = False, True
    while robot.steps > 0 and not reached:
        reached = robot.sees_goal() and robot.to_goal()
        if reached:
            break
        known = robot.node()
        if known is None or fresh:
            known = graph.number_of_nodes()
            near = robot.beside()
            graph.add_node(known)
            graph.add_edges_from(
                (known, node, {"metres": float(np.linalg.norm(pose[:2]))})
                for node, pose in near.items()
            )
            ghosts = added(ghosts, known, robot.explorable(), near)
            scores.update({(known, k): s for k, s in enumerate(robot.scores())})
            robot.remember(known)
        step, ghost = chosen(graph, known, ghosts, scores)
        fresh = False
        if ghost is None:
            return False, graph, ghosts
        if step == known:
            ghosts = {other for other in ghosts if other != ghost}
            fresh = bool(robot.to_ghost(ghost))
        else:
            robot.to_node(step)
    return reached, graph, ghosts


def explore__right_that_drives_the_whole_path(robot):
    graph, ghosts, scores, arrived = nx.Graph(), set(), {}, True
    while robot.steps:
        if robot.sees_goal() and robot.to_goal():
            return True, graph, ghosts
        here = robot.node()
        if arrived or here is None:
            here = len(graph)
            beside = robot.beside()
            graph.add_node(here)
            for node in beside:
                graph.add_edge(here, node, metres=math.dist((0, 0), beside[node][:2]))
            ghosts = added(ghosts, here, robot.explorable(), beside)
            scores |= dict(zip([(here, k) for k in range(12)], robot.scores(), strict=True))
            robot.remember(here)
        arrived = False
        if not ghosts:
            break
        best = max(ghosts, key=scores.__getitem__)
        path = nx.dijkstra_path(graph, here, best[0], weight="metres")
        if len(path) > 1:
            robot.to_node(path[1])
            continue
        arrived = robot.to_ghost(best)
        ghosts = ghosts - {best}
    return False, graph, ghosts


def _loop(robot, **faults):
    """The loop with switches for mistakes."""
    graph, ghosts, scores, arrived, rounds = nx.Graph(), set(), {}, False, 0
    while faults.get("endless") or (robot.steps > 0 and rounds < faults.get("rounds", 1_000)):
        rounds += 1
        if robot.sees_goal():
            if robot.to_goal():
                return True, graph, ghosts
            arrived = faults.get("after_mistake", arrived)
        here = robot.node()
        new = here is None or arrived
        new = (not len(graph) or arrived) if faults.get("arrived_only") else new
        if new or faults.get("always_new"):
            here, beside = len(graph), robot.beside()
            graph.add_node(here)
            for other, pose in beside.items():
                if not faults.get("no_edges"):
                    graph.add_edge(here, other, metres=np.hypot(*pose[:2]))
            old = ghosts if faults.get("comes_back") else set()
            ghosts = added(ghosts, here, robot.explorable(), beside) | old
            for k, score in enumerate(robot.scores()):
                scores[here, k] = score
            if not faults.get("never_remembers"):
                robot.remember(here)
        node, ghost = chosen(graph, here, ghosts, scores)
        if ghost is None and faults.get("no_break"):
            continue
        if ghost is None:
            break
        if node != here and not faults.get("straight"):
            robot.to_node(ghost[0] if faults.get("to_the_end") else node)
            arrived = False
            continue
        there = robot.to_ghost(ghost)
        arrived = there or faults.get("never_asks", False) or (arrived and "stays" in faults)
        ghosts = ghosts - {ghost}
    return False, graph, ghosts


def explore__does_not_end(robot):
    """no steps are left"""
    return _loop(robot, endless=True)


def explore__a_node_each_round(robot):
    """make one only where node() returns None"""
    return _loop(robot, always_new=True)


def explore__no_edges(robot):
    """is missing: each new node gets edges"""
    return _loop(robot, no_edges=True)


def explore__never_remembers(robot):
    """`remember` makes one"""
    return _loop(robot, never_remembers=True)


def explore__straight_to_the_ghost(robot):
    """drive to that node first"""
    return _loop(robot, straight=True)


def explore__to_the_end_of_the_path(robot):
    """drive from node to node"""
    return _loop(robot, to_the_end=True)


def explore__does_not_ask_whether_it_arrived(robot):
    """to_ghost() returned False, so it has not arrived"""
    return _loop(robot, never_asks=True)


def explore__a_node_only_at_ghosts(robot):
    """make one wherever node() is None"""
    return _loop(robot, arrived_only=True)


def explore__one_answer(robot):
    """return whether the goal was reached, the graph, and the set of ghosts"""
    return _loop(robot)[0]


def explore__ghosts_as_a_list(robot):
    """a list came back; return the set of ghosts"""
    reached, graph, ghosts = _loop(robot)
    return reached, graph, list(ghosts)


def explore__right_that_ends_with_the_steps(robot):
    graph, ghosts, scores, arrived, reached = nx.Graph(), set(), {}, False, False
    while robot.steps > 0:
        if robot.sees_goal():
            reached = robot.to_goal()
            if reached:
                continue
        here = robot.node()
        if here is None or arrived:
            here, beside = len(graph), robot.beside()
            graph.add_node(here)
            for other, pose in beside.items():
                graph.add_edge(here, other, metres=float(np.hypot(pose[0], pose[1])))
            ghosts = frozenset(added(ghosts, here, robot.explorable(), beside))
            scores |= {(here, k): score for k, score in enumerate(robot.scores())}
            robot.remember(here)
            arrived = False
        node, ghost = chosen(graph, here, set(ghosts), scores)
        if ghost is None:
            break
        if node == here:
            arrived, ghosts = robot.to_ghost(ghost), ghosts - {ghost}
        else:
            robot.to_node(node)
    return reached, graph, ghosts


def explore__arrives_by_mistake(robot):
    """make one only where node() returns None"""
    return _loop(robot, after_mistake=True)


def explore__stays_arrived(robot):
    """to_ghost() returned False, so it has not arrived"""
    return _loop(robot, stays=True)


def explore__explored_ghosts_come_back(robot):
    """take the set that add_ghosts returns in place of the old one"""
    return _loop(robot, comes_back=True)


def explore__fifty_rounds(robot):
    """yours drives 50 times, but 60 times is right"""
    return _loop(robot, rounds=50)


def explore__goes_on_without_ghosts(robot):
    """does the loop go on where global_policy returns no ghost?"""
    return _loop(robot, no_break=True)


def explore__returns_what_it_sees(robot):
    """it returns True, but False is right"""
    reached, graph, ghosts = _loop(robot)
    return reached or robot.sees_goal(), graph, ghosts


def explore__a_directed_graph(robot):
    """a DiGraph came back"""
    reached, graph, ghosts = _loop(robot)
    return reached, graph.to_directed(), ghosts


def explore__edges_with_a_weight(robot):
    """has no "metres\""""
    reached, graph, ghosts = _loop(robot)
    other = nx.Graph()
    other.add_nodes_from(graph)
    other.add_weighted_edges_from(graph.edges(data="metres"))
    return reached, other, ghosts


def explore__steps_called(robot):
    """robot.steps is a number, without parentheses"""
    return _loop(robot) if robot.steps() > 0 else None


# One branch only, costs, the last step, aliases


def add_ghosts__gives_the_same_set_back(ghosts, node, explorable, beside):
    """return a new set, also where nothing changes"""
    return added(ghosts, node, explorable, beside) if any(explorable) or beside else ghosts


def explorable__compares_with_a_number(free, radius):
    """the path to the point is longer than 1.05 * radius"""
    return _lengths_at(free, radius)[0] <= 1.05 * 3.0


def add_ghosts__only_the_nearest_node(ghosts, node, explorable, beside):
    """for every node beside and whatever ghosts the new one has"""
    near = sorted(beside, key=lambda other: np.hypot(*beside[other][:2]))[:1]
    return added(ghosts, node, explorable, {other: beside[other] for other in near})


def global_policy__rounds_where_nothing_costs(graph, here, ghosts, scores, goal=None, weight=0.0):
    """with its digits as they are"""
    some = {ghost: round(score, 1) for ghost, score in scores.items()}
    return chosen(graph, here, ghosts, scores if weight else some, goal, weight)


def spl__takes_the_median(success, shortest, travelled):
    """each one that failed with 0"""
    return float(np.median(success * shortest / np.maximum(shortest, travelled)))
