"""Drives with what is seen on them, for the check of the filter's loop in notebook 07."""

from dataclasses import asdict, dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.checks.engine import WrongAnswer
from tutorial_lib.checks.nb07.small_models import random_model, row_of
from tutorial_lib.geometry import Array
from tutorial_lib.topology.localization import FilterSettings


@dataclass(frozen=True, eq=False)
class Story:
    """A drive.

    Attributes:
        odometry: (T, 3).
        likelihoods: (T, V) of what is seen.
        lengths: (V + 1,) of the motion model.
        onward: (V + 1, V + 1) of the motion model.
        rules: of the filter.
    """

    odometry: Array
    likelihoods: Array
    lengths: Array
    onward: Array
    rules: FilterSettings | SimpleNamespace


class Drive:
    """A story that is looked at.

    Attributes:
        log: the steps at which somebody looked.
    """

    def __init__(self, story: Story) -> None:
        """Nobody has looked yet."""
        self._story, self.log, self._given = story, list[int](), list[Array]()

    def look(self, step: int) -> Array:
        """The likelihoods (V,) at a step."""
        if isinstance(step, bool) or not isinstance(step, int | np.integer):
            raise WrongAnswer(f"look got {step!r}; give it the number of the step")
        if not 0 <= step < len(self._story.likelihoods):
            raise WrongAnswer(
                f"look got {step}; the steps are 0 to {len(self._story.odometry) - 1}"
            )
        if self.log and step <= self.log[-1]:
            raise WrongAnswer(
                f"look got {step} after {self.log[-1]}; look once at a step, in order"
            )
        self.log.append(int(step))
        self._given.append(self._story.likelihoods[step].copy())
        return self._given[-1]

    def demand_untouched(self) -> None:
        """Demand that nobody has changed what `look` returned.

        Raises:
            WrongAnswer: when somebody has.
        """
        for step, given in zip(self.log, self._given, strict=True):
            if not np.array_equal(given, self._story.likelihoods[step]):
                raise WrongAnswer(
                    "your function changes the array that look gave it; look may keep it for "
                    "others, so make a new one: np.maximum(seen, ...) does, without out="
                )


_RULES = FilterSettings(stride=0.3, interval=6)


def _along(
    places: ArrayLike,
    gone: ArrayLike | None = None,
    vertices: int = 6,
    twins: dict[int, float] | None = None,
    rules: FilterSettings = _RULES,
) -> Story:
    """A drive along vertices a metre apart; a place below -1 shows what no vertex does."""
    x = np.asarray(places, dtype=float)
    wheels = x - x[0] if gone is None else np.asarray(gone, dtype=float)
    at = np.array([(twins or {}).get(v, v) for v in range(vertices)], dtype=float)
    seen = np.exp(-np.abs(x[:, None] - at)) * (x[:, None] >= -1)
    odometry = np.column_stack([wheels, 0 * wheels, 0 * wheels])
    return Story(odometry, seen, *row_of(vertices), rules)


def _random(seed: int) -> Story:
    """Motions and likelihoods at random; the robot often stands still."""
    rng = np.random.default_rng([seed, 11])
    steps, vertices = int(rng.integers(14, 22)), int(rng.integers(2, 5))
    motion = rng.choice([0.0, 0.05, 0.12, 0.5], (steps, 1)) * rng.normal(size=(steps, 3))
    likelihoods = rng.uniform(0.0, 1.0, (steps, vertices)) ** 2
    rules = FilterSettings(
        stride=float(rng.choice([0.2, 0.4])),
        interval=int(rng.integers(3, 8)),
        unknown=float(rng.choice([0.2, 0.5])),
        least=float(rng.choice([0.02, 0.1])),
        sharpness=float(rng.choice([0.5, 2.0])),
        hysteresis=float(rng.choice([0.5, 0.9])),
    )
    return Story(np.cumsum(motion, axis=0), likelihoods, *random_model(vertices, seed), rules)


