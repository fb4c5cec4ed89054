"""Frames and anchors of a trajectory, and a follower's states, drawn on the plan."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.topology.following.transitions import State
from tutorial_lib.validation import alike, instance, integers
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

STATES = {
    State.SEARCH: colours.FAINT,
    State.FOLLOW: colours.ROBOT,
    State.DEAD_RECKONING: colours.LASER,
    State.LOST: colours.INK,
    State.DONE: colours.GOAL,
}
"""A colour for each state of a follower."""
_JUMP = 0.25  # metres between two steps: the robot was teleported


def states_of(states: ArrayLike) -> NDArray[np.intp]:
    """A follower's states (T,), or an `InputError`."""
    return integers("states", states, ("T",), least=0, most=max(STATES))


def state_name(state: int) -> str:
    """The name of a state in plain words.

    >>> state_name(2)
    'dead reckoning'
    """
    return State(state).name.replace("_", " ").lower()


def draw_anchors(
    view: PlanView,
    picture: Picture,
    poses: ArrayLike,
    size: float = 6.0,
    colour: tuple[int, int, int] = colours.GOAL,
) -> None:
    """Draw anchors at poses (A, 3) as arrowheads."""
    instance("view", view, PlanView)
    for pose in places_of("poses", poses, ("A", 3)):
        view.arrow(picture, pose, colour, size)


def draw_states(
    view: PlanView, picture: Picture, poses: ArrayLike, states: ArrayLike, width: float = 3.0
) -> None:
    """Draw a robot's path, poses (T, 3), in the colours of its states (T,).

    The line is broken where the robot was teleported.
    """
    instance("view", view, PlanView)
    poses, states = places_of("poses", poses, ("T", 3)), states_of(states)
    alike(poses=poses, states=states)
    jumps = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1) > _JUMP
    changes = np.flatnonzero(np.diff(states).astype(bool) | jumps) + 1
    for first, last in zip([0, *changes], [*changes, len(states)], strict=True):
        joined = last < len(states) and not jumps[last - 1]
        places = poses[first : last + joined, :2]
        view.polyline(picture, places, STATES[State(states[first])], width)
