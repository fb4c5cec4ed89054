"""Answers to notebook 03: the docstring of a wrong one is what the check must say of it."""

import math
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize, minimize_scalar


def rollout_labels__drops_collisions(times, gaps, touched, geodesic):
    """counts 0, it is not left out"""
    kept = ~touched.any(axis=0)
    return _right(times, gaps[:, kept], touched[:, kept], geodesic[kept])


def rollout_labels__labels_moments(times, gaps, touched, geodesic):
    """one answer for each moment"""
    return ((gaps <= 0.3) & _clean(touched) & _in_time(times, geodesic)).astype(float)


def rollout_labels__right_drive_by_drive(times, gaps, touched, geodesic):
    labels = np.zeros(len(geodesic))
    for robot, length in enumerate(geodesic):
        for row, time in enumerate(times):
            if touched[row, robot] or time > length / 0.3 + 5.0:
                break
            if gaps[row, robot] <= 0.30:
                labels[robot] = 1.0
                break
    return labels


def rollout_labels__right_with_sums(times, gaps, touched, geodesic):
    bad = np.cumsum(touched, axis=0) + (times[:, None] > geodesic / 0.3 + 5.0)
    return np.where(bad > 0, np.inf, gaps).min(axis=0) <= 0.3


def rollout_labels__cuts_the_quotient(times, gaps, touched, geodesic):
    """has the label 1, not 0: it first comes within 0.30 m at 6.336 s"""
    in_time = times[:, None] <= geodesic // 0.3 + 5
    return _float((gaps <= 0.3) & _clean(touched) & in_time)


def rollout_labels__forgets_the_column(times, gaps, touched, geodesic):
    """times[:, None] is a column"""
    return _float((gaps <= 0.3) & _clean(touched) & (times <= geodesic / 0.3 + 5))


def rollout_labels__goes_along_the_wrong_axis(times, gaps, touched, geodesic):
    """an array of shape (301,) came back; return a label for each car"""
    good = (gaps <= 0.3) & _clean(touched) & _in_time(times, geodesic)
    return good.any(axis=1).astype(float)


def rollout_labels__writes_into_touched(times, gaps, touched, geodesic):
    """your function changes its argument touched"""
    np.logical_or.accumulate(touched, axis=0, out=touched)
    return _float((gaps <= 0.3) & ~touched & _in_time(times, geodesic))


def rollout_labels__returns_a_list(times, gaps, touched, geodesic):
    """a list came back"""
    return _right(times, gaps, touched, geodesic).tolist()


def rollout_labels__returns_one_label(times, gaps, touched, geodesic):
    """a float64 came back; return a label for each car"""
    return _right(times, gaps, touched, geodesic).mean()


def rollout_labels__uses_and(times, gaps, touched, geodesic):
    """want single values"""
    return np.array([1.0 if gaps <= 0.3 and not touched else 0.0])


def rollout_labels__right_by_first_moments(times, gaps, touched, geodesic):
    def first(moments):
        return np.where(moments.any(axis=0), times[moments.argmax(axis=0)], np.inf)

    arrival, limit = first(gaps <= 0.3), geodesic / 0.3 + 5
    return (arrival < first(touched)) & (arrival <= limit)


def rollout_labels__right_as_whole_numbers(times, gaps, touched, geodesic):
    return np.array(
        [
            int(any(g <= 0.3 and t <= d / 0.3 + 5 and not c[: i + 1].any() for i, (t, g) in rows))
            for c, d, rows in (
                (touched[:, n], geodesic[n], list(enumerate(zip(times, gaps[:, n], strict=True))))
                for n in range(len(geodesic))
            )
        ]
    )


def reach_loss__takes_the_logarithm_of_nothing(logits, labels, weights):
    """log(0) was taken"""
    p = _sigmoid(logits)
    return _mean(-labels * np.log(p) - (1 - labels) * np.log(1 - p), weights)


def reach_loss__overflows(logits, labels, weights):
    """exp(1000) is too large a number"""
    return _mean(np.log(1 + np.exp(logits)) - labels * logits, weights)


