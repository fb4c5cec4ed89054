"""The wheel odometry of the robots in an experiment: it drifts unless it is to be exact."""

from dataclasses import dataclass

from tutorial_lib.world.noise import DriftingOdometry, NoNoise, OdometryNoise

RECORDING, NAVIGATING = 1, 2
"""Uses of odometry; each drifts in its own way."""


@dataclass(frozen=True)
class Odometry:
    """Which odometry the robots of one world have.

    Attributes:
        drifts: as `WheelOdometry` does; otherwise it is exact.
        seed: of the drift, whole numbers from 0 on.
    """

    drifts: bool = True
    seed: tuple[int, ...] = (0,)

    def noise(self, use: int) -> OdometryNoise:
        """For one simulation, and one use; the same each time."""
        return DriftingOdometry(*self.seed, use) if self.drifts else NoNoise()


USUAL = Odometry()
"""Of robots in a world that has no seed."""
