"""The arithmetic of `rmp_policies`, whose checks a controller's step goes past."""

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive


def check_body(body: BicycleCar | DifferentialDrive) -> None:
    """Check that a body is one that C_RMP can drive.

    Raises:
        InputError: when it is another.
    """
    if not isinstance(body, BicycleCar | DifferentialDrive):
        raise InputError(f"body: a {type(body).__name__}; give a BicycleCar or DifferentialDrive")


def goal_policy(
    offsets: Array, velocities: Array, gain: float, damping: float, near: float
) -> tuple[Array, Array]:
    """See `rmp_policies.goal_policy`."""
    distance = np.linalg.norm(offsets, axis=-1, keepdims=True)
    accelerations = gain * offsets / np.maximum(distance, near) - damping * velocities
    return accelerations, np.broadcast_to(np.eye(2), (*offsets.shape, 2))


def obstacle_policy(
    distances: Array, closing: Array, push: float, brake: float, weight: float, fade: float
) -> tuple[Array, Array]:
    """See `rmp_policies.obstacle_policy`."""
    distances = np.maximum(distances, 0.01)  # nearer, it pushes no harder
    away = (push + brake * np.maximum(closing, 0.0)) / distances
    return away, weight * np.exp(-distances / fade)


def heading_policy(
    steerings: Array, wanted: Array, gain: float, weight: float
) -> tuple[Array, Array]:
    """See `rmp_policies.heading_policy`."""
    rates = gain * (wanted - steerings)
    return rates, np.full(rates.shape, float(weight))


def point_jacobian(points: ArrayLike) -> Array:
    """See `rmp_policies.point_jacobian`."""
    points = np.asarray(points, dtype=float)
    jacobians = np.zeros((*points.shape, 2))
    jacobians[..., 0, 0] = 1.0
    jacobians[..., 0, 1], jacobians[..., 1, 1] = -points[..., 1], points[..., 0]
    return jacobians


def control_jacobian(body: BicycleCar | DifferentialDrive, controls: Array) -> Array:
    """See `rmp_policies.control_jacobian`."""
    jacobians = np.broadcast_to(np.eye(2), (*controls.shape, 2)).copy()
    if isinstance(body, BicycleCar):
        tangent = np.tan(controls[..., 1])
        jacobians[..., 1, 0] = tangent / body.wheelbase
        jacobians[..., 1, 1] = controls[..., 0] * (1 + tangent**2) / body.wheelbase
    return jacobians


def pull_back(jacobians: Array, accelerations: Array, metrics: Array) -> tuple[Array, Array]:
    """See `rmp_policies.pull_back`."""
    weighted = np.swapaxes(jacobians, -1, -2) @ metrics
    return (weighted @ np.asarray(accelerations)[..., None])[..., 0], weighted @ jacobians


def resolve(forces: Array, metrics: Array, damping: float = 1e-6) -> Array:
    """See `rmp_policies.resolve`."""
    found = np.linalg.solve(metrics + damping * np.eye(2), forces[..., None])
    return np.asarray(found[..., 0], dtype=float)
