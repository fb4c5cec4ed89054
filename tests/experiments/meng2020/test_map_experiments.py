"""Figures 4, 8, 9, 10, 11 and 13, thresholds, faults and the bench, in a room with pillars."""

import json
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import networkx as nx
import numpy as np
import pytest

from tests.conftest import in_turn, make_box, needs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.benchmarks import map_building
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.common.results import FOLDER
from tutorial_lib.experiments.meng2020 import (
    fig4,
    fig8,
    fig9,
    fig10,
    fig11,
    fig13,
    table2,
    table2_goal_images,
    table2_thresholds,
)
from tutorial_lib.experiments.protocols import navigation_tasks
from tutorial_lib.experiments.protocols.navigation import Outcome, Result, experiences
from tutorial_lib.experiments.results_page.sources import stored_as
from tutorial_lib.experiments.robustness import faults
from tutorial_lib.interfaces import Experience
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene

use_threads(1)
networks = needs("waypoint_k5", "reach_k5")
QUICK = Options(quick=True, worlds=(20_000,))
MODULES = (
    *(fig4, fig8, fig9, fig10, fig11, fig13, faults),
    *(table2_goal_images, table2_thresholds),
)


@pytest.fixture(scope="module")
def building():
    scene = Scene(make_box(15.0, 9.0, [(4.5, 4.5, 2.2), (10.5, 4.5, 2.2)]))
    return navigation_tasks.explored("room", scene, np.random.default_rng(3), 4)


@pytest.fixture(autouse=True)
def one_building(building, monkeypatch):
    """Every world is this room."""
    for module in (*MODULES, map_building):
        monkeypatch.setattr(module, "make_building", lambda *_, **__: building)
        if hasattr(module, "for_each"):
            monkeypatch.setattr(module, "for_each", in_turn)


def part(building, count):
    """A building of which only the first trajectories were recorded."""
    recorded = RecordedWorld(building.scene, building.recorded.trajectories[:count])
    return replace(building, recorded=recorded, pairs=building.pairs[:count])


def saved(report):
    """The report as it is stored: whatever JSON cannot say would fail here."""
    return json.loads(json.dumps(report.as_dict()))


# Figures.


def test_the_two_trajectories_of_fig_4_run_side_by_side_farthest(building):
    first, last = fig4.most_in_common(building)
    assert first != last

    def common(one, other):
        one, other = (building.recorded.poses[building.recorded.frames_of(n)] for n in (one, other))
        beside = [
            np.any(
                (np.hypot(*(other[::5, :2] - pose[:2]).T) < 0.5)
                & (np.cos(other[::5, 2] - pose[2]) > 0.5)
            )
            for pose in one[::5]
        ]
        return sum(beside)

    apart = [
        (one, other)
        for one in range(len(building.pairs))
        for other in range(one + 1, len(building.pairs))
        if (
            building.pairs[one] != building.pairs[other]
        ).all()  # neither from nor to the same place
    ]
    most = max(common(one, other) for one, other in apart)
    assert (first, last) in apart
    assert common(first, last) == most > 0


@pytest.mark.full
@networks
def test_each_stage_of_fig_4_leaves_less_of_the_map(monkeypatch):
    def beginnings(*given):  # of whole drives, all pairs of frames take long
        return [Experience(o.observations[:90], o.timestamps[:90]) for o in experiences(*given)]

    monkeypatch.setattr(fig4, "experiences", beginnings)
    rows = fig4.EXPERIMENT.report(QUICK).rows
    assert [row["stage"] for row in rows] == [fig4.FRAMES, "dense", "pruned", "reused"]
    every, dense, pruned, reused = rows
    assert every["vertices"] == every["frames"]
    assert every["edges"] > every["vertices"] > 10 * pruned["vertices"]
    assert dense["edges"] == dense["vertices"] * (dense["vertices"] - 1)
    assert pruned["vertices"] == dense["vertices"] >= reused["vertices"]
    assert pruned["edges"] < dense["edges"]
    assert dense["vertices"] < dense["frames"]


