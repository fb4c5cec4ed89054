"""Trained weights on disk: half-precision safetensors with a card of where they come from."""

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import torch
from safetensors import SafetensorError, deserialize
from safetensors.torch import load, save
from torch import Tensor, nn

from tutorial_lib.errors import InputError
from tutorial_lib.files import make_folder, write_files
from tutorial_lib.learning.goal_map_network import GoalMapArchitecture, GoalMapNetwork
from tutorial_lib.learning.imitation_network import ImitationArchitecture, ImitationNetwork
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.panorama_network import (
    PANORAMA,
    PanoramaArchitecture,
    PanoramaNetwork,
)
from tutorial_lib.learning.reinforcement_network import (
    ReinforcementArchitecture,
    ReinforcementNetwork,
)
from tutorial_lib.learning.threads import settle_threads
from tutorial_lib.learning.views import DEGREES, LaserView, usual_name
from tutorial_lib.reading.checksums import CHECKSUM, with_checksum, without_checksum
from tutorial_lib.reading.documents import read_json
from tutorial_lib.reading.limits import MAX_WEIGHTS
from tutorial_lib.reading.regular import read_bytes
from tutorial_lib.validation import instance, path_of

FOLDER = Path(__file__).resolve().parent.parent / "weights"
"""Of the weights that come with the library."""
KINDS: dict[str, tuple[type, type[nn.Module]]] = {
    "local": (Architecture, LocalNetwork),
    "panorama": (PanoramaArchitecture, PanoramaNetwork),
    "imitation": (ImitationArchitecture, ImitationNetwork),
    "goal_map": (GoalMapArchitecture, GoalMapNetwork),
    "reinforcement": (ReinforcementArchitecture, ReinforcementNetwork),
}
"""Architecture and network by the kind that a card's architecture names; "local" if it has none."""
Network = TypeVar("Network", bound=nn.Module)
LOADED: dict[str, str] = {}
"""Networks of the library that this process has used: fingerprints of their cards, by name."""
_FLOATS = ("F16", "F32", "F64")
"""What tensors may consist of, in the words of safetensors."""
_LARGE = 1e12  # no number on a card is


@dataclass(frozen=True)
class Card:
    """Where weights come from.

    Attributes:
        name: of the network.
        command: that trains it again.
        architecture: to build it with.
        recipe: data and settings it was trained with.
        validation: what was measured on validation worlds.
        calibration: what turns the logit of reachability into a probability, see `Calibration`.
        minutes: it took, including demonstrations that were not recorded before.
        cores: that it was trained on; the reference machine has two.
        parameters: their number.
        camera: with which it learned; none for a network that looks at the laser.
        sha256: of the weights' file.
    """

    name: str
    command: str
    architecture: Any  # one of KINDS
    recipe: dict[str, Any] = field(default_factory=dict)
    validation: dict[str, float] = field(default_factory=dict)
    calibration: dict[str, Any] = field(default_factory=dict)
    minutes: float = 0.0
    cores: int = 2
    parameters: int = 0
    camera: dict[str, float] = field(default_factory=dict)
    sha256: str = ""


def save_network(network: nn.Module, card: Card, folder: Path = FOLDER) -> Path:
    """Write `NAME.safetensors` in half precision and the card `NAME.json` beside it.

    Returns:
        The file of the weights.
    """
    make_folder(folder)
    path = folder / f"{card.name}.safetensors"
    halves = {name: value.half().contiguous() for name, value in network.state_dict().items()}
    weights = save(halves)
    parameters = sum(value.numel() for value in halves.values())
    text = asdict(card) | {
        "parameters": parameters,
        "sha256": hashlib.sha256(weights).hexdigest(),
        "camera": camera_of(card.architecture),
    }
    said = json.dumps(with_checksum(text), indent=1) + "\n"
    # Together, since neither is of use with an older one of the other.
    write_files({path: weights, path.with_suffix(".json"): said.encode()})
    return path


def camera_of(architecture: Any) -> dict[str, float]:  # noqa: ANN401 - one of KINDS
    """The camera that a network of this architecture looks through, as a card has it."""
    camera: Any = PANORAMA
    if isinstance(architecture, Architecture):
        if isinstance(architecture.looks_at, LaserView):
            return {}
        camera = architecture.looks_at.camera
    # The last digit of a tangent differs from machine to machine.
    return {name: round(value, 6) for name, value in asdict(camera).items()}


