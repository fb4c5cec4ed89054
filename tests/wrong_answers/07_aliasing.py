"""Answers to the exercises of notebook 07: wrong ones, with words of their message, and right ones.

The check must say the docstring; answers called right must pass.
"""

from collections import Counter
from itertools import groupby

import numpy as np

from tutorial_lib.checks.nb07 import distance
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


def predict__linear(belief, motion, lengths, onward):
    """not motion / length"""
    leave = np.minimum(motion[:, None] / lengths, 1)
    return belief * (1 - leave) + (belief * leave) @ onward


def predict__unclipped(belief, motion, lengths, onward):
    """motion / length may be more than 1"""
    leave = motion[:, None] / lengths
    return belief * (1 - leave) + (belief * leave) @ onward


def predict__stay_and_leave_swapped(belief, motion, lengths, onward):
    """is the share that stays"""
    leave = np.exp(-motion[:, None] / lengths)
    return belief * (1 - leave) + (belief * leave) @ onward


def predict__all_of_it(belief, motion, lengths, onward):
    """only a share of the belief leaves each vertex"""
    return belief @ onward


def predict__transposed(belief, motion, lengths, onward):
    """row v of onward tells where v leads"""
    leave = 1 - np.exp(-motion[:, None] / lengths)
    return belief * (1 - leave) + (belief * leave) @ onward.T


def predict__forgets_who_stays(belief, motion, lengths, onward):
    """what does not leave stays"""
    leave = 1 - np.exp(-motion[:, None] / lengths)
    return (belief * leave) @ onward


def predict__counts_twice(belief, motion, lengths, onward):
    """take it away"""
    leave = 1 - np.exp(-motion[:, None] / lengths)
    return belief + (belief * leave) @ onward


def predict__nobody_arrives(belief, motion, lengths, onward):
    """what leaves must arrive somewhere"""
    return belief * np.exp(-motion[:, None] / lengths)


def predict__mean_length(belief, motion, lengths, onward):
    """divide by that of each vertex"""
    leave = 1 - np.exp(-motion[:, None] / lengths.mean())
    return belief * (1 - leave) + (belief * leave) @ onward


def predict__without_none(belief, motion, lengths, onward):
    """motion[:, None] / lengths has the shape"""
    leave = 1 - np.exp(-motion / lengths)
    return belief * (1 - leave) + (belief * leave) @ onward


def predict__changes_the_belief(belief, motion, lengths, onward):
    """your function changes its argument 1"""
    belief *= np.exp(-motion[:, None] / lengths)
    return belief


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


def update__adds(prior, likelihood):
    """yours adds them"""
    weights = prior + likelihood
    return weights / weights.sum(axis=1, keepdims=True)


def update__no_prior(prior, likelihood):
    """the prior counts as well"""
    weights = likelihood.copy()
    weights[weights.sum(axis=1) == 0, -1] = 1
    return weights / weights.sum(axis=1, keepdims=True)


def update__all_robots(prior, likelihood):
    """each robot's row sums to one by itself"""
    weights = prior * likelihood
    weights[weights.sum(axis=1) == 0, -1] = 1
    return weights / weights.sum()


def update__by_columns(prior, likelihood):
    """yours divides the columns"""
    weights = prior * likelihood
    weights[weights.sum(axis=1) == 0, -1] = 1
    return weights / weights.sum(axis=0)


def update__by_the_greatest(prior, likelihood):
    """not by its greatest entry"""
    weights = prior * likelihood
    weights[weights.sum(axis=1) == 0, -1] = 1
    return weights / weights.max(axis=1, keepdims=True)


def update__divides_by_nothing(prior, likelihood):
    """yours divides by 0"""
    weights = prior * likelihood
    return weights / weights.sum(axis=1, keepdims=True)


def update__spreads_evenly(prior, likelihood):
    """yours spreads it evenly"""
    weights = prior * likelihood
    weights[weights.sum(axis=1) == 0] = 1
    return weights / weights.sum(axis=1, keepdims=True)


def update__keeps_the_prior(prior, likelihood):
    """yours keeps the prior"""
    weights = prior * likelihood
    nothing = weights.sum(axis=1) == 0
    weights[nothing] = prior[nothing]
    return weights / weights.sum(axis=1, keepdims=True)


