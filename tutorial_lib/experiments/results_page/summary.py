"""The results in short: the table of the project's README."""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page import paper
from tutorial_lib.experiments.results_page.markdown import number, percent, span, table
from tutorial_lib.experiments.results_page.navigation import total
from tutorial_lib.experiments.results_page.sources import MAPS, Results, one, stored_as

HEAD = ("measured", "here", "beside it", "in the paper")
_BESIDE = {"none": "none", "replan": "replanning alone"}  # remedies, and their words


def results_in_short(results: Results) -> str:
    """A line for each main result, unfavourable ones included."""
    on_maps = {name: results.rows(f"meng_table1_{name}") for name in MAPS}
    places = {name: results.rows(f"meng_table2_{name}") for name in MAPS}
    lines = [
        local_control(results.rows("meng_table1")),
        local_control_on_maps(on_maps),
        reachability(results.rows("calibration")),
        cover_rate(results.rows("meng_fig7")),
        navigation(results.rows("meng_table2"), results.worlds("meng_table2")),
        composed_navigation(results, stored_as("tour")),
        navigation_on_maps(places),
        lookalikes(results.rows("meng_fig12"), results.worlds("meng_fig12")),
        plan_probability(results.rows("meng_fig9")),
        blocked_paths(results.rows("faults")),
        exploration(results.rows("nts_table1")),
    ]
    return table(HEAD, lines)


def local_control(rows: Rows) -> list[str]:
    """Targets reached by C."""
    found = {row["controller"]: row for row in rows if row["condition"] == "clean"}
    here = {name: percent(row["success"]) for name, row in found.items()}
    return [
        "local control: targets reached by C, k = 5",
        here["k5"],
        f"direct control {here['direct']}, random waypoints {here['random']}, oracle "
        f"{here['oracle']}",
        f"{percent(found['k5']['paper'], 0)}, direct control "
        f"{percent(found['direct']['paper'], 0)}",
    ]


def local_control_on_maps(maps: dict[str, Rows]) -> list[str]:
    """The same on maps from files."""
    k5, random, oracle = (
        _slashed([one(rows, controller=c, condition="clean")["success"] for rows in maps.values()])
        for c in ("k5", "random", "oracle")
    )
    what = f"the same on Nav2's maps {' / '.join(maps)}"
    return [what, k5, f"random waypoints {random}, oracle {oracle}", ""]


def reachability(rows: Rows) -> list[str]:
    """AUC and calibration of RE."""
    best, sptm, bound = (one(rows, estimator=name) for name in ("k5", "sptm", "geometry"))
    return [
        "reachability: RE, k = 5",
        f"AUC {number(best['auc'])}, ECE {number(best['ece'])}",
        f"SPTM's network {number(sptm['auc'])}, {number(sptm['ece'])}; true geometry AUC "
        f"{number(best['geometry_auc'])} (k = 2: {number(bound['auc'])})",
        "",
    ]


def cover_rate(rows: Rows) -> list[str]:
    """Cover rate of sparse anchors at about the same sparsity."""
    kept = {"context": "k5", "condition": "clean"}
    ours = one(rows, method="meng", threshold=0.95, **kept)
    sptm = one(rows, method="sptm", threshold=40, **kept)
    return [
        "cover rate at sparsity, k = 5, RE above 0.95",
        f"{percent(ours['cover_rate'])} at {number(ours['sparsity'])}",
        f"every {sptm['threshold']}th frame {percent(sptm['cover_rate'])} at "
        f"{number(sptm['sparsity'])}",
        f"over {percent(paper.COVERED['context'], 0)}",
    ]


def navigation(rows: Rows, worlds: int) -> list[str]:
    """Success of navigation."""
    here = {
        name: percent(total(rows, name)["success"]) for name in ("meng", "sptm", "random", "oracle")
    }
    return [
        f"navigation to an image, {worlds} buildings: Meng",
        here["meng"],
        f"SPTM {here['sptm']}, random {here['random']}, oracle {here['oracle']}",
        f"{span([row['meng_success'] for row in paper.TABLE_2])}, SPTM {span([row['sptm_success'] for row in paper.TABLE_2])}",
    ]


def composed_navigation(results: Results, name: str) -> list[str]:
    """Success after a tour in trials that no drive covers."""
    shares = {
        method: results.note(name, f"{method}, composed: ").split(" (")[0]
        for method in ("meng", "sptm", "random", "oracle")
    }
    return [
        f"the same after a tour, no drive leads there, {results.worlds(name)} buildings: Meng",
        shares["meng"],
        f"SPTM {shares['sptm']}, random {shares['random']}, oracle {shares['oracle']}",
        "",
    ]


def navigation_on_maps(maps: dict[str, Rows]) -> list[str]:
    """The same on maps from files."""
    meng, sptm, random, oracle = (
        _slashed([one(rows, method=method)["success"] for rows in maps.values()])
        for method in ("meng", "sptm", "random", "oracle")
    )
    what = f"the same on Nav2's maps {' / '.join(maps)}"
    return [what, meng, f"SPTM {sptm}, random {random}, oracle {oracle}", ""]


def lookalikes(rows: Rows, worlds: int) -> list[str]:
    """Success from starts that look alike, with all remedies and without."""
    shares = {name: percent(one(rows, remedy=name)["success"]) for name in ("all", *_BESIDE)}
    return [
        f"a start that looks like other rooms, {worlds} offices: all remedies",
        shares["all"],
        ", ".join(f"{words} {shares[name]}" for name, words in _BESIDE.items()),
        "",
    ]


def plan_probability(rows: Rows) -> list[str]:
    """Predicted and measured success of the least and the most probable plans."""
    found = [row for row in rows if not row["calibrated"]]
    least, most = found[0], found[-1]
    return [
        "a plan's probability, least probable fifth of the plans",
        percent(least["probability"]),
        f"{percent(least['success'])} arrive; most probable fifth {percent(most['probability'])}, "
        f"{percent(most['success'])} arrive",
        "",
    ]


def blocked_paths(rows: Rows) -> list[str]:
    """Robots that reach the place around a blocked path."""
    blocked, free = (one(rows, fault=fault) for fault in ("blocked", "none"))
    return [
        "the path is blocked for good, a detour exists: reached",
        percent(blocked["reached"]),
        f"nobody there {percent(free['reached'])}",
        "",
    ]


def exploration(rows: Rows) -> list[str]:
    """Success and SPL on goals 5 to 10 m away in places never seen, with signs and without."""
    here, frontier, learned, walk = (
        _slashed_pairs(
            [
                one(rows, agent=name, sensor="rgbd", signs=signs, difficulty="hard")
                for signs in ("wayfinding", "plain")
            ]
        )
        for name in ("nts", "fbe", "ans_like", "random")
    )
    paper = one(rows, agent="nts", sensor="rgbd", signs="plain", difficulty="hard")
    return [
        "a picture 5 to 10 m away in a place never seen, with signs / without: NTS",
        here,
        f"nearest frontier {frontier}, learned choice of frontier {learned}, random walk {walk}",
        f"{percent(paper['paper_success'], 0)}, SPL {number(paper['paper_spl'], 2)}",
    ]


def _slashed_pairs(rows: Rows) -> str:
    """Success of some rows, and SPL behind it."""
    success = _slashed([row["success"] for row in rows])
    return f"{success} (SPL {' / '.join(number(row['spl'], 2) for row in rows)})"


def _slashed(shares: list[float]) -> str:
    return " / ".join(percent(share) for share in shares)
