"""Offices with look-alike rooms: which rooms are twins, and where trials start and end."""

import numpy as np
import pytest

from tests.world.test_generators import signature
from tutorial_lib.experiments.protocols.lookalikes import (
    alike_rooms,
    draw_ambiguous_trials,
    make_office,
)
from tutorial_lib.world.generators import generate


@pytest.mark.parametrize("seed", [40, 41])
def test_rooms_of_one_group_have_the_same_walls_and_furniture(seed):
    plan = generate("symmetric_office", seed)
    group = alike_rooms(plan)
    looks = [signature(plan, room) for room in plan.rooms]
    for one in range(len(group)):
        for other in range(one):
            if group[one] == group[other]:
                assert all(_within(piece, looks[other][1]) for piece in looks[one][1])
                assert len(looks[one][1]) == len(looks[other][1])
                assert plan.rooms[one].kind == plan.rooms[other].kind
    sizes = np.bincount(group)
    assert sizes.max() >= 2
    assert (sizes == 1).sum() >= 2


def _within(piece, pieces):
    """Whether one of the pieces is the same, but for a rounding."""
    return any(
        piece[-2:] == other[-2:]
        and len(piece) == len(other)
        and np.allclose(piece[:-2], other[:-2], rtol=0, atol=0.005)
        for other in pieces
    )


def test_a_rounding_makes_no_room_unique():
    plan = generate("symmetric_office", 10_000, size="large")
    group = alike_rooms(plan)
    copies = [i for i, room in enumerate(plan.rooms) if _walls_of(plan, room) == {"office A"}]
    assert len(copies) == 13
    assert len(set(group[copies])) == 1


def _walls_of(plan, room):
    """The materials of the walls whose middle lies on a room's outline."""
    corners = np.asarray(room.outline)
    low, high = corners.min(axis=0), corners.max(axis=0)
    middles = (plan.walls[:, :2] + plan.walls[:, 2:4]) / 2
    inside = ((middles > low - 1e-6) & (middles < high + 1e-6)).all(axis=1)
    return {plan.wall_materials[i] for i in np.flatnonzero(inside)} - {"door frame"}


def test_an_office_of_no_twins_has_none():
    plan = generate("apartment", 40)
    assert np.bincount(alike_rooms(plan)).max() == 1


@pytest.mark.full
def test_trials_start_in_twins_and_end_in_rooms_of_their_own():
    office = make_office(10_002, 0, twins=2, unique=1)
    assert office.twin.tolist() == [True, True, False]
    trials = draw_ambiguous_trials(office, 4, np.random.default_rng(0))
    assert len(trials) >= 2
    assert office.twin[trials.pairs[:, 0]].all()
    assert not office.twin[trials.pairs[:, 1]].any()
    rooms = office.building.scene.plan.rooms
    for pair, goal in zip(trials.pairs, trials.goal_poses, strict=True):
        assert rooms[office.rooms[pair[1]]].contains(goal[:2])
