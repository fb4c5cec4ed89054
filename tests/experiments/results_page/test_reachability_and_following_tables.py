from tests.experiments.results_page.tables import cells
from tutorial_lib.experiments.results_page.following import (
    anchors_by,
    cover_rates,
    one_rollout,
    placement,
    recoveries,
)
from tutorial_lib.experiments.results_page.reachability import (
    ESTIMATORS,
    discrimination,
    precision,
)


def estimator(name, number):
    row = {"estimator": name, "geometry_auc": 0.95 + number / 1000, "far_above_09": 0.01}
    row |= {"auc": 0.8 + number / 100, "auc_low": 0.7, "auc_high": 0.9}
    row |= {"ece": 0.1 + number / 100, "ece_low": 0.05, "ece_high": 0.2, "far": 200}
    for offset, kind in enumerate(("mix", "consecutive", "map")):
        row |= {f"precision_{kind}": 0.9 + offset / 100, f"sure_{kind}": 100 * (number + 1)}
    return row


def judged():
    rows = [estimator(name, number) for number, name in enumerate(ESTIMATORS)]
    unknown = [key for key in rows[-1] if key.endswith(("_low", "_high", "_map", "_consecutive"))]
    rows[-1] |= dict.fromkeys([*unknown, "far", "far_above_09"])
    return rows


def test_auc_and_calibration_of_each_estimator_stand_beside_what_geometry_knows():
    found = cells(discrimination(judged()[::-1]))
    assert found[0] == ["estimator", "AUC", "AUC of the true geometry", "ECE"]
    first = ["RE, k = 0", "0.800 (0.700 to 0.900)", "0.950", "**0.100 (0.050 to 0.200)**"]
    assert found[1] == first
    assert found[6][1] == "**0.850 (0.700 to 0.900)**"
    assert found[7] == ["true geometry", "0.860", "0.956", "0.160"]


def test_every_precision_has_the_count_behind_it():
    found = cells(precision(judged()))
    sure = ["90.0% (180 of 200)", "91.0% (182 of 200)", "92.0% (184 of 200)"]
    assert found[2] == ["RE, k = 2", *sure, "1.00% (2 of 200)"]
    assert found[-1] == ["true geometry", "90.0% (630 of 700)", "", "", ""]


def test_how_anchors_are_chosen_is_said():
    assert anchors_by({"method": "meng", "threshold": 0.9}) == "RE above 0.9"
    assert anchors_by({"method": "sptm", "threshold": 30}) == "SPTM: every 30th frame"


def followed(method, threshold, condition, cover_rate):
    row = {"method": method, "context": "k2", "condition": condition, "threshold": threshold}
    row |= {"sparsity": 0.05, "stored": 0.2, "trajectories": 8, "cover_rate": cover_rate}
    return row | {"low": cover_rate - 0.1, "high": cover_rate}


def test_cover_rates_have_those_with_noise_beside_them():
    rows = [followed("meng", 0.9, "clean", 0.8), followed("sptm", 20, "clean", 0.7)]
    rows += [followed("meng", 0.95, "clean", 0.6), followed("meng", 0.95, "noise", 0.5)]
    kept = ["0.050", "0.200"]
    assert cells(cover_rates(rows))[1:] == [
        ["k = 2", "RE above 0.9", *kept, "80.0% (70.0 to 80.0)", ""],
        ["k = 2", "SPTM: every 20th frame", *kept, "70.0% (60.0 to 70.0)", ""],
        ["k = 2", "RE above 0.95", *kept, "60.0% (50.0 to 60.0)", "50.0% (40.0 to 50.0)"],
    ]


def test_placement_has_both_correlations():
    row = {"context": "laser", "anchors": 5_369, "sparsity": 0.1509, "metres": 0.4523}
    row |= {"with_clearance": 0.4567, "with_clearance_low": 0.2, "with_clearance_high": 0.54}
    row |= {"with_turn": -0.33, "with_turn_low": -0.39, "with_turn_high": -0.12}
    clearance, turn = "+0.46 (+0.20 to +0.54)", "-0.33 (-0.39 to -0.12)"
    expected = ["laser, k = 2", "5,369", "0.151", "0.45 m", clearance, turn]
    assert cells(placement([row]))[1] == expected


def test_one_rollout_is_shown_place_by_place():
    row = {"place": 3, "seconds": 7.0, "state": "dead_reckoning", "active": 2, "anchors": 11}
    found = cells(one_rollout([row | {"probability": 0.9953}]))
    assert found[1] == ["3", "7.0 s", "dead reckoning", "2 of 11", "0.995"]


def test_each_disturbance_has_its_line_and_the_kidnapped_cannot_finish():
    kinds = ("carried", "none", "person", "pushed", "turned")
    rows = [
        {"disturbance": kind, "trajectories": 50 + number, "finished": 0.9, "finished_low": 0.8}
        | {"finished_high": 1.0, "soon": 0.1 * number, "soon_low": 0.0, "soon_high": 0.5}
        | {"lost": 1.0}
        for number, kind in enumerate(kinds)
    ]
    found = cells(recoveries(rows))
    names = ["none", "pushed 0.5 m aside", "turned by 40°", "a person walks across"]
    assert [line[0] for line in found[1:]] == [*names, "kidnapped out of sight"]
    undisturbed = ["51", "90.0% (80.0 to 100.0)", "10.0% (0.0 to 50.0)", "100.0% (51 of 51)"]
    assert found[1][1:] == undisturbed
    assert found[5][1:] == ["50", "", "0.0% (0.0 to 50.0)", "100.0% (50 of 50)"]
