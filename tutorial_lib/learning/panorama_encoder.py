"""One panorama to features: circular convolutions over its columns, and a token per direction."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.validation import instance

ROWS, PIXELS, COLUMNS = 16, 192, 48
"""Rows and columns of a panorama, and columns of features that it is reduced to."""
WIDTH, TOKEN, MATCH, SHOWN, OWN, ATTEND = 64, 96, 16, 16, 32, 32
"""Numbers of a column, of a direction's token, of what a column is matched by, of what a matched
column shows, of what a column knows itself, and of the attention between tokens."""
SENSORS = ("rgb", "rgbd")
_STRIDE = PIXELS // COLUMNS
_FARTHEST = 10.0  # metres beyond which depth is all the same


class CircularConvolution(nn.Module):
    """A convolution around the circle: (N, L, C) to (N, L / stride, outputs).

    Output k sees the `width` columns from ``k * stride - lead`` on.
    """

    def __init__(
        self, inputs: int, outputs: int, width: int, stride: int = 1, lead: int = -1
    ) -> None:
        """Set the sizes; the window is in the middle unless `lead` says otherwise.

        Raises:
            InputError: when the width is no multiple of the stride.
        """
        super().__init__()
        if width % stride:
            raise InputError(f"convolution: width {width}, stride {stride}; give a multiple of it")
        self.blocks, self.stride = width // stride, stride
        self.lead = (width - stride) // 2 if lead < 0 else lead
        self.linear = nn.Linear(inputs * width, outputs)

    def forward(self, columns: Tensor) -> Tensor:
        """(N, L, C) to (N, L / stride, outputs)."""
        x = columns.roll(self.lead, 1) if self.lead else columns
        x = x.reshape(len(x), x.shape[1] // self.stride, x.shape[2] * self.stride)
        rest = [x.roll(-block, 1) for block in range(1, self.blocks)]
        return self.linear(torch.cat([x, *rest], dim=-1))


class PatchTokens(nn.Module):
    """Twelve overlapping patches of 12 columns each: (N, 48, C) to (N, 12, outputs).

    Token i belongs to direction i, ``30 i`` degrees counter-clockwise from ahead, whose patch has
    that direction in its middle (see `PanoramicCamera.split`).
    """

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.patches = CircularConvolution(inputs, outputs, 12, COLUMNS // DIRECTIONS, lead=2)
        # Patches come from left to right, and number 5 is the one ahead.
        self.register_buffer("order", (5 - torch.arange(DIRECTIONS)) % DIRECTIONS, persistent=False)

    def forward(self, columns: Tensor) -> Tensor:
        """(N, 48, C) to (N, 12, outputs)."""
        return self.patches(columns)[:, self.order]


class Encoded(NamedTuple):
    """N panoramas, encoded for both roles, source and goal.

    Attributes:
        depth: (N, 48) metres along each column, measured or predicted.
        match: (N, 48, MATCH) of unit length: what a column is found by.
        own: (N, 48, OWN) what a source's column knows.
        shown: (N, 48, SHOWN) what a goal's column shows where it is found.
        local: (N, 12, TOKEN) what a source's direction knows, with its neighbours and the whole.
        query: (N, 12, ATTEND) by which a source's direction asks the goal.
        key: (N, 12, ATTEND) by which a goal's direction answers.
        value: (N, 12, ATTEND) the answer.
        patch: (N, 12, ATTEND) a source's direction in the bilinear term.
        gate: (N, ATTEND) the goal in the bilinear term.
        whole: (N, TOKEN) the goal as a whole.
    """

    depth: Tensor
    match: Tensor
    own: Tensor
    shown: Tensor
    local: Tensor
    query: Tensor
    key: Tensor
    value: Tensor
    patch: Tensor
    gate: Tensor
    whole: Tensor

    def rows(self, index: Tensor) -> Encoded:
        """The panoramas of that index."""
        return Encoded(*(part[index] for part in self))

    def flat(self) -> Tensor:
        """(N, FEATURES) one row for each panorama."""
        return torch.cat([part.flatten(1) for part in self], dim=1)

    @classmethod
    def of(cls, flat: Tensor) -> Encoded:
        """The parts of rows (N, FEATURES).

        Raises:
            InputError: when the rows have another length.
        """
        if flat.ndim != 2 or flat.shape[1] != FEATURES:
            raise InputError(
                f"features: shape {tuple(flat.shape)}; give (N, {FEATURES}) rows that `embed` made"
            )
        parts = flat.split([torch.Size(shape).numel() for shape in _SHAPES], dim=1)
        return cls(*(part.unflatten(1, s) for part, s in zip(parts, _SHAPES, strict=True)))


_SHAPES = (
    *((COLUMNS,), (COLUMNS, MATCH), (COLUMNS, OWN), (COLUMNS, SHOWN), (DIRECTIONS, TOKEN)),
    *((DIRECTIONS, ATTEND),) * 4,
    *((ATTEND,), (TOKEN,)),
)
FEATURES = sum(torch.Size(shape).numel() for shape in _SHAPES)
"""Numbers of a panorama's row of features."""