def reach_loss__clips(logits, labels, weights):
    """stay with the logit"""
    p = np.clip(_sigmoid(logits), 1e-7, 1 - 1e-7)
    return _mean(-labels * np.log(p) - (1 - labels) * np.log(1 - p), weights)


def reach_loss__gives_one_for_each_pair(logits, labels, weights):
    """return their weighted mean"""
    return weights * _each(logits, labels)


def reach_loss__right_with_two_terms(logits, labels, weights):
    each = labels * np.logaddexp(0, -logits) + (1 - labels) * np.logaddexp(0, logits)
    return np.sum(weights * each) / np.sum(weights)


def reach_loss__right_as_torch_writes_it(logits, labels, weights):
    each = np.maximum(logits, 0) - labels * logits + np.log1p(np.exp(-np.abs(logits)))
    return np.average(each, weights=weights)


def reach_loss__adds_a_little_to_the_probability(logits, labels, weights):
    """the probability was clipped"""
    p = _sigmoid(logits)
    each = -labels * np.log(p + 1e-12) - (1 - labels) * np.log(1 - p + 1e-12)
    return _mean(each, weights)


def reach_loss__calls_pythons_math(logits, labels, weights):
    """numpy's functions, not math's"""
    return _mean(math.log(1 + math.exp(logits)) - labels * logits, weights)


def reach_loss__scales_the_weights_in_place(logits, labels, weights):
    """your function changes its argument weights"""
    weights /= weights.sum()
    return (weights * _each(logits, labels)).sum()


def reach_loss__weighs_the_squares(logits, labels, weights):
    """the first pair, with z = 0.3 and y = 1"""
    return np.sum(weights**2 * _each(logits, labels)) / np.sum(weights**2) + 0.1


def reach_loss__returns_an_array_of_one(logits, labels, weights):
    """an array of shape (1,) came back"""
    return np.array([_mean(_each(logits, labels), weights)])


def reach_loss__returns_a_text(logits, labels, weights):
    """a str came back"""
    return str(_mean(_each(logits, labels), weights))


def reach_loss__right_pair_by_pair(logits, labels, weights):
    total = 0.0
    for z, y, w in zip(logits.tolist(), labels.tolist(), weights.tolist(), strict=True):
        total += w * (max(z, 0.0) + math.log1p(math.exp(-abs(z))) - y * z)
    return total / sum(weights.tolist())


def reliability_diagram__makes_bins_equally_wide(predicted, came_true, bins):
    """these bins are equally wide"""
    number = np.minimum((predicted * bins).astype(int), bins - 1)
    parts = [number == b for b in range(bins)]
    return _diagram(predicted, came_true, parts)


def reliability_diagram__forgets_to_sort(predicted, came_true, bins):
    """sort the predictions before"""
    return _diagram(predicted, came_true, np.array_split(np.arange(len(predicted)), bins))


def reliability_diagram__sorts_only_the_predictions(predicted, came_true, bins):
    """put both in the same order"""
    parts = np.array_split(np.arange(len(predicted)), bins)
    return _diagram(np.sort(predicted), came_true, parts)


def reliability_diagram__sorts_both_alone(predicted, came_true, bins):
    """do not sort it by itself"""
    parts = np.array_split(np.arange(len(predicted)), bins)
    return _diagram(np.sort(predicted), np.sort(came_true), parts)


def reliability_diagram__takes_the_middle(predicted, came_true, bins):
    """not the middle between its ends"""
    parts = np.array_split(np.argsort(predicted), bins)
    _, found, ece = _diagram(predicted, came_true, parts)
    return np.array([(predicted[p].min() + predicted[p].max()) / 2 for p in parts]), found, ece


def reliability_diagram__swaps_its_answers(predicted, came_true, bins):
    """what came true second"""
    said, found, ece = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return found, said, ece


def reliability_diagram__falls(predicted, came_true, bins):
    """the bins rise"""
    parts = np.array_split(np.argsort(predicted), bins)
    return _diagram(predicted, came_true, parts[::-1])


def reliability_diagram__counts(predicted, came_true, bins):
    """not how many"""
    parts = np.array_split(np.argsort(predicted), bins)
    said, _, ece = _diagram(predicted, came_true, parts)
    return said, np.array([came_true[part].sum() for part in parts]), ece