def _seen(looks: list[list[float]], **rules: float) -> Story:
    """A robot that stands still, and sees one thing for three steps, then another for three."""
    likelihoods = np.repeat(np.array(looks, dtype=float), 3, axis=0)
    # Not FilterSettings, which refuse the limits that the exercise allows, as a hysteresis of 1.
    settings = SimpleNamespace(**{**asdict(FilterSettings(interval=3)), **rules})
    return Story(np.zeros((6, 3)), likelihoods, *row_of(likelihoods.shape[1]), settings)


def _turning() -> Story:
    """A robot that turns on the spot, past the heading at which angles jump."""
    heading = (np.arange(2.8, 3.6, 0.08) + np.pi) % (2 * np.pi) - np.pi
    odometry = np.column_stack([0 * heading, 0 * heading, heading])
    seen = np.random.default_rng(5).uniform(0.0, 1.0, (len(heading), 4))
    return Story(odometry, seen, *row_of(4), FilterSettings(interval=20))


_EXACT = FilterSettings(stride=0.25, interval=6)
_AT_REST = FilterSettings(interval=3)
_ON = np.arange(0.0, 2.0, 0.1)
_AWAY = np.full(12, -2.0)

STORIES: dict[str, Story] = {
    "along the row": _along(_ON),
    "at standstill": _along(np.full(16, 2.0)),
    "along the row, then still": _along([*_ON, *np.full(14, 1.9)]),
    "the same stretch twice": _along(np.arange(1.0, 3.4, 0.1), twins={4: 1.02, 5: 2.02}),
    "kidnapped from the row's end to its middle": _along(
        [*np.arange(0.0, 1.2, 0.1), *np.arange(3.0, 4.6, 0.1)], np.arange(28) * 0.1
    ),
    "kidnapped to a place that is not on the map": _along(
        [*np.arange(0.0, 1.2, 0.1), *_AWAY], np.arange(24) * 0.1
    ),
    "off the map, then at vertex 0, but not clearly": _along(
        [*np.full(7, -2.0), *np.full(7, -0.8), *np.zeros(7)], np.zeros(21), rules=_AT_REST
    ),
    "at rest, a little nearer to vertex 1 than to vertex 0": _along(np.full(3, 0.55)),
    "at rest, a little nearer to vertex 2 than to vertex 1": _along(np.full(3, 1.55)),
    "exactly a stride a step": _along(np.arange(0.0, 2.0, 0.25), rules=_EXACT),
    "two vertices alike, and a hysteresis of 1": _seen(
        [[0, 0, 1, 0], [0, 1, 1, 0]], hysteresis=1.0
    ),
    "another one twice as likely, and a hysteresis of a half": _seen(
        [[0, 0, 1, 0], [0, 1, 0.5, 0]], sharpness=1.0, hysteresis=0.5
    ),
    "another one a little more likely, and a hysteresis of 0.9": _seen(
        [[0, 0, 1, 0], [0, 1, 0.7, 0]], sharpness=1.0, hysteresis=0.9
    ),
    "another one far more likely, and a hysteresis of 0.2": _seen(
        [[0, 0, 1, 0], [0, 1, 0.3, 0]], sharpness=1.0, hysteresis=0.2
    ),
    "off the map, if anywhere": _seen(
        [[0, 0, 1, 0], [0.2, 0.2, 0.02, 0.2]], sharpness=1.0, unknown=0.3, least=0.01
    ),
    "least above unknown": _seen([[0, 0.6, 0, 0], [0.1, 0, 0, 0]], least=0.3, unknown=0.1),
    "strides of a few centimetres": _along(
        np.arange(0.0, 0.6, 0.03), rules=FilterSettings(stride=0.02, interval=6)
    ),
    "turning past half a turn": _turning(),
    **{f"at random ({seed})": _random(seed) for seed in range(4)},
}
