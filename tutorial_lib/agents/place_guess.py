"""Where the robots of a fleet may be: by a single view, a sequence of views, or a belief."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.remedies import Tools
from tutorial_lib.interfaces import Observation, Robots, Targets
from tutorial_lib.se2 import Array, relative
from tutorial_lib.topology.localization import OFF_MAP, BayesFilter, argmax, match_sequence
from tutorial_lib.topology.mapping.edge_search import along_trajectories
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.motion_model import length_of, motion_model, neighbourhoods
from tutorial_lib.topology.view_sensor import ViewSensor

_VIEWS, _APART = 4, 0.7  # views of a sequence, and metres from one to the next
_NEAR = 2  # edges around a vertex within which a robot may be said to be there
_LEAST = 0.3  # weight of a start that is hardly believed: better a path from there than none


@dataclass(frozen=True, eq=False)
class Weighted:
    """A `Localizer` of one robot: RE to each vertex, times how likely it is to be near it.

    Attributes:
        likely: (V,) from 0 to 1, relative to the most likely vertex.
        p_query: RE above which a vertex can be driven to at all.
        candidates: vertices that RE is queried about, those most alike.
    """

    likely: Array
    p_query: float
    candidates: int

    def localize(self, observations: Observation, topomap: TopoMap) -> Array:
        """(1, V) probabilities with which each vertex can be driven to."""
        near = np.union1d(
            topomap.nearby(observations, self.candidates)[0], topomap.alive[self.likely.argmax()]
        )
        columns = np.searchsorted(topomap.alive, near)
        columns = columns[self.likely[columns] > 0]
        rows = np.zeros(len(columns), dtype=int)
        reach = topomap.vertices.into(observations, rows, topomap.alive[columns])
        found = np.zeros((1, len(topomap)))
        found[0, columns] = np.where(reach > self.p_query, reach, 0.0) * self.likely[columns]
        return found


class PlaceGuess:
    """Where N robots may be on a map, as far as the remedies that are on allow.

    Attributes:
        filter: the beliefs, if the filter is on.
    """

    def __init__(self, robots: int, topomap: TopoMap, tools: Tools, targets: Targets) -> None:
        """Robots that may be anywhere; `targets` are all vertices as C_WP prepared them."""
        self._map, self._on = topomap, tools.remedies
        self._sensor = ViewSensor(topomap, tools.predictor, targets)
        self._column = np.full(len(topomap.vertices), -1)
        self._column[topomap.alive] = np.arange(len(topomap))
        self._near = neighbourhoods(topomap, _NEAR)
        self._before = self._columns_before()
        self.filter = BayesFilter(
            robots, motion_model(topomap), self._sensor, tools.filter_settings
        )
        self._views: list[list[Array]] = [[] for _ in range(robots)]
        self._pose = np.full((robots, 3), np.nan)  # odometry at the last of these

    def observe(self, observations: Observation, robots: Robots) -> NDArray[np.bool_]:
        """Look around; for which robots (M,) the belief is new."""
        looked = np.zeros(len(robots), dtype=bool)
        if self._on.filter:
            looked = self.filter.observe(observations, robots)
        elif self._on.sequence:
            motion = length_of(relative(self._pose[robots], observations.odometry))
            due = np.flatnonzero(~(motion < _APART))
            if due.size:
                self._remember(observations[due], robots[due])
        return looked

    def weights(self, observation: Observation, robot: int) -> Array:
        """(V,) how likely one robot is to be near each vertex, relative to the likeliest."""
        if not len(self._map):
            return np.empty(0)
        if self._on.filter:
            if self.off_map(robot) > 0.5:  # wherever RE finds it plausible
                return np.ones(len(self._map))
            mass = self.filter.belief[robot, :OFF_MAP] @ self._near
            return np.maximum(mass / mass.max(), _LEAST)
        seen = self._sensor(observation)
        if self._on.sequence:
            views = np.maximum([*self._views[robot], seen[0]], 1e-3)
            seen = match_sequence(views, self._before)[None]
        return argmax(seen)[0, :OFF_MAP]

    def off_map(self, robot: int) -> float:
        """Belief that a robot is off the map."""
        return float(self.filter.belief[robot, OFF_MAP])

    def confidence(self) -> Array:
        """(N,) belief of being near the vertex at which each robot is localized."""
        belief, vertex = self.filter.belief, self.filter.vertex
        near = self._near[vertex]
        mass = (belief[:, :OFF_MAP] * near).sum(axis=1)
        return np.where(vertex == OFF_MAP, belief[:, OFF_MAP], mass)

    def far_from(self, robot: int, vertices: Sequence[int]) -> float:
        """How much less a robot is believed to be near some vertices than anywhere else.

        0 where no place, nor being off the map, is believed more; 1 where they are not believed at
        all. Of many twins each has a small share of the belief, but no smaller than the others.
        """
        belief = self.filter.belief[robot]
        near = self._near[self._column[list(vertices)]].any(axis=0)
        most = max(float((belief[:OFF_MAP] @ self._near).max()), float(belief[OFF_MAP]))
        return max(0.0, 1.0 - float(belief[:OFF_MAP][near].sum()) / most)

    def _remember(self, observations: Observation, robots: Robots) -> None:
        """Keep the views of robots that have moved on."""
        for robot, seen in zip(robots.tolist(), self._sensor(observations), strict=True):
            self._views[robot] = [*self._views[robot][1 - _VIEWS :], seen]
        self._pose[robots] = observations.odometry

    def _columns_before(self) -> NDArray[np.intp]:
        """(V,) the column of the vertex before each on its trajectory, -1 for none."""
        topomap = self._map
        around = along_trajectories(topomap.paths, topomap.trajectory, topomap.place, 1)
        before = around[topomap.alive, 0]
        return np.where(before >= 0, self._column[before], -1)
