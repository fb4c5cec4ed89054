"""Probabilities: how right they are is measured against brute force, and they can be mended."""

import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.learning import calibration as module
from tutorial_lib.learning.calibration import (
    Calibration,
    auc,
    brier,
    fit_isotonic,
    fit_temperature,
    logit,
    reliability,
    sigmoid,
)


def bernoulli(probability, seed=0):
    """What comes true with such probabilities."""
    return (np.random.default_rng(seed).random(len(probability)) < probability).astype(float)


def calibrated(count=20_000, seed=1):
    """Probabilities that are right, and what happened."""
    probability = np.random.default_rng(seed).random(count)
    return probability, bernoulli(probability, seed + 1)


distinct = st.lists(
    st.tuples(st.integers(0, 10_000), st.booleans()),
    min_size=12,
    max_size=60,
    unique_by=lambda pair: pair[0],
)


def columns(pairs):
    predicted, true = zip(*pairs, strict=True)
    return np.array(predicted) / 10_000, np.array(true, dtype=float)


# The reliability diagram and its error.


@given(distinct, st.integers(1, 12))
def test_a_diagram_is_that_of_sorting_and_dealing_out(pairs, bins):
    diagram = reliability(*columns(pairs), bins)
    left = sorted((predicted / 10_000, true) for predicted, true in pairs)
    error = 0.0
    for number in range(bins):
        size = len(pairs) // bins + (number < len(pairs) % bins)
        part, left = left[:size], left[size:]
        predicted = sum(p for p, _ in part) / size
        measured = sum(true for _, true in part) / size
        assert diagram.predicted[number] == pytest.approx(predicted)
        assert diagram.measured[number] == pytest.approx(measured)
        assert diagram.count[number] == size
        error += abs(predicted - measured) * size / len(pairs)
    assert left == []
    assert diagram.ece == pytest.approx(error)


@given(distinct, st.randoms(use_true_random=False))
def test_the_order_of_predictions_does_not_matter(pairs, chance):
    shuffled = chance.sample(pairs, len(pairs))
    assert reliability(*columns(pairs)).ece == pytest.approx(reliability(*columns(shuffled)).ece)


def test_the_order_of_equal_predictions_does_not_matter():
    came_true = np.repeat([0.0, 1.0], 50)  # one half, as was predicted
    mixed = np.random.default_rng(0).permutation(came_true)
    predicted = np.full(100, 0.5)
    assert reliability(predicted, came_true).ece == pytest.approx(reliability(predicted, mixed).ece)
    assert reliability(predicted, came_true).ece < 0.25


def test_equal_predictions_share_the_bin_of_their_middle():
    predicted = np.array([0.1, 0.2, 0.2, 0.2, 0.3, 0.4])
    diagram = reliability(predicted, [0, 0, 1, 1, 0, 1], 3)
    assert diagram.count.tolist() == [1, 3, 2]
    assert diagram.predicted == pytest.approx([0.1, 0.2, 0.35])
    assert diagram.measured == pytest.approx([0.0, 2 / 3, 0.5])


@given(distinct)
def test_an_error_of_calibration_is_at_least_that_of_the_mean(pairs):
    predicted, true = columns(pairs)
    mean = abs(predicted.mean() - true.mean())
    assert reliability(predicted, true, 1).ece == pytest.approx(mean)
    assert mean - 1e-9 <= reliability(predicted, true).ece <= 1.0


@given(st.lists(st.booleans(), min_size=10, max_size=40))
def test_a_prediction_of_what_happens_makes_no_error(true):
    assert reliability(np.array(true, float), true).ece == pytest.approx(0.0)
    assert brier(np.array(true, float), true) == 0.0
    reverse = 1.0 - np.array(true)
    assert reliability(reverse[:10], true[:10]).ece == brier(reverse, true) == 1.0


def test_what_is_calibrated_has_a_small_error_and_what_is_not_has_its_own():
    predicted, true = calibrated()
    assert reliability(predicted, true).ece < 0.015
    for shift in (0.05, 0.2):
        bent = predicted * (1 - shift)  # on average half of the shift too low
        assert reliability(bent, true).ece == pytest.approx(shift / 2, abs=0.01)
    sure = sigmoid(3 * logit(predicted))
    assert reliability(sure, true).ece > 0.08


