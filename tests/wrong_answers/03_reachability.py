"""Answers to notebook 03: the docstring of a wrong one is what the check must say of it."""

import numpy as np
from scipy.optimize import minimize, minimize_scalar


def rollout_labels__ignores_collisions(times, gaps, touched, geodesic):
    """has failed, even if it arrives"""
    return _float((gaps <= 0.3) & _in_time(times, geodesic))


def rollout_labels__drops_collisions(times, gaps, touched, geodesic):
    """counts 0, it is not left out"""
    kept = ~touched.any(axis=0)
    return _right(times, gaps[:, kept], touched[:, kept], geodesic[kept])


def rollout_labels__makes_collisions_nan(times, gaps, touched, geodesic):
    """counts 0, not nan"""
    label = _right(times, gaps, touched, geodesic)
    return np.where(touched.any(axis=0) & (label == 0), np.nan, label)


def rollout_labels__counts_later_collisions(times, gaps, touched, geodesic):
    """after it has arrived does not count"""
    return _float((gaps <= 0.3) & _in_time(times, geodesic)) * ~touched.any(axis=0)


def rollout_labels__forgets_earlier_collisions(times, gaps, touched, geodesic):
    """free again when it arrives"""
    return _float((gaps <= 0.3) & _in_time(times, geodesic) & ~touched)


def rollout_labels__waits_forever(times, gaps, touched, geodesic):
    """after t_max does not count"""
    return _float((gaps <= 0.3) & _clean(touched))


def rollout_labels__has_no_grace(times, gaps, touched, geodesic):
    """5 s on top"""
    in_time = times[:, None] <= geodesic / 0.3
    return _float((gaps <= 0.3) & _clean(touched) & in_time)


def rollout_labels__multiplies_by_the_speed(times, gaps, touched, geodesic):
    """divide the geodesic by it"""
    in_time = times[:, None] <= geodesic * 0.3 + 5
    return _float((gaps <= 0.3) & _clean(touched) & in_time)


def rollout_labels__looks_at_the_end(times, gaps, touched, geodesic):
    """do not look only at the last moment"""
    return (gaps[-1] <= 0.3) * 1.0 * ~touched.any(axis=0)


def rollout_labels__looks_at_the_limit(times, gaps, touched, geodesic):
    """do not look only at the moment t_max"""
    row = np.abs(times[:, None] - geodesic / 0.3 - 5).argmin(axis=0)
    robots = np.arange(len(geodesic))
    return ((gaps[row, robots] <= 0.3) & _clean(touched)[row, robots]).astype(float)


def rollout_labels__is_generous(times, gaps, touched, geodesic):
    """near means within 0.30 m"""
    return _float((gaps <= 0.5) & _clean(touched) & _in_time(times, geodesic))


def rollout_labels__labels_failures(times, gaps, touched, geodesic):
    """0 for those that do not"""
    return 1.0 - _right(times, gaps, touched, geodesic)


def rollout_labels__labels_moments(times, gaps, touched, geodesic):
    """one answer for each moment"""
    return ((gaps <= 0.3) & _clean(touched) & _in_time(times, geodesic)).astype(float)


def rollout_labels__lets_everybody_pass(times, gaps, touched, geodesic):
    """the rollout that "never comes near" has the label 0"""
    return np.ones(len(geodesic))


def rollout_labels__right_drive_by_drive(times, gaps, touched, geodesic):
    labels = np.zeros(len(geodesic))
    for robot, length in enumerate(geodesic):
        for row, time in enumerate(times):
            if touched[row, robot] or time > length / 0.3 + 5.0:
                break
            if gaps[row, robot] < 0.30:
                labels[robot] = 1.0
                break
    return labels


def rollout_labels__right_with_sums(times, gaps, touched, geodesic):
    bad = np.cumsum(touched, axis=0) + (times[:, None] > geodesic / 0.3 + 5.0)
    return np.where(bad > 0, np.inf, gaps).min(axis=0) <= 0.3


def reach_loss__forgets_the_minus(logits, labels, weights):
    """turn its sign round"""
    return -_mean(_each(logits, labels), weights)


