"""Sensors that look at a `Scene` from many poses at once: camera, panorama and laser."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import flag, floats, images, instance, number, whole
from tutorial_lib.world.paint import paint_columns, paint_rows
from tutorial_lib.world.raycast import Discs, Fan, Hits
from tutorial_lib.world.scene import Scene

EYE = 0.25
"""Metres of the camera above the floor."""
WALL_HEIGHT = 1.0
"""Metres; furniture and people are as high."""
MOST_COLUMNS = 100_000
"""Of an image, and rows, and beams of a laser."""

Viewers = NDArray[np.int32]

_HEIGHTS = np.array([WALL_HEIGHT - EYE, -EYE], np.float32)
_NO_DISCS = np.zeros((0, 3), np.float32)


class _Eye:
    """What both cameras share; each defines where its columns look."""

    def look(
        self: "Camera | PanoramicCamera",
        scene: Scene,
        poses: NDArray[np.float64],
        discs: Discs | None = None,
        viewers: Viewers | None = None,
    ) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
        """Render an image from every pose.

        Args:
            scene: the world.
            poses: (N, 3).
            discs: people and obstacles.
            viewers: (N,) which robot looks; see `Raycaster.cast`.

        Returns:
            image (N, H, W, 3) uint8 RGB, left column = left of view; and depth (N, W), metres to
            the wall along each column's ray.
        """
        instance("scene", scene, Scene)
        poses = np.ascontiguousarray(floats("poses", poses, ("N", 3)))
        hits = scene.caster.cast(poses, self.fan, discs, viewers)
        image = _paint(self, scene, poses, hits, discs)
        return image, np.ascontiguousarray(hits.distance[:, ::-1])


@dataclass(frozen=True)
class Camera(_Eye):
    """A pinhole camera at the robot's pose, looking ahead.

    Columns are equally wide on the image plane. An image with fewer rows is the same image with
    taller pixels: each of its rows is the mean of those it replaces.

    Attributes:
        rows: 16 for learning, 64 for people.
        columns: pixels from left to right.
        field_of_view: horizontal, radians.
        slope: of the image's upper edge, tan(30 degrees); its lower edge mirrors it.
    """

    rows: int = 16
    columns: int = 64
    field_of_view: float = float(np.deg2rad(120.0))
    slope: float = float(np.tan(np.deg2rad(30.0)))

    def __post_init__(self) -> None:
        _check_picture(self.rows, self.columns, self.slope)
        if not number("field_of_view", self.field_of_view, above=0) < np.pi:
            raise InputError(f"field_of_view: {self.field_of_view} rad; give one below pi")

    @cached_property
    def fan(self) -> Fan:
        """One ray through the middle of each column, from right to left."""
        edge = np.tan(self.field_of_view / 2)
        middle = (np.arange(self.columns) + 0.5) * 2 / self.columns - 1
        return Fan(np.arctan(edge * middle))

    @cached_property
    def spread(self) -> NDArray[np.float32]:
        """(W,) radians that each ray's column covers."""
        edge = np.tan(self.field_of_view / 2)
        borders = np.arctan(edge * (np.arange(self.columns + 1) * 2 / self.columns - 1))
        return np.diff(borders).astype(np.float32)

    @cached_property
    def flatten(self) -> NDArray[np.float32]:
        """(W,) depth along the optical axis over the ray's length."""
        return np.cos(self.fan.angles).astype(np.float32)


