"""Navigation trials: agents start, and declare when they have arrived (Meng 2020, IV-C)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.driving.data.recorded_world import MOST_CONTEXT
from tutorial_lib.driving.rollouts import NavigationEnds, Record, Rollouts, rollout
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials
from tutorial_lib.experiments.protocols.odometry import NAVIGATING
from tutorial_lib.interfaces import Agent, Experience, Goals, Navigation, Observation
from tutorial_lib.learning.views import VIEWS, View, view_of
from tutorial_lib.se2 import Array, wrap
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import instance, integers, one_of, whole, with_methods
from tutorial_lib.world.people import Person
from tutorial_lib.world.simulation import Sensors, Simulation

NEAR, FACING = 0.5, float(np.deg2rad(60.0))
"""Metres from the goal and rad from its heading within which a declared arrival is right."""
TIMES, GRACE = 2.0, 30.0
"""A trial may take so many times the oracle's time, and so many seconds more."""
WORMHOLE = 5.0
"""Metres of geodesic beyond which an edge is a wormhole."""
K = 5
"""Images of context on either side of the goal image."""
GOAL_IMAGES = ONE, CLIP = ("one", "clip")
"""What shows a goal: one image, which stands for its whole context, or the end of a drive to it."""
ENDINGS = ("arrived", "gave_up", "stuck", "late")

Start = Callable[[Simulation], Navigation]
"""Starts the robots of a simulation towards their goals; only an oracle looks at it."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """How N trials ended.

    Attributes:
        success: (N,) arrival was declared, rightly.
        ending: (N,) one of `ENDINGS`, as the agent has it.
        seconds: (N,) until then.
        gap: (N,) metres to the goal then.
        poses: (T, N, 3) of the robots.
    """

    success: NDArray[np.bool_]
    ending: NDArray[np.str_]
    seconds: Array
    gap: Array
    poses: Array

    @property
    def there(self) -> NDArray[np.bool_]:
        """(N,) arrival was declared at the goal's position, whatever the heading."""
        return (self.ending == "arrived") & (self.gap <= NEAR)

    @property
    def wrong(self) -> NDArray[np.bool_]:
        """(N,) arrival was declared, but elsewhere."""
        return (self.ending == "arrived") & ~self.success


@dataclass(frozen=True)
class Result:
    """How one method did in one world.

    Attributes:
        outcome: of every trial.
        size: vertices, edges and wormholes of its map; None where it has none.
    """

    outcome: Outcome
    size: tuple[int, int, int] | None = None


def total_size(results: Sequence[Result]) -> tuple[int, int, int]:
    """Vertices, edges and wormholes of all maps together."""
    sizes = [result.size for result in results if result.size]
    vertices, edges, wormholes = (sum(size[part] for size in sizes) for part in range(3))
    return vertices, edges, wormholes


def navigate(
    building: Building,
    trials: Trials,
    start: Start,
    people: Sequence[Person] = (),
    record: Record | None = None,
    sensors: Sensors | None = None,
) -> Outcome:
    """Run all trials at once, each for at most `TIMES` the oracle's time and `GRACE` seconds.

    The robots have the building's body, camera and odometry, with the same drift each time, and the
    usual laser, unless other sensors are given.
    """
    odometry = instance("building", building, Building).odometry.noise(NAVIGATING)
    instance("trials", trials, Trials)
    if not callable(start):
        raise InputError(f"start: {start!r}; give a function of the simulation")
    simulation = Simulation(
        building.scene,
        trials.starts,
        body=building.body,
        people=people,
        sensors=Sensors(building.camera) if sensors is None else sensors,
        odometry_noise=odometry,
    )
    navigation, goals = start(simulation), trials.goal_poses
    ends = NavigationEnds(navigation, TIMES * trials.seconds + GRACE)
    found = rollout(simulation, navigation, ends, record)
    gap = np.linalg.norm(found.last_poses[:, :2] - goals[:, :2], axis=1)
    success = arrived_at(goals, found)
    return Outcome(success, found.ending, found.seconds, gap, found.poses)


