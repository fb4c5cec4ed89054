"""What walls look like: a material is a strip of colour along the wall."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import floats, instance, instances, number, one_of, whole

PERIOD = 25.6
"""Metres after which a strip repeats: longer than the perimeter of most rooms."""
TEXEL = 0.05
"""Metres of wall that one texel covers."""
TEXELS = round(PERIOD / TEXEL)

Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Stripe:
    """A poster, a door frame, a line: one colour from `start` to `end` metres along the wall."""

    start: float
    end: float
    colour: Colour


@dataclass(frozen=True)
class Material:
    """A strip of colour, `PERIOD` metres long and repeating.

    Attributes:
        name: unique within its floor plan.
        colour: RGB, 0 to 255, wherever no stripe is.
        stripes: drawn in order, later over earlier; each lies within 0 to `PERIOD`.
    """

    name: str
    colour: Colour
    stripes: tuple[Stripe, ...] = ()

    def __post_init__(self) -> None:
        instance("name", self.name, str)
        _check_colour(f"material {self.name!r}: colour", self.colour)
        instances("stripes", self.stripes, Stripe)
        for place, stripe in enumerate(self.stripes):
            where = f"material {self.name!r}: stripes[{place}]"
            _check_colour(f"{where}.colour", stripe.colour)
            floats(where, (stripe.start, stripe.end), (2,), infinite=True)
            if not 0.0 <= stripe.start < stripe.end <= PERIOD:
                raise InputError(
                    f"{where}: runs from {stripe.start} to {stripe.end} m; "
                    f"give 0 <= start < end <= {PERIOD}"
                )

    def texels(self) -> NDArray[np.float32]:
        """The strip as an array (TEXELS, 3), RGB 0 to 255; a stripe's edge mixes exactly."""
        strip = np.tile(np.asarray(self.colour, np.float32), (TEXELS, 1))
        left = np.arange(TEXELS) * TEXEL
        for stripe in self.stripes:
            covered = np.minimum(left + TEXEL, stripe.end) - np.maximum(left, stripe.start)
            share = np.clip(covered / TEXEL, 0.0, 1.0).astype(np.float32)[:, None]
            strip += share * (np.asarray(stripe.colour, np.float32) - strip)
        return strip


@dataclass(frozen=True)
class Look:
    """How a whole world looks to the camera.

    Attributes:
        palette: "standard", or "shifted" for colours that no training world has.
        floor: RGB.
        ceiling: RGB.
        gamma: exponent applied to every colour, 1 for none.
        noise: standard deviation of the grain of every strip, in grey levels.
    """

    palette: str = "standard"
    floor: Colour = (128, 112, 96)
    ceiling: Colour = (212, 214, 218)
    gamma: float = 1.0
    noise: float = 0.0

    def __post_init__(self) -> None:
        _check_colour("look.floor", self.floor)
        _check_colour("look.ceiling", self.ceiling)
        one_of("look.palette", self.palette, ("standard", "shifted"))
        number("look.gamma", self.gamma, least=0.2, most=5.0)
        number("look.noise", self.noise, least=0.0, most=64.0)

    def tone(self, colours: NDArray[np.floating]) -> NDArray[np.float32]:
        """Colours (...), in 0 to 255 for each channel, after gamma."""
        floats("colours", colours)
        return (255.0 * (np.clip(colours, 0, 255) / 255.0) ** self.gamma).astype(np.float32)


def texture_atlas(materials: Sequence[Material], look: Look, seed: int) -> NDArray[np.float32]:
    """Every material's strip as the camera sees it.

    Args:
        materials: M materials.
        look: gamma and grain.
        seed: of the grain.

    Returns:
        (M, TEXELS, 3) RGB, 0 to 255.
    """
    materials = instances("materials", materials, Material, empty=False)
    instance("look", look, Look)
    rng = np.random.default_rng(whole("seed", seed, least=0))
    strips = np.stack([material.texels() for material in materials])
    grain = rng.normal(0.0, 1.0, strips.shape[:2]).astype(np.float32)[..., None]
    return look.tone(strips + look.noise * grain)


def _check_colour(where: str, colour: object) -> None:
    ok = isinstance(colour, tuple) and len(colour) == 3
    if not ok or not all(type(c) is int and 0 <= c <= 255 for c in colour):
        raise InputError(f"{where}: {colour!r} is no colour; give three whole numbers 0 to 255")
