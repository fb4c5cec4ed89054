"""What Lifelong Topological Visual Navigation shows and claims, beside what is measured here."""

from __future__ import annotations

from tutorial_lib.experiments.results_page.compared_meng import DIAGRAM, NOTHING
from tutorial_lib.experiments.results_page.markdown import link, number, percent
from tutorial_lib.experiments.results_page.sources import Results, one

READS = ("ltvn_label", "ltvn_model", "ltvn_lifelong", "ltvn_spurious")
"""Reports that the rows are made from."""
QUERIES, SPOILT = "Hundreds of queries", "Spurious and missing edges"


def lines(results: Results) -> list[list[str]]:
    """A line for each figure and claim: name, the paper, here, trend."""
    label = one(results.rows("ltvn_label"), term="label", holds=True)
    return [
        [
            "Figs. 1, 3 and 4",
            "an interface with image goals, the framework, its parts",
            DIAGRAM,
            NOTHING,
        ],
        [
            "Fig. 2",
            "a spurious edge goes, a vertex is added",
            "notebook 08, § 8, draws which edges were pruned",
            "one example",
        ],
        [
            link("LTVN's label", "Fig. 5"),
            "reachable and other pairs",
            f"notebook 08, § 1; of the pairs with the label {percent(label['arrives'])} are "
            f"reached by the controller",
            NOTHING,
        ],
        ["Algorithm 1", "a graph by sampling", "notebook 08, § 3, builds it", "the same algorithm"],
        *_sizes(results),
        *_updates(results),
        [
            "fine-tuning",
            "with the drives of the target building",
            "not built",
            "nothing to compare",
        ],
    ]


def _sizes(results: Results) -> list[list[str]]:
    rows = results.rows("ltvn_lifelong")
    first = {"block": 0, "family": "others", "perception": "network"}
    names = {"frozen": "LTVN", "sptm": "SPTM", "ving": "ViNG", "meng": "Meng"}
    found = {name: one(rows, agent=name, **first) for name in names}
    sizes = ", ".join(
        f"{names[name]} {number(row['vertices'], 0)} vertices and {percent(row['success'])}"
        for name, row in found.items()
    )
    frozen, meng, others = found["frozen"], found["meng"], (found["sptm"], found["ving"])
    sparser = all(frozen["vertices"] < other["vertices"] for other in others)
    better = all(frozen["success"] > other["success"] for other in others)
    trend = (
        "as in the paper"
        if sparser and better
        else (
            f"{'sparser' if sparser else 'not sparser'} than both maps, "
            f"{'more' if better else 'not more'} success"
        )
    )
    if meng["vertices"] < frozen["vertices"]:
        trend += "; Meng's map, with which the paper does not compare, is sparser still"
    return [
        [
            link(QUERIES, "sparser, and better"),
            "sparser graphs and higher success than SPTM's and ViNG's",
            f"before updates: {sizes}",
            trend,
        ]
    ]


def _updates(results: Results) -> list[list[str]]:
    rows, spoilt = results.rows("ltvn_lifelong"), results.rows("ltvn_spurious")
    last = max(row["block"] for row in rows)
    shown = []
    for family in ("others", "loop_corridor"):
        same = {"agent": "ltvn", "perception": "network", "family": family}
        ends = [percent(one(rows, block=block, **same)["success"]) for block in (0, last)]
        shown.append(" to ".join(ends))
    frozen = one(rows, agent="frozen", perception="network", family="others", block=last)
    now = one(rows, agent="ltvn", perception="network", family="others", block=last)
    trend = (
        f"in the end {percent(1.0 - now['success'])} of the queries fail, without updates "
        f"{percent(1.0 - frozen['success'])}; most of it is won within the first block, whose "
        "robots share the map"
    )
    end = max(row["block"] for row in spoilt)
    share = max(row["share"] for row in spoilt)
    mended = {"share": share, "updates": "on", "perception": "network", "family": "others"}
    begins, ends = (one(spoilt, block=block, **mended) for block in (0, end))
    frozen = one(spoilt, block=end, **(mended | {"updates": "off"}))
    return [
        [
            link(QUERIES, "updates"),
            "success rises with the number of queries",
            f"from the first block to the last {shown[0]}, in loop corridors {shown[1]}",
            trend,
        ],
        [
            link(SPOILT, "spurious edges"),
            "updates eliminate them",
            f"with {percent(share, 0)} of the edges spoilt {percent(begins['success'])} to "
            f"{percent(ends['success'])}, without updates {percent(frozen['success'])} in the end; "
            f"{percent(ends['injected_gone'], 0)} of the injected edges that were tried often are "
            f"gone",
            f"they are eliminated; clean maps of {results.worlds('ltvn_lifelong')} buildings have "
            f"{percent(now['success'])}",
        ],
    ]
