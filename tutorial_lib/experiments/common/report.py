"""What experiments and benchmarks are given and return: options, and rows as table and JSON."""

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

DRIFTING, EXACT = ODOMETRY = ("drifting", "exact")
"""The wheel odometry of robots, see `world.noise.WheelOdometry`."""
ROUND, CAR = BODIES = ("round", "car")
"""The robots that explore, see `exploration.task` and `exploration.car_task`."""
MOST_WORLDS = 100_000
"""In one run."""
Rows = list[dict[str, Any]]
"""One for each line of the table; all have the same keys."""


POINTS, SHARE, CHANGE, NUMBER, METRES = ("points", "share", "change", "number", "metres")
FORMS = {POINTS: "{:+.1f}", SHARE: "{:.1%}", CHANGE: "{:+.3f}", NUMBER: "{:.3f}", METRES: "{:.1f}"}
"""How a finding is written; points are hundredths."""
_UNITS = {POINTS: " points", METRES: " m"}


@dataclass(frozen=True)
class Finding:
    """A number that a run found beside its table; as text the number and its interval.

    Attributes:
        what: it is of, as in "meng - sptm, composed".
        value: of it; None where it is not known.
        low: lower end of its 95% interval; None where it has none.
        high: upper end likewise.
        form: how it is written: a difference of shares as `POINTS`, a share as `SHARE`, another
            difference as `CHANGE`, any other value as `NUMBER` or in `METRES`.

    >>> str(Finding("meng - sptm", 0.021, -0.004, 0.05))
    '+2.1 points (-0.4 to +5.0)'
    """

    what: str
    value: float | None
    low: float | None = None
    high: float | None = None
    form: str = POINTS

    @property
    def line(self) -> str:
        """What it is of, and the number."""
        return f"{self.what}: {self}"

    def __str__(self) -> str:
        if self.value is None:
            return "not known"
        form, scale = FORMS[self.form], 100 if self.form == POINTS else 1
        text = form.format(scale * self.value) + _UNITS.get(self.form, "")
        if self.low is None or self.high is None:
            return text
        return f"{text} ({form.format(scale * self.low)} to {form.format(scale * self.high)})"


class Fault(str):
    """A note that a class of the user's own failed, so that its rows are missing."""

    __slots__ = ()


Notes = Sequence[str | Finding]
"""What a run says beside its rows."""


@dataclass(frozen=True)
class Options:
    """The options of the command line.

    Attributes:
        worlds: seeds of the worlds; empty for the experiment's own.
        seed: of everything random except the worlds.
        quick: at most five minutes: the same code with fewer episodes, where it takes longer.
        map: a file to run on instead of generated worlds.
        region: of the map, see `world.import_map`; the whole map unless given.
        ablation: to run instead of the experiment itself.
        palette: of generated worlds.
        family: of generated worlds, or "all"; the experiment's own, by seed, unless given.
        agent: FILE.py:CLASS of an agent, or of a component of one, to compare with the others.
        odometry: one of `ODOMETRY`.
        drives: which of the recorded drives agents learn, see `protocols.drives`; all if empty.
        starts: where trials start, see `protocols.trial_choices`; at the places if empty.
        goals: how goals are seen, likewise; as on arrival from the start if empty.
        remedies: for places that look alike, see `agents.remedies`; the experiment's own if empty.
        goal_images: what shows a goal, one of `protocols.navigation.GOAL_IMAGES`; one image if
            empty.
        body: one of `BODIES`.
        robot: FILE.py:NAME of what makes the body of robots that learn and use a map, or a pair of
            that and their camera; a `BicycleCar` and the usual camera if empty.
    """

    worlds: tuple[int, ...] = ()
    seed: int = 0
    quick: bool = False
    map: Path | None = None
    region: tuple[float, ...] | None = None
    ablation: str = ""
    palette: str = "standard"
    family: str = ""
    agent: str = ""
    odometry: str = DRIFTING
    drives: str = ""
    starts: str = ""
    goals: str = ""
    remedies: str = ""
    goal_images: str = ""
    body: str = ROUND
    robot: str = ""

    @property
    def drifts(self) -> bool:
        """Whether the robots' odometry does."""
        return self.odometry == DRIFTING


@dataclass(frozen=True)
class Report:
    """The result of one run.

    Attributes:
        name: of the experiment or benchmark.
        seed: of the run.
        worlds: seeds of the worlds.
        quick: whether it was a quick run.
        seconds: that the run took.
        rows: of the table.
        notes: to be read below the table.
        findings: numbers beside the table.
        map: name of the map's file, if it ran on one.
        made_from: fingerprints of the networks and the code, and the canary, see `provenance`.
    """

    name: str
    seed: int
    worlds: tuple[int, ...]
    quick: bool
    seconds: float
    rows: Rows
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    map: str = ""
    made_from: Mapping[str, Any] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        """Whether rows are missing since a class of the user's own failed."""
        return any(isinstance(note, Fault) for note in self.notes)

    def finding(self, what: str) -> Finding:
        """What it found of that name.

        Raises:
            LookupError: when it found nothing of the name.
        """
        found = {finding.what: finding for finding in self.findings}
        if what not in found:
            raise LookupError(f"its findings lack {what!r}")
        return found[what]

    def as_dict(self) -> dict[str, Any]:
        """For JSON, in which a number that is not finite becomes None."""
        findings = [asdict(finding) for finding in self.findings]
        return asdict(self) | {"rows": finite(self.rows), "findings": finite(findings)}

    def as_text(self) -> str:
        """A table to read; lists are only in the JSON."""
        keys = [key for key, value in self.rows[0].items() if not isinstance(value, list)]
        cells = [keys, *([_shown(row[key]) for key in keys] for row in self.rows)]
        widths = [max(len(line[i]) for line in cells) for i in range(len(keys))]
        lines = ["  ".join(c.rjust(w) for c, w in zip(line, widths, strict=True)) for line in cells]
        lines.insert(1, "  ".join("-" * width for width in widths))
        lines += [finding.line for finding in self.findings]
        return "\n".join([*lines, *self.notes, f"({self.name}: {self.seconds:.0f} s)"])


def parse_worlds(text: str) -> tuple[int, ...]:
    """World seeds from "A:B", which means A to B - 1."""
    try:
        first, last = (int(part) for part in text.split(":"))
    except ValueError:
        first, last = 0, 0
    if not 0 <= first < last:
        raise argparse.ArgumentTypeError(f"{text!r}: give A:B with 0 <= A < B, as in 20000:20020")
    if last - first > MOST_WORLDS:
        raise argparse.ArgumentTypeError(f"{text!r}: give at most {MOST_WORLDS:,} worlds")
    return tuple(range(first, last))


def finite(rows: Rows) -> Rows:
    """Rows for JSON: a number that is not finite becomes None."""
    return [{key: _finite(value) for key, value in row.items()} for row in rows]


def _finite(value: Any) -> Any:  # noqa: ANN401 - any value of a row
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _shown(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    return str(value)