@pytest.mark.full
@networks
def test_fig_8_has_the_pose_of_every_vertex(building):
    (row,) = saved(fig8.EXPERIMENT.report(QUICK))["rows"]
    assert (row["world"], row["family"], row["area"]) == (20_000, "box", 135)
    assert row["images"] == len(building.recorded.poses)
    assert len(row["poses"]) == len(row["trajectories"]) == row["vertices"]
    assert len(row["pairs"]) == row["edges"]
    for pose, trajectory in zip(row["poses"], row["trajectories"], strict=True):
        drive = building.recorded.poses[building.recorded.frames_of(trajectory)]
        assert np.abs(drive - pose).max(axis=1).min() < 1e-3


def test_fig_9_is_recalibrated_on_validation_worlds_only(monkeypatch):
    rng, worlds = np.random.default_rng(0), []

    def run_world(world, *_):
        """Plans succeed half as often as predicted; elsewhere, hardly ever."""
        worlds.append(world)
        predicted = rng.uniform(0.02, 1.0, 2_000)
        share = 0.5 if world in fig9.VALIDATION else 0.02
        return np.stack([predicted, rng.random(2_000) < share * predicted])

    monkeypatch.setattr(fig9, "run_world", run_world)
    report = fig9.EXPERIMENT.report(Options(worlds=(20_000, 20_001)))
    assert worlds == [*fig9.VALIDATION, 20_000, 20_001]
    rows = saved(report)["rows"]
    assert [row["bin"] for row in rows] == [*range(5), *range(5)]
    assert [row["calibrated"] for row in rows] == [False] * 5 + [True] * 5
    assert all(row["trials"] == 800 and row["success"] < 0.05 for row in rows)
    for plain, mended in zip(rows[:5], rows[5:], strict=True):
        assert plain["least"] <= plain["probability"] <= plain["most"]
        assert mended["probability"] == pytest.approx(plain["probability"] / 2, abs=0.05)
    assert report.worlds == (20_000, 20_001)


def test_fig_9_says_how_far_predicted_and_measured_are_apart(monkeypatch):
    rng = np.random.default_rng(1)

    def run_world(*_):
        predicted = rng.uniform(0.02, 1.0, 3_000)
        return np.stack([predicted, rng.random(3_000) < predicted**3])

    monkeypatch.setattr(fig9, "run_world", run_world)
    found = {one.what: one.value for one in fig9.EXPERIMENT.report(QUICK).findings}
    assert found["product of RE, ECE"] == pytest.approx(0.25, abs=0.03)  # the mean of x - x ** 3
    assert found["recalibrated, ECE"] < 0.03
    assert found["product of RE, Spearman over 5 bins"] == pytest.approx(1.0)


@pytest.mark.full
@networks
def test_plans_of_fig_9_are_driven_whatever_their_probability(building, monkeypatch):
    sent = []
    navigate = fig9.navigate
    monkeypatch.setattr(fig9, "navigate", lambda *a: sent.append(navigate(*a)) or sent[-1])
    probability, success = fig9.run_world(20_000, QUICK, fig9.Settings(trials=3))
    assert probability.shape == success.shape == (len(sent[0].success),)
    assert ((probability >= 0) & (probability <= 1)).all()
    assert (success == sent[0].success).all()
    assert set(success[probability == 0].tolist()) <= {0.0}


@pytest.mark.full
@networks
def test_fig_10_learns_nested_shares_of_the_trajectories(building, monkeypatch):
    few = replace(fig10.EXPERIMENT, quick_settings=fig10.Settings(trials=3))
    building, learned = part(building, 5), []
    monkeypatch.setattr(fig10, "make_building", lambda *_, **__: building)
    monkeypatch.setattr(
        fig10,
        "experiences",
        lambda building, numbers: (
            learned.append(numbers) or buildings_experiences(building, numbers)
        ),
    )
    report = few.report(QUICK)
    assert [len(numbers) for numbers in learned] == [
        round(share * len(building.pairs)) for share in fig10.SHARES
    ]
    for fewer, more in pairwise(learned):
        assert set(fewer) < set(more)
    line = [row["no_generalisation"] for row in report.rows]
    assert line == sorted(line)
    assert line[0] < line[-1] == 1.0
    assert [row["vertices"] for row in report.rows] == sorted(
        row["vertices"] for row in report.rows
    )
    assert all(row["low"] <= row["success"] <= row["high"] for row in report.rows)
    assert "of the peak" in report.notes[0]


