"""Where the numbers come from: the stored reports and the commands that make them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Finding, Report, Rows
from tutorial_lib.experiments.common.results import FOLDER, load_result
from tutorial_lib.experiments.protocols.drives import CONTINUOUS, TOUR
from tutorial_lib.experiments.protocols.navigation import CLIP, ONE
from tutorial_lib.experiments.results_page.markdown import Row, percent
from tutorial_lib.experiments.results_page.tables import matching, one

MAPS = ("depot", "tb3_sandbox", "warehouse")
"""Occupancy grids that come with Nav2 (`nav2_bringup/maps`)."""
OTHER_FAMILIES = ("hall", "scanned")
"""Of generated worlds, beside those by seed."""
EXPLORING = ("scores", "table1", "table2", "fig8", "figs", "second_visit")
"""Experiments of exploration."""
LIFELONG = ("label", "model", "finetune", "size", "lifelong", "spurious", "change")
"""Experiments of maps that mend themselves."""
LIVES = ("parts", "meng")
"""Ablations of hundreds of queries."""
RACES = ("exact", "car", "toured", "carried", "changed", "ingredients")
"""Ablations of the race."""
BENCHMARKS = ("map", "control", "reachability", "raycast", "fleet", "explore")
DRIVES = ("0.2", "0.4", TOUR)
"""Of Table II: what agents learn, beside all drives, with thresholds chosen for each."""
LEARNED = (*DRIVES, CONTINUOUS)
"""Whatever Table II is measured with, beside all drives; one drive has the tour's thresholds."""
HARDER = "meng_table2_anywhere"
"""The report on Table II after a tour with harder trials."""


def stored_as(drives: str, ablation: str = "") -> str:
    """The name of the report on Table II, or an ablation of it, with `--drives`.

    >>> stored_as("0.2"), stored_as("tour", "thresholds")
    ('meng_table2_drives_02', 'meng_table2_thresholds_tour')
    """
    return f"meng_table2_{ablation or 'drives'}_{drives.replace('.', '')}"


WORLDS, SMOOTHING = "--worlds 20000:20010", "meng_table1 --ablation smoothing"
"""What several commands have in common."""
EXPERIMENTS = {
    "plans": "experiment plans",
    "nts_wayfinding": "experiment nts_wayfinding",
    "meng_table1": "experiment meng_table1",
    **{f"meng_table1_{name}": f"experiment meng_table1 --map {name}.yaml" for name in MAPS},
    **{
        f"meng_table1_{name}": f"experiment meng_table1 --family {name} {WORLDS}"
        for name in OTHER_FAMILIES
    },
    "ablation_smoothing": f"experiment {SMOOTHING}",
    "ablation_smoothing_hall": f"experiment {SMOOTHING} --family hall {WORLDS}",
    **{f"ablation_smoothing_{name}": f"experiment {SMOOTHING} --map {name}.yaml" for name in MAPS},
    "calibration": "experiment calibration --family all",
    "calibration_hall": "experiment calibration --family hall --worlds 20000:20006",
    **{f"meng_fig{n}": f"experiment meng_fig{n}" for n in (4, 5, 6, 7, 8, 9, 10, 11, 13)},
    "disturbances": "experiment disturbances",
    "meng_table2": "experiment meng_table2",
    "meng_table2_shifted": "experiment meng_table2 --palette shifted",
    **{f"meng_table2_{name}": f"experiment meng_table2 --map {name}.yaml" for name in MAPS},
    "meng_table2_goal_images": "experiment meng_table2 --ablation goal_images",
    "meng_table2_goal_images_tour": (
        "experiment meng_table2 --ablation goal_images --drives tour --worlds 10000:10003"
    ),
    "meng_table2_thresholds": "experiment meng_table2 --ablation thresholds",
    **{
        stored_as(drives): f"experiment meng_table2 {WORLDS} --drives {drives}"
        for drives in LEARNED
    },
    **{
        stored_as(drives, "thresholds"): (
            f"experiment meng_table2 --ablation thresholds --drives {drives}"
        )
        for drives in DRIVES
    },
    HARDER: f"experiment meng_table2 {WORLDS} --drives tour --starts anywhere --goals turned",
    "meng_fig12": "experiment meng_fig12",
    "meng_fig12_localization": "experiment meng_fig12 --ablation localization",
    "meng_table2_remedies": "experiment meng_table2 --remedies all",
    "meng_table2_remedies_02": f"experiment meng_table2 {WORLDS} --drives 0.2 --remedies all",
    "faults": "experiment faults",
    **{f"nts_{name}": f"experiment nts_{name}" for name in EXPLORING},
    **{f"ltvn_{name}": f"experiment ltvn_{name}" for name in LIFELONG},
    **{f"ltvn_lifelong_{name}": f"experiment ltvn_lifelong --ablation {name}" for name in LIVES},
    "nts_table1_car": "experiment nts_table1 --body car",
    "nts_table1_rules": "experiment nts_table1 --ablation rules",
    "nts_table2_rl": "experiment nts_table2 --ablation rl",
    "race": "experiment race",
    **{f"race_{name}": f"experiment race --ablation {name}" for name in RACES},
}
"""Arguments of ``python -m tutorial_lib`` by the name of the report."""
RETIRED = (
    *("calibration_mirror", "disturbances_patience", "meng_fig13_reuse"),
    *("nts_table1_options", "nts_fig8_options"),
    *("ablation_encoder", "ablation_worlds", "ablation_rows"),
)
"""Reports on what was tried and not kept: their code is gone, their sentences or tables stay."""
GONE = "Measured with an earlier library; no command of today measures it again"
"""What a section says of those it shows, beside their names."""
COMMANDS = EXPERIMENTS | {name: f"bench {name}" for name in BENCHMARKS}
"""The same, with those whose numbers are a machine's speed."""


