"""Generated worlds by name: "family/seed/palette", as in "apartment/17/standard".

A recorded trajectory names its world so, and the pictures are rendered again from the name.
"""

from tutorial_lib.errors import InputError
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.generators.palette import PALETTES
from tutorial_lib.world.scene import Scene

LOCAL_FAMILIES = ("apartment", "office", "maze", "loop_corridor")
"""Where local control is evaluated, by seed."""
TRAINING_FAMILIES = LOCAL_FAMILIES[:3]
"""Where networks are trained, by seed: they see `loop_corridor` in validation at most."""
TRAINING_SEEDS = range(10_000)


def world_name(family: str, seed: int, palette: str = "standard") -> str:
    """The name of a generated world.

    Raises:
        InputError: saying which part is unknown.

    >>> world_name("apartment", 17)
    'apartment/17/standard'
    """
    name = f"{family}/{seed}/{palette}"
    parse_world(name)
    return name


def parse_world(name: str) -> tuple[str, int, str]:
    """Family, seed and palette of a name; each world has only one.

    Raises:
        InputError: saying which part of the name is wrong.
    """
    parts = name.split("/")
    if len(parts) != 3:
        raise InputError(f"world: {name!r}; give family/seed/palette, as in apartment/17/standard")
    family, seed, palette = parts
    if family not in FAMILIES:
        raise InputError(f"world: family {family!r} is unknown; use one of {', '.join(FAMILIES)}")
    if not (seed.isascii() and seed.isdecimal() and str(int(seed)) == seed):
        raise InputError(f"world: seed {seed!r}; give a whole number, 0 or greater")
    if palette not in PALETTES:
        raise InputError(f"world: palette {palette!r} is unknown; use one of {', '.join(PALETTES)}")
    return family, int(seed), palette


def scene_of(name: str) -> Scene:
    """Generate the world of that name.

    Raises:
        InputError: saying which part of the name is wrong.
    """
    return Scene(generate(*parse_world(name)))


def local_world(seed: int, palette: str = "standard") -> str:
    """The world of that seed on which local control is evaluated."""
    return _by_seed(LOCAL_FAMILIES, seed, palette)


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


def _by_seed(families: tuple[str, ...], seed: int, palette: str) -> str:
    # The name is checked before the seed is reckoned with.
    world_name(families[0], seed, palette)
    return world_name(families[int(seed) % len(families)], seed, palette)