buildings_experiences = fig10.experiences


@pytest.mark.full
@networks
def test_a_path_of_fig_11_joins_trajectories_that_were_not_recorded_as_one(building):
    few = replace(fig11.EXPERIMENT, settings=fig11.Settings(trials=48, share=0.6))
    report = few.report(QUICK)
    rows = report.rows
    assert len({row["trajectory"] for row in rows}) >= 2
    rng = np.random.default_rng([0, 20_000, 7])
    kept = np.sort(rng.permutation(len(building.pairs))[: round(0.6 * len(building.pairs))])
    assert {row["trajectory"] for row in rows} <= set(kept.tolist())
    pair = [rows[0]["from_place"], rows[0]["to_place"]]
    assert pair not in building.pairs[kept].tolist()
    for row in rows:
        drive = building.recorded.poses[building.recorded.frames_of(row["trajectory"])]
        assert np.abs(drive - [row["x"], row["y"], row["heading"]]).max(axis=1).min() < 1e-9
    assert f"from place {pair[0]} to {pair[1]}" in report.notes[0]


@pytest.mark.full
@networks
def test_a_world_without_a_new_path_is_an_error():
    few = replace(fig11.EXPERIMENT, settings=fig11.Settings(trials=4, share=1.0))
    with pytest.raises(InputError, match=r"meng_fig11: no new path .* give another one"):
        few.report(QUICK)


@pytest.mark.full
@networks
def test_fig_13_counts_vertices_at_even_numbers_of_frames():
    few = fig13.Settings(frames=2_000, interval=500, at_once=6)
    report = replace(fig13.EXPERIMENT, settings=few).report(Options(worlds=(20_000,)))
    assert [row["frames"] for row in report.rows] == [500, 1_000, 1_500, 2_000]
    sizes = [row["vertices"] for row in report.rows]
    assert sizes == sorted(sizes)
    assert 0 < sizes[0] < report.rows[0]["every_20th"] * 3
    assert [row["every_10th"] for row in report.rows] == [50, 100, 150, 200]
    grown = sizes[3] / sizes[1] - 1
    assert report.notes[0].startswith(f"from 1,000 to 2,000 frames {grown:.1%} more vertices")


def test_the_trajectories_of_fig_13_start_near_the_recorded_ones(building):
    more = fig13.more_trajectories(building, 45, np.random.default_rng(0), 0)
    first = building.recorded.poses[building.recorded.first_frames, :2]
    for drive in more.trajectories:
        gap = np.linalg.norm(first - drive.poses[0, :2], axis=1).min()
        assert 0 < gap < 1.0
        assert np.linalg.norm(building.places - drive.poses[-1, :2], axis=1).min() < 0.5


# Thresholds.


def result(success, vertices):
    success = np.array(success, dtype=bool)
    nothing = np.zeros(len(success))
    ending = np.where(success, "arrived", "late")
    outcome = Outcome(success, ending, nothing, nothing, nothing)
    return Result(outcome, (vertices, 2 * vertices, 1))


