"""The check of the weights of a map's edges, in notebook 05."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import Mask, calling, case, close, exercise, numbers
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.edge_rules import weight
from tutorial_lib.viz.figures.edge_tables import edge_table
from tutorial_lib.viz.figures.panels import side_by_side

BY_HAND = np.array(
    [
        [1.00, 0.97, 0.72, 0.10, 0.95, 0.20],
        [0.30, 1.00, 0.98, 0.05, 0.96, 0.93],
        [0.02, 0.25, 1.00, 0.01, 0.15, 0.90],
        [0.08, 0.91, 0.35, 1.00, 0.62, 0.40],
        [0.12, 0.94, 0.92, 0.20, 1.00, 0.99],
        [0.03, 0.10, 0.55, 0.02, 0.28, 1.00],
    ]
)
"""RE from each vertex (row) to each (column) of two trajectories, 0-1-2 and 3-4-5."""
DRIVEN = np.zeros((6, 6), dtype=bool)
"""The edges of these two trajectories."""
DRIVEN[[0, 1, 3, 4], [1, 2, 4, 5]] = True


def edge_weights(reach: Array, driven: Mask, p_edge: float) -> Array:
    """Weights (V, V) of a map's edges, inf where there is none (Meng 2020, III-E)."""
    kept = (reach > p_edge) | driven
    np.fill_diagonal(kept, False)
    return np.where(kept, weight(reach), np.inf)


def _random_map(vertices: int, seed: int) -> tuple[Array, Mask]:
    """RE and driven edges of one long trajectory."""
    reach = np.random.default_rng(seed).uniform(0.0, 1.0, (vertices, vertices)).round(2)
    np.fill_diagonal(reach, 1.0)
    return reach, np.eye(vertices, k=1, dtype=bool)


_NEVER, _FAINT = BY_HAND.copy(), BY_HAND.copy()
_NEVER[[3, 4], [4, 5]], _FAINT[[3, 4], [4, 5]] = (0.0, 0.5), (1e-15, 1.0)
_SELF = np.eye(6, dtype=bool)
CASES = {
    "the map above": case(BY_HAND, DRIVEN, 0.9),
    "another p_edge": case(BY_HAND, DRIVEN, 0.5),
    "RE of 0.995 and of 0.9999": case(
        np.where(BY_HAND > 0.98, 0.9999, BY_HAND + 0.005), DRIVEN, 0.9
    ),
    "RE equals p_edge": case(np.where(BY_HAND == 0.3, 0.9, BY_HAND), DRIVEN, 0.9),
    "a diagonal below p_edge": case(np.where(_SELF, 0.2, BY_HAND), DRIVEN, 0.9),
    "driven both ways": case(BY_HAND, DRIVEN | DRIVEN.T, 0.9),
    "driven has True on its diagonal": case(BY_HAND, DRIVEN | _SELF, 0.9),
    "no trajectory": case(BY_HAND, np.zeros_like(DRIVEN), 0.9),
    "p_edge = 0": case(np.where(BY_HAND < 0.06, 0.0, BY_HAND), DRIVEN, 0.0),
    "one vertex": case(np.ones((1, 1)), np.zeros((1, 1), dtype=bool), 0.9),
    "RE = 0 on a driven edge": case(_NEVER, DRIVEN, 0.9),
    "RE = 1e-15 on a driven edge": case(_FAINT, DRIVEN, 0.9),
    "p_edge = 1": case(BY_HAND, DRIVEN, 1.0),
    "12 vertices": case(*_random_map(12, 1), 0.5),
    "RE = 1": case(np.ones((3, 3)), np.zeros((3, 3), dtype=bool), 0.99),
    "nothing surer than 1e-13": case(np.full((3, 3), 1e-13), np.zeros((3, 3), dtype=bool), 0.0),
}
MISTAKES = """
a weight is never negative: -log RE, with a minus
    weight(reach) -> -weight(reach)
the natural logarithm is meant: np.log
    weight(reach) -> weight(reach) / np.log(10)
greater than p_edge, not equal to it
    reach > p_edge -> reach >= p_edge
driven edges stay, whatever their RE
    (reach > p_edge) | driven -> reach > p_edge
a driven edge has a weight like any other one, -log RE, not 0
    weight(reach) -> np.where(driven, 0.0, weight(reach))
1e-12 stands for every RE that is smaller, not for 0 alone
    weight(reach) -> -np.log(np.where(reach == 0, 1e-12, reach))
a driven edge stays where RE is 0, too; take 1e-12 for it
    weight(reach) -> -np.log(reach)
take the greater one of RE and 1e-12; nothing is added
    weight(reach) -> -np.log(reach + 1e-12)
no vertex is joined to itself; the diagonal is inf
    np.fill_diagonal(kept, False) -> pass
only driven edges are edges in yours; vertices with RE above p_edge are joined, too
    (reach > p_edge) | driven -> driven
    np.fill_diagonal(kept, False) -> pass
row and column are exchanged: reach[i, j] leads from i to j
    np.inf) -> np.inf).T
that is RE itself; the weight is -log RE
    weight(reach) -> reach
that is 1 - RE; the weight is -log RE, whose sums are the logarithms of products
    weight(reach) -> 1 - reach
p_edge is an argument; yours always takes 0.9
    > p_edge -> > 0.9
a weight is taken of RE, not of what is left of it: -log(RE), not -log(1 - RE)
    weight(reach) -> weight(1 - reach)
an edge needs RE above p_edge or a trajectory that goes there, not both: |, not &
    (reach > p_edge) | driven -> (reach > p_edge) & driven
the natural logarithm is meant: np.log, not np.log2
    weight(reach) -> weight(reach) / np.log(2)
a trajectory goes in one direction: driven[i, j] is no edge from j to i
    | driven -> | driven | driven.T
edges lead in both directions: yours has none from a greater index to a smaller one
    np.fill_diagonal(kept, False) -> kept = np.triu(kept, 1)
a driven edge weighs by its own RE, also where that is below p_edge
    weight(reach) -> -np.log(np.maximum(reach, p_edge))
all pairs are joined in yours; prune those that are not above p_edge
    (reach > p_edge) | driven -> np.ones(reach.shape, dtype=bool)
where there is no edge the weight is inf, not 0: 0 is the best of all edges
    np.inf -> 0.0
not a number stands where there is no edge; put np.inf
    np.inf -> np.nan
the map is directed: RE from i to j says nothing about RE from j to i
    kept = -> reach, driven = np.maximum(reach, reach.T), driven | driven.T; kept =
"""


