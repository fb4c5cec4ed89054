"""Checks of notebook 04: the exercises' rules are those that the library drives by."""

import numpy as np
import pytest

from tutorial_lib.checks.nb04 import check_choose_anchors
from tutorial_lib.checks.nb04.choose_anchors import CASES as TRAJECTORIES
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
