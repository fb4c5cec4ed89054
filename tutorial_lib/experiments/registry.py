"""All experiments and benchmarks, by the names of their commands."""

from tutorial_lib.experiments.benchmarks import (
    control,
    explore,
    fleet,
    map_building,
    raycast,
    reachability,
)
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.ltvn import change, finetune, lifelong, size, spurious
from tutorial_lib.experiments.ltvn import label as ltvn_label
from tutorial_lib.experiments.ltvn import model as ltvn_model
from tutorial_lib.experiments.meng2020 import (
    calibration,
    fig4,
    fig5,
    fig6,
    fig7,
    fig8,
    fig9,
    fig10,
    fig11,
    fig12,
    fig13,
    table1,
    table2,
)
from tutorial_lib.experiments.nts import fig8 as nts_fig8
from tutorial_lib.experiments.nts import figs as nts_figs
from tutorial_lib.experiments.nts import scores as nts_scores
from tutorial_lib.experiments.nts import second_visit, wayfinding
from tutorial_lib.experiments.nts import table1 as nts_table1
from tutorial_lib.experiments.nts import table2 as nts_table2
from tutorial_lib.experiments.race import ten_visits
from tutorial_lib.experiments.robustness import disturbances, faults, plans

_EXPERIMENTS = (
    plans,
    table1,
    table2,
    fig4,
    calibration,
    fig5,
    fig6,
    fig7,
    fig8,
    fig9,
    fig10,
    fig11,
    fig12,
    fig13,
    disturbances,
    faults,
    wayfinding,
    nts_scores,
    nts_table1,
    nts_table2,
    nts_fig8,
    nts_figs,
    ten_visits,
    second_visit,
    ltvn_label,
    ltvn_model,
    lifelong,
    size,
    change,
    spurious,
    finetune,
)
_BENCHMARKS = (raycast, fleet, control, reachability, map_building, explore)

EXPERIMENTS: dict[str, Experiment] = {
    module.EXPERIMENT.name: module.EXPERIMENT for module in _EXPERIMENTS
}
BENCHMARKS: dict[str, Experiment] = {
    module.EXPERIMENT.name: module.EXPERIMENT for module in _BENCHMARKS
}
