"""The agents that experiments compare, or one with a component of your own."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.ltvn_state import TravelSettings
from tutorial_lib.agents.mending import MendingMengAgent
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.random import RandomAgent
from tutorial_lib.agents.remedies import Remedies
from tutorial_lib.agents.remedy_agent import RemedyAgent
from tutorial_lib.agents.sptm import SPTMAgent
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.experiments.common.own import load_own
from tutorial_lib.interfaces import Agent
from tutorial_lib.learning.estimators import (
    ReachabilityNetwork,
    RelativeNetwork,
    WaypointNetwork,
)
from tutorial_lib.learning.views import named_for, view_of
from tutorial_lib.learning.weights import load_card
from tutorial_lib.topology.mapping.sampling_map import SamplingRules
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.world.sensors import Camera

CONTEXT = "k5"
WAYPOINT, REACH, SIMILARITY = NETWORKS = (f"waypoint_{CONTEXT}", f"reach_{CONTEXT}", "sptm")
"""Of Meng's agent, SPTM's and the random one, as they are called for the usual camera."""
S_SHORTCUT = 0.99
"""SPTM's threshold, chosen on validation worlds."""
SOON = 0.6
"""ViNG's threshold, chosen on validation worlds: of its longest time, one minus the share after
which another image follows at most."""
VING_RULES = {
    "reachable": SOON,
    "own_reachable": SOON,
    "merge": 0.0,
    "connect": 10.0,
    "support": 0.0,
    "by_time": True,
}
VING_TRAVEL = {"sure": SOON, "near": 0.3}
SEAMS = ("agent", "planner", "localizer", "reachability", "predictor", "controller")
"""What a class of one's own may be where whole agents are compared."""


def trained_for(name: str, camera: Camera | None) -> str:
    """The name of one of `NETWORKS` that was trained for a camera; the usual one if None.

    Raises:
        InputError: where `view_of` knows no such camera.
    """
    return name if camera is None else named_for(name, view_of(camera).degrees)


def check_trained(camera: Camera) -> None:
    """Check that there are `NETWORKS` for a camera.

    Raises:
        InputError: naming the command that trains one which is missing.
    """
    for name in NETWORKS:
        load_card(trained_for(name, camera))


def meng(camera: Camera | None = None, **changed: Any) -> MengAgent:  # noqa: ANN401 - any attribute
    """The agent of Meng 2020 with the networks for a camera; `changed` replaces attributes.

    The camera is the usual one unless given, here and below.
    """
    return MengAgent(**_shipped(camera, changed))


def mending(**changed: Any) -> MendingMengAgent:  # noqa: ANN401 - any attribute
    """The same with upkeep of its map, for the usual camera."""
    return MendingMengAgent(**_shipped(None, changed))


def remedied(
    name: str,
    camera: Camera | None = None,
    **changed: Any,  # noqa: ANN401 - any attribute
) -> RemedyAgent:
    """Meng's agent with remedies for places that look alike, one of `REMEDIES`.

    Raises:
        InputError: for an unknown name.
    """
    return RemedyAgent(**_shipped(camera, {"remedies": Remedies.named(name), **changed}))


def _shipped(camera: Camera | None, changed: Mapping[str, Any]) -> dict[str, Any]:
    """The networks for a camera, the controller, and what is changed."""
    return {
        "predictor": WaypointNetwork(trained_for(WAYPOINT, camera)),
        "controller": RMPController(),
        "reachability": ReachabilityNetwork(trained_for(REACH, camera)),
        **changed,
    }


def sptm(camera: Camera | None = None, **changed: Any) -> SPTMAgent:  # noqa: ANN401 - any attribute
    """SPTM with the same controller and follower; `changed` replaces attributes."""
    similarity = ReachabilityNetwork(trained_for(SIMILARITY, camera))
    own = {"similarity": similarity, "s_shortcut": S_SHORTCUT}
    return SPTMAgent(**_shipped(camera, {**own, **changed}))


def ltvn(**changed: Any) -> LTVNAgent:  # noqa: ANN401 - any attribute of the agent
    """LTVN's agent with the shipped model; `changed` replaces attributes."""
    model = changed.pop("model", None) or RelativeNetwork("relative_5")
    return LTVNAgent(model=model, **changed)


def ving(**changed: Any) -> LTVNAgent:  # noqa: ANN401 - any attribute of the agent
    """ViNG on the same drives and controllers; `changed` replaces attributes.

    Its map keeps every image, and joins two that are predicted to be soon after one another.
    """
    parts: dict[str, Any] = {
        "model": RelativeNetwork("ving"),
        "rules": SamplingRules(**VING_RULES),
        "travel": TravelSettings(**VING_TRAVEL),
        "maintenance": None,
        "turns": None,
    }
    return LTVNAgent(**{**parts, **changed})


def random_agent(rng: np.random.Generator, camera: Camera | None = None) -> RandomAgent:
    """The random agent."""
    return RandomAgent(WaypointNetwork(trained_for(WAYPOINT, camera)), RMPController(), rng)


def custom(where: str, camera: Camera | None = None) -> Agent:
    """An agent of the user's own, or `meng` with a component of theirs, from "FILE.py:CLASS".

    Raises:
        InputError: as `load_own` does.
    """
    seam, part = load_own(where, SEAMS)
    if seam == "agent":
        return part
    if seam == "localizer":
        return meng(camera, planner=DijkstraPlanner(localizer=part))
    return meng(camera, **{seam: part})
