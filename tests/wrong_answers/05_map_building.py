"""Answers to notebook 05: the docstring of a wrong one is what the check must say of it."""

from itertools import pairwise

import numpy as np


def edge_weights__lists_the_edges(reach, driven, p_edge):
    """but (6, 6) is needed"""
    return np.argwhere((reach > p_edge) | driven)


def edge_weights__writes_into_the_table(reach, driven, p_edge):
    """your function changes its argument reach"""
    reach[~((reach > p_edge) | driven)] = 0.0
    np.fill_diagonal(reach, 0.0)
    with np.errstate(divide="ignore"):
        return -np.log(reach)


def edge_weights__right_with_loops(reach, driven, p_edge):
    weights = np.full(reach.shape, np.inf)
    for i in range(len(reach)):
        for j in range(len(reach)):
            if i != j and (reach[i, j] > p_edge or driven[i, j]):
                weights[i, j] = -np.log(max(reach[i, j], 1e-12))
    return weights


def edge_weights__right_with_an_index(reach, driven, p_edge):
    weights = np.full_like(reach, np.inf)
    some = ((reach > p_edge) | driven) & ~np.eye(len(reach), dtype=bool)
    weights[some] = np.log(1 / np.clip(reach[some], 1e-12, None))
    return weights


def reusable__best_first(into, onward, allowed, p_reuse):
    """the best of all need not fit"""
    if not len(into):
        return -1
    best = int(np.where(allowed, into * onward, -1.0).argmax())
    return best if min(into[best], onward[best]) > p_reuse and allowed[best] else -1


def reusable__the_product_is_enough(into, onward, allowed, p_reuse):
    """each of the two must be above p_reuse, not their product"""
    product = np.where(allowed, into * onward, -1.0)
    return int(product.argmax()) if (product > p_reuse).any() else -1


def reusable__always_one(into, onward, allowed, p_reuse):
    """is there a vertex that fits?"""
    fits = (into > p_reuse) & (onward > p_reuse) & allowed
    return int(np.where(fits, into * onward, -1.0).argmax())


def reusable__none(into, onward, allowed, p_reuse):
    """return -1 where no vertex fits"""
    fits = (into > p_reuse) & (onward > p_reuse) & allowed
    return int(np.where(fits, into * onward, -1.0).argmax()) if fits.any() else None


def reusable__right_with_a_loop(into, onward, allowed, p_reuse):
    best, most = -1, 0.0
    for vertex in range(len(into)):
        if not allowed[vertex] or min(into[vertex], onward[vertex]) <= p_reuse:
            continue
        if into[vertex] * onward[vertex] > most:
            best, most = vertex, into[vertex] * onward[vertex]
    return best


def reusable__right_with_max(into, onward, allowed, p_reuse):
    fits = np.flatnonzero(allowed & (np.minimum(into, onward) > p_reuse))
    return max(fits, key=lambda vertex: into[vertex] * onward[vertex], default=-1)


def ahead_of__one_of_each_trajectory(trajectory, place, reused):
    """those that lie ahead may be taken"""
    return ~np.isin(trajectory, trajectory[reused]) if reused else np.ones(len(place), dtype=bool)


def ahead_of__lists_them(trajectory, place, reused):
    """return True or False for each"""
    allowed = np.ones(len(place), dtype=bool)
    for vertex in reused:
        allowed &= (trajectory != trajectory[vertex]) | (place > place[vertex])
    return np.flatnonzero(allowed)


def ahead_of__forbidden(trajectory, place, reused):
    """invert it"""
    behind = np.zeros(len(place), dtype=bool)
    for vertex in reused:
        behind |= (trajectory == trajectory[vertex]) & (place <= place[vertex])
    return behind


def ahead_of__right_with_the_farthest(trajectory, place, reused):
    farthest = {}
    for vertex in reused:
        own = int(trajectory[vertex])
        farthest[own] = max(farthest.get(own, -1), int(place[vertex]))
    return place > np.array([farthest.get(int(own), -1) for own in trajectory])