def _why(got: Array, want: Array, reach: Array, driven: Mask, p_edge: float) -> str:
    """The first pair with a wrong weight."""
    if np.isnan(got).any():
        return "some weights are not a number; where there is no edge the weight is np.inf"
    there = np.isfinite(want)
    elsewhere = np.unique(got[~there])
    if np.allclose(got[there], want[there]) and len(elsewhere) == 1 and elsewhere[0] != np.inf:
        value = elsewhere[0]
        return f"where there is no edge the weight is np.inf; yours has {value:g} everywhere"
    near = np.allclose(got[there], want[there], atol=1e-5)
    lowered = not near and (got[there] <= want[there] + 1e-9).all()
    if lowered and np.array_equal(there, np.isfinite(got)):
        bound = np.exp(-got[there].max())
        if np.allclose(got[there], -np.log(np.maximum(reach[there], bound))):
            return f"only RE below 1e-12 counts as 1e-12; yours lets none be below {bound:.2g}"
    apart = ~np.isclose(got, want, rtol=0, atol=1e-9)
    i, j = (int(n) for n in np.argwhere(apart)[0])
    pair = f"from {i} to {j} (RE {reach[i, j]:g})"
    if i == j:
        if np.allclose(got, np.where(np.eye(len(got), dtype=bool), weight(reach), want)):
            return "no vertex is joined to itself; the diagonal is inf"
        return f"yours joins vertex {i} to itself with {got[i, j]:.4g}; the diagonal is np.inf"
    if not np.isfinite(want[i, j]):
        words = f"RE is not greater than {p_edge:g}, and no trajectory goes there"
        return f"{pair} yours has {got[i, j]:.4g}, but there is no edge: {words}"
    if not np.isfinite(got[i, j]):
        words = "a trajectory goes there" if driven[i, j] else f"RE is greater than {p_edge:g}"
        return f"{pair} yours has no edge, but {words}"
    words = "a weight is -log RE, of RE as it is and with all digits"
    digits = next(n for n in (4, 8, 17) if f"{got[i, j]:.{n}g}" != f"{want[i, j]:.{n}g}")
    yours, right = (f"{table[i, j]:.{digits}g}" for table in (got, want))
    return f"{words}: {pair} yours has {yours}; -log RE is {right}"


def _tables(want: Array, got: Array) -> NDArray[np.uint8]:
    tables = [edge_table(w, np.isfinite(w), DRIVEN, blank=True) for w in (want, got)]
    return side_by_side(tables, ["expected", "yours"], gap=30)


check_edge_weights = exercise(
    edge_weights,
    CASES,
    MISTAKES,
    about="The map done by hand with other thresholds, RE almost 0, no edges at all, a larger one.",
    example=case(*_random_map(120, 2), 0.9),
    invoke=calling(),
    form=lambda what, got, reach, *_: numbers(what, got, reach.shape),
    same=partial(close, tolerance=1e-9),
    difference=lambda *_: "",
    broken=_why,
    altered=lambda _: "",  # `_why` asks for all digits
    draw=_tables,
)
