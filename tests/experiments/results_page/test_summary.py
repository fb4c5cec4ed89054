from tutorial_lib.experiments.results_page.summary import (
    blocked_paths,
    cover_rate,
    local_control,
    local_control_on_maps,
    lookalikes,
    navigation,
    navigation_on_maps,
    plan_probability,
    reachability,
)


def test_local_control_stands_between_random_and_the_oracle():
    success = {"k5": 0.98, "direct": 0.46, "random": 0.36, "oracle": 0.99}
    rows = [
        {"controller": name, "condition": condition, "success": share, "paper": share - 0.02}
        for condition in ("noise", "clean")
        for name, share in success.items()
    ]
    assert local_control(rows)[1:] == [
        "98.0%",
        "direct control 46.0%, random waypoints 36.0%, oracle 99.0%",
        "96%, direct control 44%",
    ]
    _, here, beside, paper = local_control_on_maps({"a": rows, "b": rows})
    assert here == "98.0% / 98.0%"
    assert beside == "random waypoints 36.0% / 36.0%, oracle 99.0% / 99.0%"
    assert paper == ""


def test_reachability_stands_beside_what_can_be_known():
    rows = [
        {"estimator": name, "auc": auc, "ece": auc / 10, "geometry_auc": 0.973}
        for name, auc in {"k5": 0.96, "sptm": 0.77, "geometry": 0.969}.items()
    ]
    _, here, beside, _ = reachability(rows)
    assert here == "AUC 0.960, ECE 0.096"
    assert beside == "SPTM's network 0.770, 0.077; true geometry AUC 0.973 (k = 2: 0.969)"


def test_cover_rates_are_compared_at_about_the_same_sparsity():
    kept = {"context": "k5", "condition": "clean"}
    rows = [kept | {"method": "meng", "threshold": 0.95, "cover_rate": 0.99, "sparsity": 0.031}]
    rows += [kept | {"method": "sptm", "threshold": 40, "cover_rate": 0.92, "sparsity": 0.032}]
    found = cover_rate(rows)
    assert found[1:] == ["99.0% at 0.031", "every 40th frame 92.0% at 0.032", "over 95%"]


def test_navigation_stands_between_random_and_the_oracle():
    success = {"meng": 0.9, "sptm": 0.95, "random": 0.1, "oracle": 1.0}
    rows = [{"method": m, "trials": 100, "success": share} for m, share in success.items()]
    what, here, beside, paper = navigation(rows, 5)
    assert what == "navigation to an image, 5 buildings: Meng"
    assert (here, beside) == ("90.0%", "SPTM 95.0%, random 10.0%, oracle 100.0%")
    assert paper == "84.6% to 95.7%, SPTM 40.2% to 51.3%"
    what, here, beside, _ = navigation_on_maps({"depot": rows, "hall": rows})
    assert what.endswith("depot / hall")
    assert here == "90.0% / 90.0%"
    assert beside.startswith("SPTM 95.0% / 95.0%, random 10.0% / 10.0%, oracle 100.0%")


def test_remedies_stand_beside_none_and_the_strongest_of_them():
    shares = {"none": 0.2, "replan": 0.76, "filter": 0.3, "all": 0.92}
    rows = [{"remedy": name, "success": share} for name, share in shares.items()]
    what, here, beside, _ = lookalikes(rows, 10)
    assert what == "a start that looks like other rooms, 10 offices: all remedies"
    assert (here, beside) == ("92.0%", "none 20.0%, replanning alone 76.0%")


def test_unfavourable_results_are_among_them():
    rows = [
        {"calibrated": calibrated, "probability": p, "success": p / 4}
        for calibrated in (True, False)
        for p in (0.6, 0.8, 0.96)
    ]
    expected = ["60.0%", "15.0% arrive; most probable fifth 96.0%, 24.0% arrive", ""]
    assert plan_probability(rows)[1:] == expected
    rows = [{"fault": "none", "reached": 0.98}, {"fault": "blocked", "reached": 0.55}]
    assert blocked_paths(rows)[1:] == ["55.0%", "nobody there 98.0%", ""]
