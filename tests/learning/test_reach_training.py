"""Training of reachability: its loss, and that it begins with the weights of C."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import torch

from tests.learning.test_reach_batches import made_up
from tests.learning.test_training import Killed, killed_when_saved
from tutorial_lib.learning import training
from tutorial_lib.learning.losses import OVERLAP_WEIGHT, reach_loss
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.reach_batches import LabelledWorld, OutcomeSource
from tutorial_lib.learning.training import Settings, copy_matching_weights, train

torch.set_num_threads(1)  # so small are they here that two threads are slower
TELLS = {"outputs": "reachability"}
SMALL = Architecture(1, "pair", **TELLS)


@pytest.fixture(scope="module")
def labelled(recorded):
    return [LabelledWorld(recorded, made_up(recorded, 20, 0), made_up(recorded, 10, 1))]


@pytest.fixture(scope="module")
def pictured(labelled):
    return OutcomeSource(labelled, SMALL, worlds=2, targets=8).block([0])


# Losses.


def cross_entropy(logits, label):
    p = 1 / (1 + np.exp(-logits.astype(float)))
    return -(label * np.log(p) + (1 - label) * np.log1p(-p))


def perfect(block):
    """Outputs (N, 3) that are right about a block, never quite sure."""
    right = np.column_stack([block.reached, block.overlap]).clip(0.001, 0.999)
    return torch.logit(torch.from_numpy(right))


def test_the_loss_is_the_cross_entropy_of_the_outcome_and_less_so_of_the_overlaps(pictured):
    outputs = np.random.default_rng(0).normal(size=(len(pictured.reached), 3)).astype(np.float32)
    wanted = cross_entropy(outputs[:, 0], pictured.reached)
    shares = cross_entropy(outputs[:, 1:], pictured.overlap).sum(axis=1)
    loss = reach_loss(torch.from_numpy(outputs), pictured)
    assert loss.shape == wanted.shape
    assert loss.numpy() == pytest.approx(wanted + OVERLAP_WEIGHT * shares, rel=1e-3)
    assert 0.0 < OVERLAP_WEIGHT < 1.0


@pytest.mark.parametrize("column", [1, 2])
def test_nothing_is_better_than_the_right_overlap(pictured, column):
    right = perfect(pictured)
    share = right[:, column].sigmoid()
    between = (share > 0.002) & (share < 0.998)
    assert between.sum() > 10
    for change in (-0.3, 0.3):
        wrong = right.clone()
        wrong[:, column] += change
        assert (reach_loss(wrong, pictured) > reach_loss(right, pictured))[between].all()


def test_the_surer_of_what_happened_the_better(pictured):
    outputs = torch.zeros(len(pictured.reached), 3)
    losses = []
    for logit in (-4.0, -1.0, 1.0, 4.0):
        outputs[:, 0] = logit * (2.0 * pictured.tensor("reached") - 1.0)
        losses.append(reach_loss(outputs, pictured))
    assert all((later < before).all() for before, later in pairwise(losses))


def test_where_nothing_is_seen_no_place_is_learnt(pictured):
    torch.manual_seed(0)
    network = LocalNetwork(SMALL)
    placed = pictured.placed > 0
    assert 0 < placed.sum() < len(placed)

    def loss(where):
        poses = np.where(where[:, None, None], 7.0, pictured.context_poses).astype(np.float32)
        with torch.inference_mode():
            return training.total_loss(network, replace(pictured, context_poses=poses)).item()

    nobody = np.zeros_like(placed)
    assert loss(~placed) == loss(nobody)
    assert loss(placed) > loss(nobody) + 0.01


def test_pairs_without_weight_do_not_count(pictured):
    network = LocalNetwork(SMALL)
    weight = (np.arange(len(pictured.weight)) % 3 > 0).astype(np.float32)
    wrong = np.where(weight > 0, pictured.reached, 1 - pictured.reached)
    with torch.inference_mode():
        one, two = (
            training.total_loss(network, replace(pictured, weight=weight, reached=reached))
            for reached in (pictured.reached, wrong)
        )
    assert one == two


# Training that begins with C's weights.


def trained(k=1, encoder="pair", seed=5):
    torch.manual_seed(seed)
    return LocalNetwork(Architecture(k, encoder))


def differing(one, two):
    """Names of the weights that differ."""
    one, two = one.state_dict(), two.state_dict()
    return {name for name in one if name not in two or not torch.equal(one[name], two[name])}


HEADS = {"heads.weight", "heads.bias"}


def test_what_fits_is_taken_over_and_nothing_else():
    network, begin = LocalNetwork(SMALL), trained()
    before, own = trained(), LocalNetwork(SMALL)
    own.load_state_dict(network.state_dict())
    copy_matching_weights(network, begin)
    assert differing(network, begin) == HEADS
    assert differing(begin, before) == set()
    assert differing(network, own) == set(own.state_dict()) - HEADS
    # Another context: its layer has another shape.
    copy_matching_weights(network := LocalNetwork(Architecture(2, "pair", **TELLS)), begin)
    assert differing(network, begin) == HEADS | {"context.weight"}


def test_training_begins_with_the_weights_that_it_is_given(labelled, pictured):
    source = OutcomeSource(labelled, SMALL, mined=0.0, worlds=2, targets=4)
    still = Settings(max_steps=1, targets=4, learning_rate=0.0)
    network, _ = train(SMALL, source, [pictured], still, init_from=trained())
    fresh, _ = train(SMALL, source, [pictured], still)
    assert differing(network, trained()) == HEADS
    assert differing(network, fresh) == set(fresh.state_dict()) - HEADS  # drawn by the seed
    moved, _ = train(
        SMALL, source, [pictured], replace(still, learning_rate=1e-3), init_from=trained()
    )
    assert differing(moved, trained()) > HEADS


def test_a_stopped_training_goes_on_to_the_same_weights(labelled, pictured, tmp_path, monkeypatch):
    source = OutcomeSource(labelled, SMALL, mined=0.0, worlds=2, targets=4)
    settings = Settings(max_steps=6, targets=4, warmup_steps=2, eval_interval=3)
    whole, progress = train(SMALL, source, [pictured], settings, init_from=trained())
    assert set(progress.history[0]) == {"step", "training", "validation"}
    checkpoint = tmp_path / "tiny.pt"
    with monkeypatch.context() as patched:
        killed_when_saved(patched)
        with pytest.raises(Killed):
            train(SMALL, source, [pictured], settings, checkpoint, init_from=trained())
    again, there = train(SMALL, source, [pictured], settings, checkpoint, init_from=trained())
    assert differing(again, whole) == set()
    assert there == progress


class Fixed(OutcomeSource):
    """The same block again and again."""

    def block(self, seed):
        return super().block([0])


@pytest.mark.full
def test_outcomes_by_lot_can_be_learnt_by_heart(labelled):
    fixed = Fixed(labelled, SMALL, mined=0.0, worlds=1, targets=8, vary=False)
    block = fixed.block([])
    settings = Settings(
        max_steps=80, targets=8, learning_rate=5e-3, warmup_steps=10, eval_interval=20
    )
    network, progress = train(SMALL, fixed, [block], settings)
    begun, least = (
        reach_loss(outputs, block).mean().item()
        for outputs in (torch.zeros(len(block.reached), 3), perfect(block))
    )
    best = progress.history[progress.best]["validation"]
    assert best - least < 0.5 * (begun - least)
    with torch.inference_mode():
        logits = training.outputs_of(network, block)[0][:, 0].numpy()
    sure = np.isin(block.reached, (0.0, 1.0))
    assert ((logits > 0) == (block.reached > 0.5))[sure].mean() > 0.85