def ahead_of__right_with_a_comprehension(trajectory, place, reused):
    return np.array(
        [
            all(trajectory[u] != trajectory[v] or place[u] < place[v] for u in reused)
            for v in range(len(place))
        ]
    )


def _pair_by_pair(reach, before, after, steps, into=None):
    """The right answer, written into a new table or into another one."""
    least = reach.copy() if into is None else into
    for i, v in np.ndindex(*reach.shape):
        for step, beside in ((-1, before), (1, after)):
            row, column = i, v
            for _ in range(steps):
                row, column = row + step, beside[column]
                if not 0 <= row < len(reach) or column < 0:
                    break
                least[i, v] = min(least[i, v], reach[row, column])
    return least


def weakest_aligned__leaves_the_table(reach, before, after, steps):
    """IndexError"""
    found = reach.copy()
    for row, column in np.ndindex(*reach.shape):
        v = column
        for step in range(1, steps + 1):
            v = after[v]
            found[row, column] = min(found[row, column], reach[row + step, v])
    return found


def weakest_aligned__a_list(reach, before, after, steps):
    """return a numpy array"""
    return _pair_by_pair(reach, before, after, steps).tolist()


def weakest_aligned__of_neighbours(reach, before, after, steps):
    """look along the trajectories from each pair itself"""
    least = reach.copy()
    for step, beside in ((-1, before), (1, after)):
        for _ in range(steps):
            fresh = least.copy()
            for i, v in np.ndindex(*reach.shape):
                row, column = i + step, beside[v]
                if 0 <= row < len(reach) and column >= 0:
                    fresh[i, v] = min(least[i, v], least[row, column])
            least = fresh
    return least


def weakest_aligned__right_pair_by_pair(reach, before, after, steps):
    return _pair_by_pair(reach, before, after, steps)


def weakest_aligned__right_shifted(reach, before, after, steps):
    found = reach.copy()
    for step, beside in ((-1, before), (1, after)):
        shifted = reach
        for _ in range(steps):
            grown = np.pad(shifted, ((1, 1), (0, 1)), constant_values=1.0)
            shifted = grown[1 + step : 1 + step + len(reach)][:, beside]
            found = np.minimum(found, shifted)
    return found


_FOUR = ((1, 1), (-1, -1), (0, 1), (0, -1))


def _search(reach, before, after, sure):
    """Pairs beside sure ones."""
    found = np.zeros(reach.shape, dtype=bool)
    for row, column in np.argwhere(sure):
        for along, across in _FOUR:
            i, v = row + along, {0: column, 1: after[column], -1: before[column]}[across]
            if 0 <= i < len(reach) and v >= 0:
                found[i, v] = np.isnan(reach[i, v])
    return found


def ask_next__wraps(reach, before, after, p_edge):
    """beyond an end there is nothing to query"""
    found = np.zeros(reach.shape, dtype=bool)
    for row, column in np.argwhere(reach > p_edge):
        for along, across in _FOUR:
            v = {0: column, 1: after[column], -1: before[column]}[across]
            if row + along < len(reach):
                found[row + along, v] = True
    return found & np.isnan(reach)


def ask_next__leaves_the_table(reach, before, after, p_edge):
    """IndexError"""
    found = np.zeros(reach.shape, dtype=bool)
    for row, column in np.argwhere(reach > p_edge):
        for along, across in _FOUR:
            v = {0: column, 1: after[column], -1: before[column]}[across]
            found[row + along, v] = True
    return found & np.isnan(reach)


def ask_next__lists_them(reach, before, after, p_edge):
    """return True or False for each"""
    return np.argwhere(_search(reach, before, after, reach > p_edge))


def ask_next__right_with_loops(reach, before, after, p_edge):
    return _search(reach, before, after, reach > p_edge)


def ask_next__right_with_padding(reach, before, after, p_edge):
    sure = np.pad(reach > p_edge, ((1, 1), (0, 1)))
    # Beside v are those whose next vertex is v, and those whose vertex before is v.
    ahead, back = sure[:, before], sure[:, after]
    near = ahead[:-2] | back[2:] | ahead[1:-1] | back[1:-1]
    return near & np.isnan(reach)


