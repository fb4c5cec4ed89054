"""Input of a network: the camera's image or the laser's scan, 64 columns."""

import re
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.validation import instance, whole
from tutorial_lib.world.raycast import Discs
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, Laser, PanoramicCamera

COLUMNS = 64
DEGREES = 120
"""Of the usual camera, from left to right."""
LEAST_DEGREES, MOST_DEGREES = 21, 170
"""Of another camera's."""
_MIDDLE = slice(16, 80)  # the 64 beams of the full circle's 96 that span 240 degrees
_BEAMS = 96


def named_for(name: str, degrees: int) -> str:
    """What a view, or a network, of the usual camera is called for one of so many degrees.

    >>> named_for("reach_k5", 90), named_for("reach_k5", 120)
    ('reach_k5_90', 'reach_k5')
    """
    return name if degrees == DEGREES or not name else f"{name}_{degrees}"


def usual_name(name: str) -> tuple[str, int]:
    """What `named_for` was given: the name for the usual camera, and the degrees.

    >>> usual_name("reach_k5_90"), usual_name("reach_k5")
    (('reach_k5', 90), ('reach_k5', 120))
    """
    found = re.fullmatch(r"(.+)_([1-9][0-9]{1,2})", name, re.ASCII)
    return (found[1], int(found[2])) if found else (name, DEGREES)


class View(Protocol):
    """How a network gets its images, (..., H, W, C) arrays, and normalizes them."""

    @property
    def name(self) -> str:
        """Its name on a network's card."""

    @property
    def size(self) -> tuple[int, int, int]:
        """Channels, rows and columns of the numbers."""

    @property
    def camera(self) -> Camera:
        """What a robot must carry."""

    def render(self, scene: Scene, poses: Array, discs: Discs | None = None) -> NDArray:
        """Images from poses (..., 3); a disc's owner is the index of a pose."""

    def of(self, observations: Observation) -> NDArray:
        """The robots' images (N, H, W, C)."""

    def vary(self, images: list[NDArray], rng: np.random.Generator) -> list[NDArray]:
        """The same augmentation for the g-th of all (G, ..., H, W, C) `images`."""

    def numbers(self, images: NDArray) -> Tensor:
        """Images (..., H, W, C) as (..., C', H, W), each number about -1 to 1."""


@dataclass(frozen=True)
class CameraView:
    """The camera's images.

    Attributes:
        rows: 16 for learning; 64 show the same in more detail.
        degrees: from left to right, a whole number above 20 and up to 170.

    Raises:
        InputError: for other degrees.
    """

    rows: int = 16
    degrees: int = DEGREES

    def __post_init__(self) -> None:
        whole("degrees", self.degrees, least=LEAST_DEGREES, most=MOST_DEGREES)

    @property
    def name(self) -> str:
        """Its name on a network's card."""
        return named_for(f"camera{self.rows}", self.degrees)

    @property
    def camera(self) -> Camera:
        """What a robot must carry."""
        return Camera(rows=self.rows, field_of_view=float(np.deg2rad(float(self.degrees))))

    @property
    def size(self) -> tuple[int, int, int]:
        """Channels, rows and columns of the numbers."""
        return (3, self.rows, COLUMNS)

    def render(self, scene: Scene, poses: Array, discs: Discs | None = None) -> NDArray[np.uint8]:
        """Images (..., H, W, 3) uint8 from poses (..., 3)."""
        image, _ = self.camera.look(scene, poses.reshape(-1, 3), discs)
        return image.reshape(*poses.shape[:-1], *image.shape[1:])

    def of(self, observations: Observation) -> NDArray[np.uint8]:
        """The robots' images."""
        return observations.image

    def vary(self, images: list[NDArray], rng: np.random.Generator) -> list[NDArray]:
        """Exchange the colour channels, invert some, and change contrast and brightness.

        A world's colours are arbitrary; what matters is where the same ones reappear.
        """
        count = len(images[0])
        order = rng.permuted(np.tile(np.arange(3), (count, 1)), axis=1)
        level = np.linspace(0.0, 1.0, 256)
        gamma = np.exp(rng.normal(0.0, 0.25, (count, 3, 1)))
        gain, shift = rng.normal(1.0, 0.12, (count, 3, 1)), rng.normal(0.0, 0.05, (count, 3, 1))
        tables = np.clip(gain * level**gamma + shift, 0.0, 1.0)
        tables = np.where(rng.random((count, 3, 1)) < 0.5, 1.0 - tables, tables)
        tables = np.rint(255 * tables).astype(np.uint8)
        return [
            np.stack(
                [
                    with_channels(p, order, tables)
                    for p, order, tables in zip(group, order, tables, strict=True)
                ]
            )
            for group in images
        ]

    def numbers(self, images: NDArray) -> Tensor:
        """Images (..., H, W, 3) as (..., 3, H, W) from -1 to 1."""
        _check(images, (self.rows, COLUMNS, 3), np.uint8)
        return _tensor(images).movedim(-1, -3).float().div_(127.5).sub_(1.0)


