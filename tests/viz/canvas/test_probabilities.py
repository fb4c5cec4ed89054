import numpy as np
import pytest

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.probabilities import probability_colours


def test_probabilities_have_the_colours_of_the_scale():
    found = probability_colours([0.0, 0.25, 0.5, 1.0])
    assert found[0].tolist() == list(colours.LASER)
    assert found[3].tolist() == list(colours.ROBOT)
    assert np.ptp(found[2].astype(int)) < 10  # one half is pale
    assert found[2].min() > 225
    assert found[1] == pytest.approx((found[0].astype(int) + found[2]) / 2, abs=1)
