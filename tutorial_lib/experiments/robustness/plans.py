"""Are the generated plans valid, and can a car drive in them?"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import walls_crossed
from tutorial_lib.driving.rollouts import ReachGoals, Rollouts, geodesic_limit, rollout
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.parallel import for_each
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators import FAMILIES, area_limits, generate
from tutorial_lib.world.importers import Region, import_map
from tutorial_lib.world.occupancy import check_closed
from tutorial_lib.world.placing import random_free_poses
from tutorial_lib.world.plan_json import plan_from_json, plan_to_json
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Laser
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.worlds import families_of

WORLDS = tuple(range(20_000, 20_200))
USUAL = FAMILIES[:5]
"""Families whose plans are examined unless one is given."""


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        goals: of the rollouts in one plan.
        driven: plans of each family in which cars drive.
    """

    goals: int = 20
    driven: int = 10


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Generate every world in every family, validate all plans, and drive in the first few.

    With `options.map` the only plan is that file's.
    """
    worlds, families = options.worlds, families_of(options.family, USUAL)
    driven = worlds[: settings.driven]
    jobs = [(family, world, world in driven) for family in families for world in worlds]
    if options.map is not None:
        jobs = [(str(options.map), 0, True)]
    found = for_each(examine, jobs, settings.goals, options.seed, options.region, label="plans")
    rows, notes = [], []
    for family in dict.fromkeys(job[0] for job in jobs):
        mine = [(job, f) for job, f in zip(jobs, found, strict=True) if job[0] == family]
        rollouts = sum(f["rollouts"] for _, f in mine)
        rows.append(
            {
                "family": family if options.map is None else options.map.name,
                "plans": len(mine),
                "valid": sum(not f["fault"] for _, f in mine),
                "drives": rollouts,
                "success": sum(f["reached"] for _, f in mine) / max(rollouts, 1),
                "walls_crossed": sum(f["walls_crossed"] for _, f in mine),
            }
        )
        notes += [f"{family} {job[1]}: {f['fault']}" for job, f in mine if f["fault"]]
    return rows, notes


def examine(
    job: tuple[str, int, bool], goals: int, seed: int, region: Region | None
) -> dict[str, Any]:
    """Validate one plan and, if the job says so, drive in it to random goals.

    Args:
        job: family, one of `FAMILIES`, or a map's file; seed of the plan; whether to drive.
        goals: of the rollouts.
        seed: of starts and goals.
        region: of a map's file, see `import_map`.
    """
    family, world, driven = job
    found = {"fault": "", "rollouts": 0, "reached": 0, "walls_crossed": 0}
    rng = np.random.default_rng([seed, world])
    try:
        plan = make_plan(family, world, region)
        scene = Scene(plan)
        paths = GridPaths(scene.clearance)
        again = plan_to_json(make_plan(family, world, region))
        found["fault"] = find_fault(plan, again, scene, paths, rng)
        rollouts = drive_about(scene, paths, goals, rng) if driven else None
    except InputError as error:
        if family not in FAMILIES:
            raise
        return found | {"fault": str(error)}
    if rollouts is not None:
        crossed = walls_crossed(scene.caster, rollouts.poses)
        reached = int(rollouts.reached.sum())
        found |= {"rollouts": goals, "reached": reached, "walls_crossed": crossed}
    return found


def make_plan(family: str, world: int, region: Region | None) -> FloorPlan:
    """The plan of a family and seed, or of a map's file."""
    known = family in FAMILIES
    return generate(family, world) if known else import_map(family, world, region=region)


def find_fault(
    plan: FloorPlan, again: str, scene: Scene, paths: GridPaths, rng: np.random.Generator
) -> str:
    """What is wrong with a plan, or ""; `again` is the JSON of the plan generated once more."""
    text = plan_to_json(plan)
    if again != text:
        return "the same seed gave another plan"
    if plan_to_json(plan_from_json(text)) != text:
        return "saving and loading changed it"
    try:
        check_closed(plan)
    except InputError as error:
        return str(error)
    if plan.family in FAMILIES and plan.family != "scanned":  # a scan may lose a corner
        for number, room in enumerate(plan.rooms):
            if not (room.contains(paths.points) & paths.largest).any():
                return f"room {number} ({room.kind}) cannot be reached by the car"
        least, most = area_limits(plan.family)
        if not least <= plan.area <= most:
            return f"its area is {plan.area:.0f} m2"
    places = paths.points[rng.integers(len(paths.points), size=100)]
    poses = np.column_stack([places, rng.uniform(-np.pi, np.pi, len(places))])
    if not np.isfinite(scene.caster.cast(poses, Laser(beams=360).fan).distance).all():
        return "a ray escaped"
    return ""


def drive_about(scene: Scene, paths: GridPaths, count: int, rng: np.random.Generator) -> Rollouts:
    """Drive `count` cars from random free poses to random places."""
    places = paths.points[paths.largest]
    starts = random_free_poses(scene, BicycleCar(), places, count, rng)
    goals = places[rng.integers(len(places), size=count)]
    simulation = Simulation(scene, starts)
    ends = ReachGoals(goals, geodesic_limit(paths, starts, goals))
    return rollout(simulation, OraclePolicy(simulation, paths, goals), ends)


EXPERIMENT = Experiment(
    "plans",
    run,
    WORLDS,
    WORLDS[:20],
    Settings(),
    quick_settings=Settings(driven=5),
    canary=Settings(goals=3, driven=2),
    accepts=frozenset({"map", "family"}),
)
