"""Generated worlds by name: "family/seed/palette", as in "apartment/17/standard".

Large ones say so: "apartment/17/standard/large".

A recorded trajectory stores this name, and its images are rendered again from it.
"""

from tutorial_lib.errors import InputError
from tutorial_lib.world.generators import AREAS, FAMILIES, generate
from tutorial_lib.world.generators.palette import PALETTES
from tutorial_lib.world.scene import Scene

LOCAL_FAMILIES = ("apartment", "office", "maze", "loop_corridor")
"""Where local control is evaluated, by seed."""
MAP_FAMILIES = ("apartment", "office", "loop_corridor")
"""Where maps are built and planned on, by seed."""
TRAINING_FAMILIES = LOCAL_FAMILIES[:3]
"""Where networks are trained, by seed: they see `loop_corridor` in validation at most."""
TRAINING_SEEDS = range(10_000)


def world_name(family: str, seed: int, palette: str = "standard", size: str = "any") -> str:
    """The name of a generated world; see `generators.generate`.

    Raises:
        InputError: saying which part is unknown.

    >>> world_name("apartment", 17)
    'apartment/17/standard'
    """
    name = f"{family}/{seed}/{palette}" + (f"/{size}" if size != "any" else "")
    parse_world(name)
    return name


def parse_world(name: str) -> tuple[str, int, str, str]:
    """Family, seed, palette and size of a name; each world has exactly one name.

    Raises:
        InputError: saying which part of the name is wrong.
    """
    parts = name.split("/")
    if len(parts) == 3:
        parts = [*parts, "any"]
    elif len(parts) != 4 or parts[3] == "any":
        raise InputError(
            f"world: {name!r}; give family/seed/palette, as in apartment/17/standard, and /large "
            "behind it for a large one"
        )
    family, seed, palette, size = parts
    if family not in FAMILIES:
        raise InputError(f"world: family {family!r} is unknown; use one of {', '.join(FAMILIES)}")
    if not (seed.isascii() and seed.isdecimal() and str(int(seed)) == seed):
        raise InputError(f"world: seed {seed!r}; give a whole number, 0 or greater")
    if palette not in PALETTES:
        raise InputError(f"world: palette {palette!r} is unknown; use one of {', '.join(PALETTES)}")
    if size not in AREAS:
        raise InputError(f"world: size {size!r} is unknown; use one of {', '.join(AREAS)}")
    return family, int(seed), palette, size


def scene_of(name: str) -> Scene:
    """Generate the world of that name.

    Raises:
        InputError: saying which part of the name is wrong.
    """
    return Scene(generate(*parse_world(name)))


def local_world(seed: int, palette: str = "standard") -> str:
    """The world of that seed on which local control is evaluated."""
    return _by_seed(LOCAL_FAMILIES, seed, palette)


def map_world(seed: int, palette: str = "standard") -> str:
    """The world of that seed in which maps are built: a large one (Meng 2020, Table II)."""
    return _by_seed(MAP_FAMILIES, seed, palette, "large")


def training_world(seed: int, palette: str = "standard") -> str:
    """The world of that seed from which networks learn.

    Raises:
        InputError: when the seed is kept for validation or tests.
    """
    name = _by_seed(TRAINING_FAMILIES, seed, palette)
    if int(seed) not in TRAINING_SEEDS:
        raise InputError(
            f"world: seed {seed} is not for training; give one from 0 to {TRAINING_SEEDS[-1]}"
        )
    return name


def _by_seed(families: tuple[str, ...], seed: int, palette: str, size: str = "any") -> str:
    # The name is checked before the seed is used as a number.
    world_name(families[0], seed, palette, size)
    return world_name(families[int(seed) % len(families)], seed, palette, size)
