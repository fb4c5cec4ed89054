import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.experiments.common.statistics import (
    difference,
    measured_over_worlds,
    over_worlds,
    wilson,
)


def slow_bootstrap(values, worlds, draws=3000):
    """Worlds are drawn again, one at a time, each with all of its episodes."""
    by_world = {}
    for value, world in zip(values, worlds, strict=True):
        by_world.setdefault(world, []).append(value)
    names, chance, means = sorted(by_world), random.Random(7), []
    for _ in range(draws):
        episodes = [v for _ in names for v in by_world[chance.choice(names)]]
        means.append(sum(episodes) / len(episodes))
    means.sort()
    return means[round(0.025 * draws)], means[round(0.975 * draws) - 1]


def episodes_of(worlds, each, seed=0, spread=0.25):
    """Successes of episodes whose worlds differ in difficulty, and their worlds."""
    rng = np.random.default_rng(seed)
    chance = np.clip(rng.normal(0.7, spread, worlds), 0, 1)
    world = np.repeat(np.arange(worlds), each)
    return (rng.random(len(world)) < chance[world]).astype(float), world


@pytest.mark.parametrize("sizes", [[20] * 12, [5, 40, 8, 30, 15, 2, 22]])
def test_the_interval_is_that_of_a_slow_bootstrap(sizes):
    rng = np.random.default_rng(1)
    worlds = rng.permutation(np.repeat(np.arange(len(sizes)), sizes))
    chance = rng.uniform(0.2, 1.0, len(sizes))
    values = (rng.random(len(worlds)) < chance[worlds]).astype(float)
    mean, low, high = over_worlds(values, worlds)
    assert mean == pytest.approx(sum(values) / len(values))
    assert (low, high) == pytest.approx(slow_bootstrap(values, worlds), abs=0.03)
    # Had episodes been the units, the interval would be much narrower.
    assert high - low > 1.5 * np.subtract(*over_worlds(values, np.arange(len(values)))[:0:-1])


@given(st.integers(2, 12), st.integers(1, 20), st.integers(0, 50))
def test_the_interval_holds_the_mean_and_lies_among_the_values(worlds, each, seed):
    values, world = episodes_of(worlds, each, seed)
    mean, low, high = over_worlds(values, world)
    assert mean == pytest.approx(values.mean())
    assert values.min() - 1e-12 <= low <= mean + 1e-12
    assert mean - 1e-12 <= high <= values.max() + 1e-12


def test_fewer_worlds_tell_less():
    widths = []
    for worlds in (4, 16, 64):
        found = [over_worlds(*episodes_of(worlds, 10, seed)) for seed in range(10)]
        widths.append(np.mean([high - low for _, low, high in found]))
    assert widths[0] > 1.5 * widths[1] > 1.5 * 1.5 * widths[2]


def test_more_episodes_in_the_same_worlds_tell_little():
    values, world = episodes_of(10, 8)
    assert over_worlds(np.repeat(values, 9), np.repeat(world, 9)) == pytest.approx(
        over_worlds(values, world)
    )


def test_about_95_of_100_intervals_hold_the_truth():
    held = 0
    for seed in range(200):
        values, world = episodes_of(30, 5, seed, spread=0.1)
        _, low, high = over_worlds(values, world)
        held += low <= 0.7 <= high
    assert 0.87 <= held / 200 <= 0.99


def test_the_worlds_order_and_names_do_not_matter():
    values, world = episodes_of(6, 9)
    wanted = over_worlds(values, world)
    order = np.random.default_rng(0).permutation(len(values))
    assert over_worlds(values[order], world[order]) == pytest.approx(wanted)
    assert over_worlds(values, 20_000 + 3 * world) == pytest.approx(wanted)
    assert over_worlds(values.tolist(), [f"world {w}" for w in world]) == pytest.approx(wanted)
    assert over_worlds(values, world) == wanted  # the same numbers each time


def test_numbers_are_plain():
    for found in (over_worlds([1, 0, 1], [0, 1, 2]), over_worlds([1, 0], [0, 0])):
        assert [type(number) for number in found] == [float] * 3


# One world.


@pytest.mark.parametrize(("successes", "count"), [(0, 10), (3, 10), (8, 10), (10, 10), (1, 1)])
def test_one_world_has_wilson_s_interval(successes, count):
    values = np.array([1.0] * successes + [0.0] * (count - successes))
    share, low, high = over_worlds(values, np.full(count, 20_007))
    assert (share, low, high) == wilson(values)
    assert share == successes / count
    # By definition the bounds p are where |share - p| is 1.96 standard deviations of p.
    for bound in (low, high):
        gap = (share - bound) ** 2
        assert gap == pytest.approx(1.96**2 * bound * (1 - bound) / count, abs=1e-12)
    assert -1e-12 <= low <= share + 1e-12
    assert share - 1e-12 <= high <= 1 + 1e-12


