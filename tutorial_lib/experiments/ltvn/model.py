"""LTVN's model before any navigation: which pairs of a tour's images it calls reachable.

A map consists of the pairs with the highest scores among very many, so what counts is how many of
those far apart it accepts where it finds most of the reachable ones. The threshold of each gate is
the least that accepts `FAR_RATE` of the far pairs of validation worlds.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.ltvn import spaced
from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.experiments.common.experiment import STANDARD, Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.drives import TOUR, part_of
from tutorial_lib.experiments.protocols.navigation_tasks import make_building
from tutorial_lib.geometry import Array
from tutorial_lib.learning.analytic_label import AnalyticLabel
from tutorial_lib.learning.calibration import reliability
from tutorial_lib.learning.estimators import RelativeNetwork
from tutorial_lib.parallel import for_each
from tutorial_lib.se2 import relative, wrap
from tutorial_lib.topology.mapping.depth_agreement import depth_agreement
from tutorial_lib.topology.mapping.image_pool import ImagePool, support
from tutorial_lib.topology.mapping.sparsify import contextified
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.visibility import mutual_overlap

FAR = 5.0
"""Metres apart from which on no pair is reachable."""
FAR_RATE = 3e-4
"""Share of the far pairs that a gate accepts on validation worlds."""
APART, TURNED = 0.64, 0.7
"""Metres, or rad, between two images of a drive."""
LOOP = "loop_corridor"
"""The family in which places look alike; its rows stand apart."""
AGREES, SUPPORTED = 0.8, 0.6
"""Of the depths of a pair, and of the images between it, that must agree."""
LIKELY = 0.02
"""Below this score no depths are compared."""
GATES = {
    "mined": ("relative_0", ()),
    "depth": ("relative_0", ("depth",)),
    "support": ("relative_0", ("support",)),
    "context": ("relative_5", ()),
    "context, depth": ("relative_5", ("depth",)),
    "context, support": ("relative_5", ("support",)),
    "all": ("relative_5", ("depth", "support")),
    "context, RGB": ("relative_rgb", ()),
    "context, RGB, support": ("relative_rgb", ("support",)),
}
"""By name the network and what a pair must pass besides: single images as in the paper, with mined
far pairs; agreement of depth; support of neighbours; the same with the target's context; and with
it, but without depth."""
VALIDATION = tuple(range(10_000, 10_006))


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        gates: of `GATES`.
        validation: worlds on which thresholds are chosen.
    """

    gates: tuple[str, ...] = tuple(GATES)
    validation: tuple[int, ...] = VALIDATION


