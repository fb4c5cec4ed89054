"""LTVN's model, tuned to one building by what a robot recorded there.

Nobody measures the building: pairs of images of one drive are labelled by its odometry
(*Lifelong Topological Visual Navigation*, Fine-tuning), which drifts little from one to the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.recorded_world import frames_around
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Experience
from tutorial_lib.learning.analytic_label import HERE, AnalyticLabel
from tutorial_lib.learning.batches import Batch, drawn, posed
from tutorial_lib.learning.estimators import RelativeNetwork
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.learning.training import Settings, train, validate
from tutorial_lib.se2 import Array, relative
from tutorial_lib.validation import instance, instances, number

LATER = 60
"""H, frames between both images of a pair that may be reachable; here a car drives 3 m."""
FAR = 5.0
"""Metres of odometry from which on a pair of one drive is certainly not reachable."""
NEAR, ANY = 1, 4
"""Starts of each target at most `LATER` frames from it, and anywhere on its drive."""
TUNED = Settings(max_steps=300, learning_rate=2e-4, warmup_steps=50, eval_interval=50)
KEPT = 0.5
"""Share of the old weights in the new ones: the mean of both keeps what drives of one building say
nothing about (Wortsman et al., Robust fine-tuning of zero-shot models, 2022)."""


@dataclass(frozen=True, eq=False)
class OwnDrives:
    """Blocks of pairs of images that a robot recorded, labelled by its odometry.

    Attributes:
        experiences: one for each drive.
        architecture: of the network to be trained.
        label: whose thresholds a reachable pair keeps. Where it was seen to be driven nearly
            straight, its target is taken to be in sight; where not, it is left out.
        worlds: drives drawn for a block.
        targets: of each drive.
    """

    experiences: Sequence[Experience]
    architecture: Architecture
    label: AnalyticLabel = field(default_factory=AnalyticLabel)
    worlds: int = 16
    targets: int = 16

    def __post_init__(self) -> None:
        instances("experiences", self.experiences, Experience, empty=False)
        instance("architecture", self.architecture, Architecture)
        instance("label", self.label, AnalyticLabel)

    @property
    def recipe(self) -> dict[str, Any]:
        """What its blocks depend on, in brief."""
        frames = sum(len(experience.timestamps) for experience in self.experiences)
        return {"frames": frames, "apart": [LATER, FAR], "block": [self.worlds, self.targets]}

    def block(self, seed: Sequence[int]) -> Batch:
        """The block of that seed: targets of `worlds` drives, shuffled."""
        return drawn(self.experiences, self.worlds, self._drive, np.random.default_rng(seed))

    def _drive(self, experience: Experience, rng: np.random.Generator) -> Batch:
        seen = experience.observations
        last, odometry = len(seen) - 1, seen.odometry
        target = rng.integers(last + 1, size=self.targets)
        near = target[:, None] - rng.integers(-LATER // 4, LATER + 1, size=(self.targets, NEAR))
        anywhere = rng.integers(last + 1, size=(self.targets, ANY))
        starts = np.hstack([np.clip(near, 0, last), anywhere])
        images = self.architecture.looks_at.of(seen)
        shown = frames_around(target, self.architecture.k, 0, last)
        source, goal = starts.ravel(), np.repeat(target, NEAR + ANY)
        reached, known = by_odometry(odometry, source, goal, self.label)
        places = posed(odometry[source], odometry[goal])
        count = len(source)
        around = odometry[np.repeat(shown, NEAR + ANY, axis=0)]
        return Batch(
            current=images[source],
            contexts=images[shown],
            waypoint=places[:, :2],
            turn=places[:, 2:],
            overlap=np.zeros((count, 2), np.float32),
            context_poses=posed(odometry[source][:, None], around),
            action=np.zeros((count, 0), np.float32),
            reached=reached.astype(np.float32),
            weight=known.astype(np.float32),
            placed=reached.astype(np.float32),
        )


def by_odometry(
    odometry: Array, source: NDArray[np.intp], target: NDArray[np.intp], label: AnalyticLabel
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which of N pairs of frames of one drive are reachable, and of which that is known.

    Args:
        odometry: (T, 3) of the drive.
        source: (N,) frames.
        target: (N,) frames.
        label: see `OwnDrives`.
    """
    seen = relative(odometry[source], odometry[target])
    metres = np.hypot(seen[:, 0], seen[:, 1])
    steps = np.hypot(*np.diff(odometry[:, :2], axis=0).T)
    driven = np.concatenate([[0.0], np.cumsum(steps)])
    soon = np.abs(target - source) <= LATER
    straight = soon & (np.abs(driven[target] - driven[source]) <= label.ratio * metres)
    ahead = (metres < HERE) | (np.abs(np.arctan2(seen[:, 1], seen[:, 0])) < label.bearing)
    fits = (metres < label.distance) & (np.abs(seen[:, 2]) < label.yaw) & ahead
    # Of a drive that comes back to where it was, odometry cannot tell how near.
    return fits & straight, np.where(soon, straight | ~fits, metres > FAR)


def fine_tuned(
    model: RelativeNetwork,
    experiences: Sequence[Experience],
    settings: Settings = TUNED,
    kept: float = KEPT,
) -> RelativeNetwork:
    """The model after training on a robot's own drives, of which every eighth only tests it.

    Args:
        model: its calibration stays.
        experiences: drives, two at least.
        settings: of the training.
        kept: share of the old weights in the new ones.

    Returns:
        A model that does better on the drives that test; the same where it does not.

    Raises:
        InputError: when there are fewer than two drives.
    """
    instance("model", model, RelativeNetwork)
    experiences = instances("experiences", experiences, Experience, empty=False)
    if len(experiences) < 2:
        raise InputError("experiences: one; give two drives at least, of which one only tests")
    instance("settings", settings, Settings)
    kept = number("kept", kept, least=0.0, most=1.0)
    testing = experiences[::8]
    learned = [one for place, one in enumerate(experiences) if place % 8]
    source, others = (OwnDrives(some, model.architecture) for some in (learned, testing))
    validation = [others.block([settings.seed, block]) for block in range(2)]
    before = validate(model.network, validation)["validation"]
    network, _ = train(model.architecture, source, validation, settings, init_from=model.network)
    old, new = model.network.state_dict(), network.state_dict()
    network.load_state_dict({name: new[name].lerp(old[name], kept) for name in new})
    better = validate(network, validation)["validation"] < before
    return RelativeNetwork(network, model.calibration) if better else model
