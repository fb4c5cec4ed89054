"""An oracle in place of the network: the four functions from the true geometry of the world."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS
from tutorial_lib.exploration.labels import (
    MAX_DISTANCE,
    connected,
    direction_ends,
    explorable,
    panorama_ranges,
    relative_polar,
)
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.geometry import Array
from tutorial_lib.observation import Observation
from tutorial_lib.validation import alike, floats, instance, number, whole
from tutorial_lib.world.sensors import PanoramicCamera


class TrueGeometry:
    """An `ExplorationModel` that knows where every picture was taken, and the world around it.

    It is given the task on purpose: an upper bound, and a stand-in for tests. Its features are the
    number of the world, and the pose.
    """

    def __init__(
        self, task: ExplorationTask, directions: int = DIRECTIONS, radius: float = RADIUS
    ) -> None:
        """Read poses and walls from `task`.

        Args:
            task: of which it knows all.
            directions: K of each panorama; 12 in the paper.
            radius: metres of a node; 3 in the paper.
        """
        self._task = instance("task", task, ExplorationTask)
        self._directions = whole("directions", directions, least=1, most=10_000)
        self._radius = number("radius", radius, least=0.1, most=50.0)
        self._names = list(dict.fromkeys(task.episodes.worlds))
        self._number = np.array([self._names.index(name) for name in task.episodes.worlds])
        self._paths = {name: GridPaths(task.scenes[name].clearance) for name in self._names}
        self._goals: Array | None = None
        self._seen: dict[bytes, Array] = {}
        self._fields: dict[tuple[int, float, float], DistanceFields] = {}

    def embed(self, observations: Observation) -> NDArray[np.float32]:
        """Features (N, 4): each picture is recognised among those of robots and goals now.

        Raises:
            InputError: when a picture was taken elsewhere, or earlier.
        """
        task = self._task
        instance("observations", observations, Observation)
        if self._goals is not task.goal_poses:
            self._goals, self._seen = task.goal_poses, self._rows(task.goals(), task.goal_poses)
        known = self._seen | self._rows(task.observe(), task.poses)
        try:
            found = [known[image.tobytes()] for image in observations.image]
        except KeyError:
            raise InputError(
                "observations: true geometry knows pictures of this moment and goals only"
            ) from None
        return np.array(found, np.float32).reshape(len(observations), 4)

    def _rows(self, seen: Observation, poses: Array) -> dict[bytes, Array]:
        """Features by picture."""
        rows = np.column_stack([self._number, poses])
        return {image.tobytes(): row for image, row in zip(seen.image, rows, strict=True)}

    def explorable(self, features: NDArray[np.floating]) -> Array:
        """The labels of F_G (N, K)."""
        features = self._checked("features", features)
        likely = explorable(self._ranges(features), self._directions, self._radius)
        return likely.astype(float)

    def same_node(self, sources: NDArray[np.floating], goals: NDArray[np.floating]) -> Array:
        """The labels of F_L (P,)."""
        sources, goals = self._pairs(sources, goals)
        bearing, metres = self.relative(sources, goals).T
        ranges = self._ranges(sources)
        return connected(ranges, bearing, metres, self._radius).astype(float)

    def relative(self, sources: NDArray[np.floating], goals: NDArray[np.floating]) -> Array:
        """True bearings and metres (P, 2)."""
        sources, goals = self._pairs(sources, goals)
        return relative_polar(sources[:, 1:].astype(float), goals[:, 1:3].astype(float))

    def scores(self, sources: NDArray[np.floating], goals: NDArray[np.floating]) -> Array:
        """The labels of F_S (P, K)."""
        sources, goals = self._pairs(sources, goals)
        found = np.zeros((len(sources), self._directions))
        for row, (source, goal) in enumerate(zip(sources, goals, strict=True)):
            scene = self._task.scenes[self._names[int(source[0])]]
            pose = source[None, 1:].astype(float)
            ends, _ = direction_ends(scene, pose, self._directions, self._radius)
            found[row] = 1 - self._field(goal).distance(ends[0]) / MAX_DISTANCE
        return np.maximum(found, 0.0)

    def ranges(self, observations: Observation) -> Array:
        """What depth cameras measure (N, W), or would measure."""
        if instance("observations", observations, Observation).depth is not None:
            return np.asarray(observations.depth, dtype=float)
        return self._ranges(self.embed(observations))

    def _checked(self, name: str, features: NDArray[np.floating]) -> Array:
        """Features (N, 4), each with the number of a world."""
        features = floats(name, features, ("N", 4))
        if not np.isin(features[:, 0], np.arange(len(self._names))).all():
            raise InputError(f"{name}: of no world of this task; give rows that `embed` returned")
        return features

    def _pairs(
        self, sources: NDArray[np.floating], goals: NDArray[np.floating]
    ) -> tuple[Array, Array]:
        sources, goals = self._checked("sources", sources), self._checked("goals", goals)
        alike(sources=sources, goals=goals)
        return sources, goals

    def _ranges(self, features: NDArray[np.floating]) -> Array:
        """(N, W) metres around the places of features."""
        poses, number = features[:, 1:].astype(float), features[:, 0].astype(int)
        found = np.empty((len(features), PanoramicCamera.columns))
        for world in np.unique(number):
            rows = np.flatnonzero(number == world)
            found[rows] = panorama_ranges(self._task.scenes[self._names[world]], poses[rows])
        return found

    def _field(self, goal: NDArray[np.floating]) -> DistanceFields:
        """How far everything is from a goal; kept, since every node asks for it."""
        key = (int(goal[0]), float(goal[1]), float(goal[2]))
        if key not in self._fields:
            paths = self._paths[self._names[key[0]]]
            self._fields[key] = paths.fields(np.array([key[1:]]), shortest=True)
        return self._fields[key]
