"""Numbers that Meng 2020 reports, beside which ours are put; those of Table I are in its rows."""

_MAP = ("success", "vertices", "edges")
_COLUMNS = ("area", "images", *(f"{method}_{key}" for method in ("meng", "sptm") for key in _MAP))
TABLE_2 = [
    dict(zip(_COLUMNS, values, strict=True))
    for values in (
        (460, 30_342, 0.869, 974, 1_482, 0.481, 1_648, 3_201),
        (207, 31_167, 0.943, 900, 1_348, 0.402, 1_688, 3_668),
        (270, 28_679, 0.912, 901, 1_467, 0.456, 1_560, 3_960),
        (403, 39_788, 0.846, 1_454, 2_275, 0.513, 2_116, 4_115),
        (205, 33_617, 0.957, 909, 1_524, 0.472, 1_808, 4_756),
    )
]
"""Test environments in square metres, images recorded, success and maps of both methods."""
TRIALS = 1_000
"""In each of them."""
P_REUSE = 0.99
"""RE above which a vertex is reused (IV-C)."""
TRAJECTORIES = 500
"""Followed in Fig. 7."""
COVERED = {"context": 0.95, "none": 0.90}
"""Cover rate of controllers with context, at least, and without it, at most (IV-B)."""