def _ahead(grown, vertex, reused):
    return all(
        grown.trajectory[vertex] != grown.trajectory[r] or grown.place[vertex] > grown.place[r]
        for r in reused
    )


def _path(grown, own, p_reuse, ahead=_ahead, last=None):
    """The new path; `last` is the anchor after the last one."""
    path, reused = [], []
    after = [*own[1:], own[-1] if last is None else last]
    for i in range(len(own)):
        into = grown.reach[path[i - 1] if i else own[0], grown.vertices]
        onward = grown.reach[grown.vertices, after[i]]
        allowed = np.array([ahead(grown, v, reused) for v in grown.vertices], dtype=bool)
        found = reusable__right_with_a_loop(into, onward, allowed, p_reuse)
        path.append(int(own[i]) if found < 0 else grown.vertices[found])
        if found >= 0:
            reused.append(grown.vertices[found])
    return path


def _insert(grown, own, scores, p_reuse, **options):
    """The right answer, which returns the path and the new vertices."""
    path = _path(grown, own, p_reuse, **options)
    new = [int(a) for a in own if int(a) in path]
    for place, vertex in enumerate(path):
        if vertex in new:
            grown.trajectory[vertex], grown.place[vertex] = len(grown.paths), place
            grown.before[vertex] = path[place - 1] if place else -1
            grown.after[vertex] = path[place + 1] if place + 1 < len(path) else -1
    grown.vertices += new
    grown.paths.append(path)
    for v in new:
        for w in grown.vertices:
            if v != w:
                grown.edge_reach[v, w], grown.edge_reach[w, v] = scores[v, w], scores[w, v]
    for v, w in pairwise(path):
        grown.driven[v, w] = True
        grown.edge_reach[v, w] = max(grown.edge_reach[v, w], grown.reach[v, w])
    return path, new


def insert__allows_all(grown, own, scores, p_reuse):
    """Never backwards"""
    _insert(grown, own, scores, p_reuse, ahead=lambda *_: True)


def insert__joins_each_with_itself(grown, own, scores, p_reuse):
    """with every other vertex, not with itself"""
    _, new = _insert(grown, own, scores, p_reuse)
    grown.edge_reach[new, new] = scores[new, new]


def insert__drives_over_dropped_anchors(grown, own, scores, p_reuse):
    """not over anchors that were replaced"""
    before = grown.driven.copy()
    _insert(grown, own, scores, p_reuse)
    grown.driven = before
    grown.driven[own[:-1], own[1:]] = True


def insert__counts_the_path_first(grown, own, scores, p_reuse):
    """is the number of paths before"""
    _, new = _insert(grown, own, scores, p_reuse)
    grown.trajectory[new] += 1


def insert__the_last_for_none(grown, own, scores, p_reuse):
    """before is the vertex before on the path"""
    path, new = _insert(grown, own, scores, p_reuse)
    if path[0] in new:
        grown.before[path[0]] = path[-1]


def insert__forgets_the_path(grown, own, scores, p_reuse):
    """paths, but"""
    _insert(grown, own, scores, p_reuse)
    grown.paths.pop()


def insert__keeps_all_as_vertices(grown, own, scores, p_reuse):
    """though they were replaced"""
    _, new = _insert(grown, own, scores, p_reuse)
    grown.vertices += [int(a) for a in own if int(a) not in new]


def insert__returns_a_path(grown, own, scores, p_reuse):
    """change the map that is given, return nothing"""
    return _insert(grown, own, scores, p_reuse)[0]


def insert__writes_into_reach(grown, own, scores, p_reuse):
    """reach, scores and own are needed again"""
    _insert(grown, own, scores, p_reuse)
    np.fill_diagonal(grown.reach, 0.0)


def insert__goes_beyond_the_end(grown, own, scores, p_reuse):
    """IndexError"""
    _insert(grown, own, scores, p_reuse, last=len(grown.reach))