@dataclass(frozen=True)
class PanoramicCamera(_Eye):
    """A camera that looks all around: column 0 looks backwards, the middle one ahead.

    Attributes:
        rows: pixels from top to bottom.
        columns: equally wide in angle.
        patches: overlapping parts, centred ``2 pi / patches`` apart.
        patch_columns: columns of each part.
        slope: as for `Camera`.
    """

    rows: int = 16
    columns: int = 192
    patches: int = 12
    patch_columns: int = 48
    slope: float = float(np.tan(np.deg2rad(30.0)))

    def __post_init__(self) -> None:
        _check_picture(self.rows, self.columns, self.slope)
        whole("patches", self.patches, least=1)
        whole("patch_columns", self.patch_columns, least=1, most=self.columns)
        if self.columns % self.patches:
            raise InputError(
                f"columns: {self.columns} in {self.patches} patches; give a multiple of patches"
            )

    @cached_property
    def fan(self) -> Fan:
        """One ray through the middle of each column, counter-clockwise from behind."""
        return Fan(full_circle(self.columns))

    @cached_property
    def spread(self) -> NDArray[np.float32]:
        """(W,) radians that each ray's column covers."""
        return np.full(self.columns, 2 * np.pi / self.columns, np.float32)

    @cached_property
    def flatten(self) -> NDArray[np.float32]:
        """(W,) ones: the image lies on a cylinder."""
        return np.ones(self.columns, np.float32)

    def split(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Cut panoramas (N, H, W, 3) into patches (N, P, H, V, 3).

        Patch p is centred on the direction ``p * 2 pi / P``, counter-clockwise from ahead.
        """
        image = images("image", image, ("N", "H", self.columns, 3))
        step = self.columns // self.patches
        centre = self.columns // 2 - step * np.arange(self.patches)
        offset = np.arange(self.patch_columns) - self.patch_columns // 2
        columns = (centre[:, None] + offset) % self.columns
        return np.moveaxis(image[:, :, columns], 1, 2)


@dataclass(frozen=True)
class Laser:
    """A laser scanner at the robot's pose; beams are equally spaced in angle.

    The 64 middle beams of the full circle's 96 are the 64-point, 240 degree scan of Meng 2020.

    Attributes:
        beams: number of beams.
        field_of_view: radians.
        range: metres; farther distances are reported as this.
    """

    beams: int = 96
    field_of_view: float = 2 * np.pi
    range: float = 10.0

    def __post_init__(self) -> None:
        whole("beams", self.beams, least=1, most=MOST_COLUMNS)
        number("field_of_view", self.field_of_view, above=0, most=2 * np.pi)
        number("range", self.range, above=0, infinite=True)

    @cached_property
    def fan(self) -> Fan:
        """The beams, counter-clockwise from the right end."""
        return Fan(full_circle(self.beams) * self.field_of_view / (2 * np.pi))

    def scan(
        self,
        scene: Scene,
        poses: NDArray[np.float64],
        discs: Discs | None = None,
        viewers: Viewers | None = None,
    ) -> NDArray[np.float64]:
        """Distances (N, B) in metres from every pose, at most `range`."""
        caster = instance("scene", scene, Scene).caster
        return np.minimum(caster.cast(poses, self.fan, discs, viewers).distance, self.range)


@dataclass(frozen=True)
class Sensors:
    """What a robot carries.

    Attributes:
        camera: takes the images; None where only the laser is needed.
        laser: scans the full circle.
        with_depth: whether observations include depth.
    """

    camera: Camera | PanoramicCamera | None = field(default_factory=Camera)
    laser: Laser = field(default_factory=Laser)
    with_depth: bool = False

    def __post_init__(self) -> None:
        if self.camera is not None and not isinstance(self.camera, Camera | PanoramicCamera):
            raise InputError(f"camera: a {type(self.camera).__name__}; give a Camera or None")
        instance("laser", self.laser, Laser)
        flag("with_depth", self.with_depth)
        if self.laser.field_of_view < 2 * np.pi:
            raise InputError("laser: a robot's laser scans the full circle; give 2 pi")
        if self.with_depth and self.camera is None:
            raise InputError("with_depth: depth needs a camera; give one, or with_depth=False")


def full_circle(count: int) -> NDArray[np.float64]:
    """Middle angles of `count` equal parts of the circle, rising from -pi."""
    count = whole("count", count, least=1, most=MOST_COLUMNS)
    return (np.arange(count, dtype=float) + 0.5) * (2 * np.pi / count) - np.pi


def beams_of(laser: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (B, 2) in the robot's frame where the beams of a full-circle scan (B,) end."""
    angles = full_circle(len(laser))
    return laser[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _check_picture(rows: int, columns: int, slope: float) -> None:
    whole("rows", rows, least=1, most=MOST_COLUMNS)
    whole("columns", columns, least=2, most=MOST_COLUMNS)
    number("slope", slope, above=0)


def _paint(
    camera: Camera | PanoramicCamera,
    scene: Scene,
    poses: NDArray[np.float64],
    hits: Hits,
    discs: Discs | None,
) -> NDArray[np.uint8]:
    """Pixels (N, H, W, 3) from what a camera's rays met."""
    count, width = hits.distance.shape
    colours = np.empty((count, width, 3), np.float32)
    nearness = np.empty((count, width), np.float32)
    shades = _NO_DISCS if discs is None else scene.plan.look.tone(discs.colours)
    found = (hits.distance, hits.wall, hits.along, camera.fan.directions, poses)
    walls = (scene.surfaces, scene.strips, shades)
    paint_columns(*found, *walls, camera.spread, camera.flatten, colours, nearness)
    image = np.empty((count, camera.rows, 3 * width), np.uint8)
    flat = colours.reshape(count, 3 * width)
    paint_rows(flat, nearness, _HEIGHTS, camera.slope, scene.backdrop, image)
    return image.reshape(count, camera.rows, width, 3)
