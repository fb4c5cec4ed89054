"""The leaderboard: which experiment judges a class, and a file of entries that can be merged."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from statistics import fmean
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from tutorial_lib.errors import InputError, one_line
from tutorial_lib.experiments.common.experiment import Experiment, library_hash
from tutorial_lib.experiments.common.own import load_own
from tutorial_lib.experiments.common.report import Fault, Options, Rows, finite
from tutorial_lib.experiments.failures import (
    Trip,
    of_exploring,
    of_local_control,
    of_navigation,
    of_visits,
)
from tutorial_lib.experiments.meng2020 import table1, table2
from tutorial_lib.experiments.nts import table1 as nts_table1
from tutorial_lib.experiments.race import ten_visits
from tutorial_lib.interfaces import SequentialExplorer
from tutorial_lib.reading.documents import read_json

SUCCESS, SPL = ("success", "low", "high"), ("spl", "spl_low", "spl_high")
LONGEST = 300
"""Characters of a name."""


@dataclass(frozen=True)
class Contest:
    """How an experiment judges a class of one's own.

    Attributes:
        experiment: with settings and quick ones; its canary is the first try.
        names: the field of its settings that names its rows; the user's own is there besides.
        column: that has these names.
        cases: the columns that tell the rows of one name apart.
        score: the column that counts, as mean over the cases, and those of its interval.
        references: names of the rows that stand beside one's own.
        failures: gives trips in one world that missed their goals; also gets options and settings.
        options: of every run.
        only: what the rows that count have in some columns.
    """

    experiment: Experiment
    names: str
    column: str
    cases: tuple[str, ...]
    score: tuple[str, str, str]
    references: tuple[str, ...]
    failures: Callable[[int, Options, Any], Iterator[Trip]]
    options: Options = field(default_factory=Options)
    only: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Of the experiment."""
        return self.experiment.name

    def refer(self, *, quick: bool) -> list[Entry]:
        """Run the references; what a killed run had finished is not run again."""
        size = "quick_settings" if quick else "settings"
        chosen = replace(getattr(self.experiment, size), **{self.names: self.references})
        options = replace(self.options, quick=quick)
        report = replace(self.experiment, **{size: chosen}).report(options)
        return [
            Entry(
                experiment=self.name,
                name=name,
                sha=library_hash(),
                quick=quick,
                worlds=report.worlds,
                rows=self.kept(report.rows, {self.column: name}),
            )
            for name in self.references
        ]

    def kept(self, rows: Rows, named: Mapping[str, str] | None = None) -> Rows:
        """What the board keeps of the rows that count."""
        wanted = {**self.only, **(named or {})}
        return [
            {column: row[column] for column in (*self.cases, *self.score)}
            for row in finite(rows)
            if all(row[column] == value for column, value in wanted.items())
        ]


LOCAL = Contest(
    replace(table1.EXPERIMENT, quick_worlds=table1.WORLDS[:4]),
    *("controllers", "controller", ("condition",), SUCCESS),
    ("oracle", "k5", "direct", "random"),
    of_local_control,
)
NAVIGATION = Contest(
    replace(table2.EXPERIMENT, canary=table2.Settings(places=3, trials_of_part=2)),
    *("methods", "method", ("world",), SUCCESS),
    ("oracle", "meng", "sptm", "random"),
    of_navigation,
    Options(drives=table2.QUICK_DRIVES),  # with all of them nearly every agent arrives
)
EXPLORING = Contest(
    replace(
        nts_table1.EXPERIMENT,
        quick_worlds=nts_table1.WORLDS[:3],
        settings=nts_table1.Settings(rgb=()),
        canary=nts_table1.Settings(1, rgb=()),
    ),
    *("rgbd", "agent", ("signs", "difficulty"), SPL),
    ("oracle", "nts", "fbe", "random"),
    of_exploring,
)
VISITS = Contest(
    ten_visits.EXPERIMENT,
    *("agents", "agent", ("visits",), SUCCESS),
    ("combined", "nts_forgets", "random_forgets", "oracle"),
    of_visits,
    only={"visits": "1-10"},
)
CONTESTS = {one.name: one for one in (LOCAL, NAVIGATION, EXPLORING, VISITS)}
SEAMS = {
    "agent": NAVIGATION,
    "explorer": EXPLORING,  # one with `look_for`: VISITS
    "planner": NAVIGATION,
    "localizer": NAVIGATION,
    "reachability": NAVIGATION,
    "predictor": LOCAL,
    "local controller": LOCAL,
    "controller": LOCAL,
}
"""What judges a class, by what it is; of several that fit the first counts."""