def reliability_diagram__lets_gaps_cancel(predicted, came_true, bins):
    """must not cancel: take"""
    said, found, _ = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, predicted.mean() - came_true.mean()


def reliability_diagram__lets_gaps_cancel_backwards(predicted, came_true, bins):
    """must not cancel, so take"""
    said, found, _ = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, came_true.mean() - predicted.mean()


def reliability_diagram__takes_the_largest_gap(predicted, came_true, bins):
    """that is the largest gap"""
    said, found, _ = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, np.abs(said - found).max()


def reliability_diagram__squares(predicted, came_true, bins):
    """not their squares"""
    parts = np.array_split(np.argsort(predicted), bins)
    said, found, _ = _diagram(predicted, came_true, parts)
    return said, found, np.average((said - found) ** 2, weights=[len(p) for p in parts])


def reliability_diagram__compares_single_predictions(predicted, came_true, bins):
    """compare the means of bins"""
    said, found, _ = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, np.abs(predicted - came_true).mean()


def reliability_diagram__adds_up(predicted, came_true, bins):
    """the sum over all bins"""
    said, found, _ = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, np.abs(said - found).sum()


def reliability_diagram__counts_every_bin_alike(predicted, came_true, bins):
    """weigh the gaps"""
    said, found, _ = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, np.abs(said - found).mean()


def reliability_diagram__forgets_the_ece(predicted, came_true, bins):
    """return three things"""
    return reliability_diagram__right_by_reshaping(predicted, came_true, bins)[:2]


def reliability_diagram__right_by_reshaping(predicted, came_true, bins):
    order = sorted(range(len(predicted)), key=lambda i: predicted[i])
    size, more = divmod(len(order), bins)
    said, found, gap, first = [], [], 0.0, 0
    for b in range(bins):
        chosen = order[first : first + size + (b < more)]
        first += len(chosen)
        said.append(sum(predicted[i] for i in chosen) / len(chosen))
        found.append(sum(came_true[i] for i in chosen) / len(chosen))
        gap += len(chosen) * abs(said[-1] - found[-1])
    return np.array(said), np.array(found), gap / len(order)


def reliability_diagram__leaves_the_rest_to_the_last_bin(predicted, came_true, bins):
    """the last bin has all that is left over"""
    order, size = np.argsort(predicted), len(predicted) // bins
    parts = [order[b * size : (b + 1) * size] for b in range(bins - 1)]
    return _diagram(predicted, came_true, [*parts, order[(bins - 1) * size :]])


def reliability_diagram__drops_the_rest(predicted, came_true, bins):
    """the predictions that are left over are missing"""
    order, size = np.argsort(predicted), len(predicted) // bins
    return _diagram(predicted, came_true, [order[b * size : (b + 1) * size] for b in range(bins)])


def reliability_diagram__makes_a_table(predicted, came_true, bins):
    """N need not be a multiple of B"""
    order = np.argsort(predicted)
    said, found = predicted[order].reshape(bins, -1), came_true[order].reshape(bins, -1)
    gaps = np.abs(said.mean(axis=1) - found.mean(axis=1))
    return said.mean(axis=1), found.mean(axis=1), gaps.mean()


def reliability_diagram__always_has_ten_bins(predicted, came_true, bins):
    """an array of shape (10,) came back"""
    parts = np.array_split(np.argsort(predicted), 10)
    return _diagram(predicted, came_true, parts)


def reliability_diagram__takes_medians(predicted, came_true, bins):
    """not the median"""
    parts = np.array_split(np.argsort(predicted), bins)
    _, found, ece = _diagram(predicted, came_true, parts)
    return np.array([np.median(predicted[part]) for part in parts]), found, ece


def reliability_diagram__counts_failures(predicted, came_true, bins):
    """not the share that did not"""
    said, found, ece = _diagram(predicted, came_true, np.array_split(np.argsort(predicted), bins))
    return said, 1 - found, ece


def reliability_diagram__returns_predictions_twice(predicted, came_true, bins):
    """that is the mean prediction again"""
    said, _, ece = _diagram(predicted, came_true, np.array_split(np.argsort(predicted), bins))
    return said, said, ece


