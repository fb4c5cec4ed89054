"""One frame of a film: the plan, the camera's and the laser's view, and the robot's state."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import overload

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import Observation
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.figures.panels import camera_picture
from tutorial_lib.world.materials import Colour
from tutorial_lib.world.raycast import Discs
from tutorial_lib.world.sensors import Camera, beams_of

MAP, SIDE, MARGIN = 720, 480, 20
Legend = Sequence[tuple[str, Colour]]
LEGEND: Legend = (
    ("robot", colours.ROBOT),
    ("planned", colours.PATH),
    ("driven", colours.TRACK),
    ("goal", colours.GOAL),
    ("person", colours.PERSON),
    ("laser", colours.LASER),
    ("in view", colours.VIEW),
)
"""Names of what moves, by its colour."""
_LASER_REACH = 4.0  # metres shown around the robot
_HALO = 0.5  # metres around the robot at which a ring shows where it is


@dataclass(frozen=True)
class Moment:
    """What is shown of one moment.

    Attributes:
        pose: (3,) of the robot.
        footprint: (K, 2) of the robot.
        observation: of this one robot.
        track: (T, 2) where it has been.
        path: (P, 2) the rest of its path.
        goal: (2,), or None where the robot has none.
        discs: people and obstacles.
        lines: names and values, written beside the laser's view.
        target: (H, W, 3) image of the goal, where the robot is given one.
        ending: how the rollout ended, written below the plan.
    """

    pose: Array
    footprint: Array
    observation: Observation
    track: Array
    path: Array
    goal: Array | None
    discs: Discs | None
    lines: Sequence[tuple[str, str]]
    target: Picture | None = None
    ending: str = ""


@dataclass(frozen=True)
class RolloutFilm(Sequence[Picture]):
    """The frames of a rollout's film, each drawn on request."""

    view: PlanView
    moments: Sequence[Moment]
    title: str
    legend: Legend = LEGEND

    def __len__(self) -> int:
        return len(self.moments)

    @overload
    def __getitem__(self, index: int) -> Picture: ...
    @overload
    def __getitem__(self, index: slice) -> "RolloutFilm": ...
    def __getitem__(self, index: int | slice) -> "Picture | RolloutFilm":
        if isinstance(index, slice):
            return replace(self, moments=self.moments[index])
        return dashboard(self.view, self.moments[index], self.title, self.legend)


def dashboard(view: PlanView, moment: Moment, title: str, legend: Legend = LEGEND) -> Picture:
    """Compose the picture of a moment, 1260 x 760 pixels."""
    height, width = MAP + 2 * MARGIN, MAP + SIDE + 3 * MARGIN
    picture = np.full((height, width, 3), colours.PAPER, np.uint8)
    picture[MARGIN : MARGIN + MAP, MARGIN : MARGIN + MAP] = draw_map(view, moment)
    label(picture, moment.ending, MARGIN, height - 6, 0.62, colours.INK)
    left = MAP + 2 * MARGIN
    label(picture, title, left, MARGIN + 16, 0.6, colours.INK)
    top = MARGIN + 36
    degrees = round(float(np.rad2deg(_field_of_view(moment))))
    views = [(moment.observation.image[0], f"camera, {degrees} degrees")]
    if moment.target is not None:
        views.append((moment.target, "target image: the goal"))
    for image, caption in views:
        shown = camera_picture(image, SIDE, smooth=True)
        picture[top : top + SIDE // 3, left : left + SIDE] = shown
        label(picture, caption, left, top + SIDE // 3 + 18, 0.5, colours.FAINT)
        top += SIDE // 3 + 40
    size = 320 if moment.target is None else 200
    picture[top : top + size, left : left + size] = draw_laser(moment, size)
    label(picture, "laser, 4 m around", left, top + size + 20, 0.5, colours.FAINT)
    gap = size * 0.18
    for i, (name, value) in enumerate(moment.lines):
        label(picture, name, left + size + 16, top + 20 + round(gap * i), 0.5, colours.FAINT)
        label(picture, value, left + size + 16, top + 40 + round(gap * i), 0.6, colours.INK)
    for i, (name, colour) in enumerate(legend):
        x, y = left + SIDE // 4 * (i % 4), top + size + 56 + 26 * (i // 4)
        cv2.circle(picture, (x + 6, y - 5), 6, colour, cv2.FILLED, cv2.LINE_AA)
        label(picture, name, x + 18, y, 0.5, colours.INK)
    return picture


def _field_of_view(moment: Moment) -> float:
    """Radians of the robot's camera; of the usual one where it is not known."""
    camera = moment.observation.camera
    return (camera if isinstance(camera, Camera) else Camera()).field_of_view


def draw_map(view: PlanView, moment: Moment) -> Picture:
    """The plan from above with everything that moves."""
    picture = view.base.copy()
    points = to_world(moment.pose, beams_of(moment.observation.laser[0]))
    aside = np.abs(np.arctan2(*beams_of(moment.observation.laser[0]).T[::-1]))
    half = aside < _field_of_view(moment) / 2
    cone = np.concatenate([moment.pose[None, :2], points[half]])
    view.polygon(picture, cone, colours.VIEW, opacity=0.35)
    view.polyline(picture, moment.path, colours.PATH, 3)
    view.polyline(picture, moment.track, colours.TRACK, 3)
    view.points(picture, points, colours.LASER, 2.0)
    if moment.goal is not None:
        view.goal(picture, moment.goal)
    if moment.discs is not None:
        for x, y, radius in moment.discs.circles:
            view.disc(picture, [x, y], radius, colours.PERSON)
    view.robot(picture, moment.pose, moment.footprint)
    view.ring(picture, moment.pose[:2], _HALO, colours.ROBOT)
    return picture


def draw_laser(moment: Moment, size: int) -> Picture:
    """The laser scan, `size` pixels square: the robot in the middle, ahead is up."""
    picture = np.full((size, size, 3), colours.ROOMS["open"], np.uint8)
    middle, scale = size / 2, size / 2 / _LASER_REACH

    def fixed(points: Array) -> NDArray[np.int32]:
        turned = np.stack([middle - points[:, 1] * scale, middle - points[:, 0] * scale], axis=1)
        return np.round(turned * 16).astype(np.int32)

    for ring in (1, 2, 3):
        radius = round(ring * scale * 16)
        centre = (round(middle * 16),) * 2
        cv2.circle(picture, centre, radius, colours.PAPER, 1, cv2.LINE_AA, 4)
    points = fixed(np.minimum(1e3, beams_of(moment.observation.laser[0])))
    cv2.fillPoly(picture, [points], colours.PAPER, cv2.LINE_AA, 4)
    for x, y in points.tolist():
        cv2.circle(picture, (x, y), 40, colours.LASER, cv2.FILLED, cv2.LINE_AA, 4)
    cv2.fillPoly(picture, [fixed(moment.footprint)], colours.ROBOT, cv2.LINE_AA, 4)
    return picture
