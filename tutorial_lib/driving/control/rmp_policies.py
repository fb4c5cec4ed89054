"""Policies, Jacobians and how they are combined: what `rmp` is made of, each by itself."""

from numpy.typing import ArrayLike

from tutorial_lib.driving.control import rmp_arithmetic as raw
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import floats, match, number
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive


def goal_policy(
    offsets: ArrayLike, velocities: ArrayLike, gain: float, damping: float, near: float
) -> tuple[Array, Array]:
    """Pull a point to its goal, and damp it: gain * offset / |offset| - damping * velocity.

    Its terminal speed is gain / damping, in m/s. Within `near` the pull fades to nothing.
    Gives accelerations (..., 2) and metrics (..., 2, 2), the identity.

    Args:
        offsets: (..., 2) from the point to its goal, metres.
        velocities: (..., 2) of the point, m/s.
        gain: m/s^2.
        damping: 1/s.
        near: metres.
    """
    offsets = floats("offsets", offsets, (..., 2))
    velocities = floats("velocities", velocities, (..., 2))
    match(offsets=offsets.shape[:-1], velocities=velocities.shape[:-1])
    gain, damping = number("gain", gain), number("damping", damping)
    return raw.goal_policy(offsets, velocities, gain, damping, number("near", near, above=0))


def obstacle_policy(
    distances: ArrayLike, closing: ArrayLike, push: float, brake: float, weight: float, fade: float
) -> tuple[Array, Array]:
    """Make the distance from an obstacle grow: (push + brake * closing) / distance.

    What it accelerates is a number, so its metric is one too. In the plane that is the metric
    weight * h h^T of the paper, h the direction to the obstacle: it has no effect sideways.
    Gives accelerations (...) of the distances, and metrics (...).

    Args:
        distances: (...) metres.
        closing: (...) m/s at which they shrink; what recedes is only pushed.
        push: m^2/s^2.
        brake: m/s, more for each m/s of closing.
        weight: metric at contact.
        fade: metres over which the metric falls to a third.
    """
    distances, closing = floats("distances", distances), floats("closing", closing)
    match(distances=distances.shape, closing=closing.shape)
    push, brake = number("push", push), number("brake", brake)
    weight, fade = number("weight", weight), number("fade", fade, above=0)
    return raw.obstacle_policy(distances, closing, push, brake, weight, fade)


def heading_policy(
    steerings: ArrayLike, wanted: ArrayLike, gain: float, weight: float
) -> tuple[Array, Array]:
    """Turn the steering to what leads along the arc to the waypoint.

    Gives rates (...) at which the steering is to change, and metrics (...).

    Steerings (...) are in rad for a car and in rad/s for a differential drive; gain in 1/s.
    """
    steerings, wanted = floats("steerings", steerings), floats("wanted", wanted)
    match(steerings=steerings.shape, wanted=wanted.shape)
    gain, weight = number("gain", gain), number("weight", weight)
    return raw.heading_policy(steerings, wanted, gain, weight)


def point_jacobian(points: ArrayLike) -> Array:
    """How a point of a rigid body moves with its twist: (..., 2, 2) for points (..., 2).

    Rows are the point's velocity ahead and to the left, columns speed and turning rate.
    """
    return raw.point_jacobian(floats("points", points, (..., 2)))


def control_jacobian(body: BicycleCar | DifferentialDrive, controls: ArrayLike) -> Array:
    """How a body's twist changes with its controls: (N, 2, 2) for controls (N, 2).

    Rows are speed and turning rate. The controls of a differential drive are its twist; a car's
    turning rate is speed * tan(steering) / wheelbase, which steering does not change at rest.
    """
    raw.check_body(body)
    return raw.control_jacobian(body, floats("controls", controls, (..., 2)))


def pull_back(jacobians: Array, accelerations: Array, metrics: Array) -> tuple[Array, Array]:
    """What a policy means for the controls: force J^T M a, and metric J^T M J.

    That Jacobians change is left out: controls are updated ten times a second.
    Jacobians (..., D, 2) are those of the D numbers that the policy accelerates, by (..., D) with
    metrics (..., D, D). Forces (..., 2) and metrics (..., 2, 2) of several policies add up.
    """
    jacobians = floats("jacobians", jacobians, (..., "D", 2))
    accelerations = floats("accelerations", accelerations, (..., "D"))
    metrics = floats("metrics", metrics, (..., "D", "D"))
    if len({jacobians.shape[-2], accelerations.shape[-1], *metrics.shape[-2:]}) > 1:
        raise InputError(
            f"jacobians: {jacobians.shape}, accelerations: {accelerations.shape}, metrics: "
            f"{metrics.shape}; give (..., D, 2), (..., D) and (..., D, D)"
        )
    leads = {"jacobians": jacobians.shape[:-2], "metrics": metrics.shape[:-2]}
    match(**leads, accelerations=accelerations.shape[:-1])
    return raw.pull_back(jacobians, accelerations, metrics)


def resolve(forces: Array, metrics: Array, damping: float = 1e-6) -> Array:
    """The accelerations of the controls (..., 2) that suit all policies best.

    They minimise the sum over the policies of (J u - a)^T M (J u - a), plus damping * |u|^2.
    Forces (..., 2) and metrics (..., 2, 2) are sums of what `pull_back` gave; the damping keeps at
    rest what no policy acts on.
    """
    forces, metrics = floats("forces", forces, (..., 2)), floats("metrics", metrics, (..., 2, 2))
    match(forces=forces.shape[:-1], metrics=metrics.shape[:-2])
    return raw.resolve(forces, metrics, number("damping", damping, above=0))