def test_each_threshold_is_a_row_over_all_worlds(monkeypatch):
    keys = [("meng", 0.99, True), ("sptm", 0.9, True)]
    found = {
        1: {keys[0]: result([1, 1], 10), keys[1]: result([0, 1], 30)},
        2: {keys[0]: result([1, 0], 20), keys[1]: result([0, 0], 50)},
    }
    composed = {1: np.array([False, True]), 2: np.array([True, True])}
    monkeypatch.setattr(
        table2_thresholds,
        "run_world",
        lambda world, *_: (found[world], ~composed[world]),
    )
    report = table2.EXPERIMENT.report(Options(ablation="thresholds", worlds=(1, 2)))
    assert report.name == "meng_table2_thresholds"
    first, second = saved(report)["rows"]
    assert "success_composed" not in first
    part = table2.EXPERIMENT.report(Options(ablation="thresholds", worlds=(1, 2), drives="0.2"))
    assert [row["success_composed"] for row in part.rows] == [
        pytest.approx(2 / 3),
        pytest.approx(1 / 3),
    ]
    assert [row["trials_composed"] for row in part.rows] == [3, 3]
    assert part.notes[0] == "best with --drives 0.2: p_edge 0.99, s_shortcut 0.9 (composed trials)"
    assert (first["method"], first["threshold"], first["replans"]) == keys[0]
    assert (first["success"], first["trials"], first["vertices"], first["edges"]) == (
        0.75,
        4,
        30,
        60,
    )
    assert (second["success"], second["wormholes"]) == (0.25, 2)


def test_the_best_threshold_replans_and_is_the_higher_of_equals():
    def row(method, threshold, replans, success, composed):
        return {
            "method": method,
            "threshold": threshold,
            "replans": replans,
            "success": success,
            "success_composed": composed,
        }

    rows = [
        row("meng", 0.9, True, 0.9, 0.3),
        row("meng", 0.95, True, 0.8, 0.4),
        row("meng", 0.99, True, 0.8, 0.4),
        row("meng", 0.99, False, 1.0, 1.0),
        row("sptm", 0.9, True, 0.5, 0.2),
        row("sptm", 0.99, True, 0.6, 0.1),
    ]
    best = table2_thresholds.best_of
    assert best(rows, "success_composed") == table2_thresholds.Thresholds(0.99, 0.9)
    assert best(rows, "success") == table2_thresholds.Thresholds(0.9, 0.99)


def test_table_2_takes_the_thresholds_that_were_best_in_validation_worlds():
    """Of each share for which they were measured."""
    for drives in ("0.2", "0.4", "tour"):
        file = FOLDER / f"{stored_as(drives, 'thresholds')}.json"
        if file.exists():
            rows = json.loads(file.read_text())["rows"]
            best = table2_thresholds.best_of(rows, "success_composed")
            assert table2.Settings().thresholds[drives] == best


def test_thresholds_are_chosen_on_validation_worlds():
    assert set(table2_thresholds.WORLDS) < set(fig9.VALIDATION)
    assert not set(fig9.VALIDATION) & set(navigation_tasks.WORLDS)


@pytest.mark.full
@needs("waypoint_k5", "reach_k5", "sptm")
def test_all_thresholds_have_the_same_trials_and_a_run_without_replanning(monkeypatch):
    calls = []

    def measured(building, trials, agent):
        calls.append((trials, agent.replan_time > 0, agent.topomap.graph.number_of_edges()))
        return result([1, 1, 1], len(agent.topomap))

    monkeypatch.setattr(table2_thresholds, "measured", measured)
    monkeypatch.setattr(
        table2_thresholds,
        "attempt",
        lambda building, trials, agent: (
            agent.learn(list(buildings_experiences(building))) or measured(building, trials, agent)
        ),
    )
    few = table2_thresholds.Settings(trials=3, re=(0.9, 0.99), similarity=(0.9, 0.99))
    part = table2_thresholds.run_world(20_000, QUICK, few)
    found = part.results
    assert len(part.driven) == 3
    assert list(found) == [
        ("meng", 0.9, True),
        ("meng", 0.99, True),
        ("meng", 0.99, False),
        ("sptm", 0.9, True),
        ("sptm", 0.99, True),
        ("sptm", 0.99, False),
    ]
    assert all(trials is calls[0][0] for trials, _, _ in calls)
    assert [replans for _, replans, _ in calls] == [key[2] for key in found]
    edges = [edges for _, _, edges in calls]
    assert edges[0] > edges[1]
    assert edges[1] == edges[2]  # the same map
    assert edges[3] > edges[4] == edges[5]


# Faults.