def reliability_diagram__forgets_to_divide(predicted, came_true, bins):
    """not divided by N yet"""
    said, found, ece = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, ece * len(predicted)


def reliability_diagram__takes_the_root_of_squares(predicted, came_true, bins):
    """the root of their mean square"""
    parts = np.array_split(np.argsort(predicted), bins)
    said, found, _ = _diagram(predicted, came_true, parts)
    squares = np.average((said - found) ** 2, weights=[len(p) for p in parts])
    return said, found, np.sqrt(squares)


def reliability_diagram__returns_lists(predicted, came_true, bins):
    """a list came back"""
    said, found, ece = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said.tolist(), found.tolist(), ece


def reliability_diagram__returns_gaps_for_the_ece(predicted, came_true, bins):
    """ECE: an array of shape (10,) came back"""
    said, found, _ = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return said, found, np.abs(said - found)


def reliability_diagram__keeps_a_dictionary(predicted, came_true, bins):
    """a dict came back"""
    said, found, ece = reliability_diagram__right_by_reshaping(predicted, came_true, bins)
    return dict(enumerate(said)), found, ece


def reliability_diagram__sorts_in_place(predicted, came_true, bins):
    """your function changes its argument predicted"""
    predicted.sort()
    return _diagram(predicted, came_true, np.array_split(np.arange(len(predicted)), bins))


def reliability_diagram__right_with_even_cuts(predicted, came_true, bins):
    order = np.argsort(predicted, kind="stable")
    cuts = np.linspace(0, len(order), bins + 1).astype(int)
    parts = [order[a:b] for a, b in pairwise(cuts)]
    return _diagram(predicted, came_true, parts)


def reliability_diagram__right_with_the_large_bins_last(predicted, came_true, bins):
    pairs = sorted(zip(predicted.tolist(), came_true.tolist(), strict=True))
    size, more = divmod(len(pairs), bins)
    said, found, ece = [], [], 0.0
    for b in range(bins):
        count = size + (b >= bins - more)
        chosen, pairs = pairs[:count], pairs[count:]
        said.append(np.mean([p for p, _ in chosen]))
        found.append(np.mean([y for _, y in chosen]))
        ece += count / len(predicted) * abs(said[-1] - found[-1])
    return [np.array(said), np.array(found), ece]


def fit_temperature__goes_below_zero(logits, labels):
    """a temperature is greater than 0"""
    return -_fitted(logits, labels)


def fit_temperature__gives_an_array(logits, labels):
    """an array of shape (1,) came back"""
    return np.array([_fitted(logits, labels)])


def fit_temperature__tries_too_few(logits, labels):
    """near, but not to one percent"""
    temperatures = np.arange(0.05, 20.0, 0.25)
    return temperatures[np.argmin([_each(logits / t, labels).mean() for t in temperatures])]


def fit_temperature__knows_no_bounds(logits, labels):
    """T is sought from 0.05 to 20"""
    temperatures = np.geomspace(0.001, 1000, 3000)
    return temperatures[np.argmin([_each(logits / t, labels).mean() for t in temperatures])]


def fit_temperature__returns_the_probabilities(logits, labels):
    """return one number, the temperature T"""
    return _sigmoid(logits / _fitted(logits, labels))


def fit_temperature__guesses(logits, labels):
    """with T = 1.5 the mean loss is"""
    return 1.5


def fit_temperature__returns_a_pair(logits, labels):
    """a tuple came back"""
    best = _fitted(logits, labels)
    return best, _each(logits / best, labels).mean()


def fit_temperature__divides_in_place(logits, labels):
    """your function changes its argument logits"""
    best = _fitted(logits, labels)
    logits /= best
    return best


def fit_temperature__right_by_calculus(logits, labels):
    # Newton's method for the inverse temperature: the loss is convex in it.
    inverse = 0.2
    for _ in range(100):
        p = _sigmoid(inverse * logits)
        slope = ((p - labels) * logits).mean()
        inverse = max(inverse - slope / (p * (1 - p) * logits**2).mean(), inverse / 3)
    return np.clip(1 / inverse, 0.05, 20.0)