@dataclass(frozen=True)
class LaserView:
    """The 64 points over 240 degrees of the paper's laser variant, left to right."""

    name: str = "laser"
    size: tuple[int, int, int] = (3, 1, COLUMNS)
    camera: Camera = field(default_factory=Camera)

    def render(self, scene: Scene, poses: Array, discs: Discs | None = None) -> NDArray[np.float32]:
        """Distances (..., 1, 64, 1) in metres from poses (..., 3)."""
        scan = Laser().scan(scene, poses.reshape(-1, 3), discs)
        return self._middle(scan).reshape(*poses.shape[:-1], 1, COLUMNS, 1)

    def of(self, observations: Observation) -> NDArray[np.float32]:
        """The robots' scans."""
        if np.shape(observations.laser)[1:] != (_BEAMS,):
            raise InputError(f"laser: {np.shape(observations.laser)[-1]} beams; give {_BEAMS}")
        return self._middle(observations.laser)[:, None, :, None]

    def vary(self, images: list[NDArray], rng: np.random.Generator) -> list[NDArray]:
        """Distances are not augmented."""
        del rng
        return images

    def numbers(self, images: NDArray) -> Tensor:
        """Distances (..., 1, 64, 1) as (..., 3, 1, 64): near, middling and far ones spread out."""
        _check(images, (1, COLUMNS, 1), np.float32)
        if not np.isfinite(images).all():
            raise InputError("images: a distance is no finite number; give metres")
        return _spread(_tensor(images)[..., 0])

    @staticmethod
    def _middle(scan: NDArray[np.floating]) -> NDArray[np.float32]:
        return np.ascontiguousarray(scan[..., _MIDDLE][..., ::-1], dtype=np.float32)


class DepthView(CameraView):
    """The camera's images, and below them a row with the depth of each column (RGB-D).

    Such a row holds millimetres in two bytes, so that images with depth are arrays of bytes as all
    others are.
    """

    @property
    def name(self) -> str:
        """Its name on a network's card."""
        return named_for(f"rgbd{self.rows}", self.degrees)

    @property
    def size(self) -> tuple[int, int, int]:
        """Channels, rows and columns of the numbers."""
        return (3, self.rows + 1, COLUMNS)

    def render(self, scene: Scene, poses: Array, discs: Discs | None = None) -> NDArray[np.uint8]:
        """Images with depth (..., H + 1, W, 3) uint8 from poses (..., 3)."""
        image, depth = self.camera.look(scene, poses.reshape(-1, 3), discs)
        both = with_depth(image, depth)
        return both.reshape(*poses.shape[:-1], *both.shape[1:])

    def of(self, observations: Observation) -> NDArray[np.uint8]:
        """The robots' images with depth.

        Raises:
            InputError: when they measured none.
        """
        if observations.depth is None:
            raise InputError("depth: none; give observations of a camera that measures it")
        return with_depth(observations.image, observations.depth)

    def vary(self, images: list[NDArray], rng: np.random.Generator) -> list[NDArray]:
        """Other colours, see `CameraView.vary`; depth stays."""
        coloured = super().vary([image[..., :-1, :, :] for image in images], rng)
        depths = [image[..., -1:, :, :] for image in images]
        return [np.concatenate(parts, axis=-3) for parts in zip(coloured, depths, strict=True)]

    def numbers(self, images: NDArray) -> Tensor:
        """Images with depth as (..., 3, H + 1, W); depth as `LaserView` has it."""
        _check(images, (self.rows + 1, COLUMNS, 3), np.uint8)
        colours = super().numbers(images[..., :-1, :, :])
        depth = _spread(_tensor(depth_of(images)[..., None, :]))
        return torch.cat([colours, depth], dim=-2)


