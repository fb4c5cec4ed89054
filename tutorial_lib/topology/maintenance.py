"""A map that mends itself: what traversals say about its edges (LTVN, Graph Maintenance).

Every change is an event, so that all of them can be listed, drawn, and undone. Ours, not the
paper's: a limit to certainty, a look along an edge as evidence, blame that is shared with the edge
before, and the return of pruned edges.
"""

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import networkx as nx
import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.validation import flag, number, whole

CERTAIN = 0.97
"""The largest probability of an edge, and one minus the least (ours): no belief is beyond doubt."""


def bayes(prior: float, succeeds: float, deceives: float, success: bool) -> float:
    """The probability of an edge after a traversal (LTVN's discrete Bayes update).

    Args:
        prior: p(r), that the edge exists.
        succeeds: p(s | r), that a traversal of one that exists succeeds.
        deceives: p(s | not r), that it seems to succeed on one that does not.
        success: whether it did.

    >>> round(bayes(0.5, 0.9, 0.05, True), 3), round(bayes(0.5, 0.9, 0.05, False), 3)
    (0.947, 0.095)
    """
    _check_likelihoods(succeeds, deceives)
    prior, success = number("prior", prior, least=0.0, most=1.0), flag("success", success)
    exists = prior * (succeeds if success else 1.0 - succeeds)
    not_there = (1.0 - prior) * (deceives if success else 1.0 - deceives)
    return exists / (exists + not_there)


def shared_bayes(
    at: float, prior: float, succeeds: float, deceives: float, success: bool
) -> tuple[float, float]:
    """Both posteriors where the robot is at the edge's source only with probability `at` (ours).

    A traversal can succeed only where the edge exists and begins where the robot is. So its failure
    speaks against both, the more against the more doubtful one.

    Args:
        at: that the robot was at the source; the belief about the edge that led there.
        prior: that the edge exists.
        succeeds: p(s | both).
        deceives: p(s | not both).
        success: whether the traversal succeeded.

    Returns:
        The probabilities that the robot was there, and that the edge exists.

    >>> tuple(round(p, 2) for p in shared_bayes(0.5, 0.95, 0.9, 0.05, False))
    (0.13, 0.91)
    """
    _check_likelihoods(succeeds, deceives)
    at = number("at", at, least=0.0, most=1.0)
    prior = number("prior", prior, least=0.0, most=1.0)
    if_both = succeeds if flag("success", success) else 1.0 - succeeds
    if_not = deceives if success else 1.0 - deceives
    both, only_at = at * prior * if_both, at * (1.0 - prior) * if_not
    only_edge, neither = (1.0 - at) * prior * if_not, (1.0 - at) * (1.0 - prior) * if_not
    total = both + only_at + only_edge + neither
    return (both + only_at) / total, (both + only_edge) / total


def gaussian(mean: float, variance: float, measured: float, noise: float) -> tuple[float, float]:
    """Mean and variance of an edge's length after a successful traversal (LTVN's Gaussian filter).

    Args:
        mean: metres of d(w).
        variance: of that.
        measured: d(w) as predicted from where the robot set off.
        noise: sigma squared, the variance of such predictions.

    >>> gaussian(1.0, 0.04, 2.0, 0.04)
    (1.5, 0.02)
    """
    for name, value in (("variance", variance), ("noise", noise)):
        number(name, value, above=0.0)
    mean, measured = number("mean", mean), number("measured", measured)
    gain = variance / (variance + noise)
    return (1.0 - gain) * mean + gain * measured, 1.0 / (1.0 / variance + 1.0 / noise)


def _check_likelihoods(succeeds: float, deceives: float) -> None:
    number("succeeds", succeeds, above=0.0, most=1.0)
    number("deceives", deceives, above=0.0, most=1.0)
    if succeeds == deceives == 1.0:
        raise InputError("succeeds, deceives: both 1; a failure would be impossible")


