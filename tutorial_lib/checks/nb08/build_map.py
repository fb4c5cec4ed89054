"""The check of Algorithm 1, in notebook 08."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, calling, case, exercise, parts
from tutorial_lib.checks.framework.answers import returned
from tutorial_lib.geometry import Array

Edge = tuple[int, int]
Case = tuple[NDArray[np.bool_], Array, list[int], float, float]


def build_map(
    reachable: NDArray[np.bool_], lengths: Array, order: list[int], merge: float, connect: float
) -> tuple[list[int], list[Edge]]:
    """Vertices, in the order in which they were added, and edges; see the exercise."""
    vertices, edges = [order[0]], []
    left, grew = order[1:], True
    while grew:
        grew, later = False, []
        for image in left:
            pairs = [(v, image) for v in vertices] + [(image, v) for v in vertices]
            if any(reachable[pair] and lengths[pair] < merge for pair in pairs):
                continue
            found = [pair for pair in pairs if reachable[pair] and lengths[pair] < connect]
            if found:
                vertices.append(image)
                edges += found
                grew = True
            else:
                later.append(image)
        left = later
    return vertices, edges


def _line(places: list[float], order: list[int]) -> Case:
    """Images along a line, each of which reaches those ahead of it, and one a little behind."""
    ahead = np.subtract.outer(places, places).T
    lengths = np.round(np.abs(ahead), 6)
    reachable = (ahead > -0.3) & (lengths < 9.0) & ~np.eye(len(places), dtype=bool)
    return reachable, lengths, order, 0.5, 1.5


def _three(reach: dict[Edge, float], others: dict[Edge, float]) -> Case:
    """Three images: lengths of the pairs that are reachable, and of some that are not."""
    reachable, lengths = np.zeros((3, 3), bool), np.full((3, 3), 2.0)
    for pair, metres in (reach | others).items():
        reachable[pair], lengths[pair] = pair in reach, metres
    return reachable, lengths, [0, 1, 2], 0.5, 1.5


def _two(reachable: list[list[int]], lengths: list[list[float]]) -> Case:
    """Two images, as a table of either kind has it."""
    return np.array(reachable, bool), np.array(lengths), [0, 1], 0.5, 1.5


def _random(seed: int) -> Case:
    rng = np.random.default_rng([seed, 8])
    count = int(rng.integers(6, 14))
    places = rng.uniform(0.0, 5.0, (count, 2))
    lengths = np.linalg.norm(places[:, None] - places, axis=-1)
    lengths = np.round(lengths * rng.uniform(0.8, 1.2, (count, count)), 1)
    reachable = (rng.random((count, count)) < 0.5) & ~np.eye(count, dtype=bool)
    return reachable, lengths, rng.permutation(count).tolist(), 0.6, 1.8


CASES = {
    "three images in a row": _line([0.0, 1.0, 2.0], [0, 1, 2]),
    "one too close to the first": _line([0.0, 0.2, 1.0], [0, 1, 2]),
    "one that is too far until another is there": _line([0.0, 1.0, 2.0, 3.0], [0, 3, 2, 1]),
    "one that nothing reaches": _line([0.0, 1.0, 8.0], [0, 2, 1]),
    "lengths of exactly D_m and D_c": _line([0.0, 0.5, 2.0, 3.0, 4.5], [0, 1, 2, 3, 4]),
    "close, but not reachable": _two([[0, 0], [0, 0]], [[0.0, 0.1], [0.1, 0.0]]),
    "close, and reachable only the other way": _two([[0, 0], [1, 0]], [[0.0, 1.0], [0.2, 0.0]]),
    "close to one that it cannot reach, and joined to another": _three(
        {(0, 1): 1.0, (1, 2): 1.0}, {(0, 2): 0.1, (2, 0): 0.1}
    ),
    "close, seen from the new image only": _three(
        {(0, 1): 1.0, (1, 2): 1.0, (2, 0): 0.2}, {(0, 2): 1.2}
    ),
    "close, seen from the vertex only": _three(
        {(0, 1): 1.0, (2, 1): 1.0, (0, 2): 0.2}, {(2, 0): 1.2}
    ),
    "edges both ways": case(
        ~np.eye(3, dtype=bool), np.where(np.eye(3), 0.0, 1.0), [2, 0, 1], 0.5, 1.5
    ),
    "longer one way than the other": _two([[0, 1], [1, 0]], [[0.0, 1.0], [2.0, 0.0]]),
    "close one way, and reachable only the other": _two([[0, 1], [0, 0]], [[0.0, 1.0], [0.2, 0.0]]),
    "a row that begins at its far end": _line(
        [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0, 6, 5, 4, 3, 2, 1]
    ),
    "vertices of which two are exactly D_c apart": _line([0.0, 0.75, 1.5], [0, 1, 2]),
    "another first image": _line([0.0, 1.0, 2.0, 3.0], [2, 0, 1, 3]),
    "one image alone": case(np.zeros((1, 1), bool), np.zeros((1, 1)), [0], 0.5, 1.5),
    **{f"at random ({seed})": _random(seed) for seed in range(6)},
}
MISTAKES = """
an image that cannot be joined yet gets another try in the next pass; yours gets only one
    grew = True -> grew = grew
