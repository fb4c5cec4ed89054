"""Tables of places that look alike: remedies (Fig. 12 of Meng 2020), and the filter alone."""

from tutorial_lib.experiments.common.report import Finding
from tutorial_lib.experiments.common.statistics import difference
from tutorial_lib.experiments.meng2020.fig12_localization import FOUND, NOTICED, RIGHT, SURE
from tutorial_lib.experiments.protocols.navigation import WORMHOLE
from tutorial_lib.experiments.results_page.markdown import Row, points, table
from tutorial_lib.experiments.results_page.sources import Results
from tutorial_lib.experiments.results_page.tables import (
    Best,
    column,
    listing,
    named,
    one,
    share,
    success,
    table_of,
)

NAMES = {
    "none": "none",
    **{name: f"{name} alone" for name in ("sequence", "replan", "cycles", "filter")},
    **{f"no_{name}": f"all but {name}" for name in ("sequence", "replan", "cycles", "filter")},
    "all": "all",
}
"""How the choices of remedies are called."""
SHOWN_CASES = {
    "driven": "driven",
    "doors": "driven, in a corridor with a twin",
    "standstill": "standing still",
    "kidnapped": "carried to another room",
}
"""How the cases of the filter are called."""
SHARES = {
    "right": f"within {RIGHT:g} m",
    "sure": f"sure (belief ≥ {SURE:g})",
    "right_if_sure": "right where sure",
    "changes_at_most_once": "vertex changes at most once",
    "noticed": f"noticed within {NOTICED:g} s",
    "found": f"localized again within {FOUND:g} s",
}
"""Columns of the table of the filter."""
ELSEWHERE = {
    "all drives": ("meng_table2", "meng_table2_remedies"),
    "20% of the drives": ("meng_table2_drives_02", "meng_table2_remedies_02"),
}
"""Reports on Table II, without the remedies and with them, by what was learned."""


def success_by_remedy(results: Results) -> str:
    """Success, the map, and how the other trials ended, for every choice of remedies."""

    def compared(row: Row) -> str:
        name = row["remedy"]
        whole = "all" if name.startswith("no_") else "none"
        if name == whole:
            return ""
        gap = results.finding("meng_fig12", f"{name} - {whole}")
        return f"{_number(str(gap))} against *{whole}*"

    return listing(
        named(results.rows("meng_fig12"), "remedy", NAMES),
        ("remedies", "{name}"),
        ("success", Best(success, "success")),
        ("points", compared),
        ("vertices", "{vertices:,}"),
        (f"edges over {WORMHOLE:g} m", "{wormholes:,} of {edges:,}"),
        ("arrived elsewhere", "{wrong_place:.1%}"),
        ("gave up", "{gave_up:.1%}"),
        ("stuck", "{stuck:.1%}"),
        ("out of time", "{late:.1%}"),
        ("in circles", "{circled:.1%}"),
    )


filter_by_case = table_of(
    ("case", "{name}"),
    ("count", "{count:,}"),
    *((words, share(key)) for key, words in SHARES.items()),
    names=("case", SHOWN_CASES),
)
"""What the filter believed, a line for each case."""


def success_elsewhere(results: Results) -> str:
    """Success in Table II without the remedies and with all, of the same trials."""
    lines = []
    for learned, names in ELSEWHERE.items():
        without, remedied = (results.rows(name, method="meng") for name in names)
        before = column(without, "success")
        after = [one(remedied, world=row["world"])["success"] for row in without]
        gaps = [late - early for early, late in zip(before, after, strict=True)]
        gap = Finding(learned, *difference(after, before, range(len(gaps))))
        lines.append(
            [
                learned,
                str(results.worlds(names[0])),
                *(str(results.finding(name, "meng, all worlds")) for name in names),
                _number(str(gap)),
                f"{_number(points(min(gaps)))} to {_number(points(max(gaps)))}",
            ]
        )
    return table(["learned", "worlds", "without", "with all", "points", "by world"], lines)


def _number(gap: str) -> str:
    return gap.replace(" points", "")