@dataclass(frozen=True)
class MaintenanceRules:
    """What traversals change.

    Attributes:
        succeeds: p(s | r) by how the robot was localized, of `KINDS`; measured on validation
            worlds, as the paper does, which has one for all.
        deceives: p(s | not r).
        sees: p(the target is seen from the source | r) by the same kinds, as measured (ours).
        imagines: p(it is seen | not r), where the map is wrong and not the model.
        prune: R_p, the probability below which an edge is pruned after a failure.
        share_blame: whether the edge before shares the blame (ours).
        returns: queries after which a pruned edge comes back that had worked before, twice as many
            each time that it is pruned again; 0 for never (ours).
        returns_blocked: the same where something stood in the way, always as many (ours); until
            then nothing is joined through it.
        expand: whether unused images are tried where no path is left.
        loosened: D_c times this for such images.
    """

    succeeds: dict[str, float] = field(
        default_factory=lambda: {"trusted": 0.97, "local": 0.9, "global": 0.75, "presumed": 0.6}
    )
    deceives: float = 0.05
    sees: dict[str, float] = field(
        default_factory=lambda: {"trusted": 0.85, "local": 0.85, "global": 0.75, "presumed": 0.5}
    )
    imagines: float = 0.1
    prune: float = 0.2
    share_blame: bool = True
    returns: int = 60
    returns_blocked: int = 20
    expand: bool = True
    loosened: float = 1.6

    def __post_init__(self) -> None:
        if set(self.succeeds) != set(KINDS):
            raise InputError(f"succeeds: {sorted(self.succeeds)}; give {', '.join(KINDS)}")
        if set(self.sees) != set(KINDS):
            raise InputError(f"sees: {sorted(self.sees)}; give {', '.join(KINDS)}")
        for value in (*self.succeeds.values(), self.deceives, *self.sees.values(), self.imagines):
            number("succeeds, deceives, sees, imagines", value, above=0.0, most=1.0)
        number("prune", self.prune, least=0.0, most=1.0)
        flag("share_blame", self.share_blame)
        whole("returns", self.returns, least=0)
        whole("returns_blocked", self.returns_blocked, least=0)
        flag("expand", self.expand)
        number("loosened", self.loosened, least=1.0)


KINDS = ("trusted", "local", "global", "presumed")
"""How a robot was localized: it has just arrived there and sees so; near its last path; anywhere;
or it drove there but does not see where it is."""
Edge = tuple[int, int]


@dataclass(frozen=True)
class Event:
    """One change of a graph.

    Attributes:
        query: in which it was made.
        kind: "success", "failure", "pruned", "blocked", "returned", "joined" or "vertex".
        edge: that changed; a vertex twice for itself.
        before: attributes of the edge; none where there was none.
        after: the same afterwards.
    """

    query: int
    kind: str
    edge: Edge
    before: dict[str, Any] | None = None
    after: dict[str, Any] | None = None


@dataclass(frozen=True)
class Traversal:
    """One attempt to drive along an edge.

    Attributes:
        edge: source and target.
        kind: how the robot was localized at the source, one of `KINDS`.
        success: whether it arrived at the target, as far as it can tell.
        measured: d(w) of the target, predicted from where it set off; none if it was not seen.
        arrived_by: the edge on which it came to the source; none if it was localized there.
        blocked: the edges that lead through what stood in its way, this one among them, and pairs
            of images between which it stood; none where nothing did.
        looked: the robot has not driven: it saw from the source that the target is not there, or
            what stands before it.
    """

    edge: Edge
    kind: str
    success: bool
    measured: float | None = None
    arrived_by: Edge | None = None
    blocked: tuple[Edge, ...] = ()
    looked: bool = False


@dataclass(frozen=True)
class _Pruned:
    """An edge as it was, the query in which it returns, and whether something stood in the way."""

    attributes: dict[str, Any]
    due: float
    blocked: bool


