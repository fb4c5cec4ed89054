"""The check of which vertices lie ahead of those reused, in notebook 05."""

import numpy as np

from tutorial_lib.checks.engine import Mask, calling, exercise, mask
from tutorial_lib.topology.mapping.edge_rules import ahead_of
from tutorial_lib.topology.mapping.vertices import Indices

Case = tuple[Indices, Indices, list[int]]


def _random_case(seed: int) -> Case:
    """Vertices of some trajectories, in no order; those reused follow no rule."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 14))
    trajectory, place = rng.integers(0, 3, count), rng.permutation(count)
    reused = rng.choice(count, int(rng.integers(0, 4)), replace=False)
    return trajectory, place, reused.tolist()


CASES: dict[str, Case] = {
    name: (np.array(trajectory, dtype=int), np.array(place, dtype=int), reused)
    for name, trajectory, place, reused in (
        ("nothing was reused yet", [0, 0, 0, 1, 1], [0, 1, 2, 0, 1], []),
        ("one was reused", [0, 0, 0, 1, 1], [0, 1, 2, 0, 1], [1]),
        ("one of each trajectory", [0, 0, 0, 1, 1, 1], [0, 1, 2, 0, 1, 2], [1, 3]),
        ("two of the same trajectory", [0, 0, 0, 0, 1], [0, 1, 2, 3, 0], [1, 2]),
        ("one, then one of another", [0, 0, 0, 0, 1, 1], [0, 1, 2, 3, 0, 1], [2, 5, 3]),
        ("indices in no order", [2, 0, 2, 0, 2, 0], [5, 4, 1, 0, 3, 2], [4, 5]),
        ("the farthest was reused first", [0, 0, 0, 0], [0, 1, 2, 3], [2, 0]),
        ("vertex 0 was reused", [0, 0, 1], [0, 1, 0], [0]),
        ("the last one was reused", [0, 0, 1], [0, 1, 0], [1]),
    )
} | {f"a map drawn at random ({seed})": _random_case(seed) for seed in range(12)}
MISTAKES = """
the vertex itself may not follow itself: its place must be greater
    place > place[vertex] -> place >= place[vertex]
vertices of other trajectories may be taken, wherever they lie
    (trajectory != trajectory[vertex]) | (place > place[vertex]) -> place > place[vertex]
of other trajectories all may be taken; yours allows only the one that was reused
    != trajectory[vertex]) | -> == trajectory[vertex]) &
of the same trajectory those that lie ahead may be taken
    (trajectory != trajectory[vertex]) | (place > place[vertex]) -> trajectory != trajectory[vertex]
not only the next one: all that lie ahead on the trajectory may be taken
    place > place[vertex] -> place == place[vertex] + 1
only the reused vertex itself is forbidden in yours; those behind it are, too
    (trajectory != trajectory[vertex]) | (place > place[vertex]) -> np.arange(len(place)) != vertex
ahead is where the place is greater; yours goes backwards
    place > place[vertex] -> place < place[vertex]
all vertices that were reused count, not only the last one
    in reused: -> in reused[-1:]:
all vertices that were reused count, not only the first one
    in reused: -> in reused[:1]:
the vertices in reused are in the order of reuse: all of them count, not only the greatest
    in reused: -> in np.sort(reused)[-1:]:
of each trajectory all that were reused count, not only the last: the farthest decides
    in reused: -> in {trajectory[vertex]: vertex for vertex in reused}.values():
as long as nothing was reused, all vertices may be taken
    np.ones(len(place), dtype=bool) -> np.full(len(place), len(reused) > 0)
a vertex's index says nothing about its place along its trajectory: compare place
    place > place[vertex] -> np.arange(len(place)) > vertex
reused holds indices of vertices: trajectory[vertex], not trajectories
    != trajectory[vertex] -> != vertex
of trajectories of which nothing was reused all vertices may be taken
    return allowed -> return allowed & np.isin(trajectory, trajectory[reused])
reused holds indices of vertices: place[vertex], not places
    > place[vertex] -> > vertex
yours forbids what may be taken and allows the rest: invert it
    return allowed -> return ~allowed
a vertex must lie ahead of all that were reused, not of one of them: and, not or
    np.ones(len(place), dtype=bool) -> np.full(len(place), len(reused) == 0)
    &= -> |=
"""


def _why(got: Mask, want: Mask, trajectory: Indices, place: Indices, reused: list[int]) -> str:
    """The first vertex about which an answer is wrong."""
    vertex = int(np.flatnonzero(got != want)[0])
    its = f"vertex {vertex} (trajectory {trajectory[vertex]}, place {place[vertex]})"
    if not reused:
        return f"yours forbids {its}, but nothing was reused: all may be taken"
    own = [v for v in reused if trajectory[v] == trajectory[vertex]]
    if want[vertex]:
        places = f"reused were places {[int(place[v]) for v in own]}, all before it"
        why = places if own else "none of its trajectory was reused"
        return f"yours forbids {its}, but {why}"
    bar = max(own, key=lambda v: place[v])
    words = f"vertex {bar} at place {place[bar]} of the same trajectory was reused"
    return f"yours allows {its}, but {words}; only greater places lie ahead"


_HINTS: dict[type[Exception], str] = {
    IndexError: "reused may be empty, and holds indices of vertices",
    ValueError: "reused may be empty; then all vertices may be taken",
}
check_ahead_of = exercise(
    ahead_of,
    CASES,
    MISTAKES,
    about="Maps of several trajectories: nothing reused yet, one vertex, several, and no order.",
    example=CASES["one of each trajectory"],
    invoke=calling(_HINTS),
    form=lambda what, got, trajectory, *_: mask(what, got, trajectory.shape),
    difference=_why,
)