def with_depth(image: NDArray[np.uint8], depth: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Images (..., H, W, 3) and depth (..., W) in metres as one array (..., H + 1, W, 3)."""
    whole = np.clip(np.rint(1_000 * depth), 0, 65_535).astype(np.uint16)
    row = np.stack([whole >> 8, whole & 255, np.zeros_like(whole)], axis=-1).astype(np.uint8)
    return np.concatenate([image, row[..., None, :, :]], axis=-3)


def depth_of(images: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(..., W) metres of images with depth (..., H + 1, W, 3)."""
    row = images[..., -1, :, :2].astype(np.float32)
    return (256.0 * row[..., 0] + row[..., 1]) / 1_000.0


VIEWS: dict[str, View] = {
    view.name: view for view in (CameraView(16), CameraView(64), LaserView(), DepthView(16))
}
"""The views of the usual sensors, by the name on a network's card; `view_named` has all."""


def view_named(name: str) -> View:
    """The view of a name such as "camera16", or "camera16_90" for a camera of 90 degrees.

    Raises:
        InputError: when there is none.
    """
    if isinstance(name, str):
        usual, degrees = usual_name(name)
        view = VIEWS.get(usual)
        if isinstance(view, CameraView) and LEAST_DEGREES <= degrees <= MOST_DEGREES:
            view = replace(view, degrees=degrees)
        if view is not None and view.name == name:
            return view
    raise InputError(
        f"view {name!r}; give one of {', '.join(VIEWS)}, or a camera's with other degrees, as "
        "camera16_90"
    )


def view_of(camera: Camera) -> CameraView:
    """The view of 16 rows through a camera that differs from the usual one in its degrees alone.

    Raises:
        InputError: for any other camera.
    """
    angle = float(np.rad2deg(instance("camera", camera, Camera).field_of_view))
    degrees = round(angle)
    if not LEAST_DEGREES <= degrees <= MOST_DEGREES or abs(angle - degrees) > 1e-6:
        raise InputError(
            f"camera: {angle:g} degrees; give a field_of_view of whole degrees, above 20 and up "
            f"to {MOST_DEGREES}"
        )
    view = CameraView(degrees=degrees)
    if replace(camera, field_of_view=view.camera.field_of_view) != view.camera:
        raise InputError(
            f"camera: {camera}; it may differ from the usual one in its field_of_view alone, so "
            "give no rows, columns or slope"
        )
    return view


def check_camera(network: str, seen: Observation, wanted: Camera | PanoramicCamera) -> None:
    """Check that images come from the camera with which a network learned, where that is known.

    Raises:
        InputError: naming the network and both cameras.
    """
    if seen.camera is not None and seen.camera != wanted:
        raise InputError(
            f"camera: {seen.camera}, and {network} learned with {wanted}; give the robot that "
            "camera, or train a network for its own"
        )


def with_channels(
    images: NDArray[np.uint8], order: NDArray[np.intp], tables: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    """Images (..., 3) with channels in another `order` (3,), each through its table (3, 256)."""
    changed = np.empty_like(images)
    for channel, source in enumerate(order):
        changed[..., channel] = tables[channel][images[..., source]]
    return changed


def _spread(metres: Tensor) -> Tensor:
    """Distances (..., H, W) as (..., 3, H, W): near, middling and far ones spread out."""
    parts = [0.5 / (metres + 0.25), metres.clamp(max=3.0) / 1.5 - 1.0, metres / 5.0 - 1.0]
    return torch.stack(parts, dim=-3)


def _tensor(images: NDArray) -> Tensor:
    """The numbers of an array, which may be a view such as one flipped left to right."""
    return torch.from_numpy(np.ascontiguousarray(images))


def _check(images: NDArray, size: tuple[int, ...], kind: type) -> None:
    images = np.asarray(images)
    if images.shape[-3:] != size or images.dtype != kind:
        raise InputError(
            f"images: {images.dtype} of shape {images.shape}; this network takes "
            f"{np.dtype(kind)} (..., {', '.join(map(str, size))}): give the robot that sensor"
        )
