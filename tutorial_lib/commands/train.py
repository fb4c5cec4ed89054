"""Trains a network from scratch, data included."""

from __future__ import annotations

import argparse

from tutorial_lib.commands.constants import PROJECT
from tutorial_lib.errors import InputError
from tutorial_lib.learning import reach_recipes, recipes
from tutorial_lib.learning.weights import save_network

NETWORKS = {
    "waypoint": recipes.WAYPOINT,
    "reachability": {**reach_recipes.REACHABILITY, "sptm": reach_recipes.SPTM},
}
"""Recipes by name and k."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the network's name and k."""
    parser.add_argument("name", choices=tuple(NETWORKS))
    choices = dict.fromkeys(k for known in NETWORKS.values() for k in known)
    parser.add_argument("--k", choices=tuple(choices), required=True)


def run(options: argparse.Namespace) -> int:
    """Train, and write the weights."""
    known = NETWORKS[options.name]
    if options.k not in known:
        raise InputError(f"train {options.name}: --k {options.k}; give one of {', '.join(known)}")
    recipe = known[options.k]
    if options.name == "waypoint":
        network, card = recipes.train_local(recipe, recipes.WORK)
    else:
        network, card = reach_recipes.train_reachability(recipe, recipes.WORK)
    path = save_network(network, card)
    # Otherwise the next call would resume a finished training.
    for checkpoint in recipe.checkpoints(recipes.WORK):
        checkpoint.unlink(missing_ok=True)
    print(f"wrote {path.relative_to(PROJECT)} after {card.minutes} min: {card.validation}")
    return 0
