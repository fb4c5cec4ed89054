"""Checks of notebook 10: how well scans fit, made-up rooms, and what the notebook says."""

from pathlib import Path

import numpy as np
import pytest

from tutorial_lib.agents.walls import match_near
from tutorial_lib.checks.nb10 import fit
from tutorial_lib.checks.nb10.accept import CASES as MATCHES
from tutorial_lib.checks.nb10.accept import _across, accept
from tutorial_lib.checks.nb10.match import CASES, NEAR, match
from tutorial_lib.checks.nb10.small_rooms import ROOMS, scan
from tutorial_lib.errors import InputError
from tutorial_lib.experiments import load_result
from tutorial_lib.geometry import compose, inverse, relative, wrap

PROJECT = Path(__file__).resolve().parents[2]
TEXT = (PROJECT / "solutions" / "10_ten_visits.py").read_text(encoding="utf-8")
RACE = {(row["agent"], row["visits"]): row for row in load_result("race").rows}
NODE, THERE = np.array([2.0, 1.5, 0.3]), np.array([2.8, 2.0, 0.9])
ROOM = "a room with a cupboard"


def pair(turn=0.0):
    """Two scans of a room and the pose between them, in a world that is turned about its origin."""
    world = np.array([0.0, 0.0, turn])
    node, there = compose(world, NODE), compose(world, THERE)
    back = inverse(world)
    scans = scan(ROOM, compose(back, node)), scan(ROOM, compose(back, there))
    return *scans, relative(node, there)


def test_a_scan_is_the_metres_to_the_walls():
    ranges = scan("a square room", np.array([1.0, 2.0, 0.0]))
    assert ranges[48] == pytest.approx(2.0, abs=0.01)  # a quarter from the left edge: to the left
    assert ranges[96] == pytest.approx(3.0, abs=0.01)  # the middle: ahead
    assert ranges[144] == pytest.approx(2.0, abs=0.01)
    assert min(ranges[0], ranges[-1]) == pytest.approx(1.0, abs=0.01)
    assert scan("a bare corridor", np.array([0.0, 0.8, 0.0]))[96] > 20


@pytest.mark.parametrize("name", ROOMS)
def test_scans_of_one_place_fit_and_the_fit_falls_on_all_sides_of_a_room(name):
    place = {"a bare corridor": (0.0, 0.8, 0.2), "a corridor with doors": (0.5, 0.8, 0.2)}
    pose = np.array(place.get(name, (1.4, 1.3, 0.2)))
    ranges = scan(name, pose)
    assert fit(ranges, ranges, np.zeros((1, 3)))[0] == pytest.approx(1.0, abs=1e-6)
    aside = np.array([[0.2, 0, 0], [-0.2, 0, 0], [0, 0.2, 0], [0, -0.2, 0], [0, 0, 0.15]])
    fits = fit(ranges, ranges, aside)
    assert ((fits > 0) & (fits < 1)).all()
    assert (fits < 0.85).all() or name == "a bare corridor"


def test_the_fit_is_the_same_from_either_side_and_however_the_world_is_turned():
    node, seen, pose = pair()
    poses = pose + np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.2, 0.1]])
    there, back = fit(node, seen, poses), fit(seen, node, inverse(poses))
    assert there == pytest.approx(back)
    assert there[0] > 0.9
    again = pair(1.1)
    assert again[2] == pytest.approx(pose)
    assert fit(*again[:2], poses) == pytest.approx(there)


def test_a_point_out_of_sight_is_no_contradiction_and_one_before_a_wall_is():
    room = np.full(192, 3.0)
    behind, before = np.full(192, 4.0), np.full(192, 2.0)
    assert fit(room, behind, np.zeros((1, 3)))[0] < 0.1  # one of both says no
    assert fit(room, before, np.zeros((1, 3)))[0] < 0.1
    half = np.where(np.arange(192) < 96, 3.0, 6.0)
    assert fit(room, half, np.zeros((1, 3)))[0] < 0.6
    node, seen, _, pose = MATCHES["a robot that is far from the node"]  # round a corner
    assert fit(node, seen, pose[None])[0] > 0.9
    assert fit(np.full(192, np.inf), room, np.zeros((1, 3)))[0] == 0.0


def test_scans_of_another_form_are_refused():
    node, seen, pose = pair()
    for wrong in ((node[None], seen, pose[None]), (node, seen[:0], pose[None]), (node, seen, pose)):
        with pytest.raises(InputError):
            fit(*wrong)


@pytest.mark.parametrize("name", CASES)
def test_the_reference_is_where_the_library_s_own_matching_is(name):
    node, seen, guess = CASES[name]
    pose = match(node, seen, guess)
    by_points = match_near(node[None], seen[None], pose[None])[0]
    if not np.isfinite(by_points).all():  # too little of either is in sight of the other
        assert fit(node, seen, pose[None])[0] > 0.6
        return
    off = pose - by_points
    assert np.hypot(off[0], off[1]) < NEAR / 2
    assert abs(wrap(off[2])) < np.deg2rad(1.5)


def test_matches_that_are_believed_and_refused_are_far_apart():
    """So that other lines than the reference's pass as well."""
    turns = np.deg2rad(np.arange(0, 360, 5))
    ring = 0.5 * np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    for name, (node, seen, guess, pose) in MATCHES.items():
        here, around = fit(node, seen, pose[None])[0], fit(node, seen, pose + ring).max()
        if accept(node, seen, guess, pose):
            assert here > 0.8, name
            assert around < here - 0.25, name
        elif name.startswith("a bare corridor"):
            assert here > 0.8, name
            assert around > here - 0.05, name


@pytest.mark.parametrize("angle", np.linspace(-np.pi, np.pi, 48, endpoint=False) + 0.01)
def test_a_bare_corridor_is_refused_at_any_angle(angle):
    assert not accept(*_across(angle))


@pytest.mark.parametrize("count", [4, 6, 8, 10, 12, 16, 18, 20, 24, 28, 32, 36, 40])
def test_some_corridor_of_the_cases_lies_between_too_few_directions(count):
    turns = np.arange(count) * 2 * np.pi / count
    ring = 0.5 * np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    drops = [
        fit(node, seen, pose[None])[0] - fit(node, seen, pose + ring).max()
        for name, (node, seen, _, pose) in MATCHES.items()
        if name.startswith("a bare corridor at ")
    ]
    assert max(drops) > 0.11
    assert min(drops) > 0.11 or count not in (4, 8)


def test_what_the_notebook_says_of_the_race_is_what_was_measured():
    def late(agent, key="success"):
        return RACE[agent, "8-10"][key]

    assert late("nts") < late("nts_forgets") < late("nts_closing")
    assert abs(RACE["nts", "1-3"]["success"] - RACE["nts_forgets", "1-3"]["success"]) < 0.05
    for visits, key in (
        ("1-3", "success"),
        ("8-10", "success"),
        ("8-10", "spl"),
        ("8-10", "missed"),
    ):
        assert RACE["ans_corrected", visits][key] >= RACE["combined", visits][key]
    assert late("combined", "passed") == 1
    assert 0.6 < late("combined", "missed") < 0.8
    assert "where the known floor ends, is at least as good in every column" in TEXT
