"""An exploration step by step: what the robot sees and remembers, and what is true."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.nts import ExploringRobot, NTSAgent
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.se2 import Array, compose, inverse, to_world


@dataclass(frozen=True, eq=False)
class Moment:
    """One robot at one step; places are where it believes them to be, from its true start.

    Attributes:
        pose: (3,) where it is.
        believed: (3,) where it takes itself to be, by odometry.
        image: (H, W, 3) its panorama.
        node: in which it is.
        nodes: (V, 3) of its graph.
        edges: pairs of nodes.
        ghosts: for each the node, the direction, the place (2,) and the score.
        target: the ghost to which it is going, as (node, direction), or None.
        place: (2,) to which it is going, or None.
        found: whether it knows where the goal is.
    """

    pose: Array
    believed: Array
    image: NDArray[np.uint8]
    node: int
    nodes: Array
    edges: list[tuple[int, int]]
    ghosts: list[tuple[int, int, Array, float]]
    target: tuple[int, int] | None
    place: Array | None
    found: bool


@dataclass(frozen=True, eq=False)
class Watched:
    """One episode of an `NTSAgent`.

    Attributes:
        moments: before each action.
        goal: (H, W, 3) the goal's picture.
        panoramas: (H, W, 3) of each node of the graph.
        scores: (V, K) of each node's directions.
        truth: (V, K) what the scores should be.
    """

    moments: list[Moment]
    goal: NDArray[np.uint8]
    panoramas: list[NDArray[np.uint8]]
    scores: Array
    truth: Array


def watch(task: ExplorationTask, agent: NTSAgent, number: int = 0) -> Watched:
    """Let an agent act until all episodes are over, and watch one of its robots.

    Args:
        task: at the beginning of its episodes.
        agent: with a graph.
        number: of the robot.
    """
    goals = task.goals()
    agent.start(goals)
    moments: list[Moment] = []
    panoramas: list[NDArray[np.uint8]] = []
    places: list[Array] = []
    start = task.poses[number]
    while not task.done.all():
        seen = task.observe()
        actions = agent.act(seen, ~task.done)
        if not task.done[number]:
            robot = agent.robots[number]
            if len(robot.memory.graph) > len(panoramas):
                panoramas.append(seen.image[number].copy())
                places.append(task.poses[number].copy())
            believed = compose(start, seen.odometry[number])
            found = bool(agent.search.found[number])
            goal = to_world(start, agent.search.places[number]) if found else None
            image = seen.image[number].copy()
            moments.append(_moment(robot, task.poses[number].copy(), believed, image, goal))
        task.step(actions)
    scene = task.scenes[task.episodes.worlds[number]]
    labels = PanoramaLabels(scene, np.array([*places, task.goal_poses[number]]))
    sources = np.arange(len(places))
    truth = labels.scores(sources, np.full(len(places), len(places)))
    scores = np.array(agent.robots[number].scores)
    return Watched(moments, goals.image[number], panoramas, scores, truth)


def _moment(
    robot: ExploringRobot,
    pose: Array,
    believed: Array,
    image: NDArray[np.uint8],
    goal: Array | None,
) -> Moment:
    """What a robot remembers now; `goal` is the place of the goal, if it knows that."""
    memory, destination = robot.memory, robot.destination
    graph = memory.graph
    nodes = compose(compose(believed, inverse(memory.offset)), graph.poses_from(memory.node))
    ghosts = [
        (
            g.node,
            g.direction,
            to_world(nodes[g.node], graph.place_of(g)),
            robot.scores[g.node][g.direction],
        )
        for g in graph.ghosts.values()
    ]
    edges = [(v, w) for v, near in enumerate(graph.edges) for w in near if v < w]
    target, place = None, goal
    if goal is None and destination is not None:
        place = to_world(nodes[destination.node], destination.place)
        ghost = destination.ghost
        target = (ghost.node, ghost.direction) if ghost is not None else None
    return Moment(
        pose, believed, image, memory.node, nodes, edges, ghosts, target, place, goal is not None
    )
