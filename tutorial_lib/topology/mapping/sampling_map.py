"""A sparse map by sampling: images that are too close go, others are joined (LTVN, Algorithm 1).

The paper does not publish its thresholds. Ours are chosen on validation worlds; so are edges in
reverse with their price, restarts, and the support of neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import RelativeModel
from tutorial_lib.se2 import Array, inverse, wrap
from tutorial_lib.topology.mapping.image_pool import ImagePool, length, support
from tutorial_lib.topology.mapping.turn_edges import TurnSettings, turns_among
from tutorial_lib.validation import flag, instance, integers, number, one_of, whole

ORDERS = ("uniform", "farthest first")


@dataclass(frozen=True)
class SamplingRules:
    """Thresholds of a map by sampling.

    Attributes:
        reachable: r-hat above which an image counts as reachable.
        own_reachable: the same for two images of one drive at most `own` frames apart (ours).
        own: frames of the pool.
        merge: D_m, length below which an image is redundant.
        connect: D_c, length below which two images are joined.
        most_turn: rad between two images that are joined, at most; a threshold of its own, as the
            paper suggests.
        support: share of the images between a pair that must agree, see `support`; 0 for none.
        order: in which images are sampled, one of `ORDERS`. The paper suggests to prefer those that
            are far from the map.
        reverse: how many times as long an edge counts that is driven in reverse; there are none if
            None. The paper drives in reverse and names no price.
        spread: sigma of d(w), metres, from validation worlds.
        by_time: whether an edge costs 1 - r-hat, the time that it takes to a model which predicts
            that (ViNG), and not its length.
    """

    reachable: float = 0.9
    own_reachable: float = 0.5
    own: int = 4
    merge: float = 0.7
    connect: float = 2.5
    most_turn: float = np.pi
    support: float = 0.5
    order: str = "uniform"
    reverse: float | None = 4.0
    spread: float = 0.2
    by_time: bool = False

    def __post_init__(self) -> None:
        for name in ("reachable", "own_reachable", "support"):
            number(name, getattr(self, name), least=0.0, most=1.0)
        whole("own", self.own, least=0)
        number("merge", self.merge, least=0.0)
        number("connect", self.connect, above=0.0)
        if self.connect <= self.merge:
            raise InputError(
                f"merge: {self.merge:g} m, connect: {self.connect:g} m; give a smaller merge"
            )
        number("most_turn", self.most_turn, above=0.0)
        one_of("order", self.order, ORDERS)
        if self.reverse is not None:
            number("reverse", self.reverse, least=1.0)
        number("spread", self.spread, above=0.0)
        flag("by_time", self.by_time)


def is_mergeable(reachable: NDArray[np.bool_], waypoints: Array, merge: float) -> NDArray[np.bool_]:
    """(...) whether images (...) at `waypoints` (..., 3) are too close: reachable and below D_m."""
    return reachable & (length(waypoints) < merge)


def is_connectable(
    reachable: NDArray[np.bool_], waypoints: Array, connect: float, most_turn: float = np.pi
) -> NDArray[np.bool_]:
    """(...) whether a controller gets from image to image: reachable and below D_c."""
    near = (length(waypoints) < connect) & (np.abs(waypoints[..., 2]) <= most_turn)
    return reachable & near


def sure_pairs(pool: ImagePool, rules: SamplingRules) -> NDArray[np.bool_]:
    """(M, M) which images count as reachable from which, each pair for itself."""
    instance("pool", pool, ImagePool)
    instance("rules", rules, SamplingRules)
    return (pool.reachable > rules.reachable) | _own(pool, rules)


def supported_pairs(pool: ImagePool, rules: SamplingRules) -> NDArray[np.bool_]:
    """(M, M) those of `sure_pairs` that the images between them support, see `support`."""
    sure = sure_pairs(pool, rules)
    if not rules.support:
        return sure
    return sure & ((support(pool, sure) >= rules.support) | _own(pool, rules))


def _own(pool: ImagePool, rules: SamplingRules) -> NDArray[np.bool_]:
    """(M, M) pairs of one drive, for which less is asked."""
    own = pool.drive[:, None] == pool.drive
    own &= np.abs(pool.frame[:, None] - pool.frame) <= rules.own
    return own & (pool.reachable > rules.own_reachable)


Links = tuple[NDArray[np.intp], NDArray[np.intp], Array]
"""Pairs of images that could be joined: sources (L,), targets (L,), and costs (L,)."""


@dataclass(eq=False)
class SampledMap:
    """A directed graph whose vertices are images of a pool.

    Attributes:
        pool: all images.
        rules: that it is built by.
        sure: (M, M) see `sure_pairs`; these decide what is redundant.
        accepted: (M, M) see `supported_pairs`; these may become edges.
        graph: on networkx; a vertex is the index of its image. An edge has `waypoint` (3,) from its
            source; `probability` that it exists, at first r-hat; `length` and `variance` of d(w);
            `reverse`, whether it is driven so; `cost`, its length with the price of that; and
            `turn`, rad, if the robot turns where it stands.
        unused: T', the images that are neither vertices nor redundant.
        redundant: those that were too close to a vertex; where the map is broken they may mend it
            (ours).
    """

    pool: ImagePool
    rules: SamplingRules
    sure: NDArray[np.bool_] = field(init=False)
    accepted: NDArray[np.bool_] = field(init=False)
    graph: nx.DiGraph = field(init=False, default_factory=nx.DiGraph)
    unused: set[int] = field(init=False)
    redundant: set[int] = field(init=False, default_factory=set)
    _links: dict[float, Links] = field(init=False, default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        self.sure = sure_pairs(self.pool, self.rules)
        self.accepted = supported_pairs(self.pool, self.rules)
        self.unused = set(range(len(self.pool)))

    def copy(self) -> SampledMap:
        """A map that changes apart from this one; both have the same pool."""
        made = copy(self)
        made.graph = self.graph.copy()
        made.unused, made.redundant = set(self.unused), set(self.redundant)
        return made

    @property
    def vertices(self) -> NDArray[np.intp]:
        """(V,) rising."""
        return np.array(sorted(self.graph), dtype=np.intp)

    def mergeable_with(self, image: int, vertices: NDArray[np.intp]) -> bool:
        """Whether an image is redundant beside one of the vertices (V,)."""
        pool, merge = self.pool, self.rules.merge
        there = is_mergeable(self.sure[vertices, image], pool.waypoints[vertices, image], merge)
        back = is_mergeable(self.sure[image, vertices], pool.waypoints[image, vertices], merge)
        return bool((there | back).any())

    def edges_with(self, image: int, vertices: NDArray[np.intp]) -> list[tuple[int, int]]:
        """Edges to and from an image that the rules allow, none in reverse.

        Args:
            image: its index.
            vertices: (V,) that it may be joined to.
        """
        rules, pool = self.rules, self.pool
        limits = (rules.connect, rules.most_turn)
        into = is_connectable(
            self.accepted[vertices, image], pool.waypoints[vertices, image], *limits
        )
        out = is_connectable(
            self.accepted[image, vertices], pool.waypoints[image, vertices], *limits
        )
        return [(int(v), image) for v in vertices[into]] + [(image, int(v)) for v in vertices[out]]

    def links(self, connect: float) -> Links:
        """Sources (L,) and targets (L,) of all that D_c = `connect` would join, and costs (L,).

        Each is driven forwards or in reverse, whichever costs less. They are computed once: neither
        the pool nor the rules change.
        """
        if connect not in self._links:
            metres, rules = length(self.pool.waypoints), self.rules
            joined = is_connectable(self.accepted, self.pool.waypoints, connect, rules.most_turn)
            cost = np.where(joined, metres, np.inf)
            if rules.reverse is not None:
                cost = np.minimum(cost, cost.T * rules.reverse)
            sources, targets = np.nonzero(np.isfinite(cost))
            self._links[connect] = sources, targets, cost[sources, targets]
        return self._links[connect]

    def attributes(self, source: int, target: int, reverse: bool = False) -> dict:
        """Of an edge as it is before anybody drove along it.

        One in reverse is that from `target` to `source`, driven backwards.
        """
        pair = (target, source) if reverse else (source, target)
        waypoint = self.pool.waypoints[pair]
        metres = float(length(waypoint))
        cost = 1.0 - float(self.pool.reachable[pair]) if self.rules.by_time else metres
        return {
            "waypoint": tuple((inverse(waypoint) if reverse else waypoint).tolist()),
            "probability": float(self.pool.reachable[pair]),
            "length": metres,
            "variance": self.rules.spread**2,
            "reverse": reverse,
            "cost": cost * ((self.rules.reverse or 1.0) if reverse else 1.0),
        }

    def join(self, edges: Sequence[tuple[int, int]]) -> None:
        """Add edges of a new image, and those in reverse where nothing leads back."""
        for edge in edges:
            self.graph.add_edge(*edge, **self.attributes(*edge))
        for source, target in edges:
            if self.rules.reverse is not None and not self.graph.has_edge(target, source):
                self.graph.add_edge(target, source, **self.attributes(target, source, reverse=True))

    def join_by_turning(self, settings: TurnSettings) -> None:
        """Join vertices at one place that look different ways, in both directions (ours).

        Two such images share nothing, so Algorithm 1 never joins them. See `turn_edges`.
        """
        everyone = self.pool.observations[np.arange(len(self.pool))]
        turns = turns_among(everyone, self.pool.drive, self.vertices, settings)
        for source, target, pose in zip(
            turns.anchors.tolist(), turns.vertices.tolist(), turns.poses, strict=True
        ):
            for edge, waypoint in (((source, target), pose), ((target, source), inverse(pose))):
                if not self.graph.has_edge(*edge):
                    self.graph.add_edge(*edge, **self._turn(waypoint, settings.p_turn))

    def _turn(self, waypoint: Array, probability: float) -> dict:
        """Attributes of an edge along which the robot turns where it stands."""
        metres = float(length(waypoint))
        return {
            "waypoint": tuple(waypoint.tolist()),
            "probability": probability,
            "length": metres,
            "variance": self.rules.spread**2,
            "reverse": False,
            "cost": metres,
            "turn": float(wrap(waypoint[2])),
        }


def build(pool: ImagePool, rules: SamplingRules, rng: np.random.Generator) -> SampledMap:
    """Sample images until none can be added any more (LTVN, Algorithm 1).

    The first image is drawn among the largest group of images that are joined (ours): one that
    stands alone would end the building at once.

    Args:
        pool: all images.
        rules: thresholds.
        rng: draws the order.
    """
    instance("rng", rng, np.random.Generator)
    made = SampledMap(pool, rules)
    if not len(pool):
        return made
    joined = made.accepted & (length(pool.waypoints) < rules.connect)
    groups = nx.connected_components(nx.from_numpy_array(joined | joined.T))
    largest = max(groups, key=lambda group: (len(group), -min(group)))
    first = int(rng.choice(sorted(largest)))
    made.graph.add_node(first)
    made.unused.discard(first)
    while _one_pass(made, rng):
        pass
    return made


def joined_map(
    pool: ImagePool, rules: SamplingRules, vertices: Sequence[int], edges: Sequence[tuple[int, int]]
) -> SampledMap:
    """A map of vertices and edges that were chosen otherwise; it gets edges in reverse, too.

    Args:
        pool: all images.
        rules: of what is added later.
        vertices: (V,) images.
        edges: (E, 2) from vertex to vertex, none in reverse.

    Raises:
        InputError: when an edge leads from or to an image that is no vertex.
    """
    made = SampledMap(pool, rules)
    most = len(pool) - 1
    chosen = integers(f"vertices of {len(pool)} images", vertices, ("V",), least=0, most=most)
    pairs = np.empty((0, 2), dtype=np.intp)
    if len(edges):
        pairs = integers("edges", edges, ("E", 2), least=0, most=most)
    if not np.isin(pairs, chosen).all():
        raise InputError("edges: one leads from or to an image that is no vertex; leave it out")
    made.graph.add_nodes_from(chosen.tolist())
    made.join([(source, target) for source, target in pairs.tolist()])
    made.unused -= set(chosen.tolist())
    return made


def _one_pass(made: SampledMap, rng: np.random.Generator) -> bool:
    """Try every unused image once; whether any was added."""
    grew = False
    left = rng.permutation(sorted(made.unused)).tolist()
    while left:
        vertices = made.vertices
        image = left.pop(_farthest(made, left, vertices) if made.rules.order != "uniform" else -1)
        if made.mergeable_with(image, vertices):
            made.unused.discard(image)
            made.redundant.add(image)
        elif edges := made.edges_with(image, vertices):
            made.join(edges)
            made.unused.discard(image)
            grew = True
    return grew


def _farthest(made: SampledMap, left: list[int], vertices: NDArray[np.intp]) -> int:
    """The place in `left` of the image that is farthest from the map, of those that can be joined.

    If none can be joined, any will do.
    """
    pairs = np.ix_(vertices, np.array(left))
    metres = np.where(made.accepted[pairs], length(made.pool.waypoints[pairs]), np.inf).min(axis=0)
    return int(np.where(metres < made.rules.connect, metres, -1.0).argmax())


def sampled_map(
    model: RelativeModel, rules: SamplingRules, seen: list[tuple], rng: np.random.Generator
) -> SampledMap:
    """A map of drives.

    Args:
        model: LTVN's.
        rules: thresholds.
        seen: of each drive the observations (N,) and contexts (N, 2k+1, ...) of its images.
        rng: draws the order.
    """
    pool = ImagePool(model)
    for number_, (observations, contexts) in enumerate(seen):
        count = len(observations)
        pool.add(observations, contexts, np.full(count, number_), np.arange(count))
    return build(pool, rules, rng)