def test_bins_have_equal_mass_however_predictions_crowd():
    predicted = np.concatenate([np.linspace(0.0, 0.01, 950), np.linspace(0.5, 1.0, 50)])
    diagram = reliability(predicted, np.zeros(1000))
    assert diagram.count.tolist() == [100] * 10
    assert (diagram.predicted[:9] < 0.011).all()
    assert diagram.ece == pytest.approx(predicted.mean())


@pytest.mark.parametrize(
    ("predicted", "true", "bins", "words"),
    [
        ([0.1] * 9, [1] * 9, 10, "bins: 10; give .* from 1 to 9"),
        ([0.1] * 9, [1] * 9, 0, "bins: 0; give .* from 1 to 9"),
        ([], [], 1, r"predicted: empty"),
        ([0.1, 0.2], [1], 1, r"predicted: 2, came_true: 1; give as many"),
        ([[0.1, 0.2]], [[1, 0]], 1, r"\(1, 2\)"),
        ([0.1, 1.2], [1, 0], 1, "predicted: 1.2; give .* from 0 to 1"),
        ([0.1, -0.2], [1, 0], 1, "predicted: -0.2"),
        ([0.1, math.nan], [1, 0], 1, "predicted: nan"),
        ([0.1, 0.2], [1, 2], 1, "came_true: 2.0"),
    ],
)
def test_what_is_no_probability_is_refused(predicted, true, bins, words):
    with pytest.raises(InputError, match=words):
        reliability(predicted, true, bins)
    if "bins" not in words:
        with pytest.raises(InputError, match=words):
            brier(predicted, true)


# Brier's score and the area under the curve.


@given(distinct)
def test_brier_s_score_is_the_mean_square(pairs):
    wanted = sum((predicted / 10_000 - true) ** 2 for predicted, true in pairs) / len(pairs)
    assert brier(*columns(pairs)) == pytest.approx(wanted)


scores = st.lists(st.tuples(st.integers(-4, 4), st.booleans()), min_size=2, max_size=40).filter(
    lambda pairs: 0 < sum(true for _, true in pairs) < len(pairs)
)


@given(scores)
def test_the_area_counts_pairs_and_ties_as_half(pairs):
    better = sum(
        1.0 if mine > other else 0.5 if mine == other else 0.0
        for mine, good in pairs
        for other, bad in pairs
        if good and not bad
    )
    count = sum(true for _, true in pairs)
    predicted, true = zip(*pairs, strict=True)
    assert auc(predicted, true) == pytest.approx(better / (count * (len(pairs) - count)))


@given(scores)
def test_the_area_depends_on_the_order_of_scores_alone(pairs):
    predicted, true = (np.array(column, float) for column in zip(*pairs, strict=True))
    area = auc(predicted, true)
    assert auc(np.exp(predicted), true) == pytest.approx(area)
    assert auc(-predicted, true) == pytest.approx(1.0 - area)
    assert auc(predicted, 1.0 - true) == pytest.approx(1.0 - area)


@pytest.mark.parametrize("true", [[1, 1, 1], [0, 0, 0]])
def test_where_all_came_true_or_nothing_did_there_is_no_area(true):
    assert math.isnan(auc([0.1, 0.2, 0.3], true))


# Logits.


@given(st.lists(st.floats(-30, 30), min_size=1, max_size=20))
def test_logits_and_probabilities_are_each_other_s_inverse(logits):
    assert sigmoid(logits) == pytest.approx([1 / (1 + math.exp(-z)) for z in logits])
    assert logit(sigmoid(logits)) == pytest.approx(np.array(logits), rel=1e-3, abs=1e-9)


# Temperature.


@given(st.floats(0.2, 5.0), st.floats(-1.5, 1.5))
def test_a_temperature_and_an_offset_are_recovered(temperature, offset):
    logits = np.linspace(-4.0, 4.0, 200)
    # With the probabilities themselves as labels nothing is left to chance.
    found = fit_temperature(logits, sigmoid(logits / temperature + offset))
    assert found == pytest.approx((temperature, offset), rel=0.01, abs=0.005)