class PanoramaEncoder(nn.Module):
    """Encodes panoramas; turned by a multiple of 30 degrees, their features only change places."""

    def __init__(self, sensor: str) -> None:
        super().__init__()
        self.sensor = sensor
        self.strip = CircularConvolution(3 * ROWS, WIDTH, 2 * _STRIDE, _STRIDE)
        if sensor == "rgbd":
            self.depth = CircularConvolution(3, WIDTH, 2 * _STRIDE, _STRIDE)
        else:
            self.ranges = nn.Sequential(
                CircularConvolution(WIDTH, OWN, 3), nn.ReLU(), nn.Linear(OWN, _STRIDE)
            )
        self.mix = nn.Sequential(
            CircularConvolution(WIDTH, WIDTH, 5),
            nn.ReLU(),
            CircularConvolution(WIDTH, WIDTH, 5),
            nn.ReLU(),
        )
        self.match = nn.Linear(WIDTH, MATCH)
        self.own = nn.Linear(WIDTH, OWN)
        self.shown = nn.Linear(WIDTH, SHOWN)
        self.tokens = PatchTokens(WIDTH, TOKEN)
        self.whole = nn.Linear(2 * TOKEN, TOKEN)
        self.beside = CircularConvolution(TOKEN, TOKEN, 3)
        self.from_whole = nn.Linear(TOKEN, TOKEN, bias=False)
        self.asked = nn.Linear(TOKEN, 4 * ATTEND)
        self.as_goal = nn.Linear(TOKEN, ATTEND + TOKEN)

    def columns(self, images: Tensor, depth: Tensor | None) -> Tensor:
        """Columns of features (N, 48, WIDTH).

        Args:
            images: (N, 16, 192, 3) uint8.
            depth: (N, 192) metres, for the sensor "rgbd".
        """
        strips = images.movedim(1, 2).flatten(2).float().div_(127.5).sub_(1.0)  # (N, 192, 48)
        x = self.strip(strips)
        if self.sensor == "rgbd":
            x = x + self.depth(_spread(instance("depth", depth, Tensor)))
        return self.mix(x.relu())

    def log_ranges(self, columns: Tensor) -> Tensor:
        """Logarithms (N, 192) of the depth that the sensor "rgb" lacks, in log metres."""
        return self.ranges(columns).flatten(1)

    def encode(self, columns: Tensor, depth: Tensor | None) -> Encoded:
        """Features of panoramas.

        Args:
            columns: (N, 48, WIDTH) from `columns`.
            depth: (N, 192) metres; predicted for the sensor "rgb".
        """
        if self.sensor == "rgbd":
            metres = instance("depth", depth, Tensor).clamp(max=_FARTHEST)
        else:
            metres = self.log_ranges(columns).clamp(max=math.log(_FARTHEST)).exp()
        metres = metres.unflatten(1, (COLUMNS, -1)).mean(-1)
        tokens = self.tokens(columns).relu()
        whole = self.whole(torch.cat([tokens.mean(1), tokens.amax(1)], dim=-1)).relu()
        local = self.beside(tokens) + self.from_whole(whole)[:, None]
        query, key, value, patch = self.asked(tokens).chunk(4, dim=-1)
        gate, goal = self.as_goal(whole).split([ATTEND, TOKEN], dim=-1)
        match = functional.normalize(self.match(columns), dim=-1)
        own, shown = self.own(columns), self.shown(columns)
        return Encoded(metres, match, own, shown, local, query, key, value, patch, gate, goal)


def _spread(depth: Tensor) -> Tensor:
    """Metres (N, 192) as (N, 192, 3) numbers: near, middling and far ones spread out."""
    parts = [
        0.5 / (depth + 0.25),
        depth.clamp(max=3.0) / 1.5 - 1.0,
        depth.clamp(max=_FARTHEST) / 5 - 1,
    ]
    return torch.stack(parts, dim=-1)
