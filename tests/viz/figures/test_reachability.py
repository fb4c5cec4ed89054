import numpy as np
import pytest

from tutorial_lib.experiments.common.statistics import wilson
from tutorial_lib.viz.figures.charts import chart
from tutorial_lib.viz.figures.reachability import draw_reliability


def test_reliability_has_wilson_s_interval_for_each_bin():
    _, (axis,) = chart()
    draw_reliability(axis, [0.2, 0.9], [0.25, 0.75], 20)
    (lines,) = axis.collections
    for share, line in zip((0.25, 0.75), lines.get_segments(), strict=True):
        _, low, high = wilson(np.arange(20) < 20 * share)
        assert line[:, 1] == pytest.approx([low, high], abs=1e-3)


@pytest.mark.filterwarnings("error")
def test_an_empty_bin_has_no_interval():
    _, (axis, alone) = chart(columns=2)
    draw_reliability(axis, [0.2, np.nan, 0.9], [0.25, np.nan, 0.75], [20, 0, 20])
    draw_reliability(alone, [0.2], [0.25], 0)
    ends = [[len(line) for line in one.collections[0].get_segments()] for one in (axis, alone)]
    assert ends == [[2, 0, 2], [0]]