class Maintenance:
    """Keeps a graph up to date with what robots experience on it.

    Attributes:
        graph: of a map; edges have `probability`, and where lengths are measured `length`,
            `variance`, `reverse` and `cost`.
        rules: what changes.
        price: times that an edge in reverse counts as long.
        events: all changes so far.
        query: the number of the current one.
        closed: pairs of images that no edge joins, but between which something was seen to stand;
            and the query in which they may be joined again.
    """

    def __init__(
        self, graph: nx.DiGraph, rules: MaintenanceRules, price: float, noise: float
    ) -> None:
        """Nothing has happened yet; `noise` is sigma squared of d(w)."""
        self.graph, self.rules, self.price = graph, rules, price
        self.noise = number("noise", noise, above=0.0)
        self.events: list[Event] = []
        self.query = 0
        self.closed: dict[Edge, float] = {}
        self._pruned: dict[Edge, _Pruned] = {}
        self._times: defaultdict[Edge, int] = defaultdict(int)
        self._worked: set[Edge] = set()

    @property
    def pruned(self) -> dict[Edge, dict[str, Any]]:
        """The edges that are pruned now, as they were at first."""
        return {edge: pruned.attributes for edge, pruned in self._pruned.items()}

    @property
    def blocked(self) -> set[Edge]:
        """Those of them where something stood in the way."""
        return {edge for edge, pruned in self._pruned.items() if pruned.blocked}

    def begin(self, query: int) -> None:
        """A query begins; edges whose time has come return."""
        self.query = whole("query", query, least=0)
        self.closed = {pair: due for pair, due in self.closed.items() if due > query}
        for edge in [edge for edge, pruned in self._pruned.items() if pruned.due <= query]:
            self.bring_back(edge)

    def experienced(self, traversal: Traversal) -> None:
        """Update the edge's belief and length, and that of the edge before; prune what fell.

        What is blocked is pruned at once, and comes back soon: the edge is no mistake of the map.
        """
        for edge in traversal.blocked:
            if self.graph.has_edge(*edge):
                self.prune_edge(edge, blocked=True)
            elif edge not in self._pruned:
                self.closed.setdefault(edge, self._reopens())
        source, target = traversal.edge
        if not self.graph.has_edge(source, target):
            return  # another robot has pruned it meanwhile
        rules, before = self.rules, traversal.arrived_by
        edge = self.graph.edges[source, target]
        prior = _doubted(edge["probability"], traversal.success)
        if traversal.looked:
            succeeds, deceives = rules.sees[traversal.kind], rules.imagines
        else:
            succeeds, deceives = rules.succeeds[traversal.kind], rules.deceives
        at = None  # the belief in the edge before, if blame is shared with it
        if rules.share_blame and before is not None and self.graph.has_edge(*before):
            at, exists = shared_bayes(
                _doubted(self.graph.edges[before]["probability"], traversal.success),
                prior,
                succeeds,
                deceives,
                traversal.success,
            )
        else:
            exists = bayes(prior, succeeds, deceives, traversal.success)
        changed: dict[str, Any] = {"probability": _limited(exists, prior)}
        if traversal.success:
            self._worked.add((source, target))
        if traversal.success and traversal.measured is not None:
            mean, variance = gaussian(
                edge["length"], edge["variance"], traversal.measured, self.noise
            )
            price = self.price if edge["reverse"] else 1.0
            changed |= {"length": mean, "variance": variance, "cost": mean * price}
        self._change("success" if traversal.success else "failure", (source, target), changed)
        if not traversal.success and exists < rules.prune:
            self.prune_edge((source, target))
        if before is not None and at is not None:
            prior = self.graph.edges[before]["probability"]
            kind = "success" if traversal.success else "failure"
            self._change(kind, before, {"probability": _limited(at, prior)})
            if not traversal.success and at < rules.prune:
                self.prune_edge(before)

    def prune_edge(self, edge: Edge, blocked: bool = False) -> None:
        """Take an edge out of the graph, until it returns."""
        rules, gone = self.rules, dict(self.graph.edges[edge])
        wait = rules.returns * 2 ** self._times[edge] if edge in self._worked else 0
        due = self.query + wait if wait else np.inf
        if blocked:
            due = self._reopens()
        self._times[edge] += not blocked
        self._pruned[edge] = _Pruned(gone, due, blocked)
        self.graph.remove_edge(*edge)
        self.events.append(Event(self.query, "blocked" if blocked else "pruned", edge, gone))

    def bring_back(self, edge: Edge) -> None:
        """Put a pruned edge back: one more failure prunes it again; or as it was, if blocked."""
        pruned = self._pruned.pop(edge)
        if not (self.graph.has_node(edge[0]) and self.graph.has_node(edge[1])):
            return
        again = dict(pruned.attributes)
        if not pruned.blocked:
            again["probability"] = min(self.rules.prune + 0.1, CERTAIN)
        before = dict(self.graph.edges[edge]) if self.graph.has_edge(*edge) else None
        self.graph.add_edge(*edge, **again)
        self.events.append(Event(self.query, "returned", edge, before, again))

    def _reopens(self) -> float:
        """The query in which what is blocked now is tried again."""
        return self.query + (self.rules.returns_blocked or np.inf)

    def add_vertex(self, vertex: int) -> None:
        """Add a vertex without edges."""
        self.graph.add_node(vertex)
        self.events.append(Event(self.query, "vertex", (vertex, vertex)))

    def add_edge(self, edge: Edge, attributes: dict[str, Any]) -> None:
        """Add an edge that was not there."""
        self.graph.add_edge(*edge, **attributes)
        self._pruned.pop(edge, None)
        self.events.append(Event(self.query, "joined", edge, None, dict(attributes)))

    def _change(self, kind: str, edge: Edge, changed: dict[str, Any]) -> None:
        before = dict(self.graph.edges[edge])
        self.graph.edges[edge].update(changed)
        self.events.append(Event(self.query, kind, edge, before, dict(self.graph.edges[edge])))


def undone(graph: nx.DiGraph, events: list[Event]) -> nx.DiGraph:
    """A copy of a graph as it was before these events, the latest last."""
    graph = graph.copy()
    for event in reversed(events):
        if event.kind == "vertex":
            graph.remove_node(event.edge[0])
        elif event.before is None:
            graph.remove_edge(*event.edge)
        else:
            if graph.has_edge(*event.edge):
                graph.edges[event.edge].clear()
            graph.add_edge(*event.edge, **event.before)
    return graph


def _doubted(probability: float, success: bool) -> float:
    """A belief before an update: no edge is beyond doubt when it fails."""
    return probability if success else min(probability, CERTAIN)


def _limited(probability: float, prior: float) -> float:
    """A belief after an update: it stays doubtful, unless the model was surer at first."""
    return float(np.clip(probability, 1.0 - CERTAIN, max(prior, CERTAIN)))
