"""Maps that mend themselves (LTVN): label, model, many queries, spoilt maps."""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.ltvn.model import APART, FAR, FAR_RATE
from tutorial_lib.experiments.ltvn.spurious import TRIED
from tutorial_lib.experiments.results_page.markdown import interval, number, percent, table
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, matching, one

FAMILIES = {"others": "apartments and offices", "loop_corridor": "loop corridors"}
"""How families are called on the page."""
AGENTS = {
    "ltvn": "LTVN",
    "frozen": "its map as it was built",
    "ving": "ViNG",
    "sptm": "SPTM",
    "meng": "Meng",
    "meng_mending": "Meng's map, kept up to date",
    "oracle": "oracle",
}
"""How agents are called on the page."""
_TERMS = {
    "all": "all pairs within 3 m",
    "overlap": "views overlap",
    "ratio": "path about straight",
    "sight": "target in sight",
    "bearing": "target ahead",
    "yaw": "turned by less than 60 degrees",
    "arc": "near one arc",
    "label": "all of these but the arc: the label",
    "label, arc": "the label, and near one arc",
}


def _label_section(results: Results) -> list[str]:
    rows = results.rows("ltvn_label")
    lines = []
    for term, words in _TERMS.items():
        yes = one(rows, term=term, holds=True)
        no = matching(rows, term=term, holds=False)
        cells = [f"{yes['pairs']:,}", _end(yes, "arrives"), _end(yes, "faces")]
        cells += [_end(no[0], end) if no else "" for end in ("arrives", "faces")]
        lines.append([words, *cells])
    return [
        f"LTVN labels a pair of images by geometry, where Meng 2020 drives. Pairs within 3 m of "
        f"{results.worlds('ltvn_label')} test worlds were driven to their true position: how many "
        f"cars arrive within 0.3 m, and how many of them face as the target does, within 60 "
        f"degrees, where a condition holds and where it does not.",
        table(
            ["condition", "pairs", "holds: arrive", "and face so", "else: arrive", "and face so"],
            lines,
        ),
    ]


def _end(row: dict, end: str) -> str:
    return interval(row, end, f"{end}_low", f"{end}_high")


def _model_section(results: Results) -> list[str]:
    rows = results.rows("ltvn_model")
    lines = []
    for row in rows:
        cells = [number(row["threshold"]), percent(row["recall"]), f"{row['far_rate']:.3%}"]
        cells += [percent(row["precision"]), percent(row["far_share"], 2)]
        errors = f"{row['waypoint_error']:.3f} m, {row['yaw_error']:.1f} degrees"
        name = FAMILIES[row["family"]]
        lines.append([row["gate"], name, *cells, errors, number(row["ece"])])
    return [
        f"Which pairs of a tour's images, {APART:g} m apart, the model calls reachable in "
        f"{results.worlds('ltvn_model')} test worlds. A gate's threshold accepts "
        f"{FAR_RATE:.2%} of the pairs more than {FAR:g} m apart in validation worlds. *Mined* "
        f"compares single images, as the paper does, and has learned from false pairs of the same "
        f"buildings; *context* sees the target's neighbours on its drive, too; *depth* and "
        f"*support* also ask that depths agree after the predicted motion, and that images "
        f"between the two do.",
        table(
            [
                *("gate", "worlds", "threshold", "reachable found", "far accepted", "precision"),
                *("far among accepted", "waypoint, median error", "ECE"),
            ],
            lines,
        ),
        "ECE is of the gate's score: a gate that closes sets it to 0, which is no calibration.",
    ]


def _lifelong_section(results: Results) -> list[str]:
    rows = results.rows("ltvn_lifelong")
    lines = []
    for row in matching(rows, block=0):
        same = {key: row[key] for key in ("agent", "perception", "family")}
        blocks = matching(rows, **same)
        end = blocks[-1]
        perception = "" if row["vertices"] is None else row["perception"]
        cells = [
            interval(row, "success"),
            str(len(blocks) * count_of(row)),
            interval(end, "success"),
        ]
        lines.append(
            [AGENTS[row["agent"]], perception, FAMILIES[row["family"]], *cells, *_sizes(end)]
        )
    count = count_of(rows[0])
    notes = [note for note in results.reports["ltvn_lifelong"].notes if ": ltvn - " in note]
    return [
        f"Each of {results.worlds('ltvn_lifelong')} test buildings is toured once; all agents get "
        f"the same queries, and fleets of 25 robots use and mend one map. *Oracle* perception has "
        f"the true label and waypoint in place of the network. Agents whose maps do not change "
        f"have only the first queries, as the column says.",
        table(
            [
                *("agent", "perception", "worlds", f"first {count} queries", "queries"),
                *(f"the last {count} of them", "vertices", "edges", "longer than 5 m"),
            ],
            lines,
        ),
        "Success by blocks of queries, with updates and without:",
        _blocks(rows),
        "Paired differences, 95 % intervals over worlds:",
        "\n".join(f"- {note}" for note in notes),
    ]


def _blocks(rows: Rows) -> str:
    """Success of the agents that run all queries, block by block."""
    last = max(row["block"] for row in rows)
    lines = []
    for end in matching(rows, block=last):
        same = {key: end[key] for key in ("agent", "perception", "family")}
        cells = [percent(one(rows, block=block, **same)["success"], 0) for block in range(last + 1)]
        lines.append([AGENTS[end["agent"]], FAMILIES[end["family"]], *cells])
    count = count_of(rows[0])
    head = [f"to {count * (block + 1)}" for block in range(last + 1)]
    return table(["agent", "worlds", *head], lines)


def count_of(row: dict) -> int:
    """Queries of one block in one world."""
    return row["queries"] // row["worlds"]


def _sizes(row: dict) -> list[str]:
    return [number(row[name], 0) for name in ("vertices", "edges")] + [number(row["wormholes"], 1)]


def _spurious_section(results: Results) -> list[str]:
    rows = results.rows("ltvn_spurious")
    return [
        f"The same with spoilt maps: before the first query a share of the edges is taken out, and "
        f"as many are added between vertices more than 5 m apart, with the beliefs and lengths of "
        f"true ones. {results.worlds('ltvn_spurious')} test worlds; success by blocks of 50 "
        f"queries.",
        spurious(rows),
        f"*Injected, gone*: of those that were tried {TRIED} times or more. *True, pruned*: of all "
        f"edges that were there before, at the end.",
    ]


def spurious(rows: Rows) -> str:
    """Success by block, for each share, with and without updates."""
    blocks = sorted({row["block"] for row in rows})
    lines = []
    for row in matching(rows, block=0):
        same = {key: row[key] for key in ("share", "updates", "perception", "family")}
        found = [one(rows, block=block, **same) for block in blocks]
        cells = [percent(found[i]["success"]) for i in range(len(blocks))]
        end = found[-1]
        cells += [percent(end["injected_gone"], 0), percent(end["true_pruned"])]
        lines.append([percent(row["share"], 0), row["updates"], FAMILIES[row["family"]], *cells])
    head = [f"{50 * block + 1} to {50 * (block + 1)}" for block in blocks]
    return table(["spoilt", "updates", "worlds", *head, "injected, gone", "true, pruned"], lines)


SECTIONS = (
    Section("LTVN's label", ("ltvn_label",), _label_section),
    Section("LTVN's model", ("ltvn_model",), _model_section),
    Section("Hundreds of queries", ("ltvn_lifelong",), _lifelong_section),
    Section("Spurious and missing edges", ("ltvn_spurious",), _spurious_section),
)