def update__nothing_returned(prior, likelihood):
    """is a return missing"""
    weights = prior * likelihood
    weights /= weights.sum()


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


def match_sequence__always_moves(likelihoods, before):
    """the robot may also stay"""
    total = likelihoods[0]
    for look in likelihoods[1:]:
        total = look * np.where(before >= 0, total[before], 0)
    return total ** (1 / len(likelihoods))


def match_sequence__never_moves(likelihoods, before):
    """the robot may also have come from"""
    return likelihoods.prod(axis=0) ** (1 / len(likelihoods))


def match_sequence__sums(likelihoods, before):
    """the better one counts, not their sum"""
    total = likelihoods[0]
    for look in likelihoods[1:]:
        total = look * (total + np.where(before >= 0, total[before], 0))
    return total ** (1 / len(likelihoods))


def match_sequence__wraps(likelihoods, before):
    """to numpy it is the last vertex"""
    total = likelihoods[0]
    for look in likelihoods[1:]:
        total = look * np.maximum(total, total[before])
    return total ** (1 / len(likelihoods))


def match_sequence__without_the_root(likelihoods, before):
    """take the T-th root"""
    total = likelihoods[0]
    for look in likelihoods[1:]:
        total = look * np.maximum(total, np.where(before >= 0, total[before], 0))
    return total


def match_sequence__latest_first(likelihoods, before):
    """the latest view is the last row"""
    total = likelihoods[-1]
    for look in likelihoods[-2::-1]:
        total = look * np.maximum(total, np.where(before >= 0, total[before], 0))
    return total ** (1 / len(likelihoods))


def match_sequence__no_vertex_0(likelihoods, before):
    """vertex 0 exists"""
    total = likelihoods[0]
    for look in likelihoods[1:]:
        total = look * np.maximum(total, np.where(before > 0, total[before], 0))
    return total ** (1 / len(likelihoods))


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


def around_cycles__counts_steps(graph, visited, cycle, bias):
    """the same vertex several times in a row is one visit"""
    counts = Counter(visited)
    return max(counts.values(), default=0) >= cycle, {
        v: {w: p * bias ** max(counts[w] - 1, 0) for w, p in out.items()}
        for v, out in graph.items()
    }


def _counts(visited):
    return Counter(v for v, _ in groupby(visited))


def _biased(graph, power, bias):
    return {v: {w: p * bias ** power(v, w) for w, p in out.items()} for v, out in graph.items()}


def around_cycles__more_than(graph, visited, cycle, bias):
    """are a cycle already: >=, not >"""
    n = _counts(visited)
    found = max(n.values(), default=0) > cycle
    return found, _biased(graph, lambda v, w: max(n[w] - 1, 0), bias)


def around_cycles__all_visits(graph, visited, cycle, bias):
    """it is the visits of one vertex that make a cycle"""
    n = _counts(visited)
    return sum(n.values()) >= cycle, _biased(graph, lambda v, w: max(n[w] - 1, 0), bias)


def around_cycles__those_that_leave(graph, visited, cycle, bias):
    """not those that leave it"""
    n = _counts(visited)
    found = max(n.values(), default=0) >= cycle
    return found, _biased(graph, lambda v, w: max(n[v] - 1, 0), bias)


def around_cycles__first_visit_too(graph, visited, cycle, bias):
    """the first visit is free"""
    n = _counts(visited)
    return max(n.values(), default=0) >= cycle, _biased(graph, lambda v, w: n[w], bias)


def around_cycles__once(graph, visited, cycle, bias):
    """yours biases once"""
    n = _counts(visited)
    return max(n.values(), default=0) >= cycle, _biased(graph, lambda v, w: int(n[w] > 1), bias)


def around_cycles__only_in_a_cycle(graph, visited, cycle, bias):
    """whether or not it is a cycle yet"""
    n = _counts(visited)
    if max(n.values(), default=0) < cycle:
        return False, {v: dict(out) for v, out in graph.items()}
    return True, _biased(graph, lambda v, w: max(n[w] - 1, 0), bias)


