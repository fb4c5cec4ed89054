import numpy as np

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.figures.edge_tables import aligned_sequences

SEQUENCES = (["1", "2", "3"], ["7", "8", "9"], [0.9, 0.8, 0.7])


def test_the_pair_that_is_asked_for_has_a_frame():
    plain, framed = aligned_sequences(*SEQUENCES), aligned_sequences(*SEQUENCES, framed=1)
    changed = np.argwhere((plain != framed).any(axis=2))
    assert (framed[tuple(changed.T)] == colours.INK).all()
    width = plain.shape[1]
    low, high = changed.min(axis=0), changed.max(axis=0)
    assert abs((low[1] + high[1]) / 2 - width / 2) < 2  # around the second of three
    assert width / 4 < high[1] - low[1] < width / 3
    assert high[0] - low[0] > 0.9 * len(plain)