def test_a_blocked_path_can_be_driven_around_but_not_through(building):
    trials = navigation_tasks.draw_trials(building, 12, np.random.default_rng(0))
    rows, kept, seconds = faults.blockades(building, trials, 4)
    assert 0 < len(kept) <= 4
    assert len(seconds) == len(kept)
    assert (seconds > trials.seconds[kept]).all()
    for row, trial in zip(rows, kept, strict=True):
        track = trials.recorded.trajectories[trial].poses[:, :2]
        gap = np.linalg.norm(track[:, None] - row, axis=-1).min()
        assert gap < Person.radius + 0.12  # the oracle's path is through them
        order = np.argsort(row @ (row[-1] - row[0]))
        steps = np.linalg.norm(np.diff(row[order], axis=0), axis=1)
        assert (steps < 2 * Person.radius + 0.34).all()  # narrower than a car between two of them


@pytest.mark.full
def test_a_path_without_a_detour_is_not_blocked(monkeypatch):
    corridor = Scene(make_box(14.0, 1.6))
    building = navigation_tasks.explored("corridor", corridor, np.random.default_rng(0), 2)
    trials = navigation_tasks.draw_trials(building, 4, np.random.default_rng(0))
    rows, kept, seconds = faults.blockades(building, trials, 4)
    assert (rows, len(kept), len(seconds)) == ([], 0, 0)


@pytest.mark.full
@networks
def test_every_fault_has_its_row_of_outcomes(monkeypatch):
    # The map of this room is too small to hold another path around a blockade.
    passable = lambda *given: np.ones(len(given[-1]), dtype=bool)  # noqa: E731
    monkeypatch.setattr(faults, "other_paths", passable)
    few = replace(faults.EXPERIMENT, quick_settings=faults.Settings(trials=10))
    report = few.report(QUICK)
    rows = {row["fault"]: row for row in saved(report)["rows"]}
    assert list(rows) == ["none", "blocked", "own_goal", "strange_goal"]
    assert rows["none"]["trials"] == rows["blocked"]["trials"] > 0
    assert rows["none"]["refused"] is rows["own_goal"]["reached"] is None
    assert rows["none"]["reached"] >= 0.75
    assert rows["own_goal"]["refused"] <= 0.25
    # Here the strange building is the same one.
    assert rows["strange_goal"]["trials"] == 10
    assert rows["blocked"]["plans"] >= 1.0


class OneTrial(SimpleNamespace):
    def __len__(self):
        return 1


def test_another_path_is_one_on_the_map_that_leads_through_nobody(monkeypatch):
    """A square of one-way edges: from corner 0 to corner 2 by 1 or by 3, and never back."""
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    poses = np.column_stack([corners, [0.0, 1.5, 0.0, 0.0]])
    graph = nx.DiGraph([(0, 1), (1, 2), (0, 3), (3, 2)])
    monkeypatch.setattr(faults, "vertex_poses", lambda *_: poses)
    agent = SimpleNamespace(topomap=SimpleNamespace(graph=graph))
    one_side, both = np.array([[2.0, 0.1]]), np.array([[2.0, 0.1], [0.1, 2.0]])
    aside = np.array([[2.0, 2.0]])

    def passable(start, goal, people):
        trials = OneTrial(starts=poses[[start]], goal_poses=goal[None])
        return bool(faults.other_paths(None, agent, trials, [people])[0])

    assert passable(0, poses[2], one_side)
    assert passable(0, poses[2], aside)
    assert not passable(0, poses[2], both)
    assert not passable(2, poses[0], aside)
    assert not passable(0, poses[2] + np.array([0.0, 0.0, 2.0]), aside)  # seen from another heading
    assert not passable(0, poses[2] + np.array([2.0, 0.0, 0.0]), aside)  # nowhere on the map


def test_faults_without_a_path_to_block_have_an_empty_row():
    empty = np.empty(0)
    row = faults._row("blocked", [{"reached": empty, "plans": empty}])
    assert (row["trials"], row["reached"], row["plans"]) == (0, None, None)


# The bench.


