"""One multi-task network for the four functions of Neural Topological SLAM (Chaplot et al. 2020).

It is equivariant to the heading of the source, in steps of 30 degrees, and invariant to that of
the goal: turning a robot on the spot only renumbers its directions.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS, bearing_of, column_bearings
from tutorial_lib.geometry import Array
from tutorial_lib.learning.panorama_encoder import (
    ATTEND,
    COLUMNS,
    OWN,
    PIXELS,
    ROWS,
    SENSORS,
    SHOWN,
    TOKEN,
    CircularConvolution,
    Encoded,
    PanoramaEncoder,
    PatchTokens,
)
from tutorial_lib.world.floorplan import ROOM_KINDS
from tutorial_lib.world.sensors import PanoramicCamera

KINDS = len(ROOM_KINDS) + 1
"""Kinds of room at a direction's end; the last one for no room, such as a doorway."""
PANORAMA = PanoramicCamera()
"""With which it learns."""
HIDDEN = 64
"""Numbers of a direction, from which all heads read."""
_FOUND = 32
_VAGUE = 0.1  # square metres of points below which their rotation says nothing
_SMALL = 0.01  # keeps square roots differentiable


@dataclass(frozen=True)
class PanoramaArchitecture:
    """All that is needed to build a network; it is stored on the card beside its weights.

    Attributes:
        sensor: "rgb", which has a head for the missing depth, or "rgbd".
        goal_blind: whether semantic scores see the source alone (an ablation).
        kind: of the network, "panorama".
    """

    sensor: str
    goal_blind: bool = False
    kind: str = "panorama"

    def __post_init__(self) -> None:
        if self.sensor not in SENSORS or self.kind != "panorama":
            raise InputError(
                f"network: sensor {self.sensor!r} of a {self.kind!r} network; give a panorama "
                f"network one of {', '.join(SENSORS)}"
            )
        if not isinstance(self.goal_blind, bool):
            raise InputError(f"network: goal_blind = {self.goal_blind!r}; give true or false")


class Seen(NamedTuple):
    """What the network predicts of N panoramas alone.

    Attributes:
        explorable: (N, 12) logits (F_G).
        kinds: (N, 12, KINDS) logits of the kind of room at each direction's end.
    """

    explorable: Tensor
    kinds: Tensor


class Compared(NamedTuple):
    """What the network predicts of N pairs of a source and a goal.

    Attributes:
        connection: (N,) logit that both belong to one node (F_L).
        direction: (N, 12) logits of the goal's direction inside the node (F_R).
        offset: (N, 12) the goal's bearing from the middle of each direction, in half bins.
        nearness: (N,) ``max(1 - d / r, 0)`` of the goal inside the node (F_R).
        scores: (N, 12) ``max(1 - d_i / 20 m, 0)`` of each direction (F_S).
        sharp: (N, 12) logits of the best direction, for the listwise loss.
        same_room: (N, 12) logits that a direction's end is in the goal's room.
        position: (N, 2) the goal's place in the source's frame as the matched columns have it, in
            metres; of use where both see the same walls.
    """

    connection: Tensor
    direction: Tensor
    offset: Tensor
    nearness: Tensor
    scores: Tensor
    sharp: Tensor
    same_room: Tensor
    position: Tensor


class _Matched(NamedTuple):
    """Columns of the source (N, 48, SHOWN + 5) as found in the goal, and the motion between both.

    `position` (N, 2) is the goal's; `fit` (N, 3) its distance, its error, and how similar columns
    are.
    """

    columns: Tensor
    position: Tensor
    fit: Tensor


