"""Many queries in one building, by robots whose map changes meanwhile (LTVN)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.ltvn_navigation import LTVNNavigation
from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.experiments.protocols.navigation import Outcome, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials
from tutorial_lib.interfaces import Experience, Goals, Navigation, Observation, Robots
from tutorial_lib.learning.analytic_label import AnalyticLabel
from tutorial_lib.learning.views import VIEWS, View
from tutorial_lib.se2 import Array, relative
from tutorial_lib.topology.mapping.sampling_map import SampledMap
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Sensors, Simulation
from tutorial_lib.world.visibility import mutual_overlap

SURE = 0.97
"""What true perception says of a reachable pair; one minus that of others."""


@dataclass
class TrueModel:
    """A `RelativeModel` without errors: it knows where each image was taken.

    Attributes:
        scene: the world.
        label: what counts as reachable.
    """

    scene: Scene
    label: AnalyticLabel = field(default_factory=AnalyticLabel)
    view: View = VIEWS["rgbd16"]
    k: int = 0

    def __post_init__(self) -> None:
        self._poses: dict[bytes, Array] = {}

    def know(self, observations: Observation, poses: Array) -> None:
        """Remember where N images were taken, (N, 3)."""
        for image, pose in zip(self.view.of(observations), poses, strict=True):
            self._poses[image.tobytes()] = pose

    def prepare(self, contexts: NDArray) -> Array:
        """The poses (M, 3) of images (M, 1, ...)."""
        return self._where(contexts[:, 0])

    def predict(self, observations: Observation, targets: Array) -> tuple[Array, Array]:
        """Whether the label holds, and the true relative poses."""
        starts = self._where(self.view.of(observations))
        seen = relative(starts, targets)
        metres = np.hypot(seen[:, 0], seen[:, 1])
        near = np.flatnonzero((metres < self.label.distance) & (abs(seen[:, 2]) < self.label.yaw))
        overlap = mutual_overlap(self.scene.caster, starts[near], targets[near])
        # Where the target is in free sight, the shortest path is the straight line.
        frames = np.zeros(len(near), dtype=np.intp)
        pairs = ReachabilityPairs(starts[near], frames, overlap, metres[near])
        reachable = np.full(len(seen), 1.0 - SURE)
        holds = self.label(self.scene.caster, pairs, targets[near])
        reachable[near] = np.where(holds, SURE, 1.0 - SURE)
        return reachable, seen

    def _where(self, images: NDArray) -> Array:
        return np.array([self._poses[image.tobytes()] for image in images]).reshape(-1, 3)


@dataclass
class Informed:
    """A `Navigation` whose true model learns where the robots are before each step."""

    navigation: Navigation
    model: TrueModel
    simulation: Simulation

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """Of the navigation."""
        return self.navigation.arrived

    @property
    def given_up(self) -> NDArray[np.bool_]:
        """Of the navigation."""
        return self.navigation.given_up

    def act(self, observations: Observation, robots: Robots) -> Array:
        """The navigation's actions."""
        self.model.know(observations, self.simulation.poses[robots])
        return self.navigation.act(observations, robots)


def deep_experiences(building: Building, model: TrueModel | None = None) -> list[Experience]:
    """What was observed on a building's drives, with depth."""
    recorded = building.recorded
    found = []
    for drive in range(len(recorded.trajectories)):
        frames = recorded.frames_of(drive)
        seen = recorded.observe(frames, depth=True)
        if model is not None:
            model.know(seen, recorded.poses[frames])
        times = recorded.begins[drive] + recorded.trajectories[drive].timestamps
        found.append(Experience(seen, times))
    return found


def deep_goals(trials: Trials, model: TrueModel | None = None) -> list[Goals]:
    """The one image of each trial's goal, with depth."""
    seen = trials.recorded.observe(trials.goals, depth=True)
    if model is not None:
        model.know(seen, trials.goal_poses)
    return [Goals(seen[[i]], seen.image[[i], None]) for i in range(len(trials))]


def run_queries(
    building: Building,
    trials: Trials,
    agent: LTVNAgent,
    fleet: int = 25,
    first: int = 0,
    people: Sequence[Person] = (),
) -> tuple[Outcome, list[LTVNNavigation]]:
    """Run trials one fleet after the other; all robots of a fleet use and mend the same map.

    Args:
        building: where.
        trials: queries, in order.
        agent: has learned the building.
        fleet: robots at a time.
        first: number of the first query.
        people: what stands in the way of all, as a closed door does.
    """
    parts: list[Outcome] = []
    navigations = []
    for begin in range(0, len(trials), fleet):
        some = trials.subset(np.arange(begin, min(begin + fleet, len(trials))))
        agent.upkeep.begin(first + begin)
        outcome, navigation = run_fleet(building, some, agent, people)
        parts.append(outcome)
        navigations.append(navigation)
    return joined_outcomes(parts), navigations


def run_fleet(
    building: Building, trials: Trials, agent: LTVNAgent, people: Sequence[Person] = ()
) -> tuple[Outcome, LTVNNavigation]:
    """Run trials at once."""
    model = agent.model if isinstance(agent.model, TrueModel) else None
    navigation = agent.start(deep_goals(trials, model))

    def start(simulation: Simulation) -> Navigation:
        return navigation if model is None else Informed(navigation, model, simulation)

    sensors = Sensors(with_depth=True)
    return navigate(building, trials, start, people, sensors=sensors), navigation


@dataclass(frozen=True)
class MapScore:
    """How good a map is.

    Attributes:
        vertices: of it; fewer are better.
        edges: of it.
        arrived: queries that reached their goal.
        queries: their number.
    """

    vertices: int
    edges: int
    arrived: int
    queries: int


def score_map(building: Building, trials: Trials, sampled: SampledMap) -> MapScore:
    """Run trials on a map that does not change, in fleets."""
    agent = LTVNAgent(model=sampled.pool.model, maintenance=None)
    agent.use(sampled)
    found, _ = run_queries(building, trials, agent)
    graph = sampled.graph
    return MapScore(len(graph), graph.number_of_edges(), int(found.success.sum()), len(trials))


def joined_outcomes(parts: Sequence[Outcome]) -> Outcome:
    """Outcomes one after the other; their poses are left out."""
    names = ("success", "ending", "seconds", "gap")
    columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Outcome(**columns, poses=np.empty((0, 0, 3)))


def image_poses(building: Building, agent: LTVNAgent) -> Array:
    """Poses (M, 3) at which the images of an agent's pool were taken; it never gets them."""
    recorded, pool = building.recorded, agent.sampled.pool
    first = recorded.first_frames[pool.drive]
    return recorded.poses[first + agent.frames]