def test_no_temperature_is_missed_for_want_of_patience():
    logits = np.linspace(-4.0, 4.0, 200)
    found = fit_temperature(logits, sigmoid(logits / 0.2 - 1.23046875))
    assert found == pytest.approx((0.2, -1.23046875), rel=0.01)


def test_a_temperature_is_recovered_from_what_happened():
    logits = np.random.default_rng(0).normal(0.5, 3.0, 20_000)
    found = fit_temperature(logits, bernoulli(sigmoid(logits / 2.0 - 0.5)))
    assert found == pytest.approx((2.0, -0.5), abs=0.12)


@pytest.mark.parametrize("scale", [0.01, 100.0])
def test_logits_may_be_of_any_size(scale):
    logits = scale * np.linspace(-4.0, 4.0, 200)
    found = fit_temperature(logits, sigmoid(logits / (2.0 * scale) - 3.0))
    assert found == pytest.approx((2.0 * scale, -3.0), rel=0.01)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("happened", [np.zeros(50), np.ones(50), np.arange(50) < 25])
def test_where_no_temperature_is_best_it_stays_finite_and_positive(happened):
    temperature, offset = fit_temperature(np.linspace(-3.0, 3.0, 50), happened)
    assert 0.0 < temperature < np.inf
    assert np.isfinite(offset)


# A rising line.


knots = st.lists(
    st.tuples(st.floats(0.05, 3.0), st.floats(0.05, 3.0)), min_size=2, max_size=12
).map(lambda steps: np.cumsum(steps, axis=0) - 10.0)


def line_by_hand(raw, mended, x):
    """The logit on the line, from its two neighbours or the two last knots."""
    after = min(max(sum(knot < x for knot in raw), 1), len(raw) - 1)
    slope = (mended[after] - mended[after - 1]) / (raw[after] - raw[after - 1])
    return mended[after - 1] + slope * (x - raw[after - 1])


@given(knots, st.lists(st.floats(-14.0, 14.0), min_size=1, max_size=10))
def test_a_calibration_is_a_line_through_its_knots_that_goes_on_beyond_them(knots, logits):
    raw, mended = knots.T
    mend = Calibration(tuple(raw), tuple(mended))
    assert mend(raw) == pytest.approx(sigmoid(mended))
    wanted = [line_by_hand(raw, mended, x) for x in logits]
    assert mend(logits) == pytest.approx(sigmoid(wanted), abs=1e-12)


@given(knots)
def test_a_calibration_rises_everywhere(knots):
    mend = Calibration(*(tuple(column) for column in knots.T))
    predicted = mend(np.linspace(-13.0, knots[:, 0].max() + 3.0, 300))
    inside = (predicted > 1e-12) & (predicted < 1 - 1e-12)
    assert (np.diff(predicted[inside]) > 0).all()
    assert (np.diff(predicted) >= 0).all()


def test_without_knots_of_its_own_a_calibration_changes_nothing():
    logits = np.linspace(-8.0, 8.0, 100)
    assert Calibration()(logits) == pytest.approx(sigmoid(logits))
    assert Calibration()(logits.reshape(4, 25)).shape == (4, 25)


@pytest.mark.parametrize(
    ("raw", "mended"),
    [
        ((0.0,), (0.0,)),
        ((), ()),
        ((0.0, 1.0), (0.0, 1.0, 2.0)),
        ((0.0, 0.0), (0.0, 1.0)),
        ((1.0, 0.0), (0.0, 1.0)),
        ((0.0, 1.0), (1.0, 1.0)),
        ((0.0, 1.0, 2.0), (0.0, 1.0, 0.5)),
        ((0.0, math.inf), (0.0, 1.0)),
        ((0.0, 1.0), (math.nan, 1.0)),
    ],
)
def test_knots_that_do_not_rise_are_refused(raw, mended):
    with pytest.raises(InputError, match=r"rising finite numbers|give finite numbers"):
        Calibration(raw, mended)


# Isotonic regression.


def bent(count=30_000):
    """Logits of a network that is too sure of some things and not sure enough of others."""
    logits = np.random.default_rng(3).normal(0.0, 2.5, count)
    return logits, bernoulli(sigmoid(0.1 * logits**3 - 0.8), 4)


