"""The learned global goal behind `interfaces.FrontierScorer`."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.learning.exploration_losses import FARTHEST
from tutorial_lib.learning.goal_map_data import CROP
from tutorial_lib.learning.goal_map_network import GoalMapNetwork
from tutorial_lib.learning.panorama_encoder import Encoded
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.weights import load_card, load_network


class LearnedFrontiers:
    """Prefers the frontier by which the path to the goal seems shortest, a `FrontierScorer`.

    Attributes:
        network: that scores frontiers.
        pairs: the multi-task network that made the features it reads.
    """

    def __init__(self, network: GoalMapNetwork, pairs: PanoramaNetwork) -> None:
        """Put a trained network behind the interface."""
        self.network, self.pairs = network.eval(), pairs.eval()

    @classmethod
    def shipped(cls, name: str) -> LearnedFrontiers:
        """Shipped weights by their name, such as "ans_like_rgbd".

        Raises:
            InputError: when they are missing, or belong to other weights of the multi-task network.
        """
        card, network = load_card(name), load_network(name, wanted=GoalMapNetwork)
        seeing = f"nts_{network.architecture.sensor}"
        if card.recipe.get("start") != load_card(seeing).sha256:
            raise InputError(
                f"{name}: was trained on other weights than {seeing} has now; train it again: "
                f"python -m tutorial_lib {card.command}"
            )
        return cls(network, load_network(seeing, wanted=PanoramaNetwork))

    @torch.inference_mode()
    def score(
        self,
        crops: NDArray[np.uint8],
        here: NDArray[np.float32],
        goals: NDArray[np.float32],
        frontiers: Array,
        robots: NDArray[np.intp],
    ) -> Array:
        """Scores (F,) of frontiers: minus the metres of the path by each to the goal.

        Args:
            crops: (N, CROP, CROP) of the map around each robot, see `interfaces.FrontierScorer`.
            here: (N, D) features of what each robot sees, by `LearnedExploration.embed`.
            goals: (N, D) of what it looks for.
            frontiers: (F, 3) x and y in the robot's frame, and metres to go.
            robots: (F,) index of the robot of each frontier.

        Raises:
            InputError: when the maps have another size, or the rows were made by another network.
        """
        if crops.shape[1:] != (CROP, CROP):
            raise InputError(f"crops: shape {crops.shape}; give (N, {CROP}, {CROP}) cells of 0.1 m")
        robots = np.asarray(robots)
        counts = np.bincount(robots, minlength=len(crops))
        order = np.argsort(robots, kind="stable")
        place = np.empty(len(robots), np.intp)
        place[order] = np.arange(len(robots)) - np.repeat(np.cumsum(counts) - counts, counts)
        padded = np.zeros((len(crops), max(counts.max(initial=0), 1), 3), np.float32)
        padded[robots, place] = frontiers
        encoded = (Encoded.of(torch.from_numpy(rows)) for rows in (here, goals))
        pairs = self.pairs.directions(*encoded)[0]
        scores = self.network(torch.from_numpy(crops), torch.from_numpy(padded), pairs).numpy()
        return -(frontiers[:, 2] + FARTHEST * (1.0 - scores[robots, place].astype(float)))
