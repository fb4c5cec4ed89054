"""Navigation over a sampled map: localize, plan, drive one edge, learn from it, and again (LTVN).

Ours: an arrival is trusted, so that the robot need not localize anew; success is strict, it must
have driven to the waypoint and see the target there; an edge that failed is avoided for a while;
and all robots of a fleet mend the same map.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.ltvn_state import GOAL, Leg, RobotState, TravelSettings
from tutorial_lib.driving.control.three_point import Stillness, ThreePointTurn
from tutorial_lib.interfaces import Controller, Goals, Observation, Robots
from tutorial_lib.se2 import Array, compose, inverse, relative, to_local, wrap
from tutorial_lib.topology.maintenance import Edge, Maintenance, Traversal
from tutorial_lib.topology.mapping.change_detection import Changes, changes, first_on_path
from tutorial_lib.topology.mapping.expansion import expanded, shortest_paths
from tutorial_lib.topology.mapping.image_pool import length
from tutorial_lib.topology.mapping.obstructed import obstructed
from tutorial_lib.topology.mapping.sampling_map import SampledMap
from tutorial_lib.validation import floats, instances
from tutorial_lib.world.simulation import STEP

_ALL = 4 * np.pi  # rad that a robot turns while it searches
_FACING = 0.3  # rad from the wanted heading within which a turn is over
_TURNING = 20.0  # seconds after which a turn has failed
_RECOVERING = 50  # steps that a robot turns before it tries again what has just failed
_LOOKS = 10  # edges at most that a robot looks along before it sets off
_LOOK_STEPS = 10  # steps from one look around to the next while it turns
_AHEAD = 5  # edges of a path that are compared with what the laser sees


class LTVNNavigation:
    """A `Navigation` of N robots over one map.

    Attributes:
        arrived: (N,) declares to have arrived.
        given_up: (N,) cannot find out where it is, or finds no path.
        states: of each robot.
        traversals: all attempts so far.
    """

    def __init__(
        self,
        sampled: SampledMap,
        upkeep: Maintenance,
        controllers: tuple[Controller, Controller],
        goals: Sequence[Goals],
        settings: TravelSettings,
        *,
        mends: bool = True,
    ) -> None:
        """Robots localize when they act for the first time.

        Args:
            sampled: the map.
            upkeep: of its graph.
            controllers: the one that drives forwards, and the one for edges in reverse.
            goals: one for each robot.
            settings: thresholds.
            mends: whether traversals change the map.
        """
        goals = instances("goals", goals, Goals, empty=False)
        self._map, self._upkeep, self._mends = sampled, upkeep, mends
        self._controllers, self._settings = controllers, settings
        self.arrived, self.given_up = np.zeros((2, len(goals)), dtype=bool)
        self.states = [self._state_for(goal) for goal in goals]
        self.traversals: list[Traversal] = []
        self._now = np.zeros(len(goals))
        self._rotation, self._stillness = ThreePointTurn(len(goals)), Stillness(len(goals))

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2): drive, or turn to look around."""
        robots = np.asarray(robots)
        self._now[robots] += STEP
        actions, over = np.zeros((len(robots), 2)), self.arrived | self.given_up
        for row, robot in enumerate(robots):
            if not over[robot]:
                self._step(observations[row], int(robot))
        over = self.arrived | self.given_up
        legs = [self.states[robot].leg for robot in robots]
        driving = np.array([leg is not None and not leg.turn for leg in legs], bool)
        driving &= ~over[robots]
        for controller, reverse in zip(self._controllers, (False, True), strict=True):
            rows = [i for i in np.flatnonzero(driving) if legs[i].reverse == reverse]
            if rows:
                seen = observations[np.array(rows)]
                aims = np.array([legs[i].aim[:2] for i in rows])
                waypoints = to_local(seen.odometry, aims)
                chosen = controller.act(seen, waypoints)
                actions[rows] = floats("actions", chosen, (len(rows), 2))
        turning = ~driving & ~over[robots]
        if turning.any():
            actions[turning] = self._turn(observations[turning], robots[turning])
        return actions

    def _turn(self, observations: Observation, robots: NDArray[np.intp]) -> Array:
        """Actions (M, 2) of robots (M,) that turn; where it is too tight, to the other side."""
        stuck = self._stillness.stuck(robots, observations.odometry)
        self._rotation.turn_back(robots[stuck], observations.odometry[stuck])
        return self._rotation.act(observations, robots)

    def _state_for(self, goal: Goals) -> RobotState:
        """How one image of the goal becomes a vertex: edges lead to it from where it is seen."""
        pool, model = self._map.pool, self._map.pool.model
        image = model.view.of(goal.observations)[:1]
        target = model.prepare(image[:, None])
        vertices = self._map.vertices
        reachable, waypoints = pool.lead_to(vertices, target)
        metres, limit = length(waypoints), self._map.rules.connect
        seen = (reachable > self._settings.sure) & (metres < limit)
        if not seen.any() and len(vertices):  # the most promising of all will have to do
            seen[reachable.argmax()] = True
        return RobotState(target, dict(zip(vertices[seen].tolist(), waypoints[seen], strict=True)))

    def _step(self, observation: Observation, robot: int) -> None:
        """Conclude a leg that is over, and begin the next."""
        state = self.states[robot]
        leg, now = state.leg, float(self._now[robot])
        if leg is not None:
            off = leg.aim - observation.odometry[0]
            gap = float(np.hypot(*off[:2]))
            if leg.turn:
                gap = 0.0 if abs(wrap(off[2])) < _FACING else np.inf
            leg.closest = min(leg.closest, gap)
            if gap > self._settings.executed and now < leg.until:
                return
            self._conclude(observation, robot, leg)
        elif state.searched % _LOOK_STEPS:
            state.searched += 1
            return
        if not self._is_there(observation, robot):
            self._go_on(observation, robot)

    def _conclude(self, observation: Observation, robot: int, leg: Leg) -> None:
        """Judge a traversal, and let the map learn from it."""
        state, settings = self.states[robot], self._settings
        state.leg, state.trusted = None, None
        executed = leg.closest <= settings.executed
        edge = (leg.source, leg.target)
        later = float(self._now[robot]) + settings.patience
        if leg.target == GOAL:
            model = self._map.pool.model
            if not executed or model.predict(observation, state.goal)[0][0] <= settings.near:
                state.avoided[edge] = later
            return
        reachable, waypoint = self._seen(observation, np.array([leg.target]))
        seen = bool(reachable[0] > settings.near)
        if settings.strict:
            success = executed and seen and np.hypot(*waypoint[0, :2]) < settings.arrival
        else:
            success = seen and float(length(waypoint[0])) < self._map.rules.connect
        done = Traversal(edge, leg.kind, bool(success), leg.measured, leg.arrived_by)
        self.traversals.append(done)
        if self._mends:
            self._upkeep.experienced(done)
        if not success:
            state.avoided[edge] = later
        if settings.trust and executed and (success or leg.kind == "trusted"):
            # Where it does not see the target it presumes for one edge to be there.
            place = relative(observation.odometry[0], leg.aim)
            kind = "trusted" if success else "presumed"
            state.trusted = leg.target, kind, edge, waypoint[0] if seen else place

    def _is_there(self, observation: Observation, robot: int) -> bool:
        """Declare to have arrived, or drive to the goal that is seen; whether one of the two."""
        state, settings = self.states[robot], self._settings
        model = self._map.pool.model
        reachable, waypoint = model.predict(observation, state.goal)
        metres = float(length(waypoint[0]))
        if reachable[0] <= settings.sure or metres > self._map.rules.connect:
            return False
        if np.hypot(*waypoint[0, :2]) < settings.goal:
            self.arrived[robot] = True
            return True
        if state.avoided.get((GOAL, GOAL), 0.0) > self._now[robot]:
            return False
        # A goal that cannot be reached from here is tried once in a while.
        state.avoided[GOAL, GOAL] = float(self._now[robot]) + 2 * settings.spare
        self._set_off(observation, robot, GOAL, GOAL, "local", None, waypoint[0])
        return True

    def _go_on(self, observation: Observation, robot: int) -> None:
        """Localize, plan and set off; or look around."""
        state = self.states[robot]
        found = self._localized(observation, state)
        if found is None:
            self._look_around(observation, robot)
            return
        here, kind, arrived_by, offset = found
        now, doubted = float(self._now[robot]), 0
        new = self._changes(observation, here, offset) if kind != "presumed" else None
        while True:
            path = self._free_path(robot, here, kind, new)
            if path is None:
                self._look_around(observation, robot)
                return
            target = path[1] if len(path) > 1 else GOAL
            edge = (here, target)
            if target == GOAL:
                seen, waypoint = None, compose(offset, state.exits[here])
                break
            known = self._map.graph.edges[edge]
            seen, waypoint = None, compose(offset, np.array(known["waypoint"]))
            if "turn" in known:
                break
            reachable, poses = self._seen(observation, np.array([target]))
            if reachable[0] > self._settings.near:
                seen = waypoint = poses[0]
                break
            unseen = reachable[0] < self._settings.doubt and kind != "presumed"
            hidden = new is not None and new.any  # what is new may hide the target
            if not unseen or hidden or state.avoided.get(edge, 0.0) > now:
                break
            self._doubt(robot, Traversal(edge, kind, False, None, arrived_by, looked=True))
            doubted += 1
            if doubted == _LOOKS:
                break
        if state.avoided.get(edge, 0.0) > now and state.searched < _RECOVERING:
            self._look_around(observation, robot)  # from elsewhere what failed may succeed
            return
        state.path = path
        self._set_off(observation, robot, here, target, kind, arrived_by, waypoint, seen)

    def _changes(self, observation: Observation, here: int, offset: Array) -> Changes | None:
        """What a robot sees that was not there when the image of its vertex was taken (ours)."""
        image = self._map.pool.observations[np.array([here])]
        return changes(observation.laser[0], image.laser[0], offset) if self._mends else None

    def _free_path(self, robot: int, here: int, kind: str, new: Changes | None) -> list[int] | None:
        """A path on which nothing new stands; the links through what does are closed (ours).

        Where there is none after some tries, it is the shortest of those that are left.
        """
        state, now = self.states[robot], float(self._now[robot])
        for _ in range(_LOOKS):
            path = self._path(state, here, now)
            blocked = () if path is None or new is None else self._blocked(path, new)
            if not blocked:
                return path
            self._doubt(robot, Traversal(blocked[0], kind, False, blocked=blocked, looked=True))
        return self._path(state, here, now)

    def _blocked(self, path: list[int], new: Changes) -> tuple[Edge, ...]:
        """The links through what stands on a path, the path's own edge first."""
        edges, poses = list(pairwise(path[: _AHEAD + 1])), [new.image]
        for edge in edges:
            poses.append(compose(poses[-1], np.array(self._map.graph.edges[edge]["waypoint"])))
        found = first_on_path(new, np.stack(poses))
        if found is None:
            return ()
        part, obstacles = found
        loosened = self._map.rules.connect * self._upkeep.rules.loosened
        return obstructed(self._map, edges[part], poses[part], obstacles, loosened)

    def _doubt(self, robot: int, looked: Traversal) -> None:
        """Avoid an edge along which a robot has only looked; the map learns from it."""
        later = float(self._now[robot]) + self._settings.patience
        self.states[robot].avoided[looked.edge] = later
        self.traversals.append(looked)
        if self._mends:
            self._upkeep.experienced(looked)

    def _set_off(
        self,
        observation: Observation,
        robot: int,
        source: int,
        target: int,
        kind: str,
        arrived_by: Edge | None,
        waypoint: Array,
        seen: Array | None = None,
    ) -> None:
        """Drive to a waypoint (3,) in the robot's frame."""
        settings = self._settings
        aim = compose(observation.odometry[0], waypoint)
        measured = None if seen is None else float(length(seen))
        edge = self._map.graph.get_edge_data(source, target, {})
        reverse, turn = bool(edge.get("reverse", False)), "turn" in edge
        slow = settings.slow * (2.0 if reverse else 1.0)  # a car is slower in reverse
        until = self._now[robot] + settings.spare + slow * np.hypot(*waypoint[:2])
        if turn:
            until = self._now[robot] + _TURNING
            self._begin_turn(observation, robot, float(wrap(waypoint[2])))
        state = self.states[robot]
        state.searched = 0
        state.leg = Leg(
            source, target, kind, arrived_by, measured, aim, float(until), reverse, turn
        )

    def _begin_turn(self, observation: Observation, robot: int, angle: float) -> None:
        """Turn by an angle in rad, from here on."""
        robots = np.array([robot])
        self._stillness.begin(robots)
        self._rotation.begin(robots, observation.odometry, np.array([angle]))

    def _localized(
        self, observation: Observation, state: RobotState
    ) -> tuple[int, str, Edge | None, Array] | None:
        """Where the robot is: vertex, how it is known, the edge that led there, and its pose.

        Locally at first, among the vertices next to the last path, then among all (LTVN).
        """
        graph, settings = self._map.graph, self._settings
        presumed = state.trusted if state.trusted and state.trusted[0] in graph else None
        if presumed is not None and presumed[1] == "trusted":
            return presumed
        around = {v for v in state.path if v in graph}
        around |= {n for v in around for n in (*graph.successors(v), *graph.predecessors(v))}
        for kind, candidates, limit in (
            ("local", np.array(sorted(around), dtype=np.intp), settings.near),
            ("global", self._map.vertices, settings.sure),
        ):
            reachable, waypoints = self._seen(observation, candidates)
            metres = np.where(reachable > limit, length(waypoints), np.inf)
            if metres.size and metres.min() < settings.localize:
                best = int(metres.argmin())
                return int(candidates[best]), kind, None, waypoints[best]
        return presumed

    def _seen(self, observation: Observation, vertices: NDArray[np.intp]) -> tuple[Array, Array]:
        """r-hat (V,) and poses (V, 3) of vertices: seen from the robot, or the robot from them.

        A robot that reversed to a vertex stands before it, and sees that only from there.
        """
        pool, model = self._map.pool, self._map.pool.model
        ahead, there = pool.seen_from(observation, vertices)
        image = model.view.of(observation)
        back, here = pool.lead_to(vertices, model.prepare(image[:, None]))
        better = back > ahead
        return np.maximum(ahead, back), np.where(better[:, None], inverse(here), there)

    def _path(self, state: RobotState, here: int, now: float) -> list[int] | None:
        """The shortest path to an image from which the goal is seen, the map expanded if needed."""
        avoided = {edge for edge, until in state.avoided.items() if until > now}
        path = self._shortest(state, here, avoided)
        if path is None and self._mends:
            exits = {vertex for vertex in state.exits if (vertex, GOAL) not in avoided}
            if expanded(self._map, self._upkeep, here, exits, avoided):
                path = self._shortest(state, here, avoided)
        # What failed is tried again rather than nothing.
        return self._shortest(state, here, set()) if path is None else path

    def _shortest(self, state: RobotState, here: int, avoided: set[Edge]) -> list[int] | None:
        """Dijkstra's path over the edges' costs to one of the exits, and from there to the goal."""
        graph = self._map.graph

        def cost(source: int, target: int, edge: dict[str, Any]) -> float | None:
            return None if (source, target) in avoided else edge["cost"]

        if here not in graph:
            return None
        metres, paths = shortest_paths(graph, here, cost)
        whole = {
            vertex: metres[vertex] + float(length(waypoint))
            for vertex, waypoint in state.exits.items()
            if vertex in metres and (vertex, GOAL) not in avoided
        }
        return paths[min(whole, key=whole.__getitem__)] if whole else None

    def _look_around(self, observation: Observation, robot: int) -> None:
        """Turn in place, up to `search` seconds; a robot that turns trusts no arrival."""
        state = self.states[robot]
        state.trusted = None
        if state.searched == 0:
            self._begin_turn(observation, robot, _ALL)
        state.searched += 1
        self.given_up[robot] = state.searched * STEP > self._settings.search
