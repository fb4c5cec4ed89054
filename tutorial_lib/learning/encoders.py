"""Comparing two images: the paper's pair encoder in small, and one that matches their columns.

Every encoder has two halves that each see one image, so that they can be computed once and kept,
and `compare`, which is all that is left to do for a pair. Sums are made in place where they can be:
fresh memory costs more time than they do.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from tutorial_lib.learning.tensors import tensor
from tutorial_lib.validation import whole

FEATURES = 96
"""Numbers that describe a pair."""
COLUMNS = 32
"""Columns of features that an image is reduced to."""
_FIRST, _WIDTH = 48, 64


def rows_away(channels: int, rows: int, outputs: int, *, bias: bool = True) -> nn.Conv2d:
    """A convolution that takes in all rows at once: what is left is 32 columns."""
    return nn.Conv2d(channels, outputs, (rows, 5), stride=(1, 2), padding=(0, 2), bias=bias)


class Narrowing(nn.Module):
    """Columns (N, 32, C) to `FEATURES` numbers: twice two neighbours are merged."""

    def __init__(self, width: int, last: int = 64) -> None:
        super().__init__()
        self.first = nn.Linear(2 * width, width)
        self.second = nn.Linear(2 * width, last)
        self.out = nn.Linear(COLUMNS // 4 * last, FEATURES)

    def forward(self, columns: Tensor) -> Tensor:
        """(N, 32, width) to (N, FEATURES)."""
        x = self.first(_merged(columns)).relu_()  # (N, 16, width)
        x = self.second(_merged(x)).relu_()  # (N, 8, last)
        return self.out(x.flatten(1)).relu_()


def _merged(columns: Tensor) -> Tensor:
    """Columns (N, L, C) as (N, L / 2, 2 C), also of no pairs at all."""
    return columns.unflatten(1, (-1, 2)).flatten(2)


def _checked_size(channels: int, rows: int) -> tuple[int, int]:
    channels = whole("channels", channels, least=1, most=1_000)
    return channels, whole("rows", rows, least=1, most=1_000)


class PairEncoder(nn.Module):
    """The paper's encoder of ``[cur, tgt, cur - tgt]``, in small (Meng 2020, III-B and Fig. 3).

    Theirs has four convolutions of 5 x 5 up to 512 channels on 64 x 64 images, some 8.5 million
    parameters with what follows; this one, for images of 16 rows, has 180,000.

    Its first layer is linear, so what it makes of the stacked channels is a sum of what it makes of
    either image alone: ``A cur + B tgt + D (cur - tgt) = (A + D) cur + (B - D) tgt``.
    """

    shape = (_FIRST, 1, COLUMNS)
    """Of an encoded image."""

    def __init__(self, channels: int, rows: int) -> None:
        super().__init__()
        self._size = (*_checked_size(channels, rows), 2 * COLUMNS)
        self.stacked = rows_away(3 * channels, rows, _FIRST)
        self.mix = nn.Conv2d(_FIRST, _WIDTH, (1, 3), padding=(0, 1))
        self.narrow = Narrowing(_WIDTH)

    def current(self, images: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 48, 1, 32), the part of the first layer that sees `cur`."""
        own, _, difference = self.stacked.weight.chunk(3, dim=1)
        return self._first(images, own + difference, self.stacked.bias)

    def target(self, images: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 48, 1, 32), the part of the first layer that sees `tgt`."""
        _, other, difference = self.stacked.weight.chunk(3, dim=1)
        return self._first(images, other - difference, None)

    def compare(self, current: Tensor, targets: Tensor) -> Tensor:
        """(N, P, FEATURES) of `current` (N, ...) and the images of `targets` (N, P, ...)."""
        tensor("current", current, ("N", *self.shape))
        tensor("targets", targets, (len(current), "P", *self.shape))
        x = (current[:, None] + targets).relu_().flatten(0, 1)
        x = self.mix(x).relu_()[:, :, 0]  # (N * P, 64, 32)
        return self.narrow(x.transpose(1, 2)).unflatten(0, targets.shape[:2])

    def _first(self, images: Tensor, weight: Tensor, bias: Tensor | None) -> Tensor:
        layer = self.stacked
        tensor("images", images, ("N", *self._size))
        return functional.conv2d(images, weight, bias, layer.stride, layer.padding)


class MatchingEncoder(nn.Module):
    """Finds each column of the current image again in the target.

    The correlation volume holds the similarity of every column of one image to every column of
    the other. Its softmax along a row says where a column is seen again; what is there, and where
    that is, joins the column's own features.

    A column is described by `first` numbers after all its rows are taken in, and by `mixed` after
    its neighbours are. It is matched by `match` numbers and contributes `width` to the comparison.
    """

    def __init__(
        self,
        channels: int,
        rows: int,
        first: int = 40,
        mixed: int = 48,
        match: int = 16,
        width: int = 32,
    ) -> None:
        super().__init__()
        self.rows = rows_away(channels, rows, first)
        self.mix = nn.Sequential(
            nn.Conv2d(first, mixed, (1, 3), padding=(0, 1)),
            nn.ReLU(inplace=True),
            nn.Conv2d(mixed, mixed, (1, 3), padding=(0, 1)),
            nn.ReLU(inplace=True),
        )
        self.match = nn.Linear(mixed, match)
        self.own = nn.Linear(mixed, width)
        self.shown = nn.Linear(mixed, width)
        self.places = nn.Parameter(0.3 * torch.randn(2, COLUMNS, width))
        self.likeness = nn.Parameter(torch.zeros(width))
        self.sharpness = nn.Parameter(torch.tensor(3.0))
        self.narrow = Narrowing(width, mixed)
        self.sizes = [match, width]
        self.shape = (COLUMNS, match + width)

    def current(self, images: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 32, match + width): what a column is found by, and what it knows."""
        match, columns = self._columns(images)
        return torch.cat([self.sharpness.exp() * match, self.own(columns) + self.places[0]], dim=-1)

    def target(self, images: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 32, match + width): what finds a column, and what it then shows."""
        match, columns = self._columns(images)
        return torch.cat([match, self.shown(columns) + self.places[1]], dim=-1)

    def compare(self, current: Tensor, targets: Tensor) -> Tensor:
        """(N, P, FEATURES) of `current` (N, ...) and the images of `targets` (N, P, ...)."""
        pairs, match = targets.shape[:2], self.sizes[0]
        found_by = current[:, None, :, :match].expand(*pairs, -1, -1).flatten(0, 1)
        targets = targets.flatten(0, 1)
        volume = self.volume(found_by, targets)
        columns = volume.softmax(dim=-1) @ targets[..., match:]
        columns = columns.addcmul_(volume.amax(dim=-1, keepdim=True), self.likeness)
        columns = columns.unflatten(0, pairs).add_(current[:, None, :, match:])
        return self.narrow(columns.flatten(0, 1).relu_()).unflatten(0, pairs)

    def volume(self, current: Tensor, target: Tensor) -> Tensor:
        """The correlation volume (N, 32, 32): rows are columns of the current image."""
        return current[..., : self.sizes[0]] @ target[..., : self.sizes[0]].transpose(1, 2)

    def _columns(self, images: Tensor) -> tuple[Tensor, Tensor]:
        """Directions (N, 32, match) to match by, and features (N, 32, mixed) of the columns."""
        x = self.mix(self.rows(images).relu_())[:, :, 0].transpose(1, 2)
        return functional.normalize(self.match(x), dim=-1), x
