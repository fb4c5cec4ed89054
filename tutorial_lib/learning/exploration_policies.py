"""Trained baselines of exploration behind their interfaces: imitation, and a global goal."""

import numpy as np
import torch
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.frontier import CROP
from tutorial_lib.exploration.labels import MAX_DISTANCE
from tutorial_lib.geometry import Array
from tutorial_lib.learning.goal_map_network import GoalMapNetwork
from tutorial_lib.learning.imitation_network import MEMORY, ImitationNetwork
from tutorial_lib.learning.panorama_encoder import FEATURES, Encoded
from tutorial_lib.learning.panorama_network import PANORAMA, PanoramaNetwork
from tutorial_lib.learning.views import check_camera
from tutorial_lib.learning.weights import Network, load_card, load_network
from tutorial_lib.observation import Observation
from tutorial_lib.world.noise import STOP

State = NDArray[np.float32]
"""(N, FEATURES + MEMORY + 1) features of the goal, memory, and the action before."""


class LearnedImitation:
    """Imitates shortest paths, a `RecurrentPolicy`.

    Attributes:
        network: that chooses actions.
    """

    def __init__(self, network: ImitationNetwork | str) -> None:
        """Put a trained policy, or shipped weights by their name, behind the interface."""
        if isinstance(network, str):
            network = load_network(network, wanted=ImitationNetwork)
        self.network = network.eval()

    @property
    def sensor(self) -> str:
        """What a robot must carry: "rgb", or "rgbd" for a depth camera as well."""
        return self.network.architecture.sensor

    @torch.inference_mode()
    def start(self, goals: Observation) -> State:
        """The state of N robots before their first step, a row each.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        features = self._encoded(goals).flat().numpy()
        memory = np.zeros((len(goals), MEMORY), np.float32)
        return np.column_stack([features, memory, np.full(len(goals), STOP, np.float32)])

    @torch.inference_mode()
    def act(self, observations: Observation, state: State) -> tuple[NDArray[np.intp], State]:
        """The most probable actions (N,), and the state after them.

        Raises:
            InputError: when image or depth do not fit the network.
        """
        goals, memory, before = torch.from_numpy(state).split([FEATURES, MEMORY, 1], dim=1)
        logits, memory = self.network(
            self._encoded(observations), Encoded.of(goals), before.long(), memory[None].contiguous()
        )
        actions = logits[:, 0].argmax(dim=1).numpy()
        after = [state[:, :FEATURES], memory[0].numpy(), actions.astype(np.float32)]
        return actions, np.column_stack(after)

    def _encoded(self, observations: Observation) -> Encoded:
        check_camera("the network that imitates", observations, PANORAMA)
        images, depth = torch.from_numpy(np.ascontiguousarray(observations.image)), None
        if observations.depth is not None:
            depth = torch.from_numpy(np.asarray(observations.depth, dtype=np.float32))
        return self.network.pairs.encode(images, depth)


class LearnedFrontierScorer:
    """Prefers the frontier by which the path to the goal seems shortest, a `FrontierScorer`.

    Attributes:
        network: that scores frontiers.
        pairs: the multi-task network that made the features it reads.
    """

    def __init__(self, network: GoalMapNetwork | str, pairs: PanoramaNetwork | None = None) -> None:
        """Put a trained network, or shipped weights by their name, behind the interface.

        Args:
            network: a network, or a name such as "ans_like_rgbd".
            pairs: the multi-task network; for shipped weights the one that they belong to.

        Raises:
            InputError: when weights are missing, or belong to others of the multi-task network.
        """
        if isinstance(network, str):
            network, pairs = with_pairs(network, GoalMapNetwork)
        if pairs is None:
            raise InputError("frontiers: give the multi-task network that made the features, too")
        self.network, self.pairs = network.eval(), pairs.eval()

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
        return -(frontiers[:, 2] + MAX_DISTANCE * (1.0 - scores[robots, place].astype(float)))


def with_pairs(name: str, wanted: type[Network]) -> tuple[Network, PanoramaNetwork]:
    """A shipped network, and the multi-task network that made the features it reads.

    Args:
        name: of its weights, such as "map_rl_rgbd".
        wanted: the class that it must have.

    Raises:
        InputError: when weights are missing, or belong to others of the multi-task network.
    """
    card, network = load_card(name), load_network(name, wanted=wanted)
    seeing = f"nts_{card.architecture.sensor}"
    if card.recipe.get("start") != load_card(seeing).sha256:
        raise InputError(
            f"{name}: was trained on other weights than {seeing} has now; train it again: "
            f"python -m tutorial_lib {card.command}"
        )
    return network, load_network(seeing, wanted=PanoramaNetwork)
