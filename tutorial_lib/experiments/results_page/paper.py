"""Numbers that Meng 2020 reports, beside which ours are put; those of Table I are in its rows."""

AREAS = (460, 207, 270, 403, 205)
"""Square metres of the five test environments of Table II."""
IMAGES = (30_342, 31_167, 28_679, 39_788, 33_617)
"""Recorded in each of them."""
SUCCESS = {
    "meng": (0.869, 0.943, 0.912, 0.846, 0.957),
    "sptm": (0.481, 0.402, 0.456, 0.513, 0.472),
}
"""Share of 1,000 trials in each of them (Table II)."""
TRIALS = 1_000
VERTICES = {
    "meng": (974, 900, 901, 1_454, 909),
    "sptm": (1_648, 1_688, 1_560, 2_116, 1_808),
}
EDGES = {
    "meng": (1_482, 1_348, 1_467, 2_275, 1_524),
    "sptm": (3_201, 3_668, 3_960, 4_115, 4_756),
}
"""Of their maps."""
P_REUSE = 0.99
"""RE above which a vertex is reused (IV-C)."""
TRAJECTORIES = 500
"""Followed in Fig. 7."""
COVERED = {True: 0.95, False: 0.90}
"""Cover rate of controllers with context, at least, and without it, at most (IV-B)."""
REAL_CAR = {"trajectories": 7, "images": 3_200, "vertices": 206, "edges": 215}
"""Of the real car (IV-D)."""
