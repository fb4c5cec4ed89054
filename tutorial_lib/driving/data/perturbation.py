"""Perturbed starts beside a recorded trajectory, from which a robot has to recover."""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.se2 import Array, compose
from tutorial_lib.validation import floats, instance, number
from tutorial_lib.world.bodies import BicycleCar, Body
from tutorial_lib.world.placing import checked_body, is_free
from tutorial_lib.world.scene import Scene

_TRIES = 8  # of a start beside a pose


@dataclass(frozen=True)
class Perturbation:
    """How far from a recorded trajectory a robot starts.

    Attributes:
        aside: metres, sigma of the shift to the left or right.
        most: metres that it is shifted at most.
        turn: rad, sigma of the turn.
        wide_turn: rad, sigma of the turn of those that come out of a manoeuvre.
        wide: share of those.
        beside: share that is shifted by anything up to `farthest` instead.
        farthest: metres.
    """

    aside: float = 0.3
    most: float = 1.0
    turn: float = float(np.deg2rad(9.0))
    wide_turn: float = float(np.deg2rad(9.0))
    wide: float = 0.0
    beside: float = 0.0
    farthest: float = 2.5

    def __post_init__(self) -> None:
        for one in fields(self):
            most = 1.0 if one.name in ("wide", "beside") else np.inf
            number(one.name, getattr(self, one.name), least=0, most=most)

    def apply(self, poses: Array, rng: np.random.Generator) -> Array:
        """Poses (N, 3) shifted sideways and turned."""
        count = len(floats("poses", poses, ("N", 3)))
        instance("rng", rng, np.random.Generator)
        aside = np.clip(rng.normal(0.0, self.aside, count), -self.most, self.most)
        if self.beside:
            anywhere = rng.uniform(-self.farthest, self.farthest, count)
            aside = np.where(rng.random(count) < self.beside, anywhere, aside)
        wide = rng.random(count) < self.wide
        turn = rng.normal(0.0, 1.0, count) * np.where(wide, self.wide_turn, self.turn)
        return compose(poses, np.stack([np.zeros(count), aside, turn], axis=1))


PAPER_PERTURBATION = Perturbation()
"""As in the authors' code; the starts of Table I."""
TRAINING_PERTURBATION = Perturbation(wide=0.4, wide_turn=float(np.deg2rad(35.0)))
"""Wider than the paper's: during a manoeuvre a car faces far aside."""

REACHABILITY_PERTURBATION = replace(TRAINING_PERTURBATION, beside=0.2)
"""Wider still: RE is also queried about places that lie beside the car."""


def perturbed(
    scene: Scene,
    poses: Array,
    perturbation: Perturbation,
    rng: np.random.Generator,
    body: Body | None = None,
) -> tuple[Array, NDArray[np.bool_]]:
    """Poses beside `poses` (N, 3) from which a body can start, and (N,) whether one was found.

    A pose from which the recorded one is not in sight lies behind a wall and is not taken.
    """
    instance("scene", scene, Scene)
    instance("perturbation", perturbation, Perturbation)
    instance("rng", rng, np.random.Generator)
    poses = floats("poses", poses, ("N", 3))
    body = BicycleCar() if body is None else checked_body(body)
    moved, found = poses.copy(), np.zeros(len(poses), dtype=bool)
    for _ in range(_TRIES):
        missing = np.flatnonzero(~found)
        if not len(missing):
            break
        tried = perturbation.apply(poses[missing], rng)
        good = is_free(scene, body, tried)
        good &= scene.caster.sees(tried[:, :2], poses[missing, :2])
        moved[missing[good]] = tried[good]
        found[missing[good]] = True
    return moved, found
