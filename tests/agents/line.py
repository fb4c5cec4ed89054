"""A corridor of numbers: robots, a network, a controller and maps on a line."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from tests.made_up_maps import sensed
from tutorial_lib.agents.map_targets import MapTargets
from tutorial_lib.agents.navigator import RULES, MapNavigation
from tutorial_lib.interfaces import Goals, Plan
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.mapping.topomap import TopoMap

FAR = 2.0


class Line:
    """Robots on a line that know by their odometers where they are, and cannot pass a wall."""

    def __init__(self, starts, wall=np.inf, seen=np.inf):
        """The laser sees something at `seen`, which need not be in the way."""
        self.x, self.wall, self.seen = np.array(starts, dtype=float), wall, seen

    def observe(self, robots=None):
        x = self.x if robots is None else self.x[robots]
        laser = np.full((len(x), 5), 50.0)
        laser[:, 2] = np.clip(self.seen - x, 0.0, 50.0)  # straight ahead
        return replace(sensed(np.column_stack([x, 0 * x, 0 * x])), laser=laser)

    def go(self, navigation, steps):
        """Act `steps` times, or until every robot is done."""
        for _ in range(steps):
            robots = np.flatnonzero(~(navigation.arrived | navigation.given_up))
            if not robots.size:
                break
            actions = navigation.act(self.observe(robots), robots)
            assert actions.shape == (len(robots), 2)
            self.x[robots] = np.minimum(self.x[robots] + 0.1 * actions[:, 0], self.wall)


class LinePredictor:
    """Waypoints at the target, and an overlap that fades over 3 m."""

    view = SimpleNamespace(of=lambda observations: observations.odometry[:, 0])
    k = 1

    def prepare(self, contexts):
        return contexts[:, contexts.shape[1] // 2]

    def predict(self, observations, targets):
        gap = targets - observations.odometry[:, 0]
        overlap = np.clip(1 - np.abs(gap) / 3, 0, 1)
        return np.column_stack([gap, 0 * gap]), np.column_stack([overlap, overlap])


class LineReachability:
    """Certain within 2 m, more so the nearer, and not behind a wall."""

    def __init__(self):
        self.wall = np.inf

    def prepare(self, contexts):
        return np.asarray(contexts)[:, np.shape(contexts)[1] // 2]

    def probability(self, observations, prepared):
        here = observations.odometry[:, 0]
        gap = np.abs(prepared - here)
        apart = (here <= self.wall) != (prepared <= self.wall)
        return np.where((gap < FAR) & ~apart, 0.9999 - 0.001 * gap, 0.02)


class LineController:
    """Half a metre a second towards the waypoint."""

    def act(self, observations, waypoints):
        assert len(waypoints) == len(observations)
        return np.column_stack([np.clip(5 * waypoints[:, 0], -0.5, 0.5), 0 * waypoints[:, 1]])


def at_places(*places):
    """Observations at places on the line."""
    x = np.array(places, dtype=float)
    return sensed(np.column_stack([x, 0 * x, 0 * x]))


def goals_at(*places):
    """Goal images of places on the line."""
    return Goals(at_places(*places), np.tile(np.array(places, dtype=float)[:, None], (1, 3)))


def line_map(places, reachability):
    topomap, x = TopoMap(reachability), np.array(places, dtype=float)
    seen, contexts = at_places(*places), np.tile(x[:, None], (1, 3))
    number = np.arange(len(x))
    topomap.make_vertices(seen, contexts, number * 1.0, 0 * number, number)
    topomap.paths = [number.tolist()]
    return topomap


def sure(vertices, goal):
    """A plan whose steps all but surely succeed."""
    return Plan(vertices, goal, (0.99,) * (len(vertices) + 1))


class Plans:
    """Returns given plans, one after the other; the last one again and again."""

    def __init__(self, *plans):
        self.plans, self.queries = list(plans), []

    def __call__(self, observation, goals, excluded):
        assert len(observation) == 1
        self.queries.append((float(observation.odometry[0, 0]), goals, set(excluded)))
        return self.plans[min(len(self.queries), len(self.plans)) - 1]


def navigation_along(find_path, goals, places=range(-4, 9), wall=np.inf, **given):
    """Navigation over a map of those places; `given` as in `navigation_over`."""
    reachability = LineReachability()
    reachability.wall = wall
    return navigation_over(line_map(places, reachability), find_path, goals, **given)


def navigation_over(topomap, find_path, goals, replan_time=60.0, timeout=4.0, kind=MapNavigation):
    """Navigation over a map, with a follower that is lost after `timeout` seconds."""
    reachability = topomap.vertices.reachability
    parts = LinePredictor(), LineController(), reachability
    targets = MapTargets(topomap, parts[0], reachability)
    return kind(
        find_path,
        lambda paths, starts: Follower(
            paths, *parts, starts=starts, settings=replace(RULES, timeout=timeout)
        ),
        targets,
        goals,
        replan_time,
    )
