"""Fig. 7 of Meng 2020: how much of a trajectory is followed, against how little of it is kept."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import in_points, measured_over_worlds
from tutorial_lib.experiments.protocols.following import Guide, trajectories
from tutorial_lib.experiments.protocols.local_control import NOISE, WORLDS
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.mapping.sparsify import every_nth, stored_frames

CONTEXTS = ("k0", "k2", "k5")
THRESHOLDS, INTERVALS = (0.9, 0.95, 0.97, 0.99), (10, 20, 30, 40)
"""p_sparsify of ours, and n of SPTM's every n-th frame."""
_QUICK_THRESHOLDS, _QUICK_INTERVALS = (0.9, 0.99), (10, 30)
_EACH, _QUICK_EACH = 8, 10
NOISY = "k2"
"""The context that is driven with actuation noise, too."""

Key = tuple[str, str, str, float]
"""Method, context, condition, threshold or interval."""


def run(options: Options) -> Report:
    """Follow the same trajectories by anchors chosen in every way."""
    begun = time.perf_counter()
    worlds = options.worlds or (WORLDS[:4] if options.quick else WORLDS)
    parts = for_each(follow_all, worlds, options.quick, options.seed, label="meng_fig7")
    where = np.repeat(np.arange(len(parts)), [len(next(iter(p.values()))["length"]) for p in parts])
    joined = {
        key: {name: np.concatenate([part[key][name] for part in parts]) for name in columns}
        for key, columns in parts[0].items()
    }
    rows = [_row(key, columns, where) for key, columns in joined.items()]
    lengths = next(iter(joined.values()))["length"]
    notes = (f"mean length {lengths.mean():.1f} m", *_notes(joined, where))
    took = time.perf_counter() - begun
    return Report("meng_fig7", options.seed, worlds, options.quick, took, rows, notes)


def follow_all(world: int, quick: bool, seed: int) -> dict[Key, dict[str, Array]]:
    """Every way to choose anchors in one world; each value is (M,) over its trajectories."""
    rng = np.random.default_rng([seed, world])
    recorded = trajectories(world, _QUICK_EACH if quick else _EACH, rng)
    thresholds = _QUICK_THRESHOLDS if quick else THRESHOLDS
    intervals = _QUICK_INTERVALS if quick else INTERVALS
    numbers = range(len(recorded.trajectories))
    found: dict[Key, dict[str, Array]] = {}
    for context in CONTEXTS:
        guide = Guide(recorded, context)
        ways = {("meng", p): [guide.anchors(i, p) for i in numbers] for p in thresholds}
        for n in intervals:
            ways["sptm", n] = [
                (frames := recorded.frames_of(i))[every_nth(len(frames), n)] for i in numbers
            ]
        trails = [trail for kept in ways.values() for trail in kept]
        metres = np.split(guide.follow(trails)[0], len(ways))
        for ((method, chosen), kept), covered in zip(ways.items(), metres, strict=True):
            found[method, context, "clean", chosen] = _columns(guide, kept, covered)
        if context == NOISY and not quick:
            ours = {key: kept for key, kept in ways.items() if key[0] == "meng"}
            trails = [trail for kept in ours.values() for trail in kept]
            metres = np.split(guide.follow(trails, NOISE, rng)[0], len(ours))
            for ((method, chosen), kept), covered in zip(ours.items(), metres, strict=True):
                found[method, context, "noise", chosen] = _columns(guide, kept, covered)
    return found


def _columns(guide: Guide, trails: list[Any], covered: Array) -> dict[str, Array]:
    """What was kept of each trajectory, and how much of it was followed; (M,) each."""
    frames = np.array([trail[-1] - trail[0] + 1 for trail in trails], dtype=float)
    arc = guide.recorded.arc
    kept = zip(trails, frames, strict=True)
    return {
        "length": np.array([arc[trail[-1]] - arc[trail[0]] for trail in trails]),
        "covered": covered,
        "anchors": np.array([len(trail) for trail in trails], dtype=float),
        "stored": np.array([stored_frames(t - t[0], int(n), guide.k) for t, n in kept], float),
        "frames": frames,
    }


def _row(key: Key, columns: dict[str, Array], where: Array) -> dict[str, Any]:
    method, context, condition, chosen = key
    rate, low, high = measured_over_worlds(_share, where, columns["covered"], columns["length"])
    return {
        "method": method,
        "context": context,
        "condition": condition,
        "threshold": chosen,
        "sparsity": _share(columns["anchors"], columns["frames"]),
        "stored": _share(columns["stored"], columns["frames"]),
        "trajectories": len(where),
        "cover_rate": rate,
        "low": low,
        "high": high,
    }


def _share(part: Array, whole: Array) -> float:
    return float(part.sum() / whole.sum())


def _notes(joined: dict[Key, dict[str, Array]], where: Array) -> list[str]:
    """Areas between the curves, and what noise costs; in points."""
    notes = []
    for context in CONTEXTS:
        curves = {
            method: [
                columns for key, columns in joined.items() if key[:3] == (method, context, "clean")
            ]
            for method in ("meng", "sptm")
        }
        found = _between(curves["meng"], curves["sptm"], where)
        notes.append(f"area between meng and sptm, {context}: {in_points(found)}")
    for key, noisy in joined.items():
        if key[2] == "noise":
            clean = joined[(*key[:2], "clean", key[3])]
            found = measured_over_worlds(
                lambda a, b, length: _share(a - b, length),
                where,
                clean["covered"],
                noisy["covered"],
                clean["length"],
            )
            notes.append(f"clean - noise, {key[1]} at {key[3]}: {in_points(found)}")
    return notes


def _between(
    ours: list[dict[str, Array]], theirs: list[dict[str, Array]], where: Array
) -> tuple[float, float, float]:
    """Mean gap of two curves over the sparsities that both have, with its interval."""
    count = len(ours)
    names = ("anchors", "frames", "covered", "length")
    columns = [curve[name] for curve in (*ours, *theirs) for name in names]

    def gap(*values: Array) -> float:
        points = np.array(
            [
                (_share(anchors, frames), _share(followed, length))
                for anchors, frames, followed, length in zip(*[iter(values)] * 4, strict=True)
            ]
        )
        first, second = (part[np.argsort(part[:, 0])] for part in (points[:count], points[count:]))
        least, most = max(first[0, 0], second[0, 0]), min(first[-1, 0], second[-1, 0])
        if least >= most:
            return float("nan")
        at = np.linspace(least, most, 50)
        return float((np.interp(at, *first.T) - np.interp(at, *second.T)).mean())

    return measured_over_worlds(gap, where, *columns)