def reach_loss__forgets_failures(logits, labels, weights):
    """there is a second term"""
    return _mean(labels * np.logaddexp(0, -logits), weights)


def reach_loss__turns_the_logit_round(logits, labels, weights):
    """a high logit predicts that the target will be reached"""
    return _mean(_each(-logits, labels), weights)


def reach_loss__rounds_labels(logits, labels, weights):
    """do not round them"""
    return _mean(_each(logits, labels > 0.5), weights)


def reach_loss__ignores_the_weights(logits, labels, weights):
    """the weights do not count yet"""
    return _each(logits, labels).mean()


def reach_loss__divides_by_the_number(logits, labels, weights):
    """not by the number of pairs"""
    return (weights * _each(logits, labels)).mean()


def reach_loss__adds_up(logits, labels, weights):
    """that is the sum"""
    return (weights * _each(logits, labels)).sum()


def reach_loss__squares(logits, labels, weights):
    """the squared error"""
    return _mean((_sigmoid(logits) - labels) ** 2, weights)


def reach_loss__takes_absolute_errors(logits, labels, weights):
    """the absolute error"""
    return _mean(np.abs(_sigmoid(logits) - labels), weights)


def reach_loss__takes_logits_for_probabilities(logits, labels, weights):
    """logits are no probabilities"""
    p = np.clip(logits, 1e-7, 1 - 1e-7)
    return _mean(-labels * np.log(p) - (1 - labels) * np.log(1 - p), weights)


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


def fit_temperature__gives_the_inverse(logits, labels):
    """that is 1 / T"""
    return 1 / _fitted(logits, labels)


def fit_temperature__gives_the_logarithm(logits, labels):
    """the logarithm of the temperature"""
    return np.log(_fitted(logits, labels))


def fit_temperature__gives_the_loss(logits, labels):
    """that is the smallest loss"""
    return _mean(_each(logits / _fitted(logits, labels), labels), np.ones(len(labels)))


def fit_temperature__gives_the_place(logits, labels):
    """the index of the best temperature in a list"""
    losses = [_each(logits / t, labels).mean() for t in np.geomspace(0.05, 20, 300)]
    return int(np.argmin(losses))


def fit_temperature__only_makes_modest(logits, labels):
    """a temperature below 1 is allowed"""
    temperatures = np.linspace(1.0, 20.0, 1901)
    return temperatures[np.argmin([_each(logits / t, labels).mean() for t in temperatures])]


def fit_temperature__squares(logits, labels):
    """not the squared error"""
    temperatures = np.geomspace(0.05, 20, 900)
    squares = [((_sigmoid(logits / t) - labels) ** 2).mean() for t in temperatures]
    return temperatures[np.argmin(squares)]


def fit_temperature__looks_at_the_ece(logits, labels):
    """not the ECE"""
    temperatures = np.geomspace(0.05, 20, 600)
    errors = [
        reliability_diagram__right_by_reshaping(_sigmoid(logits / t), labels, 10)[2]
        for t in temperatures
    ]
    return temperatures[np.argmin(errors)]


def fit_temperature__goes_uphill(logits, labels):
    """not largest"""
    temperatures = np.geomspace(0.05, 20, 600)
    return temperatures[np.argmax([_each(logits / t, labels).mean() for t in temperatures])]


def fit_temperature__goes_below_zero(logits, labels):
    """a temperature is greater than 0"""
    return -_fitted(logits, labels)


def fit_temperature__gives_an_array(logits, labels):
    """shape (1,), but () is needed"""
    return np.array([_fitted(logits, labels)])


def fit_temperature__right_by_calculus(logits, labels):
    # Newton's method for the inverse temperature: the loss is convex in it.
    inverse = 0.2
    for _ in range(100):
        p = _sigmoid(inverse * logits)
        slope = ((p - labels) * logits).mean()
        inverse = max(inverse - slope / (p * (1 - p) * logits**2).mean(), inverse / 3)
    return 1 / inverse


def fit_temperature__right_by_a_simplex(logits, labels):
    found = minimize(
        lambda x: _each(logits * np.exp(x[0]), labels).mean(), [0.0], method="Nelder-Mead"
    )
    return float(np.exp(-found.x[0]))


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
