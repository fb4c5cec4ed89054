"""A floor plan from above, and what moves on it, drawn as RGB arrays."""

from collections.abc import Iterable
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.validation import instance, number, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import (
    FAR,
    Picture,
    check_canvas,
    colour_of,
    pixels_of,
    places_of,
    thickness_of,
)
from tutorial_lib.world.materials import PERIOD, TEXEL, TEXELS
from tutorial_lib.world.scene import Scene

_SHIFT = 4  # OpenCV draws with coordinates in 1/16 of a pixel
_PLAIN = 0.45  # how much of the plan is left where it is plain
_WALL_THICKNESS = 0.15  # metres drawn behind a wall's face


class PlanView:
    """Draws on a picture of a scene from above."""

    def __init__(
        self,
        scene: Scene,
        width: int = 720,
        height: int = 720,
        margin: int = 16,
        bounds: ArrayLike | None = None,
    ) -> None:
        """Fit the scene, or what lies within `bounds`, into a picture.

        Args:
            scene: what to draw.
            width: pixels.
            height: pixels.
            margin: pixels around the plan.
            bounds: x0, y0, x1, y1 in metres; the whole plan unless given.

        Raises:
            InputError: when the bounds or what is left between the margins hold nothing.
        """
        instance("scene", scene, Scene)
        given = scene.plan.bounds if bounds is None else bounds
        x0, y0, x1, y1 = places_of("bounds", given, (4,))
        if not (x0 < x1 and y0 < y1):
            raise InputError(f"bounds: {[x0, y0, x1, y1]}; give x0 < x1 and y0 < y1")
        width, height = pixels_of("width", width), pixels_of("height", height)
        if whole("margin", margin, least=0) * 2 >= min(width, height):
            raise InputError(f"margin: {margin} pixels; give less than half of width and height")
        self.scale = min((width - 2 * margin) / (x1 - x0), (height - 2 * margin) / (y1 - y0))
        self._middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
        self._centre = np.array([width / 2, height / 2])
        self.size = (height, width)
        self.base = self._draw_scene(scene)

    @cached_property
    def plain(self) -> Picture:
        """The plan (H, W, 3) in pale grey, for maps that are drawn on it."""
        grey = cv2.cvtColor(cv2.cvtColor(self.base, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
        paled = cv2.addWeighted(grey, _PLAIN, np.full_like(grey, 255), 1 - _PLAIN, 0)
        return np.asarray(paled, np.uint8)

    def pixels(self, points: ArrayLike) -> NDArray[np.float64]:
        """Columns and rows (..., 2) of points (..., 2) in metres.

        Raises:
            InputError: when they are no such points, or 100 km away.
        """
        return self._pixels(places_of("points", points, (..., 2)))

    def polyline(
        self, picture: Picture, points: ArrayLike, colour: tuple[int, int, int], width: float
    ) -> None:
        """Draw a line through points (P, 2), `width` pixels wide."""
        places, colour = places_of("points", points, ("P", 2)), colour_of("colour", colour)
        thickness = max(1, round(thickness_of("width", width)))
        check_canvas(picture)
        if len(places) > 1:
            corners = [self._fixed(places)]
            cv2.polylines(picture, corners, False, colour, thickness, cv2.LINE_AA, _SHIFT)

    def polygon(
        self,
        picture: Picture,
        points: ArrayLike,
        colour: tuple[int, int, int],
        opacity: float = 1.0,
    ) -> None:
        """Fill a polygon (P, 2); below an opacity of 1, what lies under it shows through."""
        corners = self._fixed(places_of("points", points, ("P", 2), empty=False))
        colour, opacity = colour_of("colour", colour), number("opacity", opacity, least=0, most=1)
        check_canvas(picture)
        if opacity >= 1.0:
            cv2.fillPoly(picture, [corners], colour, cv2.LINE_AA, _SHIFT)
            return
        layer = picture.copy()
        cv2.fillPoly(layer, [corners], colour, cv2.LINE_AA, _SHIFT)
        cv2.addWeighted(layer, opacity, picture, 1 - opacity, 0, dst=picture)

    def disc(
        self, picture: Picture, centre: ArrayLike, radius: float, colour: tuple[int, int, int]
    ) -> None:
        """Draw a disc of `radius` metres."""
        x, y, size = self._round(picture, centre, radius)
        size, colour = max(2, size), colour_of("colour", colour)
        cv2.circle(picture, (x, y), size, colour, cv2.FILLED, cv2.LINE_AA, _SHIFT)

    def ring(
        self, picture: Picture, centre: ArrayLike, radius: float, colour: tuple[int, int, int]
    ) -> None:
        """Draw a circle of `radius` metres, two pixels wide."""
        x, y, size = self._round(picture, centre, radius)
        colour = colour_of("colour", colour)
        cv2.circle(picture, (x, y), size, colour, 2, cv2.LINE_AA, _SHIFT)

    def points(
        self, picture: Picture, points: ArrayLike, colour: tuple[int, int, int], radius: float
    ) -> None:
        """Draw points (P, 2) as dots of `radius` pixels."""
        size = max(2, round(thickness_of("radius", radius) * 2**_SHIFT))
        places, colour = places_of("points", points, (..., 2)), colour_of("colour", colour)
        check_canvas(picture)
        for x, y in self._fixed(places.reshape(-1, 2)).tolist():
            cv2.circle(picture, (x, y), size, colour, cv2.FILLED, cv2.LINE_AA, _SHIFT)

    def robot(self, picture: Picture, pose: ArrayLike, footprint: ArrayLike) -> None:
        """Draw a robot at `pose` (3,), its front in a lighter colour."""
        pose = places_of("pose", pose, (3,))
        footprint = places_of("footprint", footprint, ("K", 2), empty=False)
        front, half = footprint[:, 0].max(), np.abs(footprint[:, 1]).max()
        self.polygon(picture, to_world(pose, footprint), colours.ROBOT)
        nose = [[front, 0.0], [front * 0.55, half * 0.8], [front * 0.55, -half * 0.8]]
        self.polygon(picture, to_world(pose, nose), colours.PAPER)

    def arrow(
        self,
        picture: Picture,
        pose: ArrayLike,
        colour: tuple[int, int, int] = colours.ROBOT,
        size: float = 10.0,
    ) -> None:
        """Mark a pose (3,) by an arrowhead of `size` pixels, for maps on which the car is tiny."""
        pose, size = places_of("pose", pose, (3,)), thickness_of("size", size)
        head = np.array([[1.3, 0.0], [-0.9, 0.9], [-0.5, 0.0], [-0.9, -0.9]])
        rim = head * (size + 3.0) / self.scale
        self.polygon(picture, to_world(pose, rim), colours.PAPER)
        self.polygon(picture, to_world(pose, head * size / self.scale), colour)

    def goal(self, picture: Picture, point: ArrayLike) -> None:
        """Draw a goal at `point` (2,) as a ring around a dot."""
        point = places_of("point", point, (2,))
        for radius, colour in ((0.34, colours.GOAL), (0.24, colours.PAPER), (0.12, colours.GOAL)):
            self.disc(picture, point, radius, colour)

    def seen(self, picture: Picture, pose: ArrayLike, ends: ArrayLike) -> None:
        """Tint what a robot at `pose` (3,) sees: up to the `ends` (P, 2) of its rays, in order."""
        ends, pose = places_of("ends", ends, (..., 2)).reshape(-1, 2), places_of("pose", pose, (3,))
        outline = np.concatenate([pose[None, :2], ends])
        self.polygon(picture, outline, colours.VIEW, 0.5)
        self.polyline(picture, np.concatenate([outline, outline[:1]]), colours.VIEW, 1.5)

    def rays(
        self,
        picture: Picture,
        pose: ArrayLike,
        ends: ArrayLike,
        colour: tuple[int, int, int] = colours.LASER,
    ) -> None:
        """Draw rays from `pose` (3,) to their `ends` (P, 2), with a dot where each one ends."""
        ends, pose = places_of("ends", ends, (..., 2)).reshape(-1, 2), places_of("pose", pose, (3,))
        for end in ends:
            self.polyline(picture, [pose[:2], end], colour, 1)
        self.points(picture, ends, colour, 3.0)

    def _pixels(self, points: Array) -> Array:
        return self._centre + (points - self._middle) * [self.scale, -self.scale]

    def _round(self, picture: Picture, centre: ArrayLike, radius: float) -> tuple[int, int, int]:
        """Middle and radius of a disc in OpenCV's fixed point."""
        check_canvas(picture)
        x, y = self._fixed(places_of("centre", centre, (2,))).tolist()
        radius = number("radius", radius, least=0.0, most=FAR)
        return x, y, round(radius * self.scale * 2**_SHIFT)

    def _fixed(self, points: Array) -> NDArray[np.int32]:
        """Pixels in OpenCV's fixed point; whole numbers are centres of pixels."""
        pixels = self._pixels(points) - 0.5
        return np.round(pixels * 2**_SHIFT).astype(np.int32)

    def _draw_scene(self, scene: Scene) -> Picture:
        picture = np.full((*self.size, 3), colours.PAPER, np.uint8)
        free = self._free(scene)
        reach = 2 * round(_WALL_THICKNESS * self.scale) + 1
        near = cv2.dilate(free, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach)))
        picture[near > 0] = colours.SOLID
        picture[free > 0] = colours.ROOMS["hallway"]
        for room in scene.plan.rooms:
            mask = np.zeros(self.size, np.uint8)
            cv2.fillPoly(mask, [self._fixed(np.asarray(room.outline))], 1, shift=_SHIFT)
            picture[(mask & free) > 0] = colours.ROOMS[room.kind]
        for piece in scene.plan.furniture:
            material = next(m for m in scene.plan.materials if m.name == piece.material)
            self.polygon(picture, piece.outline, material.colour)
        width = max(2, round(0.06 * self.scale))
        for ends, tints in _strokes(scene):
            places = self._fixed(ends).tolist()
            for start, end, tint in zip(places, places[1:], tints, strict=False):
                cv2.line(picture, start, end, tint, width, cv2.LINE_AA, _SHIFT)
        return picture

    def _free(self, scene: Scene) -> NDArray[np.uint8]:
        """(H, W) 1 where the floor is."""
        grid = scene.clearance
        rows, columns = np.indices(self.size)
        offset = (np.stack([columns, rows], axis=-1) + 0.5 - self._centre) / self.scale
        points = offset * [1, -1] + self._middle
        cells = (points - grid.origin) / grid.resolution - 0.5
        depth = cv2.remap(
            grid.clearance,
            cells[..., 0].astype(np.float32),
            cells[..., 1].astype(np.float32),
            cv2.INTER_LINEAR,
        )
        return (depth > grid.resolution / 2).astype(np.uint8)


def _strokes(
    scene: Scene, piece: float = 0.1
) -> Iterable[tuple[NDArray[np.float64], list[list[int]]]]:
    """For every wall and furniture side the ends of short strokes, and their colours as seen."""
    plan = scene.plan
    for segment, material, offset in zip(
        plan.segments, plan.segment_materials, plan.segment_offsets, strict=True
    ):
        run = segment[2:] - segment[:2]
        length = float(np.hypot(*run))
        count = max(1, round(length / piece))
        ends = segment[:2] + np.linspace(0, 1, count + 1)[:, None] * run
        middles = (offset + (np.arange(count) + 0.5) * length / count) % PERIOD
        texels = plan.atlas[material, (middles / TEXEL).astype(int) % TEXELS]
        yield ends, texels.astype(int).tolist()
