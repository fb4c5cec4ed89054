"""Fig. 7 of Meng 2020: how much of a trajectory is followed, against how much of it is kept."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import METRES, Finding, Options, Rows
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.protocols.following import Guide, trajectories
from tutorial_lib.experiments.protocols.local_control import NOISE, WORLDS
from tutorial_lib.experiments.protocols.odometry import Odometry
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.mapping.sparsify import every_nth, stored_frames

Key = tuple[str, str, str, float]
"""Method, context, condition, threshold or interval."""


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 7.

    Attributes:
        contexts: of C and RE.
        thresholds: p_sparsify of Meng 2020.
        intervals: n of SPTM, which keeps every n-th frame.
        trajectories: in each world.
        noisy: the contexts that are also driven with actuation noise.
    """

    contexts: tuple[str, ...] = ("k0", "k2", "k5")
    thresholds: tuple[float, ...] = (0.9, 0.95, 0.97, 0.99)
    intervals: tuple[int, ...] = (10, 20, 30, 40)
    trajectories: int = 8
    noisy: tuple[str, ...] = ("k2",)


QUICK = Settings(thresholds=(0.9, 0.99), intervals=(10, 30), trajectories=10, noisy=())


def run(options: Options, settings: Settings) -> tuple[Rows, list[Finding]]:
    """Follow the same trajectories by anchors chosen in every way."""
    parts = for_each(run_world, options.worlds, options, settings, label="meng_fig7")
    world = np.repeat(np.arange(len(parts)), [len(next(iter(p.values()))["length"]) for p in parts])
    joined = {
        key: {name: np.concatenate([part[key][name] for part in parts]) for name in columns}
        for key, columns in parts[0].items()
    }
    rows = [_row(key, columns, world) for key, columns in joined.items()]
    lengths = next(iter(joined.values()))["length"]
    mean = Finding("mean length", float(lengths.mean()), form=METRES)
    return rows, [mean, *_differences(joined, world)]


def run_world(world: int, options: Options, settings: Settings) -> dict[Key, dict[str, Array]]:
    """Every choice of anchors in one world; each value is (M,) over its trajectories."""
    rng = np.random.default_rng([options.seed, world])
    recorded = trajectories(world, settings.trajectories, rng, options.family)
    indices = range(len(recorded.trajectories))
    found: dict[Key, dict[str, Array]] = {}
    for context in settings.contexts:
        guide = Guide(recorded, context, Odometry(options.drifts, (options.seed, world)))
        choices = {("meng", p): [guide.anchors(i, p) for i in indices] for p in settings.thresholds}
        ours = list(choices)
        for n in settings.intervals:
            choices["sptm", n] = [
                (frames := recorded.frames_of(i))[every_nth(len(frames), n)] for i in indices
            ]
        found |= _followed(guide, choices, "clean")
        if context in settings.noisy:
            found |= _followed(guide, {key: choices[key] for key in ours}, "noise", NOISE, rng)
    return found


def _followed(
    guide: Guide,
    choices: dict[tuple[str, float], list[Any]],
    condition: str,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
) -> dict[Key, dict[str, Array]]:
    """The columns of each choice of anchors; all are followed in one rollout."""
    paths = [anchors for kept in choices.values() for anchors in kept]
    metres = np.split(guide.follow(paths, noise, rng)[0], len(choices))
    return {
        (method, guide.context, condition, chosen): _columns(guide, kept, covered)
        for ((method, chosen), kept), covered in zip(choices.items(), metres, strict=True)
    }


def _columns(guide: Guide, kept: list[Any], covered: Array) -> dict[str, Array]:
    """How much of each trajectory was kept, and how much of it was followed; (M,) each."""
    frames = np.array([anchors[-1] - anchors[0] + 1 for anchors in kept], dtype=float)
    arc = guide.recorded.arc
    stored = [
        stored_frames(anchors - anchors[0], int(count), guide.k)
        for anchors, count in zip(kept, frames, strict=True)
    ]
    return {
        "length": np.array([arc[anchors[-1]] - arc[anchors[0]] for anchors in kept]),
        "covered": covered,
        "anchors": np.array([len(anchors) for anchors in kept], dtype=float),
        "stored": np.array(stored, dtype=float),
        "frames": frames,
    }


def _row(key: Key, columns: dict[str, Array], world: NDArray[np.intp]) -> dict[str, Any]:
    method, context, condition, chosen = key
    rate, low, high = measured_over_worlds(_share, world, columns["covered"], columns["length"])
    return {
        "method": method,
        "context": context,
        "condition": condition,
        "threshold": chosen,
        "sparsity": _share(columns["anchors"], columns["frames"]),
        "stored": _share(columns["stored"], columns["frames"]),
        "trajectories": len(world),
        "cover_rate": rate,
        "low": low,
        "high": high,
    }


def _share(part: Array, whole: Array) -> float:
    return float(part.sum() / whole.sum())


def _differences(joined: dict[Key, dict[str, Array]], world: NDArray[np.intp]) -> list[Finding]:
    """Areas between the curves, and the loss by noise; in points."""
    found = []
    for context in dict.fromkeys(key[1] for key in joined):
        curves = {
            method: [
                columns for key, columns in joined.items() if key[:3] == (method, context, "clean")
            ]
            for method in ("meng", "sptm")
        }
        area = _between(curves["meng"], curves["sptm"], world)
        found.append(Finding(f"area between meng and sptm, {context}", *area))
    for key, noisy in joined.items():
        if key[2] == "noise":
            clean = joined[(*key[:2], "clean", key[3])]
            loss = measured_over_worlds(
                lambda a, b, length: _share(a - b, length),
                world,
                clean["covered"],
                noisy["covered"],
                clean["length"],
            )
            found.append(Finding(f"clean - noise, {key[1]} at {key[3]}", *loss))
    return found


def _between(
    ours: list[dict[str, Array]], theirs: list[dict[str, Array]], world: NDArray[np.intp]
) -> tuple[float, float, float]:
    """Mean gap of two curves over the sparsities that they share, with its interval."""
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

    return measured_over_worlds(gap, world, *columns)


EXPERIMENT = Experiment(
    "meng_fig7",
    run,
    WORLDS,
    WORLDS[:4],
    Settings(),
    QUICK,
    canary=replace(QUICK, thresholds=(0.99,), intervals=(20,), trajectories=1),
    accepts=frozenset({"family", "odometry"}),
)