@dataclass(frozen=True)
class Results:
    """The stored reports by name.

    Attributes:
        reports: by name.
        read: names of those that were asked for, in order.
    """

    reports: Mapping[str, Report]
    read: list[str] = field(default_factory=list)

    def report(self, name: str) -> Report:
        """A report, which counts as read.

        Raises:
            InputError: unless there is one of that name.
        """
        if name not in self.reports:
            raise InputError(f"{name}: the page has no such report")
        self.read.append(name)
        return self.reports[name]

    def rows(self, name: str, **values: Any) -> Rows:  # noqa: ANN401 - any value of a row
        """The rows of a report that have those values."""
        return matching(self.report(name).rows, **values)

    def row(self, name: str, **values: Any) -> Row:  # noqa: ANN401 - any value of a row
        """The only row of a report that has those values."""
        return one(self.report(name).rows, **values)

    def success(self, name: str, **values: Any) -> str:  # noqa: ANN401 - any value of a row
        """The share that succeeded in the only row of a report that has those values."""
        return percent(self.row(name, **values)["success"])

    def on_maps(self, name: str) -> dict[str, Rows]:
        """The rows of the reports that measured the same on maps from Nav2, by map."""
        return {place: self.rows(f"{name}_{place}") for place in MAPS}

    def on_each_map(self, name: str, **values: Any) -> list[str]:  # noqa: ANN401
        """The shares that succeeded in the only rows on those maps that have those values."""
        return [self.success(f"{name}_{place}", **values) for place in MAPS]

    def worlds(self, name: str) -> int:
        """The number of worlds of a report."""
        return len(self.report(name).worlds)

    def finding(self, name: str, what: str) -> Finding:
        """What a report found beside its rows.

        Raises:
            LookupError: when it found nothing of that name.
        """
        return self.report(name).finding(what)

    def findings(self, name: str) -> tuple[Finding, ...]:
        """All that a report found beside its rows."""
        return self.report(name).findings

    def note(self, name: str) -> str:
        """The first note of a report.

        Raises:
            LookupError: when it has none.
        """
        return self.report(name).notes[0]


def goal_words(rows: Rows) -> str:
    """What showed the goals in a report; those before there was a choice had clips.

    >>> goal_words([{"goal_images": "one"}])
    'A goal is one image.'
    """
    if rows[0].get("goal_images", CLIP) == ONE:
        return "A goal is one image."
    return "A goal is a clip here: the images of the last 1.5 s of a drive to it."


def load_results(folder: Path = FOLDER) -> Results:
    """Load every report of which the page tells.

    Raises:
        InputError: naming a missing or damaged file and the command that makes it.
    """
    found = {}
    for name in (*COMMANDS, *RETIRED):
        path = folder / f"{name}.json"
        if not path.is_file():
            raise InputError(f"{path}: there is no such file; {remedy(name)}")
        try:
            found[name] = load_result(name, folder)
        except InputError as error:
            raise InputError(f"{error}, or {remedy(name)}") from error
    return Results(found)


def command_of(name: str) -> str:
    """The command line that makes a report."""
    kept = f"tutorial_lib/results/{name}.json"
    return f".venv/bin/python -m tutorial_lib {COMMANDS[name]} --json {kept}"


def remedy(name: str) -> str:
    """What to do about a report that is missing or damaged."""
    return "restore it" if name in RETIRED else f"make it with: {command_of(name)}"
