"""Trials of whole agents: they set out, and declare when they have arrived (Meng 2020, IV-C)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.agents.agent import Agent, Experience, Navigation
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials
from tutorial_lib.geometry import Array, wrap
from tutorial_lib.learning.views import VIEWS, View
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import Goals
from tutorial_lib.world.people import Person
from tutorial_lib.world.simulation import STEP, Simulation

NEAR, FACING = 0.5, float(np.deg2rad(60.0))
"""Metres from the goal and rad from its heading within which a robot may declare to be there."""
STUCK = 2.0
"""Seconds of touching something after which a trial ends."""
TIMES, GRACE = 2.0, 30.0
"""A trial may take so many times as long as the oracle, and so many seconds more."""
WORMHOLE = 5.0
"""Metres of geodesic from which on an edge is a wormhole."""
K = 5
"""Pictures of context on either side of a goal's."""
_BETWEEN = 60.0  # seconds from one recorded drive to the next
ENDINGS = ("arrived", "gave_up", "stuck", "late")

SetOut = Callable[[Simulation], Navigation]
"""Sends the robots of a simulation on their ways; only an oracle looks at it."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """How N trials ended.

    Attributes:
        success: (N,) arrival was declared, rightly.
        ending: (N,) one of `ENDINGS`, as the agent has it.
        seconds: (N,) until then.
        gap: (N,) metres to the goal then.
        poses: (T, N, 3) where the robots were.
    """

    success: NDArray[np.bool_]
    ending: NDArray[np.str_]
    seconds: Array
    gap: Array
    poses: Array

    @property
    def there(self) -> NDArray[np.bool_]:
        """(N,) who declared to have arrived at the goal's place, whichever way they faced."""
        return (self.ending == "arrived") & (self.gap <= NEAR)

    @property
    def wrong(self) -> NDArray[np.bool_]:
        """(N,) who declared to have arrived, but elsewhere."""
        return (self.ending == "arrived") & ~self.success


@dataclass(frozen=True)
class Result:
    """What one method made of one world.

    Attributes:
        outcome: of every trial.
        vertices: of its map; None where it has none.
        edges: of its map.
        wormholes: edges longer than `WORMHOLE`.
    """

    outcome: Outcome
    vertices: int | None = None
    edges: int | None = None
    wormholes: int | None = None


def navigate(
    house: Building, asked: Trials, start: SetOut, people: Sequence[Person] = ()
) -> Outcome:
    """Drive all trials at once."""
    simulation = Simulation(house.scene, asked.starts, people=people)
    journey, count = start(simulation), len(asked)
    limit, goals = TIMES * asked.seconds + GRACE, asked.goal_poses
    over, touched, seconds = np.zeros(count, bool), np.zeros(count), np.zeros(count)
    ending = np.full(count, "late", dtype="U8")
    last, track = asked.starts.copy(), [simulation.poses]
    while not over.all():
        robots, actions = np.flatnonzero(~over), np.zeros((count, 2))
        actions[robots] = _checked(journey.act(simulation.observe(robots), robots), len(robots))
        simulation.step(actions)
        track.append(simulation.poses)
        seconds[robots] += STEP
        touched = np.where(simulation.touching, touched + STEP, 0.0)
        last[robots] = simulation.poses[robots]
        ends = {
            "stuck": touched >= STUCK - STEP / 2,
            "gave_up": np.asarray(journey.given_up),
            "arrived": np.asarray(journey.arrived),
        }
        for name, who in ends.items():
            ending[robots[who[robots]]] = name
        over |= ends["stuck"] | ends["gave_up"] | ends["arrived"] | (seconds >= limit)
    gap = np.linalg.norm(last[:, :2] - goals[:, :2], axis=1)
    faces = np.abs(wrap(last[:, 2] - goals[:, 2])) <= FACING
    success = (ending == "arrived") & (gap <= NEAR) & faces
    return Outcome(success, ending, seconds, gap, np.stack(track))


def _checked(actions: ArrayLike, robots: int) -> Array:
    """Actions (M, 2), one for each robot that is under way."""
    actions = np.asarray(actions, dtype=float)
    if actions.shape != (robots, 2) or not np.isfinite(actions).all():
        raise InputError(f"actions: {actions.shape}; give finite (M, 2) for {robots} robots")
    return actions


def experiences(house: Building, numbers: Sequence[int] | None = None) -> Iterator[Experience]:
    """What was sensed on the recorded drives of a building, one after the other.

    Args:
        house: the building.
        numbers: of the drives, all unless given.
    """
    begins = drive_times(house)
    numbers = range(len(house.recorded.trajectories)) if numbers is None else numbers
    for number in numbers:
        seen = house.recorded.observe(house.recorded.frames_of(number))
        yield Experience(seen, begins[number] + house.recorded.trajectories[number].timestamps)


def drive_times(house: Building) -> Array:
    """Seconds (D,) at which each drive of a building begins, one after the other."""
    long = [drive.timestamps[-1] + _BETWEEN for drive in house.recorded.trajectories]
    return np.cumsum([0.0, *long[:-1]])


def goals_of(asked: Trials, view: View, k: int) -> list[Goals]:
    """What the robots are shown: the goal's picture in its context, one for each trial."""
    recorded = asked.recorded
    seen = recorded.observe(asked.goals, view.camera)
    contexts = view.render(recorded.scene, recorded.poses[recorded.context(asked.goals, k)])
    return [Goals(seen[[i]], contexts[[i]]) for i in range(len(asked))]


def vertex_poses(house: Building, topomap: TopoMap) -> Array:
    """Poses (V, 3) at which the vertices of a map were seen; the agent never knows them."""
    begins = drive_times(house)
    times = topomap.vertices.timestamps
    drives = np.searchsorted(begins, times, side="right") - 1
    first = house.recorded.first_frames[drives]
    return house.recorded.poses[first + np.rint((times - begins[drives]) / STEP).astype(int)]


def edge_lengths(house: Building, topomap: TopoMap) -> Array:
    """Geodesic metres (E,) of every edge of a map, in the order of `topomap.graph.edges`."""
    poses = vertex_poses(house, topomap)
    edges = np.array(list(topomap.graph.edges), dtype=np.intp).reshape(-1, 2)
    return house.paths.between(poses[edges[:, 0], :2], poses[edges[:, 1], :2])


def attempt(house: Building, asked: Trials, agent: Agent) -> Result:
    """One agent learns a building and is sent on its trials."""
    agent.learn(list(experiences(house)))
    return measured(house, asked, agent)


def measured(house: Building, asked: Trials, agent: Agent) -> Result:
    """What an agent that knows the building makes of the trials."""
    goals = goals_of(asked, VIEWS["camera16"], K)
    outcome = navigate(house, asked, lambda _: agent.start(goals))
    topomap = getattr(agent, "topomap", None)
    if topomap is None:
        return Result(outcome)
    long = edge_lengths(house, topomap) > WORMHOLE
    return Result(outcome, len(topomap), len(long), int(long.sum()))
