"""Answers to the exercises of notebook 07: wrong ones, with words of their message, and right ones.

The check must say the docstring; answers called right must pass.
"""

from collections import Counter
from itertools import groupby

import numpy as np

from tutorial_lib.checks.nb07 import (
    distance,
)
from tutorial_lib.checks.nb07.predict import predict as moved_on
from tutorial_lib.checks.nb07.update import update as looked

# predict


def predict__right_in_a_loop(belief, motion, lengths, onward):
    prior = np.zeros(belief.shape)
    for robot in range(len(belief)):
        for v in range(len(lengths)):
            stays = np.exp(-motion[robot] / lengths[v])
            prior[robot, v] += belief[robot, v] * stays
            for w in range(len(lengths)):
                prior[robot, w] += belief[robot, v] * (1 - stays) * onward[v, w]
    return prior


def predict__right_by_matrices(belief, motion, lengths, onward):
    count = len(lengths)
    rows = []
    for row, metres in zip(belief, motion, strict=True):
        leave = np.diag(-np.expm1(-metres / lengths))
        rows.append(row @ (np.eye(count) - leave + leave @ onward))
    return np.array(rows)


def predict__without_none(belief, motion, lengths, onward):
    """motion[:, None] / lengths has the shape"""
    leave = 1 - np.exp(-motion / lengths)
    return belief * (1 - leave) + (belief * leave) @ onward


def predict__changes_the_belief(belief, motion, lengths, onward):
    """your function changes its argument belief"""
    belief *= np.exp(-motion[:, None] / lengths)
    return belief


def _moves(belief, leave, onward):
    return belief * (1 - leave) + (belief * leave) @ onward


def predict__right_each_robot_by_itself(belief, motion, lengths, onward):
    prior = belief.copy()
    for robot in np.flatnonzero(motion):
        leave = 1 - np.exp(-motion[robot] / lengths)
        prior[robot] = _moves(belief[robot], leave, onward)
    return prior


def predict__float32(belief, motion, lengths, onward):
    """float32 keeps seven digits only"""
    out = (belief * (1 - np.exp(-motion[:, None] / lengths))).astype(np.float32)
    return (belief - out + out @ onward).astype(np.float32)


def predict__never_by_zero(belief, motion, lengths, onward):
    """or a small number added"""
    return _moves(belief, 1 - np.exp(-motion[:, None] / (lengths + 1e-6)), onward)


_SEEN = {}


def predict__remembers_the_first_motion(belief, motion, lengths, onward):
    """is right"""
    stays = _SEEN.setdefault(belief.shape, np.exp(-motion[:, None] / lengths))
    return _moves(belief, 1 - stays, onward)


# update


def update__right_in_a_loop(prior, likelihood):
    rows = []
    for one, seen in zip(prior, likelihood, strict=True):
        weights = [p * q for p, q in zip(one, seen, strict=True)]
        if not sum(weights):
            weights[-1] = 1.0
        rows.append([w / sum(weights) for w in weights])
    return np.array(rows)


def update__right_by_logarithms(prior, likelihood):
    with np.errstate(divide="ignore"):
        logs = np.log(prior) + np.log(likelihood)
    best = logs.max(axis=1, keepdims=True)
    weights = np.exp(logs - np.where(np.isfinite(best), best, 0))
    weights[~np.isfinite(best[:, 0]), -1] = 1
    return weights / weights.sum(axis=1)[:, None]


def update__not_normalized(prior, likelihood):
    """must sum to one again"""
    return prior * likelihood


def update__spreads_evenly(prior, likelihood):
    """yours spreads it evenly"""
    weights = prior * likelihood
    weights[weights.sum(axis=1) == 0] = 1
    return weights / weights.sum(axis=1, keepdims=True)


def update__nothing_returned(prior, likelihood):
    """is a return missing"""
    weights = prior * likelihood
    weights /= weights.sum()


def update__right_by_the_greatest_first(prior, likelihood):
    weights = prior * likelihood
    weights[~weights.any(axis=1), -1] = 1
    weights = weights / weights.max(axis=1, keepdims=True)
    return weights / weights.sum(axis=1, keepdims=True)


def update__right_repaired_afterwards(prior, likelihood):
    weights = prior * likelihood
    belief = weights / weights.sum(axis=1, keepdims=True)
    nowhere = np.isnan(belief).any(axis=1)
    belief[nowhere] = np.eye(belief.shape[1])[-1]
    return belief


