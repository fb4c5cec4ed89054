"""An experiment as a command: the worlds and options it takes, its settings, its report."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import joblib

from tutorial_lib.course import cache_folder
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Finding, Notes, Options, Report, Rows
from tutorial_lib.parallel import resumable

STANDARD = "standard"
"""The palette unless another one is given."""
OPTIONAL = (
    *("map", "palette", "family", "agent", "odometry", "drives", "starts", "goals", "remedies"),
    "goal-images",
    "body",
    "robot",
)
"""Options that only some experiments take."""


@cache
def library_hash() -> str:
    """Of the library's source and the cards of its weights: whatever a run's rows depend on."""
    library = Path(__file__).resolve().parents[2]
    found = sha256()
    for path in sorted([*library.rglob("*.py"), *library.glob("weights/*.json")]):
        found.update(path.read_bytes())
    return found.hexdigest()


@dataclass(frozen=True)
class Experiment:
    """One experiment or benchmark.

    Attributes:
        name: of its report; also of its command, unless it is an ablation.
        run: is given the options, with the seeds of the worlds to run on, and the settings;
            returns rows, and beside them findings and notes.
        worlds: seeds of the worlds to run on unless others are given. Where this is only one, the
            experiment runs in a single world; where it is none, it takes no worlds.
        quick_worlds: the same for a quick run; `worlds` unless given.
        settings: a dataclass of the experiment's own.
        quick_settings: the same for a quick run; `settings` unless given.
        canary: the same for a few episodes in one world, at most 20 s: their rows tell whether a
            changed library still gives the same numbers. None where nothing short does.
        accepts: which of `OPTIONAL` it takes.
        ablations: other experiments that run in its place, by name.
    """

    name: str
    run: Callable[[Options, Any], tuple[Rows, Notes]]
    worlds: tuple[int, ...] = ()
    quick_worlds: tuple[int, ...] = ()
    settings: Any = None
    quick_settings: Any = None
    canary: Any = None
    accepts: frozenset[str] = frozenset()
    ablations: Mapping[str, Experiment] = field(default_factory=dict)

    def report(self, options: Options) -> Report:
        """Run it, or the ablation that `options` name.

        Raises:
            InputError: for an option that it cannot use, before anything is run.
        """
        if options.ablation:
            return self.named(options.ablation).report(replace(options, ablation=""))
        self._check(options)
        begun = time.perf_counter()
        worlds, settings = options.worlds or self.worlds, self.settings
        if options.quick:
            worlds = options.worlds or self.quick_worlds or self.worlds
            settings = settings if self.quick_settings is None else self.quick_settings
        worlds, file = (worlds, "") if options.map is None else ((), options.map.name)
        asked = replace(options, worlds=worlds)
        # What lies in a file of one's own may change from one run to the next.
        own = options.agent or options.robot or options.map is not None
        with nullcontext() if own else resumable(self._folder(asked, settings)):
            rows, beside = self.run(asked, settings)
        changed = {"odometry": "" if options.drifts else options.odometry}
        changed["palette"] = "" if options.palette == STANDARD else options.palette
        changed["region"] = ", ".join(f"{number:g}" for number in options.region or ())
        noted = ("family", "starts", "goals", "remedies", "robot")
        changed |= {name: getattr(options, name) for name in noted}
        findings = tuple(one for one in beside if isinstance(one, Finding))
        notes = [f"custom: {options.agent}"] if options.agent else []
        notes += [one for one in beside if isinstance(one, str)]
        notes += [f"{name}: {value}" for name, value in changed.items() if value]
        return Report(
            name=self.name,
            seed=options.seed,
            worlds=worlds,
            quick=options.quick,
            seconds=time.perf_counter() - begun,
            rows=rows,
            notes=tuple(notes),
            findings=findings,
            map=file,
        )

    def named(self, ablation: str) -> Experiment:
        """One of its ablations; itself where none is named."""
        if ablation and ablation not in self.ablations:
            known = f"has {', '.join(self.ablations)}" if self.ablations else "has none"
            raise InputError(f"--ablation {ablation}: {self.name} {known}")
        return self.ablations[ablation] if ablation else self

    def canary_rows(self, options: Options) -> Rows:
        """The rows of a few episodes in one generated world; none where it has no canary."""
        chosen = self.named(options.ablation)
        if chosen.canary is None:
            return []
        worlds = (options.worlds or chosen.worlds)[:1]
        few = replace(options, ablation="", quick=True, worlds=worlds, map=None, region=None)
        return chosen.run(few, chosen.canary)[0]

    def _folder(self, options: Options, settings: Any) -> Path:  # noqa: ANN401 - a dataclass
        """Where pieces of a run are kept until it is done: by all that its rows depend on."""
        made_from = joblib.hash((options, settings, library_hash()))
        return cache_folder() / "unfinished" / f"{self.name}-{made_from}"

    def options(self) -> tuple[str, ...]:
        """Which options it takes, to read; every experiment takes --seed, --quick and --json."""
        seeds = "A:B" if len(self.worlds) > 1 else "A:A+1"
        worlds = (f"--worlds {seeds}",) if self.worlds else ()
        others = tuple(f"--{name}" for name in OPTIONAL if name in self.accepts)
        ablations = (f"--ablation {{{','.join(self.ablations)}}}",) if self.ablations else ()
        return worlds + others + ablations

    def _check(self, options: Options) -> None:
        """Refuse by name whatever would have no effect."""
        if options.seed < 0:
            raise InputError(f"--seed: {options.seed}; give a whole number from 0 on")
        usual, given = Options(), dict[str, bool]()
        for name in OPTIONAL:
            field_name = name.replace("-", "_")
            given[name] = getattr(options, field_name) != getattr(usual, field_name)
        for name, is_given in given.items():
            if is_given and name not in self.accepts:
                known = ", ".join(self.options()) or "none but --seed, --quick and --json"
                raise InputError(f"--{name}: {self.name} cannot use it; its options: {known}")
        if options.region is not None and options.map is None:
            raise InputError("--region: is that of a map's file; give --map, or leave it out")
        if options.map is not None and options.worlds:
            raise InputError("--map: replaces the generated worlds; leave out --worlds")
        for name in ("palette", "family"):
            if options.map is not None and given[name]:
                raise InputError(f"--{name}: is that of generated worlds; leave out --map")
        if options.worlds and not self.worlds:
            raise InputError(f"--worlds: {self.name} runs in no world; leave it out")
        if len(options.worlds) > len(self.worlds) == 1:
            raise InputError(f"--worlds: {self.name} runs in a single one; give A:A+1")
