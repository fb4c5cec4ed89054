"""The agents that experiments compare, and how to run one, or a component, of your own."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.random import RandomAgent
from tutorial_lib.agents.remedies import Remedies
from tutorial_lib.agents.remedy_agent import RemedyAgent
from tutorial_lib.agents.sptm import SPTMAgent
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.errors import InputError, words_of
from tutorial_lib.interfaces import Agent
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.reading.limits import MAX_TEXT
from tutorial_lib.reading.regular import read_bytes
from tutorial_lib.topology.planner import DijkstraPlanner

CONTEXT = "k5"
S_SHORTCUT = 0.99
"""SPTM's threshold, chosen on validation worlds."""
COMPONENTS = {
    "agent": ("learn", "start"),
    "planner": ("plan",),
    "localizer": ("localize",),
    "reachability": ("prepare", "probability"),
}
"""What a class of your own can be, by the methods that it has."""


def meng(**changed: Any) -> MengAgent:  # noqa: ANN401 - any attribute of the agent
    """The agent of Meng 2020 with the shipped networks; `changed` replaces attributes."""
    return MengAgent(**{**_shipped(), **changed})


def remedied(name: str, **changed: Any) -> RemedyAgent:  # noqa: ANN401 - any attribute
    """The same with remedies for places that look alike, one of `REMEDIES`.

    Raises:
        InputError: for an unknown name.
    """
    return RemedyAgent(**{**_shipped(), "remedies": Remedies.named(name), **changed})


def _shipped() -> dict[str, Any]:
    """The shipped networks, and the controller."""
    return {
        "predictor": WaypointNetwork(f"waypoint_{CONTEXT}"),
        "controller": RMPController(),
        "reachability": ReachabilityNetwork(f"reach_{CONTEXT}"),
    }


def sptm(**changed: Any) -> SPTMAgent:  # noqa: ANN401 - any attribute of the agent
    """SPTM with the same controller and follower; `changed` replaces attributes."""
    parts: dict[str, Any] = {
        "similarity": ReachabilityNetwork("sptm"),
        "predictor": WaypointNetwork(f"waypoint_{CONTEXT}"),
        "controller": RMPController(),
        "reachability": ReachabilityNetwork(f"reach_{CONTEXT}"),
        "s_shortcut": S_SHORTCUT,
    }
    return SPTMAgent(**{**parts, **changed})


def random_agent(rng: np.random.Generator) -> RandomAgent:
    """The random agent."""
    return RandomAgent(WaypointNetwork(f"waypoint_{CONTEXT}"), RMPController(), rng)


def custom(where: str) -> Agent:
    """An agent of the user's own, or `meng` with a component of theirs, from "FILE.py:CLASS".

    The class is instantiated without arguments. One with `learn` and `start` is a whole agent; one
    with `plan`, `localize`, or `prepare` and `probability` replaces that component of `meng`.

    Raises:
        InputError: if there is no such file or class, if it cannot be instantiated, or if it is
            no such component.
    """
    component = guarded(where, _instantiate, where)
    kinds = guarded(where, _kinds, component)
    if not kinds:
        known = "; ".join(f"{kind}: {', '.join(methods)}" for kind, methods in COMPONENTS.items())
        raise InputError(f"--agent {where}: has the methods of no component ({known})")
    if kinds[0] == "agent":
        return component
    if kinds[0] == "localizer":
        return meng(planner=DijkstraPlanner(localizer=component))
    return meng(**{kinds[0]: component})


def guarded(where: str, run: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
    """Call `run` with the user's agent; whatever their code raises becomes a clear message.

    Raises:
        InputError: with the file, the line and the error, in one line.
    """
    try:
        return run(*arguments)
    except KeyboardInterrupt:
        raise
    except InputError as error:
        raise InputError(f"--agent {where}: {error}") from error
    except BaseException as error:
        raise InputError(f"--agent {where}: {_fault(where, error)}") from error


def _kinds(component: object) -> list[str]:
    """What a component can be, by the methods that it has."""
    return [
        kind for kind, methods in COMPONENTS.items() if all(hasattr(component, m) for m in methods)
    ]


def _instantiate(where: str) -> Any:  # noqa: ANN401
    file, _, name = where.rpartition(":")
    path = Path(file)
    if not file or not name.isidentifier():
        raise InputError("give FILE.py:CLASS, as in my_agent.py:MyPlanner")
    if not path.exists():
        raise InputError(f"there is no file {file}")
    read_bytes(path, MAX_TEXT, "give a file of Python code")
    spec = importlib.util.spec_from_file_location(f"custom_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{file} is no Python file; its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    spec.loader.exec_module(module)
    known = getattr(module, name, None)
    if known is None:
        raise InputError(f"{file} has no {name}")
    return known()


def _fault(where: str, error: BaseException) -> str:
    """The error, and the line of the user's file in which it was raised."""
    file = Path(where.rpartition(":")[0]).resolve()
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename).resolve() == file
    ]
    # A SyntaxError has no frame in the file that it concerns.
    line = lines[-1] if lines else getattr(error, "lineno", None)
    at = f"{file.name}, line {line}: " if line else ""
    return f"{at}{words_of(error)}"
