"""Checks of notebook 04: the exercises' rules are those that the library drives by."""

import numpy as np
import pytest

from tutorial_lib.checks.nb04 import check_choose_anchors, check_move_on
from tutorial_lib.checks.nb04.choose_anchors import CASES as TRAJECTORIES
from tutorial_lib.checks.nb04.move_on import CASES as OBSERVATIONS
from tutorial_lib.topology.following.transitions import last_visited, next_active
from tutorial_lib.topology.mapping.sparsify import sparsify


class Table:
    """RE of a table; observations and targets are indices of frames."""

    def __init__(self, reach):
        self.reach = reach

    def prepare(self, targets):
        return targets

    def probability(self, observations, prepared):
        return self.reach[observations, prepared]


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_anchors_are_those_of_sparsify(name):
    reach, threshold = TRAJECTORIES[name]
    frames = np.arange(len(reach))
    right = sparsify(Table(reach), frames, frames, threshold)
    assert np.array_equal(check_choose_anchors.reference(reach, threshold), right)


@pytest.mark.parametrize("name", OBSERVATIONS)
def test_a_follower_moves_on_as_the_library_s(name):
    active, visited, reach, overlap, at, rules = OBSERVATIONS[name]
    three = range(active - 1, active + 2)
    overlaps = [overlap[place] if 0 <= place < len(reach) else np.nan for place in three]
    seen = last_visited([visited], [active], [overlaps], [at], rules.visited)
    following = [reach[active + 1] if active + 1 < len(reach) else np.nan]
    moved = next_active([active], seen, following, overlaps[2:], rules)
    right = int(moved[0]), int(seen[0])
    assert check_move_on.reference(active, visited, reach, overlap, at, rules) == right