def load_card(name: str, folder: Path = FOLDER) -> Card:
    """The card of weights.

    Raises:
        InputError: when it is missing or damaged; of a network for another camera than the usual
            one it names the command that trains it.
    """
    folder = path_of("folder", folder)
    path = folder / f"{instance('name', name, str)}.json"
    again = "restore the file, or train it again: python -m tutorial_lib train --help"
    if not path.exists():
        usual, degrees = usual_name(name)
        if degrees != DEGREES and (folder / f"{usual}.json").exists():
            command = f"python -m tutorial_lib {load_card(usual, folder).command}"
            raise InputError(
                f"{path}: there is no {usual} for a camera of {degrees} degrees; train it: "
                f"{command} --degrees {degrees}"
            )
        known = ", ".join(sorted(file.stem for file in folder.glob("*.json"))) or "none"
        raise InputError(f"{path}: there is no such card, but {known}; {again}")
    text = read_json(path, f"not a card of weights; {again}")
    try:
        if CHECKSUM in text:  # cards of older versions have none
            text = without_checksum(text)
        _check_card(text, name)
        kind = KINDS[text["architecture"].get("kind", "local")][0]
        card = Card(**(text | {"architecture": kind(**text["architecture"])}))
    except (InputError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not a card of weights ({error}); {again}") from error
    if folder == FOLDER:
        LOADED[name] = fingerprint_of(card)
    return card


def fingerprint_of(card: Card) -> str:
    """Of what a card's network predicts: its weights and its calibration."""
    said = card.sha256 + json.dumps(card.calibration, sort_keys=True)
    return hashlib.sha256(said.encode()).hexdigest()[:12]


def _check_card(text: Any, name: str) -> None:  # noqa: ANN401 - anything JSON can hold
    """Check the types of what a card says; `Card` and `Architecture` check its keys."""
    if not isinstance(text, dict):
        raise InputError("not a mapping")
    kinds: dict[str, tuple[type, ...]] = {
        **dict.fromkeys(("name", "command", "sha256"), (str,)),
        **dict.fromkeys(("architecture", "recipe", "validation", "calibration", "camera"), (dict,)),
        **dict.fromkeys(("cores", "parameters"), (int,)),
        "minutes": (int, float),
    }
    for key, kind in kinds.items():
        if key in text and (not isinstance(text[key], kind) or isinstance(text[key], bool)):
            raise InputError(f"{key}: {text[key]!r:.40} does not belong there")
    if text.get("name") != name or "command" not in text:
        raise InputError("of another name, or without a command")
    calibration = text.get("calibration", {})
    numbers = [text.get("minutes", 0.0), *text.get("validation", {}).values()]
    for knots in calibration.values():
        numbers += knots if isinstance(knots, list) else ["none"]
    good = all(type(number) in (int, float) and abs(number) < _LARGE for number in numbers)
    if not good or (calibration and set(calibration) != {"raw", "mended"}):
        raise InputError("minutes, validation, or calibration: finite numbers belong there")


def load_network(name: str, folder: Path = FOLDER, wanted: type[Network] = LocalNetwork) -> Network:
    """A trained network by its name, ready for inference.

    Args:
        name: of the weights.
        folder: that holds them.
        wanted: the class that it must have.

    Raises:
        InputError: when file or card is missing, the hash differs, the camera does not fit, or a
            tensor is missing, has another shape, or does not consist of finite real numbers; it
            names the tensor and the command that trains it again.
    """
    settle_threads()
    card = load_card(name, folder)
    path = folder / f"{name}.safetensors"
    again = f"restore the file, or train it again: python -m tutorial_lib {card.command}"
    data = read_bytes(path, MAX_WEIGHTS, again)
    if hashlib.sha256(data).hexdigest() != card.sha256:
        raise InputError(f"{path}: not the file that its card describes (SHA-256 differs); {again}")
    network = _network_of(card, wanted, path)
    try:
        network.load_state_dict(_weights_of(data, network.state_dict(), card.parameters))
    except (SafetensorError, InputError) as error:
        raise InputError(f"{path}: does not fit {card.architecture} ({error}); {again}") from error
    camera = camera_of(card.architecture)
    if card.camera not in ({}, camera):  # older cards do not say
        raise InputError(f"{path}: learned with the camera {card.camera}, not {camera}; {again}")
    network.to(memory_format=torch.channels_last)  # pyrefly: ignore[no-matching-overload]
    return network.eval()


def _weights_of(data: bytes, own: dict[str, Tensor], parameters: int) -> dict[str, Tensor]:
    """The tensors of a safetensors file, if they are those of a network whose `own` these are."""
    for name, described in deserialize(data):  # before torch sees kinds that it does not know
        if described["dtype"] not in _FLOATS:
            raise InputError(f"tensor {name}: of {described['dtype']}, not one of {_FLOATS}")
    found = {name: value.float() for name, value in load(data).items()}
    for name in own.keys() | found.keys():
        if name not in found or name not in own:
            raise InputError(f"tensor {name}: {'missing' if name in own else 'not known'}")
    check_like(found, own)
    count = sum(value.numel() for value in found.values())
    if count != parameters:
        raise InputError(f"{count} parameters, of which its card says {parameters}")
    return found


def check_like(found: dict[str, Tensor], own: dict[str, Tensor]) -> None:
    """Check that tensors have the shapes of others by the same names, and are finite.

    Raises:
        InputError: naming the tensor.
    """
    for name, value in found.items():
        if value.shape != own[name].shape:
            shapes = tuple(value.shape), tuple(own[name].shape)
            raise InputError(f"tensor {name}: shape {shapes[0]} instead of {shapes[1]}")
        if not value.isfinite().all():
            raise InputError(f"tensor {name}: holds what is no finite number")


def _network_of(card: Card, wanted: type[Network], path: Path) -> Network:
    """An untrained network of the card's architecture."""
    kind = dict(KINDS.values())[type(card.architecture)]
    if kind is not wanted:
        raise InputError(f"{path}: holds a {kind.__name__} where a {wanted.__name__} is needed")
    return wanted(card.architecture)


def untrained(architecture: Any) -> nn.Module:  # noqa: ANN401 - one of KINDS
    """A network of this architecture; `LocalNetwork` refuses what is none."""
    return dict(KINDS.values()).get(type(architecture), LocalNetwork)(architecture)


def digest_of(network: nn.Module) -> str:
    """A short name for a network's weights: the same ones have the same."""
    found = hashlib.sha256()
    for name, value in sorted(network.state_dict().items()):
        found.update(name.encode() + value.contiguous().numpy().tobytes())
    return found.hexdigest()[:16]
