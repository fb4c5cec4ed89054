"""The results in short: each line of the README's block, from made-up rows."""

from dataclasses import replace

from tests.experiments.results_page.tables import cells
from tutorial_lib.experiments.results_page.page import block_of
from tutorial_lib.experiments.results_page.sources import MAPS, Results, load_results

STORED = load_results()


def line(beginning, **given):
    """The cells of the first line that begins so."""
    return next(found for found in lines(**given) if found[0].startswith(beginning))


def lines(*, worlds=None, **rows):
    """The cells of all lines where some reports have other rows, and are of that many worlds."""
    reports = {}
    for name, found in rows.items():
        report = replace(STORED.reports[name], rows=found)
        reports[name] = replace(report, worlds=tuple(range(worlds))) if worlds else report
    block = block_of(Results({**STORED.reports, **reports})).splitlines()
    return cells("\n".join(line for line in block if line.startswith("|")))


def test_local_control_stands_between_random_and_the_oracle():
    success = {"k5": 0.98, "direct": 0.46, "random": 0.36, "oracle": 0.99}
    rows = [
        {"controller": name, "condition": condition, "success": share, "paper": share - 0.02}
        for condition in ("noise", "clean")
        for name, share in success.items()
    ]
    assert line("local control", meng_table1=rows)[1:] == [
        "98.0%",
        "direct control 46.0%, random waypoints 36.0%, oracle 99.0%",
        "96%, direct control 44%",
    ]
    maps = {f"meng_table1_{name}": rows for name in MAPS}
    _, here, beside, paper = line("the same on Nav2", **maps)
    assert here == "98.0% / 98.0% / 98.0%"
    assert beside == "random waypoints 36.0% / 36.0% / 36.0%, oracle 99.0% / 99.0% / 99.0%"
    assert paper == ""


def test_reachability_stands_beside_what_can_be_known():
    rows = [
        {"estimator": name, "auc": auc, "ece": auc / 10, "geometry_auc": 0.973}
        for name, auc in {"k5": 0.96, "sptm": 0.77, "geometry": 0.969}.items()
    ]
    _, here, beside, _ = line("reachability", calibration=rows)
    assert here == "AUC 0.960, ECE 0.096"
    assert beside == "SPTM's network 0.770, 0.077; true geometry AUC 0.973 (k = 2: 0.969)"


def test_cover_rates_are_compared_at_about_the_same_sparsity():
    kept = {"context": "k5", "condition": "clean"}
    rows = [kept | {"method": "meng", "threshold": 0.95, "cover_rate": 0.99, "sparsity": 0.031}]
    rows += [kept | {"method": "sptm", "threshold": 40, "cover_rate": 0.92, "sparsity": 0.032}]
    found = line("cover rate", meng_fig7=rows)
    assert found[1:] == ["99.0% at 0.031", "every 40th frame 92.0% at 0.032", "over 95%"]


def test_navigation_stands_between_random_and_the_oracle():
    success = {"meng": 0.9, "sptm": 0.95, "random": 0.1, "oracle": 1.0}
    rows = [{"method": m, "trials": 100, "success": share} for m, share in success.items()]
    what, here, beside, paper = line("navigation to", worlds=5, meng_table2=rows)
    assert what == "navigation to an image, 5 buildings: Meng"
    assert (here, beside) == ("90.0%", "SPTM 95.0%, random 10.0%, oracle 100.0%")
    assert paper == "84.6% to 95.7%, SPTM 40.2% to 51.3%"
    maps = {f"meng_table2_{name}": rows for name in MAPS}
    found = [found for found in lines(**maps) if found[0].startswith("the same on Nav2")]
    what, here, beside, _ = found[1]
    assert what.endswith("depot / tb3_sandbox / warehouse")
    assert here == "90.0% / 90.0% / 90.0%"
    assert beside.startswith("SPTM 95.0% / 95.0% / 95.0%, random 10.0% / 10.0% / 10.0%, oracle 100")


def test_remedies_stand_beside_none_and_the_strongest_of_them():
    shares = {"none": 0.2, "replan": 0.76, "filter": 0.3, "all": 0.92}
    rows = [{"remedy": name, "success": share} for name, share in shares.items()]
    what, here, beside, _ = line("a start", worlds=10, meng_fig12=rows)
    assert what == "a start that looks like other rooms, 10 offices: all remedies"
    assert (here, beside) == ("92.0%", "none 20.0%, replanning alone 76.0%")


def test_unfavourable_results_are_among_them():
    rows = [
        {"calibrated": calibrated, "probability": p, "success": p / 4}
        for calibrated in (True, False)
        for p in (0.6, 0.8, 0.96)
    ]
    expected = ["60.0%", "15.0% arrive; most probable fifth 96.0%, 24.0% arrive", ""]
    assert line("a plan", meng_fig9=rows)[1:] == expected
    rows = [{"fault": "none", "reached": 0.98}, {"fault": "blocked", "reached": 0.55}]
    assert line("the path", faults=rows)[1:] == ["55.0%", "nobody there 98.0%", ""]
