"""Where the episodes of environments come from: generated worlds by seed, or a map of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import (
    DIFFICULTIES,
    Episodes,
    EpisodeSource,
    exploration_world,
)
from tutorial_lib.validation import instance, listed, whole
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.importers import import_map
from tutorial_lib.world.occupancy import check_closed
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of


class DrawnEpisodes:
    """Draws episodes; each world's places are looked for once.

    Attributes:
        sources: of the worlds in which episodes were drawn, by name.
    """

    def __init__(
        self,
        worlds: Sequence[int] | None,
        plan: str | Path | FloorPlan | None,
        signs: str,
        difficulty: str,
    ) -> None:
        """Choose worlds and difficulty; see `environment.ImageGoalNavigation`."""
        check_known("signs", signs, SIGNS)
        check_known("difficulty", difficulty, tuple(DIFFICULTIES))
        if plan is not None and (worlds is not None or signs != "plain"):
            raise InputError(
                "plan: it is the only world and has no signs; leave worlds and signs out"
            )
        self._plan = None if plan is None else Scene(_floor_plan(plan))
        self._worlds = _seeds(range(100) if worlds is None else worlds)
        self._signs, self._difficulty = signs, difficulty
        self._scenes: dict[str, Scene] = {}
        self.sources: dict[str, EpisodeSource] = {}

    def draw(
        self, options: dict[str, Any] | None, rng: np.random.Generator, starts: int = 1
    ) -> tuple[str, Scene, Episodes]:
        """The name of a world, the world, and an episode in it, or several to one goal."""
        worlds, difficulty = self._chosen({} if options is None else options)
        world = "plan"
        if self._plan is None:
            world = exploration_world(int(rng.choice(worlds)), self._signs)
        if world not in self.sources:
            self._scenes[world] = scene_of(world) if self._plan is None else self._plan
            self.sources[world] = EpisodeSource(world, self._scenes[world])
        return world, self._scenes[world], self.sources[world].draw({difficulty: 1}, rng, starts)

    def _chosen(self, options: dict[str, Any]) -> tuple[tuple[int, ...], str]:
        """Worlds and difficulty of the next episode."""
        known = ("difficulty", "world") if self._plan is None else ("difficulty",)
        for name in instance("options", options, dict):
            check_known("options", name, known)
        difficulty = options.get("difficulty", self._difficulty)
        check_known("options: difficulty", difficulty, tuple(DIFFICULTIES))
        if "world" not in options:
            return self._worlds, difficulty
        return (whole("options: world", options["world"], least=0),), difficulty


def check_known(what: str, value: object, known: tuple[object, ...]) -> None:
    """Check that a value is one of those that are known."""
    if not any(type(value) is type(one) and value == one for one in known):
        raise InputError(f"{what}: {value!r} is unknown; use one of {', '.join(map(str, known))}")


def _floor_plan(plan: str | Path | FloorPlan) -> FloorPlan:
    """A floor plan whose rooms are closed, from a file unless it is one."""
    if isinstance(plan, FloorPlan):
        check_closed(plan)
        return plan
    if not isinstance(plan, str | Path):
        raise InputError(
            f"plan: of type {type(plan).__name__}; give the name of a map's file or a FloorPlan"
        )
    return import_map(plan)


def _seeds(worlds: Sequence[int]) -> tuple[int, ...]:
    """Seeds of worlds, checked."""
    given = listed("worlds", worlds, "seeds of worlds")
    whole = [isinstance(seed, int | np.integer) and seed >= 0 for seed in given]
    if not given or not all(whole):
        raise InputError(f"worlds: {worlds!r}; give seeds, at least one, whole numbers from 0 on")
    return tuple(map(int, given))