def insert__right_step_by_step(grown, own, scores, p_reuse):
    _insert(grown, own, scores, p_reuse)


def insert__right_with_tables(grown, own, scores, p_reuse):
    path = np.array(_path(grown, own, p_reuse))
    new = path == own
    around = np.concatenate([[-1], path, [-1]])
    grown.before[own[new]], grown.after[own[new]] = around[:-2][new], around[2:][new]
    grown.trajectory[own[new]], grown.place[own[new]] = len(grown.paths), np.flatnonzero(new)
    everything = np.append(np.array(grown.vertices, dtype=int), own[new])
    for rows, columns in ((own[new], everything), (everything, own[new])):
        kept = np.ix_(rows, columns)
        grown.edge_reach[kept] = scores[kept]
    np.fill_diagonal(grown.edge_reach, 0)
    steps = path[:-1], path[1:]
    grown.driven[steps] = True
    grown.edge_reach[steps] = np.maximum(grown.edge_reach[steps], grown.reach[steps])
    grown.vertices = everything
    grown.paths = [*grown.paths, path]
    return grown


def edge_weights__diag_one(reach, driven, p_edge):
    """yours joins vertex 0 to itself with 1; the diagonal is np.inf"""
    kept = (reach > p_edge) | driven
    w = np.where(kept, -np.log(np.maximum(reach, 1e-12)), np.inf)
    np.fill_diagonal(w, 1.0)
    return w


def edge_weights__mutates_driven(reach, driven, p_edge):
    """your function changes its argument driven"""
    driven |= reach > p_edge
    np.fill_diagonal(driven, False)
    return np.where(driven, -np.log(np.maximum(reach, 1e-12)), np.inf)


def edge_weights__big(reach, driven, p_edge):
    """where there is no edge the weight is np.inf; yours has 1e+09 everywhere"""
    kept = (reach > p_edge) | driven
    np.fill_diagonal(kept, False)
    return np.where(kept, -np.log(np.maximum(reach, 1e-12)), 1e9)


def edge_weights__eps6(reach, driven, p_edge):
    """only RE below 1e-12 counts as 1e-12; yours lets none be below 1e-06"""
    kept = (reach > p_edge) | driven
    np.fill_diagonal(kept, False)
    return np.where(kept, -np.log(np.maximum(reach, 1e-6)), np.inf)


def edge_weights__neq1(reach, driven, p_edge):
    """no vertex is joined to itself; the diagonal is inf"""
    kept = ((reach > p_edge) & (reach < 1)) | driven
    return np.where(kept, -np.log(np.maximum(reach, 1e-12)), np.inf)


def reusable__truthy(into, onward, allowed, p):
    """vertex 0 is a vertex like any other, and may be the best"""
    f = (into > p) & (onward > p) & allowed
    i = int(np.where(f, into * onward, 0).argmax()) if len(into) else -1
    return i or -1


def reusable__skip0(into, onward, allowed, p):
    """vertex 0 is a vertex, too; yours looks at the others"""
    best, b = -1, 0
    for i in range(1, len(into)):
        if into[i] > p and onward[i] > p and allowed[i] and into[i] * onward[i] > b:
            best = i
            b = into[i] * onward[i]
    return best


def reusable__list(into, onward, allowed, p):
    """an ndarray came back; return the index of one vertex, a whole number, or -1"""
    return np.flatnonzero((into > p) & (onward > p) & allowed)


def reusable__bool(into, onward, allowed, p):
    """True came back; return the index of one vertex, a whole number, or -1"""
    return bool(((into > p) & (onward > p) & allowed).any())


def reusable__mutates(into, onward, allowed, p):
    """your function changes its argument into"""
    into[~allowed] = 0
    f = (into > p) & (onward > p)
    return int(np.where(f, into * onward, -1).argmax()) if f.any() else -1


def ahead_of__or(t, p, reused):
    """yours forbids vertex"""
    ok = np.zeros(len(p), bool)
    for v in reused:
        ok |= (t != t[v]) | (p > p[v])
    return ok


