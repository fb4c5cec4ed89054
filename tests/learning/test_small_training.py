import numpy as np
import pytest
import torch
from torch import nn

from tutorial_lib.learning.small_training import TrainingPlan, learning_rate_at, train_network
from tutorial_lib.learning.training import Settings
from tutorial_lib.learning.training_probe import trace

GRADIENTS = np.random.default_rng(0).normal(size=(40, 3))


def plan(**changes):
    usual = {"max_steps": 20, "learning_rate": 0.1, "warmup_steps": 5, "max_norm": 1.0}
    return TrainingPlan(**{**usual, "eval_interval": 4, "patience": 9, **changes})


def test_it_learns_a_line():
    torch.manual_seed(0)
    network = nn.Linear(1, 1)
    x = torch.linspace(-1, 1, 32)[:, None]

    def loss_of(module, batch):
        return ((module(batch) - 3 * batch + 1) ** 2).mean()

    history = train_network(
        network,
        torch.optim.Adam(network.parameters()),
        lambda step: x[step % 4 :: 4],
        loss_of,
        lambda module: loss_of(module, x).item(),
        plan(max_steps=400, eval_interval=100),
    )
    assert [entry[0] for entry in history] == [100, 200, 300, 400]
    assert history[-1][2] < 1e-3
    assert not network.training


def test_the_rate_warms_up_and_decays_as_the_library_s_does():
    own, library = plan(), Settings(max_steps=20, learning_rate=0.1, warmup_steps=5)
    for step in range(20):
        later = 0.005 * 0.1 * min(1, (step + 1) / 5)  # the library's does not quite reach zero
        assert library.learning_rate_at(step) == pytest.approx(learning_rate_at(step, own) + later)


def test_it_ends_when_patience_is_used_up_and_keeps_the_best_weights():
    seen = trace(train_network, plan(patience=2), GRADIENTS, [3.0, 1.0, 2.0, 1.0, 0.0])
    assert [entry[0] for entry in seen.history] == [4, 8, 12, 16]
    np.testing.assert_array_equal(seen.final, seen.weights[1])
    moved = [1.0, -1.0, 0.5] - np.array(seen.rates[:8]) @ np.array(seen.gradients[:8])
    np.testing.assert_allclose(seen.final, moved)


def test_gradients_are_shortened_together():
    seen = trace(train_network, plan(max_norm=0.5), GRADIENTS, [1.0])
    lengths = np.linalg.norm(seen.gradients, axis=1)
    wanted = np.minimum(np.linalg.norm(GRADIENTS[: len(lengths)], axis=1), 0.5)
    np.testing.assert_allclose(lengths, wanted, rtol=1e-5)
    assert all(seen.training)
    assert all(seen.evaluating)
    assert not any(seen.tracked)