def arrived_at(goals: Array, found: Rollouts) -> NDArray[np.bool_]:
    """(N,) whether arrival was declared at the goals (N, 3), facing as they do."""
    last = found.last_poses
    gap = np.linalg.norm(last[:, :2] - goals[:, :2], axis=1)
    faces = np.abs(wrap(last[:, 2] - goals[:, 2])) <= FACING
    return (found.ending == "arrived") & (gap <= NEAR) & faces


def experiences(building: Building, indices: Sequence[int] | None = None) -> Iterator[Experience]:
    """What was observed on a building's recorded trajectories, one after the other.

    Args:
        building: the building.
        indices: of the trajectories; all unless given.

    Raises:
        InputError: when there is no such trajectory.
    """
    recorded, camera = instance("building", building, Building).recorded, building.camera
    known = range(len(recorded.trajectories))
    if indices is not None:
        indices = integers("indices", indices, ("N",), least=0, most=len(known) - 1).tolist()
    return (recorded.experience(i, camera) for i in (known if indices is None else indices))


def goals_of(trials: Trials, view: View, k: int, images: str = ONE) -> list[Goals]:
    """The goal of each trial, as a robot is shown it.

    Args:
        trials: to be run.
        view: of the networks.
        k: images of their context on either side.
        images: one of `GOAL_IMAGES`.

    Raises:
        InputError: for other `images`.
    """
    recorded = instance("trials", trials, Trials).recorded
    with_methods("view", view, "render")
    k = whole("k", k, least=0, most=MOST_CONTEXT)
    one_of("images", images, GOAL_IMAGES)
    around = trials.goals[:, None] if images == ONE else recorded.context(trials.goals, k)
    seen = recorded.observe(trials.goals, view.camera)
    contexts = view.render(recorded.scene, recorded.poses[around])
    if images == ONE:
        contexts = np.repeat(contexts, 2 * k + 1, axis=1)
    return [Goals(seen[[i]], contexts[[i]]) for i in range(len(trials))]


def refusals(
    agent: MengAgent, observations: Observation, trials: Trials, images: str = ONE
) -> dict[str, Array]:
    """Whether each goal is refused, and the probability of the best path to it."""
    goals = goals_of(trials, VIEWS["camera16"], K, images)
    pairs = range(min(len(goals), len(observations)))
    plans = [agent.planner.plan(observations[[i]], goals[i], agent.topomap) for i in pairs]
    return {
        "refused": np.array([bool(plan.refusal) for plan in plans]),
        "probability": np.array([plan.probability for plan in plans]),
    }


def vertex_poses(building: Building, topomap: TopoMap) -> Array:
    """Poses (V, 3) at which a map's vertices were recorded; the agent never gets them."""
    instance("topomap", topomap, TopoMap)
    return instance("building", building, Building).recorded.poses_at(topomap.vertices.timestamps)


def edge_lengths(building: Building, topomap: TopoMap) -> Array:
    """Geodesic metres (E,) of every edge of a map, in the order of `topomap.graph.edges`."""
    poses = vertex_poses(building, topomap)
    return _lengths(building, topomap.graph, poses)


def sizes_of(building: Building, graph: nx.DiGraph, poses: Array) -> tuple[int, int, int]:
    """Vertices, edges and wormholes of a map whose images were taken at poses (M, 3)."""
    lengths = _lengths(building, graph, poses)
    return len(graph), len(lengths), int((lengths > WORMHOLE).sum())


def _lengths(building: Building, graph: nx.DiGraph, poses: Array) -> Array:
    edges = np.array(list(graph.edges), dtype=np.intp).reshape(-1, 2)
    return building.paths.between(poses[edges[:, 0], :2], poses[edges[:, 1], :2])


def attempt(building: Building, trials: Trials, agent: Agent, images: str = ONE) -> Result:
    """Let an agent learn a building, then run its trials, with `images` of their goals."""
    agent.learn(list(experiences(building)))
    return measured(building, trials, agent, images)


def measured(building: Building, trials: Trials, agent: Agent, images: str = ONE) -> Result:
    """Run the trials with an agent that has learned the building."""
    goals = goals_of(trials, view_of(building.camera), K, images)
    outcome = navigate(building, trials, lambda _: agent.start(goals))
    topomap = getattr(agent, "topomap", None)
    if topomap is None:
        return Result(outcome)
    poses = vertex_poses(building, topomap)
    return Result(outcome, sizes_of(building, topomap.graph, poses))
