"""Any kind of map, recognised by its suffix and content."""

from pathlib import Path

from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import read_json
from tutorial_lib.validation import path_of
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.importers.houseexpo import import_houseexpo
from tutorial_lib.world.importers.regions import Region
from tutorial_lib.world.importers.ros_map import import_ros_map
from tutorial_lib.world.importers.surfaces import check_choice
from tutorial_lib.world.plan_json import load_plan


def import_map(
    path: str | Path, seed: int = 0, palette: str = "standard", region: Region | None = None
) -> FloorPlan:
    """Read a map of any known kind.

    Args:
        path: a ROS map's YAML file, a HouseExpo JSON file, or a floor plan saved by this library.
        seed: of an imported map's colours; a saved plan keeps its own.
        palette: "standard" or "shifted", for an imported map; a saved plan keeps its own.
        region: of a ROS map, see `import_ros_map`; the whole map unless given.

    Returns:
        The floor plan, in metres.

    Raises:
        InputError: when the file is missing, of no known kind, or malformed, or has no region.
    """
    check_choice(seed, palette)
    path = path_of("path", path)
    if path.suffix.lower() in (".yaml", ".yml"):
        return import_ros_map(path, seed, palette, region)
    if path.suffix.lower() != ".json":
        raise InputError(f"{path}: unknown kind of map; give a .yaml, .yml or .json file")
    if region is not None:
        raise InputError(f"region: {path.name} is no ROS map (.yaml); leave the region out")
    content = read_json(path, "give a map's file; was it cut off?")
    if isinstance(content, dict) and "schema" in content:
        return load_plan(path)
    if isinstance(content, dict) and "verts" in content:
        return import_houseexpo(path, seed, palette)
    raise InputError(
        f"{path.name}: has neither 'verts' (HouseExpo) nor 'schema' (a saved floor plan); "
        "give one of these kinds"
    )
