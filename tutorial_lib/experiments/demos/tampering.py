"""A map that mends itself, at which one tampers: shut a door, cut an edge, add one, and watch."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.lifelong import image_poses, run_queries
from tutorial_lib.experiments.protocols.navigation import WORMHOLE
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials
from tutorial_lib.topology.maintenance import Edge
from tutorial_lib.validation import instance, instances, one_of
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.living_maps import draw_living_map
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.charts import chart, from_figure
from tutorial_lib.viz.figures.maps import pale_view
from tutorial_lib.viz.figures.panels import side_by_side
from tutorial_lib.world.people import Person

BLOCK = 25
"""Queries that a press runs."""
RUN, DOOR, CUT, ADD = f"next {BLOCK} queries", "shut or open the door", "cut an edge", "add an edge"
_HIGH = 470  # pixels of the picture


@dataclass(frozen=True)
class Block:
    """What a press of `RUN` came to.

    Attributes:
        success: share of the queries that arrived.
        pruned: edges that were out of the map afterwards.
        shut: whether the door was.
    """

    success: float
    pruned: int
    shut: bool


class TamperedMap:
    """A map that mends itself, and what one does to it; without Jupyter.

    Attributes:
        actions: what `press` may be given.
        shut: whether the door is.
        blocks: what happened so far.
        cut: edges that were cut.
        added: edges that were added, and are none.
    """

    actions = (RUN, DOOR, CUT, ADD)

    def __init__(
        self,
        building: Building,
        agent: LTVNAgent,
        queries: Trials,
        door: Sequence[Person],
        first: int = 0,
    ) -> None:
        """Begin with an agent that has learned the building.

        Args:
            building: with the drives that the agent learned.
            agent: with its map, which changes.
            queries: of which each block takes the next; after the last, the first ones again.
            door: people who stand in a door when it is shut.
            first: number of the first query.

        Raises:
            InputError: when there are fewer than `BLOCK` queries, or the agent has no map or does
                not mend it.
        """
        instance("building", building, Building)
        instance("agent", agent, LTVNAgent)
        if not len(agent.sampled.pool) or agent.maintenance is None:
            raise InputError("agent: has no map that mends itself; let it learn, with maintenance")
        if len(instance("queries", queries, Trials)) < BLOCK:
            raise InputError(f"queries: {len(queries)}; give {BLOCK} or more")
        self._building, self._agent, self._queries = building, agent, queries
        self._people, self._first = instances("door", door, Person), first
        self._poses, self._rng = image_poses(building, agent), np.random.default_rng(0)
        self._view = pale_view(building.scene, side=_HIGH)
        self.shut, self.text = False, "Nothing has happened yet."
        self.blocks: list[Block] = []
        self.cut: list[Edge] = []
        self.added: list[Edge] = []

    def press(self, name: str) -> None:
        """Do one of `actions`.

        Raises:
            InputError: when there is no such action.
        """
        doing: dict[str, Callable[[], str]] = {
            RUN: self._run,
            DOOR: self._turn_door,
            CUT: self._cut,
            ADD: self._add,
        }
        self.text = doing[one_of("name", name, self.actions)]()

    def render(self) -> Picture:
        """The map as it is now, beside the blocks so far, if there are any."""
        view, upkeep = self._view, self._agent.upkeep
        picture = view.base.copy()
        draw_living_map(view, picture, self._poses, upkeep.graph, upkeep.pruned)
        for number, person in enumerate(self._people):
            place = np.asarray(person.route)[0]
            if self.shut:
                view.disc(picture, place, person.radius, colours.PERSON)
            view.ring(picture, place, person.radius, colours.PERSON)
            if not number:
                x, y = view.pixels(place).round().astype(int).tolist()
                label(picture, "shut" if self.shut else "open", x - 54, y + 5, 0.6)
        for edges, tone in ((self.cut, colours.INK), (self.added, colours.LASER)):
            for source, target in edges:
                for vertex in (source, target):
                    view.ring(picture, self._poses[vertex, :2], 0.3, tone)
        parts = {"grey: sure; vermilion: doubted; dashed: pruned": picture}
        if self.blocks:
            parts[f"each block of {BLOCK} queries"] = self._chart()
        return side_by_side([*parts.values()], [*parts])

    def _run(self) -> str:
        upkeep, done = self._agent.upkeep, len(self.blocks) * BLOCK
        some = self._queries.subset(np.arange(done, done + BLOCK) % len(self._queries))
        first, people = self._first + done, self._people if self.shut else ()
        found, _ = run_queries(self._building, some, self._agent, BLOCK, first, people)
        self.blocks.append(Block(float(found.success.mean()), len(upkeep.pruned), self.shut))
        yours = ""
        for edges, words in ((self.cut, "cut edges are back"), (self.added, "added ones are left")):
            here = sum(upkeep.graph.has_edge(*edge) for edge in edges)
            yours += f"; {here} of your {len(edges)} {words}" if edges else ""
        return (
            f"{found.success.sum()} of {BLOCK} arrive, {found.seconds.mean():.0f} s on average; "
            f"{upkeep.graph.number_of_edges()} edges, {len(upkeep.pruned)} pruned{yours}."
        )

    def _turn_door(self) -> str:
        self.shut = not self.shut
        return f"The door is {'shut' if self.shut else 'open'} now; the robots don't know it yet."

    def _cut(self) -> str:
        """Prune the edge that was driven most often; it comes back as any pruned edge does."""
        upkeep = self._agent.upkeep
        driven = Counter(event.edge for event in upkeep.events if event.kind == "success")
        known = [edge for edge, _ in driven.most_common() if upkeep.graph.has_edge(*edge)]
        edge = (known or sorted(upkeep.graph.edges))[0]
        upkeep.prune_edge(edge)
        self.cut.append(edge)
        return f"You cut an edge that was driven {driven[edge]} times; black rings mark its ends."

    def _add(self) -> str:
        """Add an edge between places far apart, which looks like any other one."""
        upkeep = self._agent.upkeep
        driven = [(a, b) for a, b, edge in upkeep.graph.edges(data=True) if "turn" not in edge]
        edges, vertices = sorted(driven), self._agent.sampled.vertices
        tried = self._rng.choice(vertices, (1000, 2)).tolist()
        apart = [float(np.hypot(*(self._poses[a] - self._poses[b])[:2])) for a, b in tried]
        far = next((i for i, metres in enumerate(apart) if metres > WORMHOLE), None)
        if far is None:
            return f"No two places are {WORMHOLE:.0f} m apart; no edge was added."
        like = edges[int(self._rng.integers(len(edges)))]
        edge = (tried[far][0], tried[far][1])
        upkeep.add_edge(edge, dict(upkeep.graph.edges[like]))
        self.added.append(edge)
        return (
            f"You added an edge that isn't there, {apart[far]:.0f} m long; "
            "vermilion rings mark its ends."
        )

    def _chart(self) -> Picture:
        figure, (axes,) = chart(4.6, _HIGH / 96)
        numbers = [self._first + BLOCK * (number + 1) for number in range(len(self.blocks))]
        success = [block.success for block in self.blocks]
        axes.plot(numbers, success, color=colours.unit(colours.ROBOT), marker="o", label="arrive")
        look = {"color": colours.unit(colours.LASER), "marker": "s"}
        pruned = [block.pruned / 100 for block in self.blocks]
        axes.plot(numbers, pruned, label="edges pruned, hundreds", **look)
        for number, block in zip(numbers, self.blocks, strict=True):
            if block.shut:
                shade = colours.unit(colours.PERSON)
                axes.axvspan(number - BLOCK, number, color=shade, alpha=0.2)
        axes.set(ylim=(0, 1.05), xlabel="queries; pink where the door was shut")
        axes.set_xlim(self._first, max([self._first + 4 * BLOCK, *numbers]))
        axes.legend(loc="lower right")
        return from_figure(figure)