def _over(weights):
    return weights / weights.sum(axis=1, keepdims=True)


def update__float32(prior, likelihood):
    """float32 keeps seven digits only"""
    weights = (prior * likelihood).astype(np.float32)
    weights[weights.sum(axis=1) == 0, -1] = 1
    return _over(weights)


# match_sequence


def match_sequence__right_by_recursion(likelihoods, before):
    def best(view, vertex):
        if vertex < 0:
            return 0.0
        here = likelihoods[view, vertex]
        if not view:
            return here
        return here * max(best(view - 1, vertex), best(view - 1, before[vertex]))

    count = len(likelihoods)
    return np.array([best(count - 1, v) ** (1 / count) for v in range(len(before))])


def match_sequence__right_by_logarithms(likelihoods, before):
    logs = np.log(likelihoods)
    total = logs[0]
    for look in logs[1:]:
        come = np.where(before < 0, -np.inf, total[before])
        total = look + np.maximum(come, total)
    return np.exp(total / len(logs))


def match_sequence__only_the_last(likelihoods, before):
    """looks at the last view only"""
    return likelihoods[-1].copy()


def _matched(likelihoods, before, none=0.0, root=None):
    total = likelihoods[0]
    for look in likelihoods[1:]:
        total = look * np.maximum(total, np.where(before >= 0, total[before], none))
    return total ** (1 / (root or len(likelihoods)))


def match_sequence__right_padded(likelihoods, before):
    total = likelihoods[0]
    for look in likelihoods[1:]:
        total = look * np.maximum(total, np.append(total, 0)[before])
    return total ** (1 / len(likelihoods))


def match_sequence__right_staying_where_none_is_before(likelihoods, before):
    before = np.where(before < 0, np.arange(len(before)), before)
    total = np.ones(len(before))
    for look in likelihoods:
        total = look * np.maximum(total, total[before])
    return total ** (1 / len(likelihoods))


def match_sequence__square_root(likelihoods, before):
    """not always the square root"""
    return _matched(likelihoods, before, root=2)


def match_sequence__one_where_there_is_none(likelihoods, before):
    """has the likelihood 0, not 1"""
    return _matched(likelihoods, before, none=1.0)


def match_sequence__a_little_added(likelihoods, before):
    """or a small number added"""
    logs = np.log(likelihoods + 1e-7)
    total = logs[0]
    for look in logs[1:]:
        total = look + np.maximum(total, np.where(before >= 0, total[before], -np.inf))
    return np.exp(total / len(logs))


# around_cycles


def around_cycles__right_with_groupby(graph, visited, cycle, bias):
    counts = Counter(v for v, _ in groupby(visited))
    result = {}
    for v, out in graph.items():
        result[v] = {}
        for w, p in out.items():
            for _ in range(counts[w] - 1):
                p *= bias
            result[v][w] = p
    return any(n >= cycle for n in counts.values()), result


def _counts(visited):
    return Counter(v for v, _ in groupby(visited))


def _biased(graph, power, bias):
    return {v: {w: p * bias ** power(v, w) for w, p in out.items()} for v, out in graph.items()}


def around_cycles__changes_the_map(graph, visited, cycle, bias):
    """your function changes the map"""
    n = _counts(visited)
    for out in graph.values():
        for w in out:
            out[w] *= bias ** max(n[w] - 1, 0)
    return max(n.values(), default=0) >= cycle, graph


def around_cycles__max_of_nothing(graph, visited, cycle, bias):
    """max() of nothing needs default=0"""
    n = _counts(visited)
    return max(n.values()) >= cycle, _biased(graph, lambda v, w: max(n[w] - 1, 0), bias)


def _reference(graph, visited, cycle, bias):
    n = _counts(visited)
    return max(n.values(), default=0) >= cycle, _biased(graph, lambda v, w: max(n[w] - 1, 0), bias)


def around_cycles__right_with_copies(graph, visited, cycle, bias):
    n, new = _counts(visited), {v: dict(out) for v, out in graph.items()}
    for out in new.values():
        for w in out:
            out[w] *= bias ** max(n[w] - 1, 0)
    return np.any([count >= cycle for count in n.values()]), new


def around_cycles__the_map_itself(graph, visited, cycle, bias):
    """is the map itself"""
    n = _counts(visited)
    if max(n.values(), default=0) < 2:
        return 1 <= cycle <= max(n.values(), default=0), graph
    return _reference(graph, visited, cycle, bias)


