"""The seams: what an agent observes, and the small interfaces of its parts.

Any object with the right methods fits: a network, an oracle, a student's class. Everything comes in
batches: the first axis of every array counts robots, images or pairs.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.observation import Experience, Goals, Observation
from tutorial_lib.validation import floats, instance, integers, whole

Array = NDArray[np.float64]
Robots = NDArray[np.intp]
"""(M,) indices of robots in a fleet, rising."""
HERE, Edges = -1, set[tuple[int, int]]
"""Where the robot is, in place of a vertex; and edges, from a vertex or from there to a vertex."""

_ROUNDING = 1e-6  # of a probability in single precision


@dataclass(frozen=True)
class Plan:
    """A path over the map from what is observed now to a goal.

    Attributes:
        vertices: of the map, in order; none where the goal itself can be reached from here.
        goal: index of the goal image that it leads to.
        probabilities: RE of every step, the first from here and the last to the goal; none where
            a planner has no RE.
        refusal: why the robot should not start; empty if it should.
    """

    vertices: tuple[int, ...] = ()
    goal: int = 0
    probabilities: tuple[float, ...] = ()
    refusal: str = ""

    def __post_init__(self) -> None:
        vertices = np.asarray(integers("vertices", self.vertices, ("P",), least=0))
        whole("goal", self.goal, least=0)
        steps = floats("probabilities", self.probabilities, ("P",), least=0, most=1 + _ROUNDING)
        object.__setattr__(self, "vertices", tuple(vertices.tolist()))
        object.__setattr__(self, "probabilities", tuple(steps.tolist()))
        instance("refusal", self.refusal, str)
        wanted = len(vertices) + 1
        if len(steps) not in (0, wanted):
            raise InputError(
                f"probabilities: {len(steps)} for {len(vertices)} vertices; give {wanted}, of "
                "every step from here to the goal, or none"
            )

    @property
    def probability(self) -> float:
        """That every step succeeds, were they independent; 0 without a path or without RE."""
        return float(np.prod(self.probabilities)) if self.probabilities else 0.0


Targets = Any
"""What a robot is to reach: images with their context, a pose for an oracle, ..."""


class View(Protocol):
    """What a network looks at: the camera's image or the laser's scan."""

    def of(self, observations: Observation) -> NDArray:
        """What N robots see, as the network wants it, (N, H, W, C)."""


@runtime_checkable
class WaypointPredictor(Protocol):
    """C_WP (Meng 2020, III-B): where to drive next in order to reach a target."""

    @property
    def view(self) -> View:
        """What it looks at."""

    @property
    def k(self) -> int:
        """Images of context on either side of a target."""

    def prepare(self, contexts: NDArray) -> Targets:
        """Targets from images (M, 2k+1, H, W, C); computed once, indexable by an array."""

    def predict(self, observations: Observation, targets: Targets) -> tuple[Array, Array]:
        """Waypoints (N, 2) in the robots' frames, and overlaps (N, 2) in [0, 1]."""


@runtime_checkable
class Controller(Protocol):
    """C_RMP (Meng 2020, III-B): drives to a waypoint without hitting anything."""

    def act(self, observations: Observation, waypoints: Array) -> Array:
        """Actions (N, 2): commanded speed in m/s, and steering in rad (car) or rad/s."""


@runtime_checkable
class LocalController(Protocol):
    """C (Meng 2020, III-B): from the current image and a target to an action."""

    def act(self, observations: Observation, targets: Targets) -> Array:
        """Actions (N, 2): commanded speed in m/s, and steering in rad (car) or rad/s."""


