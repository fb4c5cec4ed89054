import pytest

from tests.experiments.results_page.tables import cells
from tutorial_lib.experiments.results_page.maps import (
    cost,
    growth,
    growths,
    stages,
    whole_maps,
)
from tutorial_lib.experiments.results_page.navigation import composed_of, fewer_trajectories
from tutorial_lib.experiments.results_page.probability import (
    outcomes_of_faults,
    plan_probabilities,
)
from tutorial_lib.experiments.results_page.speed import closed_loop, fleets, queries, rays
from tutorial_lib.experiments.results_page.worlds import plans


def test_stages_of_a_map_are_in_order():
    names = ("reused", "dense", "pruned", "every frame")
    rows = [{"stage": s, "vertices": 1_000 + n, "edges": n} for n, s in enumerate(names)]
    assert [line[1:] for line in cells(stages(rows))[1:]] == [
        *(["1,003", "3"], ["1,001", "1"], ["1,002", "2"], ["1,000", "0"])
    ]


def test_whole_maps_have_a_line_each():
    row = {"world": 5, "family": "office", "area": 290, "images": 25_038}
    found = cells(whole_maps([row | {"vertices": 155, "edges": 1_283}]))
    assert found[1] == ["office 5", "290 m²", "25,038", "155", "1,283"]


def test_growth_is_shown_and_counted_over_the_second_half():
    sizes = {10_000: 50, 20_000: 60, 30_000: 70, 50_000: 80, 100_000: 100}
    rows = [{"world": 3, "frames": n, "vertices": v} for n, v in sizes.items()]
    rows += [{"world": 4, "frames": n, "vertices": 2 * v - 100} for n, v in sizes.items()]
    assert cells(growth(rows))[1:] == [
        ["3", "50", "60", "80", "100"],
        ["4", "0", "20", "60", "100"],
    ]
    assert growths(rows) == pytest.approx([0.25, 2 / 3])


def test_fewer_trajectories_are_counted():
    row = {"share": 0.6, "trials": 300, "success": 0.5, "no_generalisation": 0.25}
    expected = ["60%", "50.0% (150 of 300)", "25.0% (75 of 300)", "139.4"]
    assert cells(fewer_trajectories([row | {"vertices": 139.4}]))[1] == expected


def measured(method, seconds, plan, recall, size="one building"):
    row = {"method": method, "map": size, "vertices": 1_169, "recall": recall, "queries": 32_029}
    return row | {"seconds_per_trajectory": seconds, "plan_ms": plan}


def test_cost_has_the_recall_and_the_faster_of_each_pair_bold():
    rows = [measured("indexed", 0.1, 37.0, 0.9184), measured("exhaustive", 0.9, 30.0, 1.0)]
    rows += [
        measured("indexed", 0.3, 3.0, None, "many"),
        measured("exhaustive", 9, 30, None, "many"),
    ]
    found = cells(cost(rows))
    one = ["one building", "1,169"]
    assert found[1] == [*one, "indexed", "**0.10**", "32,029", "91.84%", "37"]
    assert found[2] == [*one, "all pairs", "0.90", "32,029", "100.00%", "**30**"]
    assert found[3][3:] == ["**0.30**", "32,029", "", "**3**"]


def test_a_path_is_composed_of_pieces_of_trajectories():
    assert composed_of([{"trajectory": t} for t in (4, 4, 1, 4)]) == [2, 1, 1]


def test_plans_have_both_probabilities_and_the_success_of_their_bin():
    row = {"bin": 0, "trials": 220, "success": 0.14, "low": 0.1, "high": 0.19}
    rows = [row | {"calibrated": True, "probability": 0.13}]
    rows += [row | {"calibrated": False, "probability": 0.6}]
    assert cells(plan_probabilities(rows))[1] == [
        *("1", "220", "60.0%", "13.0%", "14.0% (10.0 to 19.0)")
    ]


def test_faults_are_counted_by_what_was_asked_of_the_agent():
    nothing = dict.fromkeys(("reached", "refused", "plans", "probability"))
    rows = [
        nothing | {"fault": "none", "trials": 10, "reached": 0.9, "plans": 1.0},
        nothing | {"fault": "blocked", "trials": 20, "reached": 0.5, "plans": 6.03},
        nothing | {"fault": "own_goal", "trials": 30, "refused": 0.1, "probability": 0.9},
        nothing | {"fault": "strange_goal", "trials": 40, "refused": 1.0, "probability": 0.5},
    ]
    assert [line[1:] for line in cells(outcomes_of_faults(rows))[1:]] == [
        ["90.0% (9 of 10)", "", "1.0", ""],
        ["50.0% (10 of 20)", "", "6.0", ""],
        ["", "10.0% (3 of 30)", "", "90.0%"],
        ["", "100.0% (40 of 40)", "", "50.0%"],
    ]


def test_rays_are_multiples_of_pymunk_for_each_number_of_walls():
    methods = ("pymunk", "numpy", "numba", "numba_single", "image16", "image64")
    rows = [
        {"method": method, "walls": walls, "frames_per_s": 5_000.4, "ratio": number * walls / 50}
        for walls in (50, 5_000)
        for number, method in enumerate(methods)
    ]
    found = cells(rays(rows))
    assert found[0] == ["", "50 walls", "5,000 walls"]
    assert found[1] == ["pymunk, frames/s", "5,000", "5,000"]
    assert found[3] == ["rays, batches of 256", "2.0 ×", "200.0 ×"]
    assert found[6] == ["images 64 × 64", "**5.0 ×**", "**500.0 ×**"]


def test_the_closed_loop_has_the_share_of_each_stage():
    shares = {"sense": 0.1, "network": 0.6, "rmp": 0.25, "move": 0.05, "all": 1.0}
    rows = [
        {"cars": 64, "stage": stage, "share": share, "car_steps_per_s": 1_000 * share}
        | {"plain_over_cached": 2.78 if stage == "network" else None}
        for stage, share in shares.items()
    ]
    assert cells(closed_loop(rows))[1] == ["64", "1,000", "10%", "60%", "25%", "5%", "2.8 ×"]


def test_queries_and_fleets_are_shown():
    rates = {"plain": 4_841.5, "rollouts": 142.2, "cached": 23_747.9}
    rows = [{"what": what, "per_s": rate} for what, rate in rates.items()]
    assert [line[1] for line in cells(queries(rows))[1:]] == ["142", "23,748", "4,842"]
    rows = [{"method": "separate", "cars": 256, "steps_per_s": 40_866.0, "ratio": 1.0}]
    rows += [{"method": "fleet", "cars": 256, "steps_per_s": 246_477.0, "ratio": 6.03}]
    assert cells(fleets(rows))[1:] == [
        ["one space", "256", "**246,477**", "6.0 ×"],
        ["a space for each car", "256", "40,866", "1.0 ×"],
    ]


def test_plans_are_counted_by_family():
    row = {"family": "loop_corridor", "plans": 20, "valid": 19, "drives": 200, "success": 0.985}
    expected = ["loop corridor", "19 of 20", "98.5% (197 of 200)", "3"]
    assert cells(plans([row | {"walls_crossed": 3}]))[1] == expected