def around_cycles__shared_inner(graph, visited, cycle, bias):
    """round and round: the graph that came back is the map itself, or shares"""
    n = _counts(visited)
    found, biased = _reference(graph, visited, cycle, bias)
    new = dict(graph)
    for v, out in graph.items():
        if any(n[w] > 1 for w in out):
            new[v] = biased[v]
    return found, new


def around_cycles__drops_vertices_without_edges(graph, visited, cycle, bias):
    """lacks 4, from which no edge leads"""
    found, biased = _reference(graph, visited, cycle, bias)
    return found, {v: out for v, out in biased.items() if out}


def around_cycles__other_vertices(graph, visited, cycle, bias):
    """has vertices that the map has not: [99]"""
    found, biased = _reference(graph, visited, cycle, bias)
    return found, {**biased, 99: {}}


# track


def _tracked(
    odometry,
    look,
    lengths,
    onward,
    rules,
    *,
    begins=-1,
    measure=distance,
    likelihood=lambda view, rules: (
        np.append(np.maximum(view, rules.least), rules.unknown) ** rules.sharpness
    ),
):
    count = len(lengths)
    belief = prior = np.full((1, count), 1 / count)
    since, vertex, waited = odometry[0], begins, rules.interval
    beliefs, vertices = [], []
    for step, pose in enumerate(odometry):
        gone = measure(since, pose)
        waited += step > 0
        far = gone >= rules.stride
        if far:
            prior, since = moved_on(belief, np.array([gone]), lengths, onward), pose
        if far or waited >= rules.interval:
            waited = 0
            belief = looked(prior, likelihood(look(step), rules)[None])
        best = int(np.argmax(belief[0]))
        if belief[0, vertex] < rules.hysteresis * belief[0, best]:
            vertex = -1 if best == count - 1 else best
        beliefs.append(belief[0])
        vertices.append(vertex)
    return np.array(beliefs), vertices


def track__right(odometry, look, lengths, onward, rules):
    return _tracked(odometry, look, lengths, onward, rules)


def track__vertices_only(odometry, look, lengths, onward, rules):
    """return the beliefs and the vertices"""
    return _tracked(odometry, look, lengths, onward, rules)[1]


def track__right_with_arrays(odometry, look, lengths, onward, rules):
    beliefs, vertices = _tracked(odometry, look, lengths, onward, rules)
    whole = np.zeros(len(vertices), dtype=int)
    whole[:] = vertices
    return [beliefs, whole]


def track__right_by_hand(odometry, look, lengths, onward, rules):
    prior = belief = np.full(len(lengths), 1 / len(lengths))
    at, looked_at, state, rows = 0, None, len(lengths) - 1, []
    for step in range(len(odometry)):
        gone = distance(odometry[step], odometry[at])
        if far := gone >= rules.stride:
            leave = -np.expm1(-gone / lengths)
            prior, at = belief - belief * leave + (belief * leave) @ onward, step
        if far or looked_at is None or step - looked_at >= rules.interval:
            seen = np.append(np.clip(look(step), rules.least, None), rules.unknown)
            weights = prior * (seen / seen.max()) ** rules.sharpness
            belief, looked_at = weights / weights.sum(), step
        if belief[state] < rules.hysteresis * belief.max():
            state = int(belief.argmax())
        rows.append((belief, state if state < len(lengths) - 1 else -1))
    return np.stack([row for row, _ in rows]), tuple(vertex for _, vertex in rows)


def track__vertices_as_floats(odometry, look, lengths, onward, rules):
    """np.zeros(T) makes floats"""
    beliefs, vertices = _tracked(odometry, look, lengths, onward, rules)
    numbers = np.zeros(len(odometry))
    numbers[:] = vertices
    return beliefs, numbers


def track__vertices_as_a_column(odometry, look, lengths, onward, rules):
    """vertices of shape (20, 1), but (20,) is right"""
    beliefs, vertices = _tracked(odometry, look, lengths, onward, rules)
    return beliefs, np.array(vertices)[:, None]


def track__one_vertex(odometry, look, lengths, onward, rules):
    """the vertices are an int; return a list"""
    beliefs, vertices = _tracked(odometry, look, lengths, onward, rules)
    return beliefs, vertices[-1]


def track__list_of_beliefs(odometry, look, lengths, onward, rules):
    """the beliefs are a list; return an array"""
    beliefs, vertices = _tracked(odometry, look, lengths, onward, rules)
    return list(beliefs), vertices