@runtime_checkable
class Policy(Protocol):
    """Drives a fleet in closed loop, see `driving.rollouts`."""

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,) that are still under way, as for a `Controller`."""


@runtime_checkable
class Reachability(Protocol):
    """RE (Meng 2020, III-C): the probability that C reaches a target.

    It may also have `embed(observations)`, for retrieval: without it a map is built exhaustively.
    """

    def prepare(self, targets: Targets, /) -> Any:  # noqa: ANN401 - whatever the estimator caches
        """Compute once what does not depend on the observation; may return `targets` itself."""

    def probability(self, observations: Observation, prepared: Any) -> Array:  # noqa: ANN401
        """Probabilities (N,) in [0, 1]."""


@runtime_checkable
class RelativeModel(Protocol):
    """f of LTVN: whether a target is reachable, and where it is if so."""

    @property
    def view(self) -> View:
        """What it looks at."""

    @property
    def k(self) -> int:
        """Images of context on either side of a target."""

    def prepare(self, contexts: NDArray) -> Targets:
        """Targets from images (M, 2k+1, H, W, C); computed once, indexable by an array.

        Images alone are (M, 1, H, W, C).
        """

    def predict(self, observations: Observation, targets: Targets) -> tuple[Array, Array]:
        """Probabilities (N,) that targets are reachable, and their poses (N, 3) if they are."""


@runtime_checkable
class Localizer(Protocol):
    """To which vertices of the map a robot may drive from where it is."""

    def localize(self, observations: Observation, topomap: Any) -> Array:  # noqa: ANN401
        """Probabilities (N, V) in [0, 1] that each vertex of `topomap.alive` is reached from here.

        A planner takes them as RE of the first step of a path, so that they need not sum to one.
        """


@runtime_checkable
class Planner(Protocol):
    """From what a robot observes to a goal, over the map."""

    def plan(
        self,
        observation: Observation,
        goals: Goals,
        topomap: Any,  # noqa: ANN401
        excluded: Collection[tuple[int, int]] = (),
    ) -> Plan:
        """A path over the map that avoids the `excluded` edges, or a refusal."""


@runtime_checkable
class Navigation(Policy, Protocol):
    """A `Policy` of N robots, each with a goal, that declares when it is over."""

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """(N,) declares to have arrived."""

    @property
    def given_up(self) -> NDArray[np.bool_]:
        """(N,) does not go on."""


@runtime_checkable
class Agent(Protocol):
    """A whole system."""

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Learn a building from trajectories recorded in it."""

    def start(self, goals: Sequence[Goals]) -> Navigation:
        """Send robots that stand somewhere in that building to one goal each."""


@runtime_checkable
class ExplorationModel(Protocol):
    """The four functions of Neural Topological SLAM (Chaplot et al. 2020, section 4).

    Features are rows: one of each panorama, which a node keeps. Directions are 12 bins; bin i is
    centred on the bearing of 30 i degrees, counter-clockwise from the source's heading.
    """

    def embed(self, observations: Observation) -> NDArray[np.float32]:
        """Features (N, D) of N panoramas, of a source or of a goal alike."""

    def explorable(self, features: NDArray[np.float32]) -> Array:
        """F_G: probabilities (N, 12) that a direction leads to explorable area."""

    def same_node(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_L: calibrated probabilities (P,) that a goal is visible from its source within 3 m."""

    def scores(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_S: scores (P, 12) in [0, 1], the higher the nearer a direction leads to the goal."""

    def relative(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_R: goals (P, 2) of the same node: bearing in the source's frame (rad), and metres."""

    def ranges(self, observations: Observation) -> Array:
        """Metres (N, W) to the wall in each column: measured, or predicted from the image."""


@runtime_checkable
class ExplorerAgent(Protocol):
    """N robots in lock-step in places that they have never seen, each with a goal's picture."""

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,), see `Observation.pictures`; forget all before."""

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Discrete actions (N,) of all robots; those of robots not `running` (N,) do nothing.

        Of cars (the observations say so) instead waypoints (N, 2) in their frames, metres; a row
        that is not a number stops.
        """


@runtime_checkable
class SequentialExplorer(ExplorerAgent, Protocol):
    """An `ExplorerAgent` that can go on to other goals, and keeps what it remembers."""

    def look_for(self, goals: Observation) -> None:
        """Go on from where the robots are to other goals (N,)."""


@runtime_checkable
class RecurrentPolicy(Protocol):
    """A policy with a memory, such as one that imitates shortest paths."""

    def start(self, goals: Observation) -> Any:  # noqa: ANN401 - whatever it remembers
        """The state of N robots before their first step; its first axis counts the robots."""

    def act(self, observations: Observation, state: Any) -> tuple[NDArray[np.intp], Any]:  # noqa: ANN401
        """Discrete actions (N,), and the state after them."""


@runtime_checkable
class FrontierScorer(Protocol):
    """Where on a metric map to look for a goal, in place of the nearest frontier."""

    def score(
        self,
        crops: NDArray[np.uint8],
        here: NDArray[np.float32],
        goals: NDArray[np.float32],
        frontiers: Array,
        robots: NDArray[np.intp],
    ) -> Array:
        """Scores (F,) of frontiers, the higher the better.

        Args:
            crops: (N, S, S) of the map around each robot: 0 unknown, 1 free, 2 occupied; x of the
                robot's frame runs along columns, y along rows, and the robot is in the middle.
            here: (N, D) features of what each robot sees, see `ExplorationModel.embed`.
            goals: (N, D) of what it looks for.
            frontiers: (F, 3) x and y in the robot's frame, and metres to go.
            robots: (F,) index of the robot of each frontier.
        """
