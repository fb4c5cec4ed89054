"""The 2D world: floor plans, rays, sensors, bodies and their motion."""

from tutorial_lib.world.bodies import BicycleCar, Body, DifferentialDrive
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.importers import import_houseexpo, import_map, import_ros_map
from tutorial_lib.world.noise import WheelOdometry
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import is_free, random_free_poses
from tutorial_lib.world.plan_json import load_plan, save_plan
from tutorial_lib.world.raycast import Discs, Fan, Raycaster
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import (
    EYE,
    WALL_HEIGHT,
    Camera,
    Laser,
    PanoramicCamera,
    Sensors,
    full_circle,
)
from tutorial_lib.world.simulation import STEP, Simulation
from tutorial_lib.world.visibility import mutual_overlap
from tutorial_lib.world.worlds import local_world, map_world, scene_of, training_world, world_name

__all__ = [
    "EYE",
    "FAMILIES",
    "STEP",
    "WALL_HEIGHT",
    "BicycleCar",
    "Body",
    "Camera",
    "DifferentialDrive",
    "Discs",
    "Fan",
    "FloorPlan",
    "Laser",
    "PanoramicCamera",
    "Person",
    "Raycaster",
    "Scene",
    "Sensors",
    "Simulation",
    "WheelOdometry",
    "full_circle",
    "generate",
    "import_houseexpo",
    "import_map",
    "import_ros_map",
    "is_free",
    "load_plan",
    "local_world",
    "map_world",
    "mutual_overlap",
    "random_free_poses",
    "save_plan",
    "scene_of",
    "training_world",
    "world_name",
]
