"""Training by reinforcement, with PPO of Stable-Baselines3 (the extra `rl`)."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from math import log
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray

from tutorial_lib.environments import in_lock_step
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import (
    DIFFICULTIES,
    Episodes,
    draw_episodes,
    exploration_world,
)
from tutorial_lib.exploration.task import ExplorationTask, explore
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.reinforcement_environment import PolicyEnvironments
from tutorial_lib.learning.reinforcement_network import (
    THOUGHT,
    LearnedReinforcement,
    ReinforcementArchitecture,
    ReinforcementNetwork,
    Trunk,
)
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.learning.weights import Card, load_card, load_network
from tutorial_lib.world.noise import STOP
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of

_NEVER = -20.0  # logit of stopping while that is no use
_SELDOM = 0.04  # the chance of stopping when it begins to be of use
_VALUE = 64  # hidden numbers of the value's estimate, which is of use in training only
_OUTCOMES = ("success", "spl")


@dataclass(frozen=True)
class PPOSettings:
    """Hyperparameters of a training, and what it learns on.

    Attributes:
        first: frames in which episodes end near the goal by themselves and no robot stops: before
            it knows the way, the best that a robot can do is to stop at once.
        steps: frames after these, of all robots together.
        worlds: training worlds of each kind of episodes, six times as many in all.
        each: robots of each difficulty and kind of signs.
        rollout: steps of each robot between two updates.
        batch: frames of a step of Adam.
        epochs: of each update.
        learning_rate: of Adam; in the last 40% of the later steps it falls to zero.
        discount: of rewards.
        entropy: weight of the policy's entropy.
        divergence: of the policy from that before an update, which ends where it is half as much
            again.
        interval: steps between two evaluations.
        unseen: seeds of the worlds of these.
        episodes: of each difficulty in each of them.
        seed: of the initial weights and of the episodes.
    """

    first: int = 120_000
    steps: int = 480_000
    worlds: int = 27
    each: int = 16
    rollout: int = 64
    batch: int = 1536
    epochs: int = 3
    learning_rate: float = 8e-4
    discount: float = 0.99
    entropy: float = 0.002
    divergence: float = 0.02
    interval: int = 60_000
    unseen: tuple[int, ...] = tuple(range(10_000, 10_010))
    episodes: int = 3
    seed: int = 0

    def learning_rate_at(self, left: float) -> float:
        """The learning rate where a share of the steps is left."""
        return self.learning_rate * min(1.0, left / 0.4)


@dataclass(frozen=True)
class ReinforcementRecipe:
    """All that a policy comes from.

    Attributes:
        name: of the weights.
        command: that trains it.
        architecture: of the network.
        settings: of its training.
        start: weights of the multi-task network that it reads.
    """

    name: str
    command: str
    architecture: ReinforcementArchitecture
    settings: PPOSettings = field(default_factory=PPOSettings)
    start: str = "nts_rgbd"

    def checkpoints(self, work: Path) -> tuple[Path, ...]:
        """Files of the state of its training: none."""
        del work
        return ()


def _recipe(name: str, *, maps: bool) -> ReinforcementRecipe:
    command = f"train {name} --sensor rgbd"
    return ReinforcementRecipe(f"{name}_rgbd", command, ReinforcementArchitecture(maps))


REINFORCEMENT = {
    "target_rl": _recipe("target_rl", maps=False),
    "map_rl": _recipe("map_rl", maps=True),
}
"""What `train` can train by reinforcement."""


class _Seeing(Trunk):
    """The trunk as Stable-Baselines3 builds it."""

    features_dim = THOUGHT

    def __init__(self, space: spaces.Dict, architecture: ReinforcementArchitecture) -> None:
        del space
        super().__init__(architecture)


class _Curve:
    """What a training has come to, measured every so many steps.

    Attributes:
        rows: of all measurements: the "steps", and by difficulty success and SPL of the training
            episodes that ended since the last one, and of those in unseen worlds.
        before: frames of the learner before this one.
    """

    def __init__(
        self, recipe: ReinforcementRecipe, many: PolicyEnvironments, unseen: Unseen
    ) -> None:
        self.rows: list[dict[str, float]] = []
        self.before = 0
        self._recipe, self._many, self._unseen = recipe, many, unseen
        self._next, self._ended = recipe.settings.interval, _none()

    def __call__(self, within: Mapping[str, Any], _: Mapping[str, Any]) -> bool:
        """Look at a step of PPO, whose variables these are; go on."""
        for robot in np.flatnonzero(within["dones"]):
            info = within["infos"][robot]
            ended = self._ended[self._many.difficulty[robot]]
            ended.append((info["is_success"], info["spl"]))
        model = within["self"]
        if self.before + model.num_timesteps >= self._next:
            self._next += self._recipe.settings.interval
            self.measure(model)
        return True

    def measure(self, model: Any) -> None:  # noqa: ANN401 - PPO
        """Add a row."""
        row: dict[str, float] = {"steps": self.before + model.num_timesteps}
        for level, ended in self._ended.items():
            means = np.array(ended, float).reshape(-1, 2).mean(axis=0) if ended else (0.0, 0.0)
            row |= {f"training_{name}_{level}": v for name, v in zip(_OUTCOMES, means, strict=True)}
        network = network_of(self._recipe.architecture, model.policy)
        row |= self._unseen.measured(network, stops_itself=not self.before)
        self.rows.append({name: round(float(value), 4) for name, value in row.items()})
        self._ended = _none()


class Unseen:
    """Episodes in validation worlds."""

    def __init__(self, settings: PPOSettings, pairs: PanoramaNetwork) -> None:
        """Draw them; `pairs` is the multi-task network."""
        self._seed, self._pairs, parts = settings.seed, pairs, []
        self._scenes: dict[str, Scene] = {}
        for seed in settings.unseen:
            name = exploration_world(seed)
            self._scenes[name] = scene_of(name)
            counts = dict.fromkeys(DIFFICULTIES, settings.episodes)
            rng = np.random.default_rng([settings.seed, seed])
            parts.append(draw_episodes(name, self._scenes[name], counts, rng))
        self._episodes = Episodes.joined(parts)

    def measured(self, network: ReinforcementNetwork, *, stops_itself: bool) -> dict[str, float]:
        """Success and SPL of a policy, by difficulty; see `ExplorationTask` for `stops_itself`."""
        rng = np.random.default_rng([self._seed, 1])
        task = ExplorationTask(self._scenes, self._episodes, rng, stops_itself=stops_itself)
        explore(task, LearnedReinforcement(network, self._pairs, np.random.default_rng(self._seed)))
        levels = np.array(self._episodes.difficulty)
        return {
            f"{name}_{level}": getattr(task, name)[levels == level].mean()
            for level in DIFFICULTIES
            for name in _OUTCOMES
        }


def train_reinforcement(
    recipe: ReinforcementRecipe, work: Path
) -> tuple[ReinforcementNetwork, Card]:
    """Train a policy on fresh episodes; an interrupted training begins again.

    Args:
        recipe: what to train.
        work: not used: nothing is recorded.

    Returns:
        The network and its card, on which its curve is.

    Raises:
        InputError: without Stable-Baselines3.
    """
    del work
    settings, architecture, begun = recipe.settings, recipe.architecture, time.process_time()
    ppo = _ppo()
    use_threads(1)
    pairs = load_network(recipe.start, wanted=PanoramaNetwork)
    many = PolicyEnvironments(settings.worlds, settings.each, pairs, maps=architecture.maps)
    envs = in_lock_step(many, many.single_observation_space, lambda seen: seen)
    curve = _Curve(recipe, many, Unseen(settings, pairs))
    model = _learner(ppo, envs, recipe, lambda left: settings.learning_rate)
    _set_stop(model, _NEVER)
    model.learn(settings.first, callback=curve)
    many.ask_for_stop()
    curve.before, weights = model.num_timesteps, model.policy.state_dict()
    model = _learner(ppo, envs, recipe, settings.learning_rate_at)
    model.policy.load_state_dict(weights)
    _set_stop(model, _level(network_of(architecture, model.policy), envs.reset()) + log(_SELDOM))
    model.learn(settings.steps, callback=curve)
    curve.measure(model)
    start = load_card(recipe.start).sha256
    said = {**asdict(settings), "start": start, "curve": curve.rows}
    minutes = round((time.process_time() - begun) / 60, 1)
    card = Card(
        recipe.name,
        recipe.command,
        architecture,
        said,
        validation_of(curve.rows[-1]),
        minutes=minutes,
        cores=1,
    )
    return network_of(architecture, model.policy), card


def validation_of(row: dict[str, float]) -> dict[str, float]:
    """What a card says of the last measurement; "validation" is the share that failed."""
    success = [row[f"success_{level}"] for level in DIFFICULTIES]
    return {"validation": round(1 - sum(success) / len(success), 4)} | row


def _learner(ppo: Any, envs: Any, recipe: ReinforcementRecipe, rate: Any) -> Any:  # noqa: ANN401
    """PPO with an untrained policy of that architecture."""
    settings = recipe.settings
    return ppo(
        "MultiInputPolicy",
        envs,
        n_steps=settings.rollout,
        batch_size=settings.batch,
        n_epochs=settings.epochs,
        learning_rate=rate,
        gamma=settings.discount,
        ent_coef=settings.entropy,
        target_kl=settings.divergence,
        seed=settings.seed,
        device="cpu",
        policy_kwargs={
            "features_extractor_class": _Seeing,
            "features_extractor_kwargs": {"architecture": recipe.architecture},
            "net_arch": {"pi": [], "vf": [_VALUE]},
        },
    )


def _level(network: ReinforcementNetwork, seen: dict[str, NDArray]) -> float:
    """The logit whose chance is as good as that of all actions but stopping, as robots see it."""
    with torch.inference_mode():
        logits = network({name: torch.from_numpy(part) for name, part in seen.items()})
    return float(logits.logsumexp(1).mean())


def _set_stop(model: Any, logit: float) -> None:  # noqa: ANN401 - PPO
    """Set how likely it is to stop, all else being equal."""
    with torch.no_grad():
        model.policy.action_net.bias[STOP] = logit


def network_of(architecture: ReinforcementArchitecture, policy: Any) -> ReinforcementNetwork:  # noqa: ANN401
    """What chooses the actions of a policy of PPO, without the value."""
    network = ReinforcementNetwork(architecture)
    network.trunk.load_state_dict(policy.features_extractor.state_dict())
    network.choose.load_state_dict(policy.action_net.state_dict())
    return network.eval()


def _none() -> dict[str, list[tuple[bool, float]]]:
    return {level: [] for level in DIFFICULTIES}


def _ppo() -> Any:  # noqa: ANN401 - its class
    """PPO.

    Raises:
        InputError: where Stable-Baselines3 is not installed.
    """
    try:
        from stable_baselines3 import PPO
    except ImportError as error:
        raise InputError(
            'train: PPO needs Stable-Baselines3; python -m pip install ".[rl]"'
        ) from error
    return PPO
