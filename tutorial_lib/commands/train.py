"""Trains a network from scratch, data included."""

import argparse
from typing import Any

from tutorial_lib.commands.constants import PROJECT
from tutorial_lib.commands.experiment import add_scheduler
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.cluster import on_cluster
from tutorial_lib.learning import (
    exploration_recipes,
    goal_map_recipes,
    imitation_recipes,
    reach_recipes,
    recipes,
    relative_recipes,
)
from tutorial_lib.learning.panorama_encoder import SENSORS
from tutorial_lib.learning.reach_recipes import ReachRecipe
from tutorial_lib.learning.reinforcement_training import REINFORCEMENT, train_reinforcement
from tutorial_lib.learning.views import DEGREES, LEAST_DEGREES, MOST_DEGREES
from tutorial_lib.learning.weights import load_card, save_network

NETWORKS = {
    "waypoint": recipes.WAYPOINT,
    "reachability": {**reach_recipes.REACHABILITY, **reach_recipes.OF_TIME},
    "relative": relative_recipes.RELATIVE,
}
"""Recipes by name and k."""
OF_CAMERA = ("waypoint", "reachability")
"""Those that can be trained for a camera of other degrees."""
EXPLORATION = {
    "nts": "the functions of Neural Topological SLAM",
    "il": "a recurrent policy that imitates shortest paths; needs the weights of nts",
    "target_rl": "a policy on pictures that learns by reinforcement; needs the extra rl",
    "map_rl": "the same on pictures and a metric map",
    "ans_like": "a choice among frontiers of a metric map; needs the weights of nts",
}
"""Networks of exploration, by name; their recipes depend on the sensor."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the network's name, with k or the sensor."""
    names = parser.add_subparsers(dest="name", required=True)
    choices = dict.fromkeys(k for known in NETWORKS.values() for k in known)
    for name in NETWORKS:
        command = names.add_parser(name)
        command.add_argument("--k", choices=tuple(choices), required=True)
        command.set_defaults(degrees=None)
        if name in OF_CAMERA:
            command.add_argument(
                "--degrees",
                type=int,
                metavar="N",
                help=f"of the camera from left to right, {LEAST_DEGREES} to {MOST_DEGREES}; "
                f"{DEGREES} unless given",
            )
        add_scheduler(command)
    for name, words in EXPLORATION.items():
        command = names.add_parser(name, help=words)
        sensors = ("rgbd",) if name in REINFORCEMENT else SENSORS
        command.add_argument("--sensor", choices=sensors, required=True)
        add_scheduler(command)
        if name == "nts":
            kinds = command.add_mutually_exclusive_group()
            shared = {"dest": "kind", "action": "store_const", "default": ""}
            for kind, meaning in exploration_recipes.KINDS.items():
                kinds.add_argument(f"--{kind}", const=kind, help=meaning, **shared)


def run(options: argparse.Namespace) -> int:
    """Train, and write the weights."""
    recipe, train = _chosen(options)
    with on_cluster(options.scheduler):
        network, card = train(recipe, recipes.WORK)
    path = save_network(network, card)
    # Otherwise the next call would resume a finished training.
    for checkpoint in recipe.checkpoints(recipes.WORK):
        checkpoint.unlink(missing_ok=True)
    print(f"wrote {path.relative_to(PROJECT)} after {card.minutes} min: {card.validation}")
    return 0


def _chosen(options: argparse.Namespace) -> tuple[Any, Any]:
    """The recipe, and the function that trains by it.

    Raises:
        InputError: when there is no such network of that k, or for a camera of so many degrees,
            or that from which it starts was not trained yet.
    """
    if options.name == "nts":
        recipe = exploration_recipes.NTS[options.sensor, options.kind]
        return recipe, exploration_recipes.train_nts
    if options.name == "il":
        return imitation_recipes.IMITATION[options.sensor], imitation_recipes.train_imitation
    if options.name == "ans_like":
        return goal_map_recipes.GOAL_MAPS[options.sensor], goal_map_recipes.train_goal_map
    if options.name in REINFORCEMENT:
        return REINFORCEMENT[options.name], train_reinforcement
    known = NETWORKS[options.name]
    if options.k not in known:
        raise InputError(f"train {options.name}: --k {options.k}; give one of {', '.join(known)}")
    recipe: Any = known[options.k]
    if options.name == "relative":
        return recipe, relative_recipes.train_relative
    if options.degrees is not None:
        try:
            recipe = recipe.with_degrees(options.degrees)
        except InputError as error:
            raise InputError(f"--{error}") from None
    first = recipe.controller if isinstance(recipe, ReachRecipe) else recipe.start
    if first:  # before anything is recorded
        load_card(first)
    if options.name == "waypoint":
        return recipe, recipes.train_local
    if options.k in reach_recipes.OF_TIME:
        return recipe, reach_recipes.train_proximity
    return recipe, reach_recipes.train_reachability