def around_cycles__removes(graph, visited, cycle, bias):
    """there may be no other way"""
    n = _counts(visited)
    left = {v: {w: p for w, p in out.items() if n[w] < 2} for v, out in graph.items()}
    return max(n.values(), default=0) >= cycle, left


def around_cycles__changes_the_map(graph, visited, cycle, bias):
    """your function changes its arguments"""
    n = _counts(visited)
    for out in graph.values():
        for w in out:
            out[w] *= bias ** max(n[w] - 1, 0)
    return max(n.values(), default=0) >= cycle, graph


def around_cycles__max_of_nothing(graph, visited, cycle, bias):
    """max() of nothing needs default=0"""
    n = _counts(visited)
    return max(n.values()) >= cycle, _biased(graph, lambda v, w: max(n[w] - 1, 0), bias)


# track


def _tracked(
    odometry,
    look,
    lengths,
    onward,
    rules,
    *,
    start=None,
    always=False,
    twice=False,
    forgets=False,
    keeps_pose=False,
    power=True,
    floor=True,
    sticky=True,
    off=True,
    waits=True,
):
    count = len(lengths)
    belief = prior = np.full((1, count), 1 / count)
    last, waited, vertex = odometry[0], rules.interval if start is None else start, -1
    beliefs, vertices = [], []
    for step in range(len(odometry)):
        gone = distance(last, odometry[step])
        waited += step > 0
        far = gone >= rules.stride
        if far:
            prior = moved_on(belief, np.array([gone]), lengths, onward)
            last = last if keeps_pose else odometry[step]
        if far or always or (waits and waited >= rules.interval):
            waited = 0
            seen = np.append(np.maximum(look(step), rules.least if floor else 0), rules.unknown)
            base = np.full((1, count), 1 / count) if forgets else (belief if twice else prior)
            belief = looked(base, seen[None] ** (rules.sharpness if power else 1))
        states = belief[0] if off else belief[0, :-1]
        best = int(np.argmax(states))
        if not sticky or belief[0, vertex] < rules.hysteresis * states[best]:
            vertex = -1 if best == count - 1 else best
        beliefs.append(belief[0])
        vertices.append(vertex)
    return np.array(beliefs), vertices


def track__right(odometry, look, lengths, onward, rules):
    return _tracked(odometry, look, lengths, onward, rules)


def track__looks_always(odometry, look, lengths, onward, rules):
    """looking costs time"""
    return _tracked(odometry, look, lengths, onward, rules, always=True)


def track__same_evidence_twice(odometry, look, lengths, onward, rules):
    """the same evidence counts again and again"""
    return _tracked(odometry, look, lengths, onward, rules, twice=True)


def track__forgets(odometry, look, lengths, onward, rules):
    """yours forgets all that was believed before"""
    return _tracked(odometry, look, lengths, onward, rules, forgets=True)


def track__from_the_start(odometry, look, lengths, onward, rules):
    """yours measures it from the start"""
    return _tracked(odometry, look, lengths, onward, rules, keeps_pose=True)


def track__no_power(odometry, look, lengths, onward, rules):
    """to the power of rules.sharpness"""
    return _tracked(odometry, look, lengths, onward, rules, power=False)


def track__no_floor(odometry, look, lengths, onward, rules):
    """a picture may always deceive"""
    return _tracked(odometry, look, lengths, onward, rules, floor=False)


def track__flickers(odometry, look, lengths, onward, rules):
    """the robot stays at its vertex while"""
    return _tracked(odometry, look, lengths, onward, rules, sticky=False)


def track__never_off_the_map(odometry, look, lengths, onward, rules):
    """off the map is the last state"""
    return _tracked(odometry, look, lengths, onward, rules, off=False)


def track__does_not_wait(odometry, look, lengths, onward, rules):
    """looks all the same after rules.interval steps"""
    return _tracked(odometry, look, lengths, onward, rules, waits=False, start=0, always=False)


def track__no_first_look(odometry, look, lengths, onward, rules):
    """look at the first step, too"""
    return _tracked(odometry, look, lengths, onward, rules, start=0)


def track__vertices_only(odometry, look, lengths, onward, rules):
    """return the beliefs and the vertices"""
    return _tracked(odometry, look, lengths, onward, rules)[1]