class PanoramaNetwork(nn.Module):
    """Shared encoder, and heads for connection, intra-node pose, openings and semantic scores."""

    def __init__(self, architecture: PanoramaArchitecture) -> None:
        super().__init__()
        self.architecture = architecture
        self.encoder = PanoramaEncoder(architecture.sensor)
        self.openings = nn.Sequential(nn.Linear(TOKEN, 32), nn.ReLU(), nn.Linear(32, 1))
        self.kinds = nn.Linear(TOKEN, KINDS)
        self.sharpness = nn.Parameter(torch.tensor([2.5, 2.0]))
        self.find = nn.Linear(SHOWN + 5, OWN)
        self.found = PatchTokens(OWN, _FOUND)
        self.both = nn.Linear(_FOUND + 2 * ATTEND + 5, TOKEN)
        self.judge = CircularConvolution(TOKEN, HIDDEN, 3)
        self.each = nn.Linear(HIDDEN, 4)  # score, direction, offset, same room
        self.overall = nn.Sequential(nn.Linear(2 * HIDDEN, HIDDEN), nn.ReLU())
        self.of_pair = nn.Linear(HIDDEN, 3)  # connection, nearness, level of the scores
        self.list_scale = nn.Parameter(torch.tensor(2.0))
        self.register_buffer("bearing", _complex(column_bearings(COLUMNS)), persistent=False)
        ahead = _complex(bearing_of(np.arange(DIRECTIONS)))
        self.register_buffer("ahead", ahead, persistent=False)

    def encode(self, images: Tensor, depth: Tensor | None) -> Encoded:
        """Features of panoramas, computed once for all pairs that they are part of.

        Args:
            images: (N, 16, 192, 3) uint8.
            depth: (N, 192) metres; not looked at by the sensor "rgb".

        Raises:
            InputError: when images or depth do not fit the network.
        """
        return self.encoder.encode(self.columns(images, depth), depth)

    def columns(self, images: Tensor, depth: Tensor | None) -> Tensor:
        """Columns of features (N, 48, WIDTH), from which `encode` goes on."""
        if images.shape[1:] != (ROWS, PIXELS, 3) or images.dtype != torch.uint8:
            raise InputError(
                f"panoramas: {images.dtype} of shape {tuple(images.shape)}; give uint8 "
                f"(N, {ROWS}, {PIXELS}, 3)"
            )
        if self.architecture.sensor == "rgbd" and (
            depth is None or depth.shape != (len(images), PIXELS)
        ):
            raise InputError(
                f"panoramas: a network for rgbd needs depth (N, {PIXELS}); give the robot a depth "
                "camera, or take the network for rgb"
            )
        return self.encoder.columns(images, depth)

    def seen(self, encoded: Encoded) -> Seen:
        """What is predicted of panoramas alone."""
        local = encoded.local.relu()
        return Seen(self.openings(local)[..., 0], self.kinds(local))

    def compare(self, sources: Encoded, goals: Encoded) -> Compared:
        """What is predicted of N pairs, from N sources and as many goals."""
        hidden, pooled, position = self.directions(sources, goals)
        score, direction, offset, same_room = self.each(hidden).unbind(-1)
        connection, nearness, level = self.of_pair(pooled).unbind(-1)
        if self.architecture.goal_blind:
            hidden, pooled = self._judged(sources.local)
            score, level = self.each(hidden)[..., 0], self.of_pair(pooled)[..., 2]
        score = score + level[:, None]
        return Compared(
            connection,
            direction,
            offset.tanh(),
            nearness.sigmoid(),
            score.sigmoid(),
            self.list_scale.exp() * score,
            same_room,
            position,
        )

    def directions(self, sources: Encoded, goals: Encoded) -> tuple[Tensor, Tensor, Tensor]:
        """What all heads read of N pairs: of each direction, of all together, and the goal's place.

        Returns:
            hidden (N, 12, HIDDEN), pooled (N, HIDDEN), and position (N, 2), see `Compared`.
        """
        between, position = self._between(sources, goals)
        return *self._judged(sources.local + goals.whole[:, None] + between), position

    def _between(self, sources: Encoded, goals: Encoded) -> tuple[Tensor, Tensor]:
        """(N, 12, TOKEN) what each direction has to do with the goal, and its place (N, 2)."""
        matched = self._matched(sources, goals)
        found = self.found((sources.own + self.find(matched.columns)).relu()).relu()
        attention = (sources.query @ goals.key.transpose(1, 2) / ATTEND**0.5).softmax(-1)
        bilinear = sources.patch * goals.gate[:, None]
        place = _times_conjugate(matched.position[:, None], self.ahead)  # (N, 12, 2)
        fit = matched.fit[:, None].expand(-1, DIRECTIONS, -1)
        parts = [found, attention @ goals.value, bilinear, place, fit]
        return self.both(torch.cat(parts, dim=-1)), matched.position

    def _matched(self, sources: Encoded, goals: Encoded) -> _Matched:
        """Where columns of the source are found in the goal, and how both then lie to each other.

        With points p of the source and q of the goal as complex numbers, weighted by how well they
        match, the rigid motion ``p = R q + t`` of least squares has ``R ~ sum w (p - p0) conj(q -
        q0)`` and ``t = p0 - R q0`` (Umeyama 1991): t is the goal's place. It turns with the source
        and does not change with the goal's heading.
        """
        similar = sources.match @ goals.match.transpose(1, 2)  # (N, 48, 48)
        sharpness, confidence = self.sharpness.exp()
        points = goals.depth[..., None] * self.bearing
        shown = torch.cat([goals.shown, self.bearing.expand_as(points), points], dim=-1)
        shown = (sharpness * similar).softmax(-1) @ shown
        best = similar.amax(-1, keepdim=True)
        weight = (confidence * best).softmax(1)
        p, q = sources.depth[..., None] * self.bearing, shown[..., -2:]
        p0, q0 = ((weight * x).sum(1, keepdim=True) for x in (p, q))
        turn = (weight * _times_conjugate(p - p0, q - q0)).sum(1, keepdim=True)
        turn = turn * (turn.square().sum(-1, keepdim=True) + _VAGUE**2).rsqrt()
        implied = p - _times(turn, q)
        position = p0 - _times(turn, q0)
        error = (weight * (implied - position).square().sum(-1, keepdim=True)).sum(1)
        distance = position[:, 0].square().sum(-1, keepdim=True).add(_SMALL**2).sqrt()
        in_column = [_times(turn, shown[..., -4:-2]), implied]
        in_column = [_times_conjugate(x, self.bearing) for x in in_column]
        columns = torch.cat([shown[..., :-4], *in_column, best], dim=-1)
        fit = torch.cat([distance, (error + _SMALL**2).sqrt(), best.mean(1)], dim=-1)
        return _Matched(columns, position[:, 0], fit)

    def _judged(self, directions: Tensor) -> tuple[Tensor, Tensor]:
        """Hidden numbers of each direction (N, 12, H), and of all together (N, H)."""
        hidden = self.judge(directions.relu()).relu()
        return hidden, self.overall(torch.cat([hidden.mean(1), hidden.amax(1)], dim=-1))


def _complex(angles: Array) -> Tensor:
    """Unit vectors (K, 2) of angles (K,)."""
    return torch.from_numpy(np.stack([np.cos(angles), np.sin(angles)], axis=-1)).float()


def _times(a: Tensor, b: Tensor) -> Tensor:
    """The product of complex numbers (..., 2)."""
    real = a[..., 0] * b[..., 0] - a[..., 1] * b[..., 1]
    return torch.stack([real, a[..., 0] * b[..., 1] + a[..., 1] * b[..., 0]], dim=-1)


def _times_conjugate(a: Tensor, b: Tensor) -> Tensor:
    """The product of complex numbers (..., 2) with conjugates of others."""
    real = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]
    return torch.stack([real, a[..., 1] * b[..., 0] - a[..., 0] * b[..., 1]], dim=-1)
