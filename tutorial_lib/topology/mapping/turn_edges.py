"""Edges along which a robot turns where it stands: from a drive to one that looks another way.

Two pictures that look opposite ways at one place have nothing in common, so that RE joins no two
drives there. Where a scan of the full circle lies on that of a vertex, and the walls around have
the same colours as seen on either drive, the places are the same: the scans tell by how much to
turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation
from tutorial_lib.se2 import Array, relative, to_world, wrap
from tutorial_lib.topology.mapping.anchors import Anchors
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch
from tutorial_lib.topology.mapping.scan_matching import likely_rotations, match_scans
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.validation import alike, floats, instance, integers, number, whole
from tutorial_lib.world.sensors import Camera, full_circle

_BESIDE = 3  # anchors before and after, whose pictures show the walls around, too
_SEEN = 5.0  # metres up to which colours are compared
_SAME = 0.2  # metres between two sights of the same wall
_SIGHTS = 12  # of a wall at least that both drives saw
_ROWS = (3 / 8, 1 / 2)  # of a picture, from the top, that show walls near and far


@dataclass(frozen=True)
class TurnSettings:
    """When two places are joined by turning.

    Attributes:
        p_turn: probability of such an edge. Were it much lower, plans would lead around a whole
            building to save a turn.
        least: rad of heading between both at least.
        reach: metres between both at most.
        candidates: vertices whose scans are compared with that of an anchor.
        agreement: share of the points that either scan must confirm.
        colours: correlation that the walls' colours must have.
        most: edges from an anchor, with `least` between their headings.
    """

    p_turn: float = 0.95
    least: float = float(np.deg2rad(60.0))
    reach: float = 1.0
    candidates: int = 24
    agreement: float = 0.95
    colours: float = 0.35
    most: int = 3

    def __post_init__(self) -> None:
        number("turns: least", self.least, least=0.0)
        number("turns: reach", self.reach, least=0.0)
        for name in ("p_turn", "agreement", "colours"):
            number(f"turns: {name}", getattr(self, name))
            if not 0.0 < getattr(self, name) < 1.0:
                raise InputError(
                    f"turns: {name} = {getattr(self, name)}; give a number between 0 and 1"
                )
        for name in ("candidates", "most"):
            whole(f"turns: {name}", getattr(self, name), least=1)


@dataclass(frozen=True, eq=False)
class Turns:
    """N pairs of places that may be joined by turning.

    Attributes:
        anchors: (N,) of the new trajectory.
        vertices: (N,) of the map.
        poses: (N, 3) of the vertices as seen from the anchors.
        scores: (N,) agreement of the scans, by which the best are chosen.
    """

    anchors: Indices
    vertices: Indices
    poses: Array
    scores: Array

    def __len__(self) -> int:
        return len(self.anchors)

    def subset(self, chosen: NDArray) -> Turns:
        """Those that an index or a mask selects."""
        return Turns(
            self.anchors[chosen], self.vertices[chosen], self.poses[chosen], self.scores[chosen]
        )

    def of(self, anchors: Indices, vertices: Indices) -> Turns:
        """The same with the indices that theirs stand for."""
        return replace(self, anchors=anchors[self.anchors], vertices=vertices[self.vertices])


def add_turns(
    topomap: TopoMap, anchors: Anchors, path: Indices, settings: TurnSettings | None = None
) -> int:
    """Join the new vertices of a trajectory to others by turning, both ways.

    Args:
        topomap: the map, to which the trajectory was added.
        anchors: of the trajectory.
        path: (A,) the vertex of each anchor.
        settings: thresholds.

    Returns:
        How many edges were added.
    """
    settings = TurnSettings() if settings is None else settings
    instance("settings", settings, TurnSettings)
    instance("topomap", topomap, TopoMap)
    count, most = len(instance("anchors", anchors, Anchors)), len(topomap.vertices) - 1
    path = integers("path", path, (count,), least=0, most=most)
    fresh = np.flatnonzero(topomap.trajectory[path] == len(topomap.paths) - 1)
    alive = topomap.alive
    seen = anchors.observations[fresh], topomap.vertices.observations[alive]
    turns = _by_scans(*seen, settings).of(fresh, alive)
    sights = [_sights(anchors.observations, i, np.arange(len(anchors))) for i in turns.anchors]
    alike = [
        colour_correlation(ours, _sights_from(topomap, int(v)), pose)
        for ours, v, pose in zip(sights, turns.vertices, turns.poses, strict=True)
    ]
    turns = turns.subset(np.array(alike, dtype=float) > settings.colours)
    added = 0
    for anchor in np.unique(turns.anchors):
        best = _apart(turns.subset(turns.anchors == anchor), settings)
        for vertex, pose in zip(best.vertices.tolist(), best.poses, strict=True):
            added += topomap.connect_by_turn(int(path[anchor]), vertex, settings.p_turn, pose[2])
            added += topomap.connect_by_turn(vertex, int(path[anchor]), settings.p_turn, -pose[2])
    return added


def colour_correlation(
    ours: tuple[Array, Array], theirs: tuple[Array, Array], pose: Array
) -> float:
    """How far two drives agree on the colours of the walls that both saw.

    Args:
        ours: points (N, 2) in metres and their colours (N, 3), as seen from here.
        theirs: points (M, 2) and colours (M, 3), as seen from there.
        pose: (3,) of there, as seen from here.

    Returns:
        Correlation, -1 to 1; not a number where too few walls were seen by both.
    """
    (points, colours), (others, other_colours) = _sight("ours", ours), _sight("theirs", theirs)
    pose = floats("pose", pose, (3,))
    if not len(points) or not len(others):
        return float("nan")
    far, nearest = KDTree(to_world(pose, others)).query(points, distance_upper_bound=_SAME)
    both = np.isfinite(far)
    if both.sum() < _SIGHTS:
        return float("nan")
    here, there = colours[both], other_colours[nearest[both]]
    here, there = here - here.mean(axis=0), there - there.mean(axis=0)
    scale = np.sqrt((here**2).sum() * (there**2).sum())
    return float((here * there).sum() / scale) if scale > 0 else float("nan")


def _sight(name: str, sight: tuple[Array, Array]) -> tuple[Array, Array]:
    """Points (N, 2) and colours (N, 3)."""
    if not isinstance(sight, tuple) or len(sight) != 2:
        raise InputError(f"{name}: give a tuple of points (N, 2) and colours (N, 3)")
    points, colours = floats(name, sight[0], ("N", 2)), floats(name, sight[1], ("N", 3))
    alike(**{name: points, f"colours of {name}": colours})
    return points, colours


def turns_among(
    seen: Observation, drive: Indices, images: Indices, settings: TurnSettings
) -> Turns:
    """Pairs of images that were taken at one place and look different ways.

    Args:
        seen: M observations.
        drive: (M,) of each; those of one lie next to each other, in order.
        images: (V,) those of them that are compared.
        settings: thresholds.

    Returns:
        Pairs of such images; the best for each that look different ways.
    """
    turns = _by_scans(seen[images], seen[images], settings).of(images, images)
    sights = {
        image: _sights(seen, image, np.flatnonzero(drive == drive[image]))
        for image in np.union1d(turns.anchors, turns.vertices).tolist()
    }
    alike = [
        colour_correlation(sights[i], sights[j], pose)
        for i, j, pose in zip(
            turns.anchors.tolist(), turns.vertices.tolist(), turns.poses, strict=True
        )
    ]
    turns = turns.subset(np.array(alike, dtype=float) > settings.colours)
    best = [
        _apart(turns.subset(turns.anchors == image), settings) for image in np.unique(turns.anchors)
    ]
    if not best:
        return turns
    parts = zip(*((b.anchors, b.vertices, b.poses, b.scores) for b in best), strict=True)
    return Turns(*(np.concatenate(part) for part in parts))


def _by_scans(seen: Observation, known: Observation, settings: TurnSettings) -> Turns:
    """Pairs whose scans agree, near each other and with different headings."""
    ours, theirs = (np.asarray(one.laser, dtype=float) for one in (seen, known))
    alike, rotations = likely_rotations(ours, theirs, settings.least)
    count = min(settings.candidates, len(theirs))
    best = np.argpartition(-alike, count - 1, axis=1)[:, :count]
    rows, columns = np.repeat(np.arange(len(ours)), count), best.ravel()
    starts = np.zeros((len(rows), rotations.shape[2], 3))
    starts[:, :, 2] = rotations[rows, columns]
    poses, scores = match_scans(ours[rows], theirs[columns], starts)
    near = np.linalg.norm(poses[:, :2], axis=1) < settings.reach
    aside = np.abs(wrap(poses[:, 2])) > settings.least
    fits = near & aside & (scores > settings.agreement)
    return Turns(rows, columns, poses, scores).subset(fits)


def _apart(turns: Turns, settings: TurnSettings) -> Turns:
    """The best of one anchor whose headings differ from each other."""
    chosen: list[int] = []
    for i in np.argsort(-turns.scores, kind="stable"):
        gaps = np.abs(wrap(turns.poses[chosen, 2] - turns.poses[i, 2]))
        if len(chosen) < settings.most and (gaps > settings.least).all():
            chosen.append(int(i))
    return turns.subset(np.array(chosen, dtype=np.intp))


def _sights_from(topomap: TopoMap, vertex: int) -> tuple[Array, Array]:
    """Points and colours around a vertex, from its own trajectory."""
    own = np.flatnonzero(topomap.trajectory == topomap.trajectory[vertex])
    return _sights(topomap.vertices.observations, vertex, own)


def _sights(
    observations: Observation | GrowingBatch, place: int, own: Indices
) -> tuple[Array, Array]:
    """Points (N, 2) in the frame of one place, and colours (N, 3), seen there and close by.

    Args:
        observations: of a trajectory or of a map.
        place: index of the place.
        own: indices of its own trajectory, in order; their odometry is comparable.
    """
    middle = int(np.searchsorted(own, place))
    around = own[max(middle - _BESIDE, 0) : middle + _BESIDE + 1]
    seen = observations[around]
    poses = relative(observations[np.array([place])].odometry, seen.odometry)
    camera = seen.camera if isinstance(seen.camera, Camera) else Camera()
    half, laser = camera.field_of_view / 2, np.asarray(seen.laser, dtype=float)
    angles = full_circle(laser.shape[1])
    beams = np.flatnonzero(np.abs(angles) < half)
    aside = np.tan(angles[beams]) / np.tan(half)
    columns = ((1.0 - aside) / 2 * seen.image.shape[2]).astype(int)
    first, last = (int(share * seen.image.shape[1]) for share in _ROWS)
    last = max(last, first + 1)
    colours = seen.image[:, first:last].astype(float).mean(axis=1)[:, columns]
    rays = np.stack([np.cos(angles[beams]), np.sin(angles[beams])], axis=1)
    points = np.stack(
        [to_world(p, row[:, None] * rays) for p, row in zip(poses, laser[:, beams], strict=True)]
    )
    near = laser[:, beams] < _SEEN
    return points[near], colours[near]
