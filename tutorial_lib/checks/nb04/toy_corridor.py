"""A small corridor for the check of the follower's loop, in notebook 04."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tutorial_lib.checks.nb04.observations import OTHER_RULES, RULES
from tutorial_lib.se2 import Array, compose, to_local
from tutorial_lib.topology.following.transitions import FollowerSettings, State

STEP = 0.1
"""Seconds of a step."""
_SPEED, _TURN = 0.0437, 0.25  # metres and rad that the toy robot moves in a step
_RULES = replace(RULES, timeout=2.05, effort=1.55)
Span = tuple[float, float]


class Memory(NamedTuple):
    """What a follower remembers from one step to the next.

    Attributes:
        state: a `State`.
        active: index of the anchor that is driven to, -1 in Search.
        visited: index of the anchor last visited, -1 for none.
        place: (2,) the last waypoint, metres in the odometer's frame.
        waited: seconds without progress.
        nearest: the least distance to a waypoint of the active anchor, metres.
    """

    state: State = State.SEARCH
    active: int = -1
    visited: int = -1
    place: Array = np.zeros(2)
    waited: float = 0.0
    nearest: float = np.inf


@dataclass(frozen=True)
class Story:
    """What happens to a robot in the corridor; moments are seconds, spans from when to when."""

    start: float = -0.3  # metres along the corridor
    blind: Span = (np.inf, np.inf)  # it recognizes nothing
    hidden: Span = (np.inf, np.inf)  # RE is middling: enough to go on, not enough to come back
    pushed: float = np.inf  # by half a metre; the odometer does not notice
    stuck: Span = (np.inf, np.inf)  # it cannot move
    turned: float = 0.0  # the odometer's frame, rad
    rules: FollowerSettings = _RULES
    seconds: float = 20.0
    anchors: int = 5
    spacing: float = 1.0  # metres from one anchor to the next


STORIES = {
    "undisturbed": Story(),
    "an odometer whose frame is turned": Story(turned=2.2),
    "blind for a second": Story(blind=(3.0, 4.0), turned=0.8),
    "hidden, then blind": Story(hidden=(2.6, 3.4), blind=(3.4, 3.9), turned=-1.0),
    "pushed aside": Story(pushed=3.0, turned=1.1),
    "blind for good": Story(blind=(3.0, 99.0)),
    "nothing in sight at the start": Story(blind=(0.0, 99.0)),
    "behind a chair for a second": Story(stuck=(3.0, 4.2)),
    "behind a chair, with patience": Story(
        stuck=(3.0, 5.0), rules=replace(RULES, timeout=0.35, effort=3.05)
    ),
    "behind a chair for good": Story(stuck=(3.0, 99.0)),
    "behind a chair, blind in between": Story(stuck=(2.5, 99.0), blind=(3.3, 4.1)),
    "begins at the third anchor": Story(start=2.2, turned=0.5),
    "other rules": Story(
        blind=(3.0, 3.6), turned=0.3, rules=replace(OTHER_RULES, timeout=0.35, effort=3.05, at=0.4)
    ),
    "the next anchor out of sight": Story(anchors=3, spacing=2.4, turned=1.7),
    "a single anchor": Story(anchors=1),
    "other rules, a single anchor": Story(start=-1.0, anchors=1, rules=replace(_RULES, at=0.4)),
    "other rules, blind": Story(blind=(3.0, 4.0), turned=0.4, rules=replace(_RULES, p_lose=0.05)),
}


class Corridor:
    """A robot in the corridor, what it observes, and how it moves."""

    def __init__(self, story: Story) -> None:
        self.story, self.step = story, 0
        self.pose = np.array([story.start, 0.2, 0.3])
        self.odometry = np.array([3.0, -2.0, story.turned])
        x = story.spacing * np.arange(story.anchors)
        self.anchors = np.stack([x, 0.3 * np.sin(1.3 * x)], axis=1)

    @property
    def seconds(self) -> float:
        """Since the start."""
        return self.step * STEP

    def _now(self, span: Span) -> bool:
        return span[0] - 1e-9 <= self.seconds < span[1] - 1e-9

    def observe(self, memory: Memory) -> tuple[Array, Array, Array, Array]:
        """RE, overlaps (L,) and waypoints (L, 2) of the anchors around, and the odometer."""
        ahead = to_local(self.pose, self.anchors)
        distance = np.linalg.norm(ahead, axis=1)
        reach = 1.0 / (1.0 + np.exp(4.0 * (distance - 1.9)))
        overlap = 0.95 * np.exp(-(distance**2) / 2.2)
        if self._now(self.story.hidden):
            reach = 0.6 * reach
        if self._now(self.story.blind):
            reach, overlap, ahead = 0.1 * reach, 0.1 * overlap, 0.05 * ahead
        queried = np.abs(np.arange(len(ahead)) - memory.active) <= 1
        queried |= memory.state == State.SEARCH
        waypoints = np.where(queried[:, None], ahead, np.nan)
        return reach * queried, overlap * queried, waypoints, self.odometry.copy()

    def drive(self, target: Array) -> None:
        """Move a step towards a point (2,) in the robot's frame."""
        self.step += 1
        if abs(self.seconds - self.story.pushed) < STEP / 2:
            self.pose = compose(self.pose, [0.0, 0.5, 0.4])
        if self._now(self.story.stuck):
            return
        distance = float(np.hypot(*target))
        turn = float(np.clip(np.arctan2(target[1], target[0]), -_TURN, _TURN)) * (distance > 0.05)
        moved = np.array([min(_SPEED, distance), 0.0, turn])
        self.pose, self.odometry = compose(self.pose, moved), compose(self.odometry, moved)
