"""Floor plans from existing maps: ROS occupancy grids and HouseExpo outlines."""

from tutorial_lib.world.importers.any_map import import_map
from tutorial_lib.world.importers.houseexpo import import_houseexpo
from tutorial_lib.world.importers.regions import Region, parse_region
from tutorial_lib.world.importers.ros_map import import_ros_map

__all__ = ["Region", "import_houseexpo", "import_map", "import_ros_map", "parse_region"]