def test_the_rising_line_mends_what_no_temperature_can():
    logits, true = bent()
    mend = fit_isotonic(logits[::2], true[::2])
    others, happened = logits[1::2], true[1::2]
    temperature, offset = fit_temperature(logits[::2], true[::2])
    warm = reliability(sigmoid(others / temperature + offset), happened).ece
    assert reliability(sigmoid(others), happened).ece > 0.1
    assert reliability(mend(others), happened).ece < 0.02 < warm


def test_no_two_scores_become_one():
    logits, true = bent(5000)
    mend = fit_isotonic(logits, true)
    assert len(np.unique(mend(logits))) == len(np.unique(logits))
    assert (np.argsort(mend(logits)) == np.argsort(logits)).all()
    assert auc(mend(logits), true) == auc(logits, true)


@given(st.integers(40, 400), st.integers(0, 1000), st.floats(0.0, 1.0))
def test_whatever_happened_the_line_rises(count, seed, share):
    rng = np.random.default_rng(seed)
    logits = rng.permutation(np.linspace(-6, 6, count) + rng.uniform(0, 0.01, count))
    mend = fit_isotonic(logits, rng.random(count) < share)
    assert (np.diff(mend.raw) > 0).all()
    assert (np.diff(mend.mended) > 0).all()
    assert np.isfinite(mend.mended).all()
    assert len(mend.raw) <= module._KNOTS
    assert logits.min() - 1e-3 <= mend.raw[0] <= mend.raw[-1] <= logits.max() + 1e-3


def test_what_falls_is_pooled():
    logits = np.linspace(-5.0, 5.0, 4000)
    mend = fit_isotonic(logits, bernoulli(sigmoid(-logits)))  # the surer the rarer
    slope = np.diff(mend.mended) / np.diff(mend.raw)
    assert slope == pytest.approx(module._STEEP, abs=0.002)
    assert mend(mend.raw[0]) == pytest.approx(0.5, abs=0.05)


def test_knots_lie_closer_together_at_the_upper_end():
    logits, true = bent()
    raw = np.array(fit_isotonic(logits, true).raw)
    assert len(raw) == module._KNOTS
    above = np.array([(logits > knot).mean() for knot in raw])
    assert above[-1] < 0.005
    assert above[0] > 0.02
    assert -np.diff(above)[-1] < 0.4 * -np.diff(above)[:10].min()


@pytest.mark.parametrize("happened", [0.0, 1.0])
def test_nothing_is_ever_certain(happened):
    logits = np.linspace(-3.0, 3.0, 2000)
    predicted = fit_isotonic(logits, np.full(2000, happened))(logits)
    assert ((predicted > 0.0) & (predicted < 1.0)).all()
    assert np.abs(predicted - happened).max() < 0.05
    # A bin of 117, and half a pair more that did not go as all others.
    assert abs(predicted[1000] - happened) == pytest.approx(0.5 / 118, rel=0.2)


def test_the_order_of_the_pairs_does_not_matter():
    logits, true = bent(3000)
    order = random.Random(0).sample(range(3000), 3000)
    assert fit_isotonic(logits, true) == fit_isotonic(logits[order], true[order])

    coarse = logits.round(1)  # many are equal
    assert fit_isotonic(coarse, true) == fit_isotonic(coarse[order], true[order])


def test_chances_can_be_learnt_from_as_well_as_outcomes():
    logits = np.linspace(-4.0, 4.0, 20_000)
    mend = fit_isotonic(logits, sigmoid(0.5 * logits + 1.0))
    inner = np.linspace(-3.0, 3.0, 50)
    assert mend(inner) == pytest.approx(sigmoid(0.5 * inner + 1.0), abs=0.01)


@pytest.mark.parametrize("scale", [1e-3, 1e-2])
def test_logits_that_hardly_differ_can_be_mended(scale):
    logits = scale * np.linspace(-1.0, 1.0, 2000)
    mend = fit_isotonic(logits, bernoulli(np.full(2000, 0.5)))
    assert mend(logits).mean() == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("logits", [np.zeros(50), np.zeros(1)])
def test_a_network_with_constant_logits_cannot_be_mended(logits):
    with pytest.raises(InputError, match="rising"):
        fit_isotonic(logits, np.ones(len(logits)))
