"""The checks of what a traversal says about an edge, in notebook 08."""

from functools import partial

import numpy as np

from tutorial_lib.checks.engine import calling, case, close, exercise, farthest, numbers, parts
from tutorial_lib.checks.framework.wording import both
from tutorial_lib.geometry import Array
from tutorial_lib.topology.maintenance import bayes, gaussian

BELIEFS = {
    "a success on an edge that is doubted": case(0.5, 0.9, 0.05, True),
    "a failure on the same": case(0.5, 0.9, 0.05, False),
    "a failure on an edge that is nearly sure": case(0.97, 0.9, 0.05, False),
    "a success after many failures": case(0.02, 0.75, 0.1, True),
    "a success that is as likely without the edge": case(0.3, 0.4, 0.4, True),
    "a robot that seldom succeeds": case(0.6, 0.3, 0.2, False),
    "a success that is less likely with the edge": case(0.5, 0.3, 0.6, True),
    "an edge that surely exists": case(1.0, 0.9, 0.05, False),
    "an edge that surely does not": case(0.0, 0.9, 0.05, True),
    "a success that numpy measured": case(0.5, 0.9, 0.05, np.True_),
}
BAYES = """
a failure is no success: its likelihoods are 1 - p(s | r) and 1 - p(s | not r)
    succeeds if success else 1.0 - succeeds -> succeeds
    deceives if success else 1.0 - deceives -> deceives
without the edge a traversal succeeds with p(s | not r), not with 1 - p(s | r)
    deceives if success else 1.0 - deceives -> 1 - succeeds if success else succeeds
divide by p(s), the sum over both cases; else it is no probability
    exists / (exists + not_there) -> exists
in the sum below, too, each likelihood is multiplied by what was believed before
    exists / (exists + not_there)
        -> exists / (SUCCEEDS + DECEIVES)
    SUCCEEDS -> (succeeds if success else 1.0 - succeeds)
    DECEIVES -> (deceives if success else 1.0 - deceives)
a failure with the edge has the likelihood 1 - p(s | r), and without it 1 - p(s | not r)
    succeeds if success else 1.0 - succeeds -> succeeds if success else deceives
    deceives if success else 1.0 - deceives -> deceives if success else succeeds
the case without the edge has the probability 1 - prior
    (1.0 - prior) * -> 1.0 *
multiply the likelihood by what was believed before
    prior * (succeeds if success else 1.0 - succeeds) -> (succeeds if success else 1.0 - succeeds)
    (1.0 - prior) * -> 1.0 *
a failure is no success where the edge is missing, either
    deceives if success else 1.0 - deceives -> deceives
a failure is no success where the edge exists, either
    succeeds if success else 1.0 - succeeds -> succeeds
that is the probability that the edge does not exist; return the other
    exists / (exists + not_there) -> not_there / (exists + not_there)
"""


def _broken_belief(got: float, want: float, *case: float) -> str:
    prior, _, _, success = case
    if not 0 <= got <= 1:
        return "a probability lies between 0 and 1"
    if prior in (0.0, 1.0):
        return "what is certain stays so, whatever happens"
    if (got > prior) != (want > prior):
        event = "success" if success else "failure"
        return f"after this {event} the belief moves the other way: the two likelihoods decide"
    return "prior x likelihood, over the sum of that for both cases: the edge exists, or not"


check_bayes = exercise(
    bayes,
    BELIEFS,
    BAYES,
    about="Successes and failures on edges that are doubted, nearly sure, and certain.",
    example=case(0.5, 0.9, 0.05, True),
    calls=20_000,
    invoke=calling({TypeError: "all arguments are numbers, success is True or False"}),
    form=lambda what, got, *_: numbers(what, got, ()),
    same=partial(close, tolerance=1e-9),
    difference=farthest,
    broken=_broken_belief,
)

LENGTHS = {
    "as sure of either": case(1.0, 0.04, 2.0, 0.04),
    "a long edge that was hardly measured": case(3.0, 1.0, 2.0, 0.04),
    "one measured often": case(1.5, 0.001, 2.5, 0.04),
    "a measurement that agrees": case(1.2, 0.09, 1.2, 0.01),
    "noise of another size": case(0.8, 0.5, 0.3, 0.25),
}
GAUSSIAN = """
the mean moves by the share variance / (variance + noise); yours has the noise on top
    variance / (variance + noise) -> noise / (variance + noise)
variances are squares already; do not square them
    variance / (variance + noise) -> variance**2 / (variance**2 + noise**2)
what is measured makes it surer: 1 / new = 1 / variance + 1 / noise; the variance never grows
    1.0 / (1.0 / variance + 1.0 / noise) -> variance + noise
the variance becomes smaller with every measurement; yours stays
    1.0 / (1.0 / variance + 1.0 / noise) -> variance
the mean of both variances is no filter: 1 / new = 1 / variance + 1 / noise
    1.0 / (1.0 / variance + 1.0 / noise) -> (variance + noise) / 2
a filter weighs; the plain mean of both lengths forgets how sure either is
    gain = variance / (variance + noise) -> gain = 0.5
1 / new = 1 / variance + 1 / noise; invert the sum
    1.0 / (1.0 / variance + 1.0 / noise) -> 1 / variance + 1 / noise
that is the standard deviation; return the variance
    1.0 / (1.0 / variance + 1.0 / noise) -> (1 / (1 / variance + 1 / noise)) ** 0.5
"""


def _two(what: str, got: object, *_: object) -> Array:
    words = "return two numbers, the mean and the variance"
    both = list(got) if isinstance(got, np.ndarray) and got.ndim else got
    return np.array([float(numbers(what, one, ())) for one in parts(what, both, 2, words)])


def _broken_length(got: Array, want: Array, *_: float) -> str:
    if abs(got[0] - want[0]) > 1e-9:
        return "the mean moves towards what was measured, by variance / (variance + noise)"
    return "the variance: 1 / new = 1 / variance + 1 / noise"


def _unlike(got: Array, want: Array, *_: float) -> str:
    mean, variance = (both(*pair) for pair in zip(got, want, strict=True))
    return f"mean {mean[0]} and variance {variance[0]}, but {mean[1]} and {variance[1]} are right"


check_gaussian = exercise(
    gaussian,
    LENGTHS,
    GAUSSIAN,
    about="Lengths that were measured often or hardly ever.",
    example=case(1.0, 0.04, 2.0, 0.04),
    calls=20_000,
    invoke=calling({TypeError: "all arguments are numbers"}),
    form=_two,
    same=partial(close, tolerance=1e-9),
    difference=_unlike,
    broken=_broken_length,
)