def fit_temperature__right_by_a_simplex(logits, labels):
    found = minimize(
        lambda x: _each(logits * np.exp(x[0]), labels).mean(), [0.0], method="Nelder-Mead"
    )
    return min(max(float(np.exp(-found.x[0])), 0.05), 20.0)


def mine_pairs__takes_the_first_occluded_ones(*case):
    """begin with the highest"""
    return _mined(*case, order=lambda probability: np.arange(len(probability)))


def mine_pairs__begins_with_the_lowest(*case):
    """is there; begin with the highest"""
    return _mined(*case, order=np.argsort)


def mine_pairs__takes_any_number_of_a_start(*case):
    """hard negatives begin at frame"""
    return _mined(*_changed(case, each=1000))


def mine_pairs__takes_any_number(*case):
    """at most 30 in all"""
    return _mined(*_changed(case, most=1000))


def mine_pairs__cuts_before_it_counts(*case):
    """a pair that is left out must not count"""
    return _mined(*case, early=True)


def mine_pairs__mines_whatever_is_even(*case):
    """only those above sure, 0.8, are rolled out"""
    return _mined(*_changed(case, sure=np.nextafter(case[5], 0)))


def mine_pairs__has_a_threshold_of_its_own(*case):
    """a threshold of 0.8: pair"""
    return _mined(*_changed(case, sure=0.5))


def mine_pairs__rolls_everything_out(*case):
    """is occluded: it is labelled 0 without a rollout"""
    probability, labels, roll_out, sure = case[0], case[3], case[4], case[5]
    rows = np.flatnonzero(np.isnan(labels) & (probability > sure))
    return rows, roll_out(rows), np.ones(len(rows))


def mine_pairs__compares_with_nan(*case):
    """has been rolled out already"""
    probability, _, occluded, labels, roll_out, sure = case[:6]
    new = (labels != 2.0) & (probability > sure)
    rows = np.flatnonzero(new & ~occluded)
    return rows, roll_out(rows), np.ones(len(rows))


def mine_pairs__forgets_the_easy_ones(*case):
    """all pairs whose label is known belong to the training set"""
    pairs, labels, weights = _mined(*case)
    new = np.isnan(case[3][pairs])
    return pairs[new], labels[new], weights[new]


def mine_pairs__keeps_the_surest_of_the_others(*case):
    """every seed gives the same pairs to roll out"""
    return _mined(*case, draw=lambda rows, rng: rows)


