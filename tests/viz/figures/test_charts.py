import numpy as np

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.figures.charts import chart, from_figure


def test_a_figure_becomes_a_picture():
    figure, axes = chart(4, 3, columns=2)
    for axis in axes:
        axis.plot([0, 1], [0, 1], color=colours.unit(colours.ROBOT))
    picture = from_figure(figure)
    assert picture.shape == (288, 384, 3)
    assert picture.dtype == np.uint8
    near = np.abs(picture.astype(int) - colours.ROBOT).max(axis=-1) < 3
    assert near.sum() > 50
