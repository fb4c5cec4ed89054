"""The second visit: what an exploration saw becomes a map, on which paths are planned.

The agent of Meng 2020 cannot go where it never was, and that of Neural Topological SLAM forgets
what it explored. Here the first calls the second where no path is probable enough; the second says
when the goal is reached, since it looks at the whole panorama.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.navigator import MapAgent
from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.agents.votes import agreeing
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import bearing_of
from tutorial_lib.exploration.goal_search import of_all
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.local_policy import LocalPolicy
from tutorial_lib.exploration.turned_views import turned
from tutorial_lib.interfaces import HERE, Edges, Plan
from tutorial_lib.observation import Experience, Goals, Observation
from tutorial_lib.se2 import wrap
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.transitions import FollowerSettings, State
from tutorial_lib.validation import instance, whole
from tutorial_lib.world.noise import LEFT, RIGHT, STOP

DISCRETE = FollowerSettings(at=0.4, facing=0.05, confirm=1, fall=1.0)
"""For actions of 0.25 m, each of which counts as a step of 0.1 s; the heading does not matter, and
a fall of RE says nothing."""
_ACTION = 0.5  # seconds that an action takes, about
_LEAST = 0.15  # metres that a frame is from the next, at least
_FACES = np.deg2rad(10.0)  # off which a robot turns before it follows a path: a turn


@dataclass(frozen=True)
class ReturnSettings:
    """When a robot plans.

    Attributes:
        headings: evenly spaced, in which it looks for vertices, and in which goals may be met.
        losses: of a path, or of a goal that was not there, after which it plans no more.
        pause: actions of exploring from one plan to the next.
        turning: actions of turning where a path continues in another direction, after which it
            is lost.
    """

    headings: int = 6
    losses: int = 6
    pause: int = 25
    turning: int = 40

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            whole(name, value, least=1)


def visit(run: Sequence[Observation], robot: int, *, with_depth: bool = False) -> list[Experience]:
    """What one robot saw on its run: ahead of it, and, for the path back, over its shoulder.

    Only where it moved on is a frame kept; a panorama shows what is ahead and what is behind.

    Args:
        run: panoramas with depth of N robots, before each action.
        robot: which of them.
        with_depth: whether the pictures have depth.

    Returns:
        Two trajectories; none where the robot hardly moved.
    """
    seen = Observation.joined([observations[robot] for observations in run])
    moved = np.linalg.norm(np.diff(seen.odometry[:, :2], axis=0), axis=1)
    kept = np.flatnonzero(np.append(moved, 1.0) > _LEAST)
    if len(kept) < 2:
        return []
    there = seen[kept]
    seconds = _ACTION * np.arange(len(kept), dtype=float)
    return [
        Experience(turned(there, 0.0, with_depth=with_depth), seconds),
        Experience(turned(there[::-1], np.pi, with_depth=with_depth), seconds + seconds[-1] + 60.0),
    ]


class ReturningAgent:
    """An `ExplorerAgent` that plans over a map, and explores where no path is probable enough.

    Attributes:
        plans: the last plan of each robot; None where it has none.
        follower: follows the plans.
        recalled: (N,) actions that each robot took along its plans, turns included.
    """

    def __init__(
        self,
        memory: MapAgent,
        explorer: NTSAgent | None = None,
        settings: ReturnSettings | None = None,
    ) -> None:
        """Navigate with what `memory` learned.

        Args:
            memory: has learned from trajectories such as those of `visit`.
            explorer: acts where there is no path, and says when the goal is reached; without it, a
                robot without a path stops once it plans no more.
            settings: when to plan.
        """
        self._memory = instance("memory", memory, MapAgent)
        self._explorer = None if explorer is None else instance("explorer", explorer, NTSAgent)
        settings = ReturnSettings() if settings is None else settings
        self._settings = instance("settings", settings, ReturnSettings)
        self._headings = bearing_of(np.arange(self._settings.headings), self._settings.headings)

    def start(self, goals: Observation) -> None:
        """Begin on the way to `goals` (N,), panoramas; see `ExplorerAgent`."""
        instance("goals", goals, Observation)
        count = len(goals)
        self._goals = [self._looked_for(self._all_around(goals[n])) for n in range(count)]
        first = len(self._memory.topomap.vertices)
        self._first = first + self._settings.headings * np.arange(count)
        contexts = np.concatenate([goal.contexts for goal in self._goals])
        encoded = self._memory.targets().followed_by(contexts)
        paths = AnchorPaths(*encoded, [[goal] for goal in self._first])
        follower = self._memory.make_follower()
        self.follower = follower(paths, starts=np.zeros(count, dtype=int))
        self.plans: list[Plan | None] = [None] * count
        self.recalled = np.zeros(count, np.intp)
        self._aims = np.full(count, np.nan)  # heading at which a path begins, until it is faced
        self._due, self._lost, self._turning = np.zeros((3, count), np.intp)
        self._excluded: list[Edges] = [set() for _ in range(count)]
        self._turns: list[dict[int, float]] = [{} for _ in range(count)]
        self._maps = LocalMaps(count)
        self._policy = LocalPolicy(self._maps)
        if self._explorer is not None:
            self._explorer.start(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Actions (N,) of all robots; those not `running` (N,) stop."""
        running = of_all(observations, running, len(self.plans))
        robots = np.flatnonzero(running)
        actions = self._explore(observations, running)
        here = observations[robots]
        if here.depth is None:
            raise InputError("observations: panoramas without depth; use the rgbd sensor")
        self._maps.observe(robots, here.odometry, here.depth)
        for row, robot in enumerate(robots.tolist()):
            if self.plans[robot] is None and self._is_due(robot):
                self._plan(here[row], robot)
        planned = [row for row, robot in enumerate(robots) if self.plans[robot] is not None]
        rows = np.array(planned, dtype=np.intp)
        actions[robots[rows]] = self._follow(turned(here[rows], 0.0), robots[rows])
        return actions

    def _explore(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """What the explorer does; it goes on for robots that see their goal.

        Without one, a robot turns until it plans again; one that plans no more stops.
        """
        if self._explorer is None:
            return np.where(running & self._plans_again(), LEFT, STOP)
        for robot in np.flatnonzero(running):
            if self.plans[robot] is not None:
                self._explorer.robots[robot].interrupt()
        actions = self._explorer.act(observations, running)
        for robot in np.flatnonzero(running & self._explorer.search.found):
            self.plans[robot], self._due[robot] = None, self._settings.pause
        return actions

    def _is_due(self, robot: int) -> bool:
        """Whether to plan now."""
        if self._explorer is not None and self._explorer.search.found[robot]:
            return False
        self._due[robot] -= 1
        return bool(self._due[robot] <= 0 and self._plans_again()[robot])

    def _plans_again(self) -> NDArray[np.bool_]:
        """Whether each robot (N,) may still plan."""
        return self._lost < self._settings.losses

    def _plan(self, observation: Observation, robot: int) -> None:
        """Take the most probable path, whatever direction it begins in; or none."""
        views = self._all_around(observation)
        best, plan = self._best_path(views, robot)
        if plan.refusal and self._excluded[robot]:
            self._excluded[robot].clear()
            best, plan = self._best_path(views, robot)
        self._due[robot] = self._settings.pause
        if plan.refusal and (self._explorer is not None or not plan.probability):
            if self._explorer is None:
                self._lost[robot] = self._settings.losses  # it sees no more from where it stands
            return
        # A robot that cannot explore takes an improbable path rather than none.
        self._excluded[robot] -= {edge for edge in self._excluded[robot] if edge[0] == HERE}
        self.plans[robot], self._aims[robot] = plan, views.odometry[best, 2]
        path = [*plan.vertices, int(self._first[robot]) + plan.goal]
        self._turns[robot] = self._memory.topomap.turns_on(plan.vertices)
        self.follower.assign(robot, path, self._turns[robot])

    def _best_path(self, views: Observation, robot: int) -> tuple[int, Plan]:
        """The view from which the most probable path begins, and that path."""
        goals, excluded = self._goals[robot], self._excluded[robot]
        topomap = self._memory.topomap
        starts = agreeing(topomap, views, self._headings)
        vertices = {(HERE, int(vertex)) for vertex in topomap.alive}
        plans = [
            self._memory.find_path(
                views[i], goals, excluded | (vertices - {(HERE, vertex) for vertex in starts[i]})
            )
            for i in range(len(views))
        ]
        best = max(range(len(plans)), key=lambda i: (not plans[i].refusal, plans[i].probability))
        return best, plans[best]

    def _follow(self, seen: Observation, robots: NDArray[np.intp]) -> NDArray[np.intp]:
        """Actions (M,) along the plans of robots (M,); first they turn to where those begin."""
        self.recalled[robots] += 1
        aside = wrap(self._aims[robots] - seen.odometry[:, 2])
        facing = ~(np.abs(aside) > _FACES)
        self._aims[robots[facing]] = np.nan
        actions = np.where(aside > 0, LEFT, RIGHT)
        rows = np.flatnonzero(facing)
        if len(rows):
            actions[rows] = self._go_on(seen[rows], robots[rows])
        return actions

    def _go_on(self, seen: Observation, robots: NDArray[np.intp]) -> NDArray[np.intp]:
        """Actions (M,) of robots that face their paths: the follower's, by the local policy."""
        self.follower.act(seen, robots)
        memory = self.follower.memory
        actions = np.full(len(robots), LEFT)
        rows = np.flatnonzero(~memory.over[robots] & (memory.state[robots] != State.TURN))
        if len(rows):
            mine = robots[rows]
            places = memory.waypoints[mine]
            actions[rows] = self._policy.act(mine, seen.odometry[rows], places)[0]
            self._turning[mine] = 0
        for row in np.flatnonzero(memory.state[robots] == State.TURN):
            actions[row] = self._turn(robots[row])
        for row in np.flatnonzero(memory.over[robots]):
            if memory.done[robots[row]] and self._explorer is None:
                actions[row] = STOP
            else:
                self._lose(robots[row])
        return actions

    def _turn(self, robot: int) -> int:
        """To the side on which the path goes on; a robot that does not find it is lost."""
        self._turning[robot] += 1
        if self._turning[robot] > self._settings.turning:
            self._lose(robot)
        angle = self._turns[robot].get(int(self.follower.memory.active[robot]), 1.0)
        return LEFT if angle > 0 else RIGHT

    def _lose(self, robot: int) -> None:
        """Plan anew in the next step, not over what could not be passed.

        So does a robot that comes to the end of its path, but whose explorer does not see the goal
        there.
        """
        plan, ahead = self.plans[robot], int(self.follower.memory.active[robot])
        if plan is None:
            return  # it has lost its path in this step already
        path = [HERE, *plan.vertices]
        step = min(ahead, len(plan.vertices) - 1)
        if step >= 0:
            self._excluded[robot].add((path[step], path[step + 1]))
        self.plans[robot] = None
        self._lost[robot] += 1
        self._due[robot] = self._turning[robot] = 0
        if self._explorer is not None:
            self._explorer.search.look_again(np.array([robot]))

    def _all_around(self, observation: Observation) -> Observation:
        """Views (K,) of one panorama in all directions."""
        count = len(self._headings)
        one = np.zeros(count, dtype=np.intp)
        return turned(observation[one], self._headings)

    def _looked_for(self, views: Observation) -> Goals:
        """A goal from views (K,) of it; each is its own context, since nobody drove by."""
        images = self._memory.predictor.view.of(views)
        return Goals(views, np.repeat(images[:, None], 2 * self._memory.predictor.k + 1, axis=1))