@dataclass(frozen=True, eq=False)
class Scored:
    """All P ordered pairs of one tour's images.

    Attributes:
        family: of the world.
        far, reachable, seen: (P,) whether a pair is far, has the label, and shares what it sees.
        scores: by gate (P,) r-hat, and 0 where the gate closes.
        off: by network the errors (R, 2) of the reachable pairs' positions and headings.
    """

    family: str
    far: NDArray[np.bool_]
    reachable: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    scores: dict[str, Array]
    off: dict[str, Array]


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Score all pairs of validation worlds, choose thresholds, and count on the other worlds."""
    worlds = [(world, STANDARD) for world in settings.validation]
    worlds += [(world, options.palette) for world in options.worlds]
    found = for_each(scored, worlds, options.seed, settings.gates, label="ltvn_model")
    chosen, measured = found[: len(settings.validation)], found[len(settings.validation) :]
    rows: Rows = []
    for gate in settings.gates:
        limit = threshold([part for part in chosen if part.family != LOOP], gate)
        for family in ("others", LOOP):
            parts = [part for part in measured if (part.family == LOOP) == (family == LOOP)]
            if parts:
                rows.append(row_of(gate, family, limit, parts))
    notes = [
        f"threshold: accepts {FAR_RATE:.2%} of the pairs more than {FAR:g} m apart in validation "
        f"worlds other than {LOOP}",
        "waypoint_error, yaw_error: medians over reachable pairs, metres and degrees",
    ]
    return rows, notes


def scored(item: tuple[int, str], seed: int, gates: tuple[str, ...]) -> Scored:
    """What every gate says about all pairs of the tour of one world with its palette."""
    world, palette = item
    whole = make_building(world, seed, palette=palette)
    models = {name: RelativeNetwork(name) for name in dict.fromkeys(GATES[g][0] for g in gates)}
    return scores_of(part_of(whole, TOUR, seed).recorded, models, gates)


def scores_of(
    recorded: RecordedWorld, models: dict[str, RelativeNetwork], gates: tuple[str, ...]
) -> Scored:
    """What gates say about all pairs of images of recorded drives.

    Args:
        recorded: the drives.
        models: of the gates' networks, by name.
        gates: of `GATES`.
    """
    kept = [
        frames[spaced(recorded.poses[frames], APART, TURNED)]
        for frames in map(recorded.frames_of, range(len(recorded.trajectories)))
    ]
    poses = recorded.poses[np.concatenate(kept)]
    count = len(poses)
    source, target = (pairs.ravel() for pairs in np.indices((count, count)))
    source, target = source[source != target], target[source != target]
    seen = relative(poses[source], poses[target])
    metres = np.hypot(seen[:, 0], seen[:, 1])
    near = np.flatnonzero(metres < FAR)
    caster = recorded.scene.caster
    overlap = mutual_overlap(caster, poses[source[near]], poses[target[near]])
    straight = ReachabilityPairs(poses[source[near]], target[near], overlap, metres[near])
    reachable, shared = np.zeros((2, len(metres)), bool)
    reachable[near] = AnalyticLabel()(caster, straight, poses[target[near]])
    shared[near] = straight.seen
    scores, off = {}, {}
    for name, model in models.items():
        pool = ImagePool(model)
        for drive, frames in enumerate(kept):
            all_frames = recorded.frames_of(drive)
            context = contextified(all_frames[:, None], model.k)[frames - all_frames[0]][..., 0]
            images = model.view.render(recorded.scene, recorded.poses[context])
            observations = recorded.observe(frames, depth=True)
            pool.add(observations, images, np.full(len(frames), drive), np.arange(len(frames)))
        passes = _passes(pool, source, target)
        pairs = pool.reachable[source, target]
        for gate in gates:
            network, needed = GATES[gate]
            if network == name:
                scores[gate] = np.where(_all(passes, needed, len(pairs)), pairs, 0.0)
        error = pool.waypoints[source, target][reachable] - seen[reachable]
        off[name] = np.column_stack([np.hypot(error[:, 0], error[:, 1]), abs(wrap(error[:, 2]))])
    return Scored(recorded.scene.plan.family, metres > FAR, reachable, shared, scores, off)


def _passes(pool: ImagePool, source: NDArray, target: NDArray) -> dict[str, NDArray[np.bool_]]:
    """Which pairs pass each check."""
    supported = support(pool, pool.reachable > 0.5)[source, target] >= SUPPORTED
    images = pool.observations[np.arange(len(pool))]
    depth = np.asarray(images.depth)
    bearings = Camera().fan.angles[::-1]
    likely = np.flatnonzero(pool.reachable[source, target] > LIKELY)
    source, target = source[likely], target[likely]
    waypoints = pool.waypoints[source, target]
    agree = np.zeros(len(supported), bool)
    agree[likely] = depth_agreement(depth[source], depth[target], waypoints, bearings) >= AGREES
    return {"support": supported, "depth": agree}


def _all(passes: dict[str, NDArray[np.bool_]], needed: tuple[str, ...], count: int) -> NDArray:
    return np.logical_and.reduce([np.ones(count, bool), *(passes[name] for name in needed)])


def threshold(parts: list[Scored], gate: str) -> float:
    """The least score that at most `FAR_RATE` of the far pairs exceed."""
    far = np.sort(np.concatenate([part.scores[gate][part.far] for part in parts]))
    return float(far[-1 - int(FAR_RATE * len(far))])


def row_of(gate: str, family: str, limit: float, parts: list[Scored]) -> dict[str, Any]:
    """What a gate with that threshold accepts of the pairs of several worlds."""
    score, far, reachable, seen = (
        np.concatenate(columns)
        for columns in zip(
            *((part.scores[gate], part.far, part.reachable, part.seen) for part in parts),
            strict=True,
        )
    )
    network, _ = GATES[gate]
    off = np.concatenate([part.off[network] for part in parts])
    accepted = score > limit
    return {
        "sensor": "rgb" if network == "relative_rgb" else "rgbd",
        "gate": gate,
        "family": family,
        "worlds": len(parts),
        "pairs": len(score),
        "threshold": limit,
        "far_rate": float(accepted[far].mean()),
        "recall": float(accepted[reachable].mean()),
        "precision": float(reachable[accepted].mean()) if accepted.any() else None,
        "far_share": float(far[accepted].mean()) if accepted.any() else None,
        "waypoint_error": float(np.median(off[:, 0])),
        "yaw_error": float(np.rad2deg(np.median(off[:, 1]))),
        "ece": reliability(score[seen], reachable[seen].astype(float)).ece,
    }


EXPERIMENT = Experiment(
    "ltvn_model",
    run,
    tuple(range(20_000, 20_009)),
    tuple(range(20_000, 20_004)),
    settings=Settings(),
    quick_settings=Settings(gates=("mined", "all"), validation=VALIDATION[:4]),
    canary=Settings(gates=("mined",), validation=VALIDATION[:1]),
    accepts=frozenset({"palette"}),
)
