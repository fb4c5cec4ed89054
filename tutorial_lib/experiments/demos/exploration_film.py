"""The film of an exploration: the panorama with its scores, what the robot knows, and the truth."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.protocols.ghost_moments import GhostMoment
from tutorial_lib.exploration.local_map import RESOLUTION
from tutorial_lib.se2 import Array, compose, to_world
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.ghost_graphs import GHOST, UNSEEN, draw_ghost_graph, draw_seen
from tutorial_lib.viz.canvas.labels import label, text_size
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.figures.directions import panorama_picture, scored_panorama
from tutorial_lib.viz.figures.panels import faded
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera

SHARP = PanoramicCamera(rows=64, columns=768)
"""For the film; the network looks at 16 x 192 pixels."""
_WIDE, _HIGH, _MARGIN, _PLAN = 1260, 1000, 20, 600
_GOAL = (760, 80)  # pixels of the goal's picture
_CAPTION = 24
_PATH = 8  # pixels, so that it is seen under the graph's edges
_BEYOND = 4.5  # metres shown beyond where the robot was
_HALO = 0.5  # metres around the robot at which a ring shows where it is
_LEGEND = (
    ("robot", colours.ROBOT),
    ("node", colours.INK),
    ("ghost, with its score", GHOST),
    ("where it goes", colours.PATH),
    ("driven", colours.TRACK),
    ("goal", colours.GOAL),
    ("not seen yet", UNSEEN),
)


@dataclass(frozen=True, eq=False)
class ExplorationMoment:
    """What is shown of one moment.

    Attributes:
        pose: (3,) the true one.
        odometry: (3,) where the robot believes that it is since its start.
        image: (H, W, 3) panorama.
        scores: (K,) of its directions.
        explorable: (K,) which of them lead to explorable area.
        graph: what the robot remembers.
        grid: (S, S) what it has seen, see `LocalMaps`.
        corner: (2,) of the grid.
        track: (T, 2) where it has been in truth.
        goal_seen: (2,) where it sees its goal, by its odometry; None while it does not.
        lines: names and values.
    """

    pose: Array
    odometry: Array
    image: Picture
    scores: Array
    explorable: NDArray[np.bool_]
    graph: GhostMoment
    grid: NDArray[np.uint8]
    corner: Array
    track: Array
    goal_seen: Array | None
    lines: tuple[tuple[str, str], ...]


class ExplorationFilm:
    """The frames of an exploration's film, each drawn on request."""

    def __init__(
        self,
        scene: Scene,
        moments: Sequence[ExplorationMoment],
        start: Array,
        goal: Array,
        title: str,
        known: str = "by odometry that drifts",
    ) -> None:
        """Show moments.

        Args:
            scene: the world.
            moments: one for each frame.
            start: (3,) true pose at which odometry is 0, so that both plans can be compared.
            goal: (3,) where the goal's picture was taken.
            title: of all frames.
            known: how the robot knows where it is, in words.
        """
        believed = to_world(start, np.array([moment.odometry[:2] for moment in moments]))
        shown = np.concatenate([moments[-1].track, believed, goal[None, :2]])
        self._view = PlanView(scene, _PLAN, _PLAN, bounds=_around(shown, scene))
        self._moments = moments
        self._start, self._goal = start, goal
        self._title, self._how = title, known
        self._picture = panorama_picture(SHARP.look(scene, goal[None])[0][0], *_GOAL)
        self._truth = faded(self._view.base, 0.35)

    def __len__(self) -> int:
        return len(self._moments)

    def __getitem__(self, index: int) -> Picture:
        moment = self._moments[index]
        picture = np.full((_HIGH, _WIDE, 3), colours.PAPER, np.uint8)
        label(picture, self._title, _MARGIN, 32, 0.7)
        inner = _WIDE - 2 * _MARGIN
        best = np.where(moment.explorable, moment.scores, -1.0).argmax()
        chosen = int(best) if moment.explorable.any() else None
        seen = scored_panorama(moment.image, moment.scores, moment.explorable, chosen, width=inner)
        top = _put(picture, seen, _MARGIN, 46)
        words = (
            "What the robot sees: ahead in the middle, behind at both ends. Bars: scores of 12 "
            "directions; dark where one is explorable, green the best of these."
        )
        top = _caption(picture, words, _MARGIN, top)
        bottom = _put(picture, self._picture, _MARGIN, top)
        self._write(picture, moment, top)
        top = _caption(picture, "The goal: a picture from somewhere in here.", _MARGIN, bottom)
        right = _WIDE - _MARGIN - _PLAN
        _put(picture, self._known(moment), _MARGIN, top)
        bottom = _put(picture, self._drawn(moment), right, top)
        words = f"What it knows: seen so far, and its graph, {self._how}."
        _caption(picture, words, _MARGIN, bottom)
        _caption(picture, "The truth, which it does not know.", right, bottom)
        _draw_legend(picture, bottom + _CAPTION + 26)
        return picture

    def _write(self, picture: Picture, moment: ExplorationMoment, top: int) -> None:
        """The state beside the goal's picture."""
        left = _MARGIN + _GOAL[0] + 24
        for number, (name, value) in enumerate(moment.lines):
            y = top + 16 + 25 * number
            label(picture, name, left, y, 0.5, colours.FAINT)
            label(picture, value, left + 130, y, 0.58, colours.INK)

    def _known(self, moment: ExplorationMoment) -> Picture:
        """The map and the graph by odometry."""
        view, graph = self._view, moment.graph
        picture = draw_seen(view, moment.grid, moment.corner, RESOLUTION, self._start)
        if moment.goal_seen is not None:
            path = np.stack([moment.odometry[:2], moment.goal_seen])
            view.polyline(picture, to_world(self._start, path), colours.PATH, _PATH)
            view.goal(picture, to_world(self._start, moment.goal_seen))
        elif len(graph.path):
            view.polyline(picture, to_world(self._start, graph.path), colours.PATH, _PATH)
        nodes, ghosts = (to_world(self._start, one) for one in (graph.nodes, graph.ghosts))
        hung = list(zip(graph.hosts, ghosts, graph.scores, strict=True))
        draw_ghost_graph(view, picture, nodes, graph.edges, hung, written=True)
        self._draw_robot(picture, compose(self._start, moment.odometry))
        return picture

    def _drawn(self, moment: ExplorationMoment) -> Picture:
        """The floor plan with the robot and the goal."""
        picture = self._truth.copy()
        self._view.polyline(picture, moment.track, colours.TRACK, 3)
        self._view.goal(picture, self._goal[:2])
        self._draw_robot(picture, moment.pose)
        return picture

    def _draw_robot(self, picture: Picture, pose: Array) -> None:
        self._view.robot(picture, pose, DifferentialDrive().footprint)
        self._view.ring(picture, pose[:2], _HALO, colours.ROBOT)


def _around(points: Array, scene: Scene) -> Array:
    """The part of a plan about points (P, 2): x0, y0, x1, y1."""
    low, high = points.min(axis=0) - _BEYOND, points.max(axis=0) + _BEYOND
    x0, y0, x1, y1 = scene.plan.bounds
    return np.concatenate([np.maximum(low, [x0, y0]), np.minimum(high, [x1, y1])])


def _put(picture: Picture, part: Picture, left: int, top: int) -> int:
    """Put a part at a place; returns the row below it."""
    high, wide = part.shape[:2]
    picture[top : top + high, left : left + wide] = part
    return top + high


def _caption(picture: Picture, text: str, left: int, top: int) -> int:
    """Write a line of small letters; returns the row below it."""
    label(picture, text, left, top + 17, 0.5, colours.FAINT)
    return top + _CAPTION


def _draw_legend(picture: Picture, y: int) -> None:
    x = _MARGIN
    for name, colour in _LEGEND:
        cv2.circle(picture, (x + 6, y - 5), 6, colour, cv2.FILLED, cv2.LINE_AA)
        label(picture, name, x + 18, y, 0.5, colours.INK)
        x += 44 + text_size(name, 0.5)[0]
