"""The options that name a map's file, and a part of it."""

import argparse
from pathlib import Path

from tutorial_lib.errors import InputError


def add_map(parser: argparse.ArgumentParser) -> None:
    """Declare --map and --region."""
    parser.add_argument(
        "--map", type=Path, metavar="FILE", help="a ROS map's YAML, a HouseExpo or a plan's JSON"
    )
    parser.add_argument(
        "--region",
        type=_region,
        metavar="X0,Y0,X1,Y1",
        help="of a ROS map: all in this box, in metres of the map's frame; or X,Y: the free part "
        "that holds this point",
    )


def _region(text: str) -> tuple[float, ...]:
    # Here, since the library takes seconds to import, and most runs have no region.
    from tutorial_lib.world.importers import parse_region

    try:
        return parse_region(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("region: ")) from None