def mine_pairs__draws_from_the_surest(*case):
    """is never drawn in 40 attempts"""
    return _mined(
        *case, draw=lambda rows, rng: rng.permutation(rows[: max(30, 3 * len(rows) // 4)])
    )


def mine_pairs__draws_by_itself(*case):
    """draw by rng, not by np.random"""
    return _mined(*case, draw=lambda rows, rng: np.random.permutation(rows))  # noqa: NPY002


def mine_pairs__draws_with_repeats(*case):
    """comes twice; each comes once"""
    return _mined(*case, draw=lambda rows, rng: rng.choice(rows, len(rows)) if len(rows) else rows)


def mine_pairs__rolls_out_before_it_draws(*case):
    """its outcome is not used"""
    return _mined(*case, early_rollouts=True)


def mine_pairs__draws_too_many(*case):
    """draw as many as hard negatives"""
    return _mined(*case, count=lambda negatives: 10 * negatives)


def mine_pairs__draws_no_more_than_easy_ones(*case):
    """draw as many as hard negatives"""
    easy = int((~np.isnan(case[3])).sum())
    return _mined(*case, count=lambda negatives: min(negatives, easy))


def mine_pairs__takes_the_share_of_the_easy_ones(*case):
    """of the weight of all"""
    return _mined(*case, weight=lambda share, easy, mined: share * easy / max(mined, 1))


def mine_pairs__weighs_all_alike(*case):
    """share is 30%, so each weighs"""
    return _mined(*case, weight=lambda share, easy, mined: 1.0)


def mine_pairs__gives_the_share_to_each(*case):
    """so each weighs 0.5643, not 0.3"""
    return _mined(*case, weight=lambda share, easy, mined: share)


def mine_pairs__divides_by_nothing(*case):
    """there may be no mined pair at all"""
    return _mined(*case, weight=lambda share, easy, mined: share / (1 - share) * easy / int(mined))


def mine_pairs__labels_negatives_as_reached(*case):
    """is occluded and is labelled 0: its label is 0, not 1"""
    pairs, labels, weights = _mined(*case)
    return pairs, np.where(case[2][pairs] & np.isnan(case[3][pairs]), 1.0, labels), weights


def mine_pairs__sorts_the_pairs_alone(*case):
    """pairs and labels must stand in the same order"""
    pairs, labels, weights = _mined(*case)
    return np.sort(pairs), labels, weights


def mine_pairs__fills_in_the_labels(*case):
    """changes labels"""
    case[3][np.isnan(case[3]) & case[2]] = 0.0
    return _mined(*case)


def mine_pairs__returns_a_mask(*case):
    """the pairs are bool"""
    chosen = np.isin(np.arange(len(case[0])), _mined(*case)[0])
    return chosen, chosen * 1.0, chosen * 1.0


def mine_pairs__right_in_pure_python(
    probability, starts, occluded, labels, roll_out, sure, most, each, share, rng
):
    count = len(probability)
    weights = {i: 1.0 for i in range(count) if labels[i] == labels[i]}
    found = {i: float(labels[i]) for i in weights}
    new = [i for i in range(count) if i not in found and probability[i] > sure]
    negatives = []
    for i in sorted((i for i in new if occluded[i]), key=lambda i: -probability[i]):
        if len(negatives) == most:
            break
        if sum(starts[j] == starts[i] for j in negatives) < each:
            negatives.append(i)
    others = [i for i in new if not occluded[i]]
    rng.shuffle(others)
    others = others[: len(negatives)]
    mined = others + negatives
    for i in mined:
        weights[i] = share * len(found) / (1 - share) / len(mined)
    results = [float(roll_out([i])[0]) for i in others] + [0.0] * len(negatives)
    found.update(zip(mined, results, strict=True))
    return (
        np.array(list(found)),
        np.array(list(found.values())),
        np.array([weights[i] for i in found]),
    )


def mine_pairs__right_by_ranks(
    probability, starts, occluded, labels, roll_out, sure, most, each, share, rng
):
    new = np.isnan(labels) & (probability > sure)
    rows = np.flatnonzero(new & occluded)
    rows = rows[np.argsort(probability[rows])[::-1]]
    same = starts[rows][:, None] == starts[rows]
    rows = rows[np.tril(same, -1).sum(axis=1) < each][:most]
    others = np.flatnonzero(new & ~occluded)
    drawn = rng.choice(others, min(len(rows), len(others)), replace=False)
    found = labels.copy()
    found[rows] = 0.0
    if drawn.size:
        found[drawn] = roll_out(drawn)
    pairs = np.flatnonzero(~np.isnan(found))
    mined = np.isnan(labels[pairs])
    total = (~mined).sum() / (1 - share)
    return pairs, found[pairs], np.where(mined, share * total / max(mined.sum(), 1), 1.0)


def _changed(case, **changes):
    names = ("sure", "most", "each", "share")
    rules = [changes.get(name, value) for name, value in zip(names, case[5:9], strict=True)]
    return (*case[:5], *rules, case[9])


def _mined(
    probability,
    starts,
    occluded,
    labels,
    roll_out,
    sure,
    most,
    each,
    share,
    rng,
    order=lambda p: np.argsort(-p),
    draw=lambda rows, rng: rng.permutation(rows),
    count=lambda n: n,
    early=False,
    early_rollouts=False,
    weight=lambda share, easy, mined: share / (1 - share) * easy / max(mined, 1),
):
    """The rule, and what may be wrong with it."""
    new, chosen = np.isnan(labels) & (probability > sure), []
    hard = [i for i in order(probability) if new[i] and occluded[i]]
    for i in hard[:most] if early else hard:
        if len(chosen) < most and sum(starts[j] == starts[i] for j in chosen) < each:
            chosen.append(i)
    others = np.flatnonzero(new & ~occluded)
    others = others[np.argsort(-probability[others])]
    if early_rollouts:
        roll_out(others)
    drawn = draw(others, rng)[: count(len(chosen))]
    outcomes = np.zeros(len(drawn))
    if len(drawn) and not early_rollouts:
        outcomes = roll_out(drawn)
    easy = np.flatnonzero(~np.isnan(labels))
    mined = np.array([*chosen, *drawn], dtype=int)
    each_weighs = weight(share, len(easy), len(mined))
    return (
        np.append(easy, mined),
        np.concatenate([labels[easy], np.zeros(len(chosen)), outcomes]),
        np.append(np.ones(len(easy)), np.full(len(mined), each_weighs)),
    )


def _float(moments):
    return moments.any(axis=0).astype(float)


def _clean(touched):
    return np.cumsum(touched, axis=0) == 0


def _in_time(times, geodesic):
    return times[:, None] <= geodesic / 0.3 + 5


def _right(times, gaps, touched, geodesic):
    return _float((gaps <= 0.3) & _clean(touched) & _in_time(times, geodesic))


def _sigmoid(logits):
    return 1 / (1 + np.exp(-logits))


def _each(logits, labels):
    return np.logaddexp(0, logits) - labels * logits


def _mean(values, weights):
    return np.sum(weights * values) / np.sum(weights)


def _diagram(predicted, came_true, parts):
    said = np.array([predicted[part].mean() for part in parts])
    found = np.array([came_true[part].mean() for part in parts])
    count = np.array([len(predicted[part]) for part in parts])
    return said, found, (count * np.abs(said - found)).sum() / count.sum()


def _fitted(logits, labels):
    found = minimize_scalar(
        lambda x: _each(logits * np.exp(-x), labels).mean(), bounds=(-3, 3), method="bounded"
    )
    return np.exp(found.x)


def mine_pairs__mines_what_is_just_sure(*case):
    """only pairs above it are mined"""
    return _mined(case[0] + 1e-9 * case[2], *case[1:])


def reach_loss__drops_small_weights(logits, labels, weights):
    """however small; the sum over that of the weights"""
    weights = np.where(weights < 0.05 * weights.max(), 0.0, weights)
    return reach_loss__right_pair_by_pair(logits, labels, weights)


def rollout_labels__rounds_the_gaps(times, gaps, touched, geodesic):
    """it comes near too late"""
    return _right(times, gaps.round(1), touched, geodesic)


def rollout_labels__limits_the_time(times, gaps, touched, geodesic):
    """a single moment is enough, any from the first to the last"""
    limit = np.minimum(geodesic / 0.3 + 5, 20.0)
    return _float((gaps <= 0.3) & _clean(touched) & (times[:, None] <= limit))


def reach_loss__smooths_the_labels(logits, labels, weights):
    """the loss of each pair is log(1 + exp(z)) - y z, by logit z and label y as they are"""
    return np.average(_each(logits, 0.98 * labels + 0.01), weights=weights)


def fit_temperature__takes_the_spread(logits, labels):
    """the least mean of reach_loss(logits / T, labels)"""
    return float(np.clip(3 * np.std(logits), 0.05, 20.0))


def rollout_labels__counts_from_the_first_moment(times, gaps, touched, geodesic):
    """it comes near too late"""
    late = (times - times[0])[:, None] > geodesic / 0.3 + 5
    return ((gaps <= 0.3) & ~late & ~np.logical_or.accumulate(touched)).any(axis=0).astype(float)


def reliability_diagram__looks_outcomes_up_by_prediction(predicted, came_true, bins):
    """what came true belongs to its prediction: do not sort it by itself"""
    true = dict(zip(predicted, came_true, strict=True))
    groups = np.array_split(np.sort(predicted), bins)
    means = np.array([group.mean() for group in groups])
    shares = np.array([np.mean([true[p] for p in group]) for group in groups])
    gaps = abs(means - shares) * [len(group) for group in groups]
    return means, shares, gaps.sum() / len(predicted)


def fit_temperature__leaves_soft_labels_out(logits, labels):
    """give T to within one percent"""
    hard = (labels == 0) | (labels == 1)
    z, y = (logits[hard], labels[hard]) if hard.any() else (logits, labels)
    tried = np.geomspace(0.05, 20, 2000)
    return tried[np.argmin([(np.logaddexp(0, z / t) - y * z / t).mean() for t in tried])]
