"""Comparing two pictures: the paper's pair encoder, and one that matches their columns.

Every encoder has two halves that each see one picture, so that they can be computed once and kept,
and `compare`, which is all that is left to do for a pair.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

FEATURES = 96
"""Numbers that describe a pair."""
COLUMNS = 32
"""Columns of features that a picture is reduced to."""
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
        count = len(columns)
        x = functional.relu(self.first(columns.reshape(count, COLUMNS // 2, -1)))  # (N, 16, width)
        x = functional.relu(self.second(x.view(count, COLUMNS // 4, -1)))  # (N, 8, last)
        return functional.relu(self.out(x.flatten(1)))


class PairEncoder(nn.Module):
    """The paper's encoder of ``[cur, tgt, cur - tgt]`` (Meng 2020, III-B).

    Its first layer is linear, so what it makes of the stacked channels is a sum of what it makes of
    either picture alone: ``A cur + B tgt + D (cur - tgt) = (A + D) cur + (B - D) tgt``.
    """

    def __init__(self, channels: int, rows: int) -> None:
        super().__init__()
        self.stacked = rows_away(3 * channels, rows, _FIRST)
        self.mix = nn.Conv2d(_FIRST, _WIDTH, (1, 3), padding=(0, 1))
        self.narrow = Narrowing(_WIDTH)

    def current(self, pictures: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 48, 1, 32), the part of the first layer that sees `cur`."""
        own, _, difference = self.stacked.weight.chunk(3, dim=1)
        return self._first(pictures, own + difference, self.stacked.bias)

    def target(self, pictures: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 48, 1, 32), the part of the first layer that sees `tgt`."""
        _, other, difference = self.stacked.weight.chunk(3, dim=1)
        return self._first(pictures, other - difference, None)

    def compare(self, current: Tensor, target: Tensor) -> Tensor:
        """(N, FEATURES) of pairs."""
        x = functional.relu(current + target)
        x = functional.relu(self.mix(x))[:, :, 0]  # (N, 64, 32)
        return self.narrow(x.transpose(1, 2))

    def _first(self, pictures: Tensor, weight: Tensor, bias: Tensor | None) -> Tensor:
        layer = self.stacked
        return functional.conv2d(pictures, weight, bias, layer.stride, layer.padding)


class MatchingEncoder(nn.Module):
    """Finds each column of either picture again in the other one.

    The correlation volume holds the similarity of every column of one picture to every column of
    the other. Its softmax along a row says where a column is seen again; what is there, and where
    that is, joins the column's own features.
    """

    def __init__(self, channels: int, rows: int, match: int = 24, width: int = 48) -> None:
        super().__init__()
        self.rows = rows_away(channels, rows, _FIRST)
        self.mix = nn.Sequential(
            nn.Conv2d(_FIRST, _WIDTH, (1, 3), padding=(0, 1)),
            nn.ReLU(),
            nn.Conv2d(_WIDTH, _WIDTH, (1, 3), padding=(0, 1)),
            nn.ReLU(),
        )
        self.match = nn.Linear(_WIDTH, match)
        self.own = nn.ModuleList([nn.Linear(_WIDTH, width) for _ in range(2)])
        self.shown = nn.ModuleList([nn.Linear(_WIDTH, width, bias=False) for _ in range(2)])
        self.place = nn.Parameter(0.3 * torch.randn(4, COLUMNS, width))
        self.likeness = nn.Parameter(torch.zeros(2, width))
        self.sharpness = nn.Parameter(torch.tensor(3.0))
        self.narrow = nn.ModuleList([Narrowing(width) for _ in range(2)])
        self.sizes = [match, width, width]

    def current(self, pictures: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 32, match + 2 width)."""
        return self._describe(pictures, 0)

    def target(self, pictures: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 32, match + 2 width)."""
        return self._describe(pictures, 1)

    def compare(self, current: Tensor, target: Tensor) -> Tensor:
        """(N, FEATURES) of pairs."""
        match, own, shown = current.split(self.sizes, dim=-1)
        other_match, other_own, other_shown = target.split(self.sizes, dim=-1)
        volume = self.sharpness.exp() * match @ other_match.transpose(1, 2)  # (N, 32, 32)
        there = self._join(0, volume, own, other_shown)
        back = self._join(1, volume.transpose(1, 2), other_own, shown)
        return self.narrow[0](there) + self.narrow[1](back)

    def _describe(self, pictures: Tensor, side: int) -> Tensor:
        """What each column is found by, what it knows, and what it shows to those who find it."""
        x = self.mix(functional.relu(self.rows(pictures)))[:, :, 0].transpose(1, 2)  # (N, 32, 64)
        match = functional.normalize(self.match(x), dim=-1)
        own = self.own[side](x) + self.place[side]
        shown = self.shown[side](x) + self.place[2 + side]
        return torch.cat([match, own, shown], dim=-1)

    def _join(self, side: int, volume: Tensor, own: Tensor, shown: Tensor) -> Tensor:
        """Columns (N, 32, width) with what they find in the other picture."""
        found = volume.softmax(dim=-1) @ shown
        best = volume.amax(dim=-1, keepdim=True) * self.likeness[side]
        return functional.relu(own + found + best)


class SeparateEncoder(nn.Module):
    """An ablation: either picture becomes a feature vector alone, and only those are compared."""

    def __init__(self, channels: int, rows: int) -> None:
        super().__init__()
        self.rows = rows_away(channels, rows, _FIRST)
        self.mix = nn.Conv2d(_FIRST, _WIDTH, (1, 3), padding=(0, 1))
        self.narrow = Narrowing(_WIDTH)
        self.both = nn.Linear(2 * FEATURES, FEATURES)

    def current(self, pictures: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, FEATURES)."""
        x = functional.relu(self.mix(functional.relu(self.rows(pictures))))
        return self.narrow(x[:, :, 0].transpose(1, 2))

    target = current

    def compare(self, current: Tensor, target: Tensor) -> Tensor:
        """(N, FEATURES) of pairs."""
        return functional.relu(self.both(torch.cat([current, target], dim=-1)))


class StackedEncoder(nn.Module):
    """An ablation: the current picture and all of the target's in one stack of channels."""

    def __init__(self, channels: int, rows: int, pictures: int) -> None:
        super().__init__()
        self.first = rows_away(channels, rows, _FIRST)
        self.others = rows_away(pictures * channels, rows, _FIRST, bias=False)
        self.mix = nn.Conv2d(_FIRST, _WIDTH, (1, 3), padding=(0, 1))
        self.narrow = Narrowing(_WIDTH)

    def current(self, pictures: Tensor) -> Tensor:
        """(N, C, H, 64) to (N, 48, 1, 32)."""
        return self.first(pictures)

    def target(self, pictures: Tensor) -> Tensor:
        """(N, P * C, H, 64) to (N, 48, 1, 32)."""
        return self.others(pictures)

    compare = PairEncoder.compare
