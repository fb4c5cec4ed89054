"""Table II where it separates the methods: maps of a part of the drives."""

from __future__ import annotations

from tutorial_lib.experiments.protocols.drives import CONTINUOUS, TOUR
from tutorial_lib.experiments.results_page.markdown import listed, number, percent, table
from tutorial_lib.experiments.results_page.navigation import METHODS, thresholds
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import (
    DRIVES,
    HARDER,
    LEARNED,
    Results,
    goal_words,
    matching,
    stored_as,
)
from tutorial_lib.topology.mapping.turn_edges import TurnSettings

SHOWN = {TOUR: "a tour", CONTINUOUS: "a tour in one drive"}
"""How drives are called that are no share."""


def shown(drives: str) -> str:
    """What was learned, to read.

    >>> shown("0.2"), shown("tour")
    ('20%', 'a tour')
    """
    return SHOWN.get(drives) or percent(float(drives), 0)


def composed_trials(results: Results, names: dict[str, str]) -> str:
    """Success in composed trials for what was learned, over all worlds of each report.

    Args:
        results: the reports.
        names: of the reports, by what is written in the first column.
    """
    lines = []
    for label, name in names.items():
        rows = matching(results.rows(name), method="meng")
        cells = [results.note(name, f"{method}, composed: ") for method in METHODS]
        known = [row for row in rows if row["success_driven"] is not None]
        trials = [row["trials"] - row["trials_composed"] for row in known]
        sure = sum(n * row["success_driven"] for n, row in zip(trials, known, strict=True))
        lines.append(
            [
                label,
                f"{sum(row['trials_composed'] for row in rows):,}",
                *cells,
                results.note(name, "meng - sptm, composed: "),
                percent(sure / sum(trials)) if sum(trials) else "",
                results.note(name, "goals, composed: ").split(" ")[0],
            ]
        )
    head = ["learned", "trials", *METHODS.values(), "Meng - SPTM", "Meng, driven", "goals passed"]
    return table(head, lines)


def map_sizes(results: Results, names: dict[str, str]) -> str:
    """Images and size of the maps, on average over the worlds of each report."""
    lines = []
    for label, name in names.items():
        cells = []
        for method in ("meng", "sptm"):
            rows = matching(results.rows(name), method=method)
            means = [sum(row[key] for row in rows) / len(rows) for key in ("vertices", "edges")]
            cells += [number(mean, 0) for mean in means]
            cells.append(f"{sum(row['wormholes'] for row in rows):,}")
        images = sum(row["images"] for row in rows) / len(rows)
        lines.append([label, number(images, 0), *cells])
    head = ["learned", "images", "Meng: vertices", "edges", "wormholes in all"]
    return table([*head, "SPTM: vertices", "edges", "wormholes in all"], lines)


def _composing_section(results: Results) -> list[str]:
    names = {shown(drives): stored_as(drives) for drives in LEARNED}
    worlds = results.worlds(stored_as(DRIVES[0]))
    hidden = results.note("meng_table2", "driven: ").split(" of the trials")[0]
    return [
        f"The protocol of Table II above has a blind spot: every ordered pair of places was "
        f"driven, so that in {hidden} of its trials some recorded drive passes the start and "
        f"later the goal, and an agent that only repeats drives succeeds. Here all agents learn "
        f"the same part of the drives: a share of them, or a tour (each place to the next and "
        f"back, as separate drives, or as one with the car's own turns in it). Trials that no "
        f"learned drive covers must be *composed* of several. {worlds} test worlds, the same "
        f"trials for all; intervals are bootstrapped over worlds, differences are paired. "
        f"{_goals_of(results, names | {'a tour, harder trials': HARDER})}",
        composed_trials(results, names | {"a tour, harder trials": HARDER}),
        f"Harder trials start anywhere instead of at the places, and of all images of a place the "
        f"goal is the one that looks most unlike what the robot would see on arrival. The oracle "
        f"arrives as it comes and does not turn to the goal's heading, so a map may do better. "
        f"*Meng, driven* are the other trials; *goals passed* is the share of the composed ones "
        f"whose goal some learned drive passes as it looks: of the others no map has an image. "
        f"Where drives meet that look opposite ways, no two images have anything in common; Meng's "
        f"map joins them by turning (p = {TurnSettings().p_turn:g} each), where scans and colours "
        f"say that the place is the same. The thresholds of both maps were chosen for each share "
        f"on validation worlds; for the tour in one drive they are those of the tour.",
        map_sizes(results, names),
    ]


def _thresholds_section(results: Results) -> list[str]:
    tables = []
    for drives in DRIVES:
        name = stored_as(drives, "thresholds")
        best = results.note(name, f"best with --drives {drives}: ")
        tables += [
            f"{shown(drives)[0].upper()}{shown(drives)[1:]}: best {best}.",
            chosen(results, name),
        ]
    return [
        f"Thresholds for each share, chosen on {results.worlds(stored_as('0.2', 'thresholds'))} "
        f"validation worlds by success in composed trials: p_edge of RE for Meng, similarity for "
        f"SPTM.",
        *tables,
    ]


def chosen(results: Results, name: str) -> str:
    """Success by threshold, with that in composed trials behind it."""
    rows = results.rows(name)
    lines = thresholds(rows).splitlines()
    shares = (f" {percent(row['success_composed'])} " for row in rows)
    more = [" composed ", "---", *shares]
    return "\n".join(f"{line}{cell}|" for line, cell in zip(lines, more, strict=True))


def _goals_of(results: Results, names: dict[str, str]) -> str:
    """What showed the goals, by what was learned."""
    said: dict[str, list[str]] = {}
    for label, name in names.items():
        said.setdefault(goal_words(results.rows(name)), []).append(label)
    if len(said) == 1:
        return next(iter(said))
    return " ".join(f"{listed(labels).capitalize()}: {words}" for words, labels in said.items())


SECTIONS = (
    Section(
        "Table II: a part of the drives",
        (*(stored_as(drives) for drives in LEARNED), HARDER),
        _composing_section,
    ),
    Section(
        "Table II: thresholds for a part of the drives",
        tuple(stored_as(drives, "thresholds") for drives in DRIVES),
        _thresholds_section,
    ),
)