def judged(where: str, *, quick: bool, first: bool) -> dict[str, Any]:
    """What a class is, what judges it, and the rows of a run of it alone; fields of an `Entry`.

    Beside these a "failure", the worst one as `Trip.stored`, except of the first try.

    Args:
        where: "FILE.py:CLASS".
        quick: fewer worlds and episodes.
        first: only a few episodes in one world.

    Raises:
        InputError: as `load_own` does.
    """
    seam, part = load_own(where, tuple(SEAMS))
    remembers = seam == "explorer" and isinstance(part, SequentialExplorer)
    contest = VISITS if remembers else SEAMS[seam]
    run, found = contest.experiment, {"seam": seam, "experiment": contest.name}
    settings = run.canary if first else run.quick_settings if quick else run.settings
    worlds = (run.quick_worlds if quick else run.worlds)[: 1 if first else None]
    options = replace(contest.options, quick=quick, worlds=worlds, agent=where)
    alone = replace(settings, **{contest.names: ()})
    try:
        rows, notes = run.run(options, alone)
    except InputError as error:
        return {**found, "fault": str(error)}
    for fault in (note for note in notes if isinstance(note, Fault)):
        return {**found, "fault": str(fault)}
    found |= {"worlds": worlds, "rows": contest.kept(rows)}
    if first:
        return found
    trips = contest.failures(worlds[0], options, alone)
    worst = max(trips, key=lambda trip: trip.gap, default=None)
    return found if worst is None else {**found, "failure": worst.stored}


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What became of a class, or of a reference.

    Attributes:
        experiment: that judged it; empty if nobody knows what the class is.
        seam: what it is, of `SEAMS`; empty for a reference.
        name: FILE.py:CLASS without the folder, or that of a reference.
        sha: SHA-256 of its file, or of the library; empty if the file cannot be read.
        quick: whether it was a quick run.
        worlds: seeds of the worlds.
        rows: a case each.
        fault: how it failed, in one line; then there are no rows.
    """

    experiment: str = ""
    seam: str = ""
    name: str
    sha: str
    quick: bool
    worlds: tuple[int, ...] = ()
    rows: Rows = field(default_factory=list)
    fault: str = ""

    @property
    def score(self) -> float:
        """The mean over the cases of what counts."""
        return fmean(row[CONTESTS[self.experiment].score[0]] for row in self.rows)

    @property
    def run(self) -> tuple[Any, ...]:
        """What entries have in common that can be compared."""
        columns = CONTESTS[self.experiment].cases
        cases = tuple(", ".join(str(row[name]) for name in columns) for row in self.rows)
        return self.experiment, self.quick, self.worlds, cases


def merged(entries: Iterable[Entry]) -> list[Entry]:
    """Every entry once, in an order that does not depend on the one given."""
    found = {json.dumps(asdict(entry), sort_keys=True): entry for entry in entries}
    return [found[key] for key in sorted(found)]


def text_of(entries: Iterable[Entry]) -> str:
    """A board as JSON."""
    lines = [asdict(entry) for entry in merged(entries)]
    return json.dumps({"version": 1, "entries": lines}, indent=1) + "\n"


def read_board(path: Path) -> list[Entry]:
    """The entries of a file.

    Raises:
        InputError: naming the file and what is wrong in it.
    """
    advice = "give a file that leaderboard wrote"
    board = read_json(path, advice)
    try:
        if set(board) != {"version", "entries"} or board["version"] != 1:
            raise InputError("version: give 1, and entries")
        return merged([_entry(f"entries[{i}]", one) for i, one in enumerate(board["entries"])])
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: no leaderboard ({error}); {advice}") from error


def _entry(where: str, given: dict[str, Any]) -> Entry:
    """An entry of which every field is checked."""
    if set(given) != {one.name for one in fields(Entry)}:
        raise InputError(f"{where}: has other fields than an entry")
    name, worlds, rows, fault = (given[one] for one in ("name", "worlds", "rows", "fault"))
    contest = CONTESTS.get(given["experiment"])
    fits = {
        "experiment": contest is not None or given["experiment"] == "",
        "seam": given["seam"] in ("", *SEAMS),
        "name": isinstance(name, str) and name == one_line(name, LONGEST) != "",
        "sha": re.fullmatch(r"([0-9a-f]{64})?", given["sha"]) is not None,
        "quick": isinstance(given["quick"], bool),
        "worlds": isinstance(worlds, list) and all(type(seed) is int for seed in worlds),
        "rows": isinstance(rows, list)
        and all(contest is not None and _is_row(row, contest) for row in rows),
        "fault": isinstance(fault, str) and fault == one_line(fault) and bool(fault) != bool(rows),
    }
    wrong = [name for name, good in fits.items() if not good]
    if wrong:
        raise InputError(f"{where}: {', '.join(wrong)} cannot be right")
    checked: dict[str, Any] = {**given, "worlds": tuple(worlds)}
    return Entry(**checked)


def _is_row(row: dict[str, Any], contest: Contest) -> bool:
    """Whether a row has the columns that count, and shares in them."""
    if set(row) != {*contest.cases, *contest.score}:
        return False
    known = [row[name] for name in contest.score if row[name] is not None]
    named = all(type(row[name]) in (str, int) for name in contest.cases)
    shares = all(type(one) in (int, float) and 0 <= one <= 1 for one in known)
    return named and shares and row[contest.score[0]] is not None


def ranked(entries: Iterable[Entry]) -> dict[tuple[Any, ...], list[Entry]]:
    """By seam and run the entries with a score, references among them, the best first."""
    best = sorted((one for one in entries if one.rows), key=lambda one: -one.score)
    keys = sorted({(one.seam, *one.run) for one in best if one.seam})
    return {
        (seam, *run): [one for one in best if one.seam in ("", seam) and one.run == (*run,)]
        for seam, *run in keys
    }


def page_of(entries: Iterable[Entry]) -> str:
    """A board as a page of HTML that needs no other file."""
    entries = merged(entries)
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("leaderboard.html.j2").render(
        tables=ranked(entries), contests=CONTESTS, faults=[one for one in entries if one.fault]
    )