@pytest.mark.full
@networks
def test_the_bench_compares_the_index_with_all_queries(building, monkeypatch):
    building = part(building, 6)
    monkeypatch.setattr(map_building, "make_building", lambda *_, **__: building)
    monkeypatch.setattr(map_building, "_PLANS", 4)
    few = map_building.Settings(places=5, sizes=(20, 40))
    report = replace(map_building.EXPERIMENT, quick_settings=few).report(QUICK)
    kinds = list(dict.fromkeys(row["map"] for row in report.rows))
    assert kinds == ["one building", "one building, no reuse", "many buildings, no reuse"]
    for kind in kinds:
        rows = [row for row in report.rows if row["map"] == kind]
        for indexed, exhaustive in zip(rows[::2], rows[1::2], strict=True):
            assert (indexed["method"], exhaustive["method"]) == ("indexed", "exhaustive")
            assert indexed["queries"] <= exhaustive["queries"]
    plain = [row for row in report.rows if row["map"] == kinds[1]]
    assert plain[0]["vertices"] == plain[1]["vertices"] > report.rows[0]["vertices"]
    assert plain[1]["recall"] == 1.0
    assert 0.9 < plain[0]["recall"] <= 1.0
    assert [
        row["vertices"] >= size for row, size in zip(report.rows[4:], (20, 20, 40, 40), strict=True)
    ]
    words = "\n".join(report.notes)
    assert f"{len(building.recorded.poses):,} frames mapped in" in words
    saved(report)


@networks
@pytest.mark.full
def test_recall_counts_what_the_index_lacks_once_and_no_driven_edge(building, monkeypatch):
    trajectories = list(map_building.sparsified(part(building, 4)))
    settings = map_building.MapSettings()
    assert np.isnan(map_building.recall(trajectories, map_building.MapSettings(p_edge=1.0)))
    assert 0.8 < map_building.recall(trajectories, settings) <= 1.0
    # An index that never looks finds nothing, though the map has all its driven edges.
    monkeypatch.setattr(map_building.Insertion, "_seeds", blind_unless_exhaustive)
    assert map_building.recall(trajectories, settings) == 0.0


def blind_unless_exhaustive(insertion, worth, back):
    """No seeds, unless every vertex is a candidate."""
    every = insertion.candidates >= worth.shape[1]
    return (worth, back) if every else (worth & False, back & False)


@networks
@pytest.mark.full
def test_comparing_with_every_vertex_leaves_the_map_as_it_is(building):
    agent = agents.meng()
    trajectories = list(map_building.sparsified(building))
    agent.learn([])
    topomap = map_building.TopoMap(agent.reachability, map_building.MapSettings(p_reuse=1.0))
    for anchors in trajectories[:3]:
        map_building.add_trajectory(topomap, anchors)
    before = nx.to_dict_of_dicts(topomap.graph)
    seconds, queries = map_building.exhaustively(topomap, trajectories[3])
    assert nx.to_dict_of_dicts(topomap.graph) == before
    assert len(topomap.paths) == 3
    count, known = len(trajectories[3]), len(topomap)
    # In both directions with every vertex, and with each other but to itself and to the next.
    assert queries >= 2 * count * known
    assert seconds > 0


@pytest.mark.full
@networks
def test_the_higher_the_threshold_of_a_goal_the_more_goals_are_refused():
    few = table2_goal_images.Settings(4, 4, (0.0, 0.9, 1.0))
    ablation = replace(table2_goal_images.EXPERIMENT, settings=few)
    rows = saved(ablation.report(Options(worlds=(1,))))["rows"]
    keys = [(row["goal_images"], row["p_goal"]) for row in rows]
    assert keys == [(images, least) for images in ("one", "clip") for least in few.p_goal]
    for images in ("one", "clip"):
        none, some, every = (row for row in rows if row["goal_images"] == images)
        assert none["success"] >= some["success"] > every["success"] == 0.0
        for column in ("refused", "refused_strange"):
            assert none[column] <= some[column] <= every[column] == 1.0
        assert {row["trials"] for row in (none, some, every)} == {4}
        assert (none["trials_composed"], none["success_composed"]) == (0, None)