def track__not_numbers(odometry, look, lengths, onward, rules):
    """from step 0 on beliefs are not numbers (nan)"""
    seen = lambda view, rules: np.append(view * np.nan, rules.unknown)  # noqa: E731
    return _tracked(odometry, look, lengths, onward, rules, likelihood=seen)


def track__changes_the_odometry(odometry, look, lengths, onward, rules):
    """your function changes its argument odometry"""
    odometry[:, 2] += 1
    return _tracked(odometry, look, lengths, onward, rules)


def track__changes_the_lengths(odometry, look, lengths, onward, rules):
    """your function changes its argument lengths"""
    got = _tracked(odometry, look, lengths, onward, rules)
    lengths *= 2
    return got


def track__changes_onward(odometry, look, lengths, onward, rules):
    """your function changes its argument onward"""
    got = _tracked(odometry, look, lengths, onward, rules)
    onward *= 2
    return got


def track__changes_what_is_seen(odometry, look, lengths, onward, rules):
    """changes the array that look gave it"""

    def seen(step):
        view = look(step)
        return np.maximum(view, rules.least, out=view)

    return _tracked(odometry, seen, lengths, onward, rules)


def track__number_for_the_motion(odometry, look, lengths, onward, rules):
    """an array of one, np.array([metres])"""
    belief = np.full((1, len(lengths)), 1 / len(lengths))
    return moved_on(belief, distance(odometry[0], odometry[1]), lengths, onward), [-1]


def track__none_for_the_vertex(odometry, look, lengths, onward, rules):
    """Is the vertex always a number?"""
    return _tracked(odometry, look, lengths, onward, rules, begins=None)


def track__belief_of_one_dimension(odometry, look, lengths, onward, rules):
    """belief[0] is that of the robot"""
    belief = np.full(len(lengths), 1 / len(lengths))
    return belief[0, -1], [-1]


def track__right_by_the_number_of_the_look(odometry, look, lengths, onward, rules):
    count = len(lengths)
    belief = prior = np.full((1, count), 1 / count)
    last, looked_at, vertex, beliefs, vertices = odometry[0], 0, -1, [], []
    for step, pose in enumerate(odometry):
        metres = distance(last, pose)
        far = metres >= rules.stride
        if far:
            prior, last = moved_on(belief, np.array([metres]), lengths, onward), pose
        if far or step == 0 or step - looked_at >= rules.interval:
            seen = np.append(np.maximum(look(step), rules.least), rules.unknown)
            belief = looked(prior, seen[None] ** rules.sharpness)
            looked_at = step
        if belief[0, vertex] < rules.hysteresis * belief[0].max():
            vertex = int(belief[0].argmax())
            vertex = -1 if vertex == count - 1 else vertex
        beliefs.append(belief[0])
        vertices.append(vertex)
    return np.array(beliefs), vertices


# Ties, small values


def predict__rounds_the_motion(belief, motion, lengths, onward):
    """by each robot's own motion, unrounded"""
    return moved_on(belief, motion.round(1), lengths, onward)


def predict__rests_below_two_millimetres(belief, motion, lengths, onward):
    """small motions count as well"""
    return moved_on(belief, np.where(motion < 0.002, 0.0, motion), lengths, onward)


def update__softens(prior, likelihood):
    """no other function of them"""
    weights = np.exp(prior * likelihood)
    return weights / weights.sum(axis=1, keepdims=True)


def match_sequence__comes_from_two_before(likelihoods, before):
    """at the same vertex or at before[v], nowhere else"""
    total = likelihoods[0]
    for look in likelihoods[1:]:
        come = np.where(before >= 0, total[before], 0)
        total = look * np.maximum.reduce([total, come, np.where(before >= 0, come[before], 0)])
    return total ** (1 / len(likelihoods))


def track__looks_in_every_second_step(odometry, look, lengths, onward, rules):
    """a robot that has moved a stride since its last prediction predicts, and looks"""
    return _tracked(odometry, look, lengths, onward, rules, measure=lambda *_: 0.0)


def around_cycles__drops_the_edges(graph, visited, cycle, bias):
    """every edge stays, and none is added"""
    n = _counts(visited)
    found, biased = _reference(graph, visited, cycle, bias)
    return found, {v: {w: p for w, p in out.items() if n[w] < cycle} for v, out in biased.items()}
