"""Generated worlds by name: "family/seed/palette", as in "apartment/17/standard".

Large ones say so behind that, and so do those with signs that lead, in this order:
"apartment/17/standard/large/wayfinding".

A recorded trajectory stores this name, and its images are rendered again from it.
"""

from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, one_of, whole
from tutorial_lib.world.generators import AREAS, FAMILIES, SIGNS, generate
from tutorial_lib.world.generators.palette import PALETTES
from tutorial_lib.world.scene import Scene

LOCAL_FAMILIES = ("apartment", "office", "maze", "loop_corridor")
"""Where local control is evaluated, by seed."""
MAP_FAMILIES = ("apartment", "office", "loop_corridor")
"""Where maps are built and planned on, by seed."""
TRAINING_FAMILIES = ("apartment", "office", "hall", "scanned", "maze")
"""Where networks are trained, by seed: they see `loop_corridor` in validation at most."""
VALIDATION_FAMILIES = (*TRAINING_FAMILIES, "loop_corridor")
"""Where training is stopped and networks are calibrated, by seed; what "all" families means."""
TRAINING_SEEDS = range(10_000)
_WITH_SIGNS = 4  # one in so many training worlds of each family


def world_name(
    family: str, seed: int, palette: str = "standard", size: str = "any", signs: str = "plain"
) -> str:
    """The name of a generated world; see `generators.generate`.

    Raises:
        InputError: saying which part is unknown.

    >>> world_name("apartment", 17)
    'apartment/17/standard'
    """
    one_of("family", family, FAMILIES)
    one_of("palette", palette, PALETTES)
    one_of("size", size, AREAS)
    one_of("signs", signs, SIGNS)
    seed = whole("seed", seed, least=0)
    return "/".join([family, str(seed), palette, *_options(size, signs)])


def parse_world(name: str) -> tuple[str, int, str, str, str]:
    """Family, seed, palette, size and signs of a name; each world has exactly one name.

    Raises:
        InputError: saying which part of the name is wrong.
    """
    instance("name", name, str)
    family, seed, palette, *options = name.split("/") if name.count("/") > 1 else ("", "", "", "")
    size = options.pop(0) if options and options[0] not in SIGNS else "any"
    signs = options.pop(0) if options else "plain"
    if options or "" in (family, size, signs) or _options(size, signs) != name.split("/")[3:]:
        raise InputError(
            f"world name: {name!r}; give family/seed/palette, as in apartment/17/standard, and "
            "/large behind it for a large one, /wayfinding for one with signs"
        )
    if family not in FAMILIES:
        raise InputError(f"world: family {family!r} is unknown; use one of {', '.join(FAMILIES)}")
    try:
        number = int(seed)
    except ValueError:  # not a number, or one of thousands of digits
        number = -1
    if number < 0 or str(number) != seed:
        raise InputError(f"world: seed {seed!r}; give a whole number, 0 or greater")
    for what, value, known in (
        ("palette", palette, PALETTES),
        ("size", size, AREAS),
        ("signs", signs, SIGNS),
    ):
        if value not in known:
            raise InputError(f"world: {what} {value!r} is unknown; use one of {', '.join(known)}")
    return family, number, palette, size, signs


def _options(size: str, signs: str) -> list[str]:
    """The parts of a name that stand only where they say something."""
    return [part for part, usual in ((size, "any"), (signs, "plain")) if part != usual]


def scene_of(name: str) -> Scene:
    """Generate the world of that name.

    Raises:
        InputError: saying which part of the name is wrong.
    """
    return Scene(generate(*parse_world(name)))


def families_of(family: str, usual: tuple[str, ...]) -> tuple[str, ...]:
    """The families that an option asks for: the `usual` ones if empty, "all", or a single one.

    >>> families_of("hall", LOCAL_FAMILIES)
    ('hall',)
    """
    if instance("family", family, str):
        one_of("family", family, ("all", *FAMILIES))
    return {"": usual, "all": VALIDATION_FAMILIES}.get(family, (family,))


def local_world(seed: int, palette: str = "standard", family: str = "") -> str:
    """The world of that seed on which local control is evaluated.

    Args:
        seed: chooses the family as well, among `LOCAL_FAMILIES`.
        palette: of the world.
        family: see `families_of`.
    """
    return _by_seed(families_of(family, LOCAL_FAMILIES), seed, palette)


def map_world(seed: int, palette: str = "standard", family: str = "") -> str:
    """The world of that seed in which maps are built: a large one (Meng 2020, Table II).

    Args:
        seed: chooses the family as well, among `MAP_FAMILIES`.
        palette: of the world.
        family: see `families_of`.
    """
    return _by_seed(families_of(family, MAP_FAMILIES), seed, palette, "large")


def training_world(seed: int, palette: str = "standard") -> str:
    """The world of that seed from which networks learn; every fourth of a family has signs.

    Raises:
        InputError: when the seed is kept for validation or tests.
    """
    name = _by_seed(TRAINING_FAMILIES, seed, palette)
    if int(seed) not in TRAINING_SEEDS:
        raise InputError(
            f"world: seed {seed} is not for training; give one from 0 to {TRAINING_SEEDS[-1]}"
        )
    with_signs = int(seed) // len(TRAINING_FAMILIES) % _WITH_SIGNS == _WITH_SIGNS - 1
    return f"{name}/wayfinding" if with_signs else name


def validation_world(seed: int) -> str:
    """The world of that seed on which training is stopped and networks are calibrated."""
    return _by_seed(VALIDATION_FAMILIES, seed, "standard")


def _by_seed(families: tuple[str, ...], seed: int, palette: str, size: str = "any") -> str:
    seed = whole("seed", seed, least=0)
    return world_name(families[seed % len(families)], seed, palette, size)
