"""The library's modules whose settings and constants the templates tell, by their names there."""

from types import ModuleType

from tutorial_lib.agents import blockades, mending, remedy_navigation
from tutorial_lib.driving import metrics
from tutorial_lib.driving.data import perturbation, reachability_pairs, recorded_world
from tutorial_lib.experiments.ltvn import change, model, spurious
from tutorial_lib.experiments.meng2020 import fig4, fig12_localization, table1
from tutorial_lib.experiments.nts import second_visit
from tutorial_lib.experiments.protocols import (
    exploration,
    local_control,
    navigation,
    navigation_tasks,
    reachability,
    visits,
)
from tutorial_lib.experiments.race import runners, ten_visits
from tutorial_lib.experiments.robustness import disturbances, faults, plans
from tutorial_lib.exploration import explorable, ghost_graph, goal_search
from tutorial_lib.learning import (
    exploration_data,
    exploration_losses,
    exploration_recipes,
    fine_tuning,
    panorama_encoder,
    weights,
)
from tutorial_lib.topology import maintenance, planner
from tutorial_lib.topology.following import transitions
from tutorial_lib.topology.mapping import edge_rules, image_pool, sampling_map, turn_edges

_MODULES = (
    *(blockades, change, disturbances, edge_rules, explorable, exploration, exploration_data),
    *(exploration_losses, exploration_recipes, faults, fig12_localization, fig4, fine_tuning),
    *(ghost_graph, goal_search, image_pool, local_control, maintenance, mending, metrics, model),
    *(navigation, navigation_tasks, panorama_encoder, perturbation, planner, plans),
    *(reachability, reachability_pairs, recorded_world, remedy_navigation, runners, sampling_map),
    *(second_visit, spurious, table1, ten_visits, transitions, turn_edges, visits, weights),
)
LIBRARY: dict[str, ModuleType] = {module.__name__.rpartition(".")[2]: module for module in _MODULES}