join a new image to every vertex that it can be joined to, not only to the first
    edges += found -> edges += found[:1]
an image that is too close is dropped; yours keeps it
    continue -> pass
either may reach the other; yours looks only from the vertices to the new image
    + [(image, v) for v in vertices] -> + []
either may reach the other; yours looks only from the new image to the vertices
    [(v, image) for v in vertices] + -> [] +
edges lead both ways, each where it is reachable; yours lead into the new image only
    found = [pair for pair in pairs if -> found = [pair for pair in pairs[: len(vertices)] if
edges lead both ways, each where it is reachable; yours lead out of the new image only
    found = [pair for pair in pairs if -> found = [pair for pair in pairs[len(vertices) :] if
an image is too close only if it is reachable as well: lengths of other pairs mean nothing
    reachable[pair] and lengths[pair] < merge -> lengths[pair] < merge
an edge needs r-hat, too: lengths of pairs that are not reachable mean nothing
    reachable[pair] and lengths[pair] < connect -> lengths[pair] < connect
each direction has an r-hat of its own; an edge needs that of its direction alone
    reachable[pair] and lengths[pair] < connect
        -> reachable[pair] and reachable[pair[::-1]] and lengths[pair] < connect
below D_m is too close; exactly D_m is not
    < merge -> <= merge
below D_c can be joined; exactly D_c cannot
    < connect -> <= connect
below D_m is too close, below D_c can be joined; exactly D_m or D_c is neither
    < merge -> <= merge
    < connect -> <= connect
D_m decides what is too close, D_c what can be joined; yours has them exchanged
    lengths[pair] < merge -> lengths[pair] < CONNECT
    lengths[pair] < connect -> lengths[pair] < merge
    CONNECT -> connect
too close is too close, whichever of the two reaches the other; yours looks one way only
    < merge for pair in pairs) -> < merge for pair in pairs[: len(vertices)])
too close is too close, whichever of both it is that reaches the other; yours looks one way
    < merge for pair in pairs) -> < merge for pair in pairs[len(vertices) :])
the first image of the order is the first vertex
    order[0] -> min(order)
    left, grew = order[1:] -> left, grew = [i for i in order if i != min(order)]
an edge (v, w) leads from v to w; yours lead the other way
    edges += found -> edges += [edge[::-1] for edge in found]
"""


def _formed(what: str, got: object, *_: object) -> tuple[list[int], list[Edge]]:
    words = "return two lists, the vertices and the edges (source, target)"
    vertices, edges = parts(what, returned(what, got), 2, words)
    try:
        return [int(v) for v in vertices], sorted((int(a), int(b)) for a, b in edges)
    except (TypeError, ValueError) as error:
        raise WrongAnswer(f"{what}: {words}") from error


def _difference(got: tuple, want: tuple, *_: object) -> str:
    if got[0] != want[0]:
        return f"the vertices {got[0]} came back, but {want[0]} is right"
    extra = sorted(set(got[1]) - set(want[1]))
    missing = sorted(set(want[1]) - set(got[1]))
    words = [f"{extra[0]} is too many"] if extra else []
    words += [f"{missing[0]} is missing"] if missing else []
    return f"of the edges {' and '.join(words)}" if words else "an edge is there twice"


def _broken(got: tuple, want: tuple, *_: object) -> str:
    if len(got[0]) != len(set(got[0])):
        return "a vertex is added once"
    if set(got[0]) - set(want[0]):
        return "an image too close to a vertex, or one that nothing can be joined to, is no vertex"
    if set(want[0]) - set(got[0]):
        return "each image that can be joined and is not too close becomes a vertex, at last"
    if got[0] != want[0]:
        return "images are tried in their order, and those that are left again in the same order"
    return "an edge stands for every reachable pair below D_c of the new image and an older vertex"


check_build_map = exercise(
    build_map,
    CASES,
    MISTAKES,
    about="Images in a row, too close, too far, one-way, in several orders, and at random.",
    example=_random(7),
    calls=20,
    endless="Your function has not ended after {seconds:g} seconds. A pass that adds nothing is "
    "the last one.",
    invoke=calling({IndexError: "reachable[i, j] is the pair from image i to image j"}),
    form=_formed,
    same=lambda got, want, *_: got == want,
    difference=_difference,
    broken=_broken,
)