def test_wilson_s_interval_is_the_one_in_the_books():
    assert wilson(np.array([1.0] * 8 + [0.0] * 2)) == pytest.approx((0.8, 0.490, 0.943), abs=1e-3)


# Two systems on the same episodes.


def test_a_difference_is_as_sure_as_there_are_worlds():
    # All episodes of a world go the same way: ten worlds say little, a thousand episodes much.
    gaps = np.repeat([1.0, -1.0] * 5, 100)
    worlds = np.repeat(np.arange(10), 100)
    mean, low, high = difference(gaps, np.zeros(1000), worlds)
    assert mean == 0.0
    assert high - low > 0.9
    _, low, high = difference(gaps, np.zeros(1000), np.zeros(1000))
    assert high - low < 0.15


def test_a_difference_is_paired():
    rng = np.random.default_rng(0)
    first, world = episodes_of(15, 30)
    second = np.where(rng.random(len(first)) < 0.1, 0.0, first)
    mean, low, high = difference(first, second, world)
    assert mean == pytest.approx(first.mean() - second.mean())
    assert (low, high) == pytest.approx(slow_bootstrap(first - second, world), abs=0.01)
    alone = over_worlds(first, world)
    assert high - low < 0.5 * (alone[2] - alone[1])


@pytest.mark.parametrize("worlds", [1, 8])
def test_two_that_are_the_same_do_not_differ(worlds):
    values, world = episodes_of(worlds, 20)
    assert difference(values, values, world) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("worlds", [1, 8])
def test_a_difference_can_be_negative_and_its_interval_holds_it(worlds):
    values, world = episodes_of(worlds, 60)
    worse = np.where(np.arange(len(values)) % 5 == 0, 0.0, values)
    mean, low, high = difference(worse, values, world)
    assert low < mean < high <= 0.0
    assert mean == pytest.approx((worse - values).mean())
    assert low > -0.35
    other = difference(values, worse, world)
    assert other == pytest.approx((-mean, -high, -low), abs=0.03)


# What is no mean.


def mean(values):
    return float(values.mean())


def test_of_a_mean_the_interval_is_that_of_the_mean():
    values, world = episodes_of(12, 15)
    assert measured_over_worlds(mean, world, values) == pytest.approx(
        over_worlds(values, world), abs=0.03
    )


def test_what_is_measured_may_be_anything():
    values, world = episodes_of(9, 20)
    values = values + np.random.default_rng(3).normal(size=len(values))
    found = measured_over_worlds(lambda x: float(np.median(x)), world, values)
    by_world, chance, medians = [values[world == w] for w in range(9)], random.Random(7), []
    for _ in range(2000):
        medians.append(np.median(np.concatenate([chance.choice(by_world) for _ in by_world])))
    wanted = (np.median(values), *np.quantile(medians, [0.025, 0.975]))
    assert found == pytest.approx(wanted, abs=0.08)
    assert found[1] < found[0] < found[2]
    assert found == measured_over_worlds(lambda x: float(np.median(x)), world, values)


def test_columns_are_drawn_together():
    values, world = episodes_of(6, 10)
    seen = []

    def gap(first, second):
        seen.append((first == second + 1).all())
        return float((first - second).mean())

    assert measured_over_worlds(gap, world, values + 1, values) == (1.0, 1.0, 1.0)
    assert all(seen)


def test_worlds_are_drawn_whole_and_as_many_as_there_are():
    world = np.repeat([3, 8, 9], [2, 5, 1])
    rows = np.arange(8)

    def check(drawn):
        times = np.bincount(drawn, minlength=8)
        each = times[[0, 2, 7]]
        assert (times == np.repeat(each, [2, 5, 1])).all()
        assert each.sum() == 3
        return 0.0

    assert measured_over_worlds(check, world, rows) == (0.0, 0.0, 0.0)


def test_one_world_is_measured_by_its_rows():
    values = np.random.default_rng(0).normal(size=400)
    found = measured_over_worlds(mean, np.full(400, 20_003), values)
    half = 1.96 * values.std() / 20
    assert found == pytest.approx(
        (values.mean(), values.mean() - half, values.mean() + half), abs=0.02
    )


def test_draws_in_which_nothing_can_be_measured_do_not_count():
    def ratio(values):
        return float("nan") if values.all() else mean(values)

    values, world = np.array([1.0, 1.0, 0.0, 0.0]), np.array([0, 0, 1, 1])
    assert measured_over_worlds(ratio, world, values) == (0.5, 0.0, 0.5)