def ahead_of__lastoftraj(t, p, reused):
    """of each trajectory all that were reused count, not only the last: the farthest"""
    last = {}
    for v in reused:
        last[t[v]] = p[v]
    return np.array([p[i] > last.get(t[i], -1) for i in range(len(p))], dtype=bool)


def ahead_of__only_self(t, p, reused):
    """only the reused vertex itself is forbidden in yours; those behind it are,"""
    ok = np.ones(len(p), bool)
    ok[reused] = False
    return ok


def ahead_of__ints(t, p, reused):
    """return True or False for each, not numbers"""
    ok = np.ones(len(p))
    for v in reused:
        ok *= (t != t[v]) | (p > p[v])
    return ok


def ahead_of__empty_none(t, p, reused):
    """your function returned nothing; is a return missing?"""
    if not reused:
        return None
    return np.array([all(t[i] != t[v] or p[i] > p[v] for v in reused) for i in range(len(p))])


def ahead_of__crash_empty(t, p, reused):
    """IndexError: list index out of"""
    v = reused[-1]
    return (t != t[v]) | (p > p[v])


def weakest_aligned__mutates(reach, before, after, steps):
    """your function changes its argument reach"""
    return _pair_by_pair(reach, before, after, steps, reach)


def weakest_aligned__continues_from_end(reach, before, after, steps):
    """for anchor 0 and vertex 0 the least of the aligned pairs is"""
    least = reach.copy()
    for i, v in np.ndindex(*reach.shape):
        r, c = i, v
        for d, b in ((-1, before), (1, after)):
            for _ in range(steps):
                r, c = r + d, b[c]
                if not 0 <= r < len(reach) or c < 0:
                    break
                least[i, v] = min(least[i, v], reach[r, c])
    return least


def weakest_aligned__nan(reach, before, after, steps):
    """some of it is not a number; every pair has at least its own RE"""
    return np.full_like(reach, np.nan)


def ask_next__mutates(reach, before, after, p):
    """your function changes its argument reach"""
    f = _search(reach, before, after, reach > p)
    reach[np.isnan(reach)] = 0
    return f


def weakest_aligned__stops_on_both_sides(reach, before, after, steps):
    """a sequence ends on its own side only"""
    least = reach.copy()
    for row, column in np.ndindex(*reach.shape):
        behind = ahead = column
        for step in range(1, steps + 1):
            behind, ahead = before[behind], after[ahead]
            if min(behind, ahead, row - step) < 0 or row + step >= len(reach):
                break
            pairs = reach[row - step, behind], reach[row + step, ahead]
            least[row, column] = min(least[row, column], *pairs)
    return least


def ask_next__forgets_one_neighbour(reach, before, after, p_edge):
    """of the four neighbours (i, before[v]) is missing"""
    votes = np.zeros(reach.shape, dtype=bool)
    for i, v in np.argwhere(reach > p_edge):
        for row, column in ((i + 1, after[v]), (i - 1, before[v]), (i, after[v])):
            if 0 <= row < len(reach) and column >= 0:
                votes[row, column] = True
    return votes & np.isnan(reach)


def weakest_aligned__rounds(reach, before, after, steps):
    """your answers are rounded to 2 digits; return all digits"""
    return np.round(_pair_by_pair(reach, before, after, steps), 2)


def edge_weights__takes_sure_edges_for_certain(reach, driven, p_edge):
    """RE of 0.995 and of 0.9999"""
    weights = edge_weights__right_with_loops(reach, driven, p_edge)
    return np.where(weights < 0.01, 0.0, weights)


def weakest_aligned__keeps_the_column(reach, before, after, steps):
    """yours leaves out an aligned pair"""
    best = _pair_by_pair(reach, before, after, steps)
    return np.maximum(best, np.median(reach))


def ask_next__goes_two_steps(reach, before, after, p_edge):
    """only the four neighbours of pairs that are sure now"""
    first = _search(reach, before, after, reach > p_edge)
    return first | _search(reach, before, after, first)
