"""How sure RE is along recorded drives, and of a goal: where it hardly is, a trip shows little."""

import numpy as np

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.experiments.protocols.navigation import goals_of
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials
from tutorial_lib.geometry import Array
from tutorial_lib.learning.views import view_of
from tutorial_lib.topology.mapping.sparsify import contextified
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.topology.query import query

STEP = 5
"""Frames from one place on a drive to the next: about half a metre."""
_NEAR = 4.0  # metres from the goal


def sureness(building: Building, agent: MengAgent) -> list[Array]:
    """RE (S,) from each place on a drive to the next, for all drives of a building."""
    found = []
    for number in range(len(building.pairs)):
        seen = building.recorded.observe(building.recorded.frames_of(number), building.camera)
        images = agent.predictor.view.of(seen)
        targets = contextified(images, agent.predictor.k)[STEP::STEP]
        prepared = agent.reachability.prepare(targets)
        found.append(query(agent.reachability, seen[np.arange(len(targets)) * STEP], prepared))
    return found


def recognised_from(building: Building, trial: Trials, agent: MengAgent) -> int:
    """From how many places on the drives RE is sure of the goal; 0 if one of them is elsewhere."""
    frames = np.concatenate(
        [building.recorded.frames_of(i)[::STEP] for i in range(len(building.pairs))]
    )
    goals = goals_of(trial, view_of(building.camera), agent.predictor.k)[0]
    prepared = agent.reachability.prepare(goals.contexts)
    seen = building.recorded.observe(frames, building.camera)
    sure = query(agent.reachability, seen, prepared[np.zeros(len(frames), dtype=np.intp)])
    gaps = np.linalg.norm(building.recorded.poses[frames, :2] - trial.goal_poses[0, :2], axis=1)
    from_where = gaps[sure > DijkstraPlanner.p_goal]
    return len(from_where) if (from_where <= _NEAR).all() else 0
