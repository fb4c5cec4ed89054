import errno
import hashlib
import json
import re
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

import joblib
import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from tutorial_lib import cli
from tutorial_lib.commands import train as train_command
from tutorial_lib.errors import InputError
from tutorial_lib.learning import recipes
from tutorial_lib.learning.batches import Source
from tutorial_lib.learning.exploration_recipes import NTS
from tutorial_lib.learning.goal_map_recipes import GOAL_MAPS
from tutorial_lib.learning.imitation_recipes import IMITATION
from tutorial_lib.learning.networks import ENCODERS, Architecture, LocalNetwork
from tutorial_lib.learning.reinforcement_training import REINFORCEMENT
from tutorial_lib.learning.training import Settings
from tutorial_lib.learning.weights import (
    FOLDER,
    KINDS,
    Card,
    load_card,
    load_network,
    save_network,
)
from tutorial_lib.reading.checksums import with_checksum, without_checksum
from tutorial_lib.world.sensors import Camera, PanoramicCamera

torch.set_num_threads(1)  # so small are they here that two threads are slower
MEGABYTE = 1_000_000
SHIPPED = sorted(file.stem for file in FOLDER.glob("*.safetensors"))
AGAIN = r"python -m tutorial_lib train waypoint --k 9"


def make(architecture=Architecture(1, "pair"), seed=0):  # noqa: B008 - it is frozen
    torch.manual_seed(seed)
    return LocalNetwork(architecture).eval()


def card_for(network, name="some"):
    return Card(
        name,
        "train waypoint --k 9",
        network.architecture,
        {"steps": 3, "rate": 0.1},
        {"validation": 0.5},
        minutes=1.5,
    )


def outputs_of(network):
    """What a network answers about random pictures."""
    torch.manual_seed(1)
    size = network.architecture.looks_at.size
    with torch.inference_mode():
        return network(torch.rand(4, *size), torch.rand(4, network.architecture.images, *size))


def damaged(folder, change, **edits):
    """Change the bytes of the weights, and edit their card; a hash of None is reckoned anew."""
    path = folder / "some.safetensors"
    path.write_bytes(change(path.read_bytes()))
    if "sha256" in edits and edits["sha256"] is None:
        edits["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    card = path.with_suffix(".json")
    content = json.loads(card.read_text()) | edits
    del content["checksum"]
    card.write_text(json.dumps(with_checksum(content)))


@pytest.fixture
def folder(tmp_path):
    """A folder with the weights and the card of a network, as `some`."""
    network = make()
    save_network(network, card_for(network), tmp_path)
    return tmp_path


@pytest.mark.parametrize("encoder", ENCODERS)
def test_what_is_saved_is_loaded(tmp_path, encoder):
    network = make(Architecture(2, encoder))
    path = save_network(network, card_for(network), tmp_path)
    assert path == tmp_path / "some.safetensors"
    loaded = load_network("some", tmp_path)
    assert not loaded.training
    assert loaded.architecture == network.architecture
    for name, value in network.state_dict().items():
        assert torch.equal(loaded.state_dict()[name], value.half().float()), name
    assert {value.dtype for value in loaded.state_dict().values()} == {torch.float32}
    torch.testing.assert_close(outputs_of(loaded), outputs_of(network), rtol=0.01, atol=0.002)
    assert (
        outputs_of(loaded) - outputs_of(make(Architecture(2, encoder), seed=5))
    ).abs().max() > 0.02


def said(camera):
    return {name: pytest.approx(value, abs=1e-6) for name, value in asdict(camera).items()}


def test_the_card_is_kept_and_tells_size_and_hash(folder):
    card, network = load_card("some", folder), make()
    content = (folder / "some.safetensors").read_bytes()
    parameters = sum(value.numel() for value in network.parameters())
    digest = hashlib.sha256(content).hexdigest()
    assert card == replace(
        card_for(network), parameters=parameters, sha256=digest, camera=said(Camera())
    )
    assert 2 * parameters < len(content) < 2 * parameters + 10_000


def test_every_card_has_the_camera(folder):
    for file in FOLDER.glob("*.json"):
        card = load_card(file.stem)
        explores = "rgb" in card.name and card.name != "relative_rgb"
        camera = PanoramicCamera() if "nts" in card.name or explores else Camera()
        assert card.camera == ({} if "laser" in card.name else said(camera)), card.name


def test_weights_that_learned_with_another_camera_are_refused(folder):
    path = folder / "some.json"
    card = without_checksum(json.loads(path.read_text()))
    card["camera"]["field_of_view"] = 1.5
    path.write_text(json.dumps(with_checksum(card)))
    with pytest.raises(InputError, match=r"learned with the camera .*'field_of_view': 1\.5"):
        load_network("some", folder)


def test_saving_changes_neither_the_network_nor_the_bytes(folder, tmp_path):
    network, before = make(), (folder / "some.safetensors").read_bytes()
    answers = outputs_of(network)
    save_network(network, card_for(network), folder)
    assert (folder / "some.safetensors").read_bytes() == before
    assert torch.equal(outputs_of(network), answers)
    assert {value.dtype for value in network.parameters()} == {torch.float32}
    assert sorted(file.name for file in tmp_path.iterdir()) == ["some.json", "some.safetensors"]


def test_a_missing_folder_is_made(tmp_path):
    network = make()
    save_network(network, card_for(network), tmp_path / "new" / "weights")
    assert load_network("some", tmp_path / "new" / "weights").architecture == network.architecture


def test_a_save_that_fails_leaves_the_old_weights(folder, monkeypatch):
    def full(path, data):
        with path.open("wb") as file:
            file.write(data[: len(data) // 2])
        raise OSError(errno.ENOSPC, "no space left")

    before = outputs_of(load_network("some", folder))
    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"some\.safetensors, .*some\.json: cannot .*no space"):
        save_network(make(seed=5), card_for(make()), folder)
    assert len(list(folder.iterdir())) == 2
    assert torch.equal(outputs_of(load_network("some", folder)), before)


@pytest.mark.parametrize("choice", recipes.WAYPOINT)
def test_every_network_that_is_shipped_is_small_enough(tmp_path, choice):
    recipe = recipes.WAYPOINT[choice]
    network = make(recipe.architecture)
    path = save_network(network, card_for(network, recipe.name), tmp_path)
    assert path.stat().st_size <= MEGABYTE
    assert recipe.command == f"train waypoint --k {choice}"


def test_every_recipe_has_a_name_and_an_architecture_of_its_own():
    names = [recipe.name for recipe in recipes.WAYPOINT.values()]
    assert len(set(names)) == len({r.architecture for r in recipes.WAYPOINT.values()}) == len(names)


# What may be wrong with the file: the change of its bytes, and of its card.
def edited(change):
    """Bytes of weights of which the dictionary was changed."""

    def bytes_of(content, path):
        path.write_bytes(content)
        values = load_file(path)
        change(values)
        save_file(values, path)
        return path.read_bytes()

    return bytes_of


def refused(folder, words):
    """Loading fails in one line that names the file and the command that trains it again."""
    with pytest.raises(InputError, match=rf"some\.safetensors.*{words}.*{AGAIN}") as caught:
        load_network("some", folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("place", [0, 7, 40, 5000, -1])
def test_a_flipped_byte_is_named(folder, place):
    def flip(content):
        changed = bytearray(content)
        changed[place] ^= 0x10
        return bytes(changed)

    damaged(folder, flip)
    refused(folder, "SHA-256 differs")


@pytest.mark.parametrize("size", [0, 1, 7, 100, 5000, -1000, -1])
def test_a_truncated_file_is_named_even_if_the_card_agrees(folder, size):
    damaged(folder, lambda content: content[:size])
    refused(folder, "SHA-256 differs")
    damaged(folder, lambda content: content, sha256=None)
    refused(folder, "does not fit")


@pytest.mark.parametrize(
    "other",
    [
        {"k": 2},
        {"k": 0},
        {"encoder": "matching"},
        {"view": "camera64"},
        {"view": "laser"},
        {"outputs": "action"},
    ],
)
def test_weights_of_another_architecture_are_refused(folder, other):
    architecture = json.loads((folder / "some.json").read_text())["architecture"] | other
    damaged(folder, lambda content: content, architecture=architecture)
    refused(folder, "does not fit")


def entry(value):
    """Weights in which one tensor is another."""
    return lambda values: values.update({"heads.bias": value(values["heads.bias"])})


def of_zeros(value, kind):
    return torch.zeros(value.shape, dtype=kind)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda values: values.pop("heads.bias"), "tensor heads.bias: missing"),
        (lambda values: values.update(more=torch.zeros(3)), "tensor more: not known"),
        (entry(lambda _: torch.zeros(7)), r"tensor heads.bias: shape \(7,\) instead of"),
        (entry(lambda value: value[None]), "tensor heads.bias: shape"),
        (lambda values: values.clear(), "missing"),
        (entry(lambda value: value * np.nan), "tensor heads.bias: holds what is no finite number"),
        (entry(lambda value: value - np.inf), "tensor heads.bias: holds what is no finite number"),
        *(
            (entry(partial(of_zeros, kind=kind)), f"tensor heads.bias: of {name}, not one of")
            for kind, name in (
                *((torch.int8, "I8"), (torch.int64, "I64"), (torch.bool, "BOOL")),
                *((torch.complex64, "C64"), (torch.bfloat16, "BF16")),
                *((torch.float8_e4m3fn, "F8_E4M3"), (torch.uint8, "U8")),
            )
        ),
    ],
)
def test_weights_that_are_not_all_there_or_no_numbers_are_refused(folder, change, words):
    path = folder / "some.safetensors"
    content = edited(change)(path.read_bytes(), path)
    damaged(folder, lambda _: content, sha256=None)
    refused(folder, f"does not fit .*{words}")


@pytest.mark.parametrize("kind", ["F4", "F6_E2M3", "F6_E3M2", "F8_E8M0", "F128"])
def test_kinds_that_torch_does_not_know_are_refused(folder, kind):
    content = (folder / "some.safetensors").read_bytes()
    length = int.from_bytes(content[:8], "little")
    head = json.loads(content[8 : 8 + length])
    head["heads.bias"]["dtype"] = kind
    said = json.dumps(head).encode()
    said += b" " * (-len(said) % 8)
    again = len(said).to_bytes(8, "little") + said + content[8 + length :]
    damaged(folder, lambda _: again, sha256=None)
    refused(folder, "does not fit")


@pytest.mark.parametrize("kind", [torch.float32, torch.float64])
def test_weights_may_have_more_digits(folder, kind):
    before, path = outputs_of(load_network("some", folder)), folder / "some.safetensors"
    change = edited(lambda values: values.update({k: v.to(kind) for k, v in values.items()}))
    content = change(path.read_bytes(), path)
    damaged(folder, lambda _: content, sha256=None)
    assert torch.equal(outputs_of(load_network("some", folder)), before)


@pytest.mark.parametrize("other", [-1, 0, 10**9])
def test_a_card_that_counts_other_parameters_is_refused(folder, other):
    damaged(folder, lambda content: content, parameters=other)
    refused(folder, rf"parameters, of which its card says {other}")


def test_what_is_no_safetensors_file_is_refused(folder):
    for content in (b"", b"hello", b"\xff" * 5000, b'{"a": 1}' * 10):
        damaged(folder, lambda _, content=content: content, sha256=None)
        refused(folder, "does not fit")


def test_missing_weights_are_named(folder):
    (folder / "some.safetensors").unlink()
    refused(folder, "no such file")


def test_a_missing_card_is_named_with_those_that_are_there(folder):
    with pytest.raises(InputError, match=r"other\.json.* some;.*python -m tutorial_lib train"):
        load_network("other", folder)
    (folder / "some.json").unlink()
    with pytest.raises(InputError, match=r"some\.json.* none;.*python -m tutorial_lib train"):
        load_network("some", folder)


DAMAGED = {
    "empty": lambda text: "",
    "cut": lambda text: text[: len(text) // 2],
    "list": lambda text: "[1, 2]",
    "null": lambda text: "null",
    "number": lambda text: "3",
    "no_architecture": lambda text: text.replace('"architecture"', '"building"'),
    "no_command": lambda text: text.replace('"command"', '"order"'),
    "no_encoder": lambda text: text.replace('"pair"', '"pear"'),
    "k_word": lambda text: text.replace('"k": 1', '"k": "one"'),
    "k_half": lambda text: text.replace('"k": 1', '"k": 1.5'),
    "k_large": lambda text: text.replace('"k": 1', '"k": 1000000'),
    "k_none": lambda text: text.replace('"k": 1', '"k": null'),
    "more": lambda text: text.replace('"name"', '"more": 1, "name"'),
    "view_list": lambda text: text.replace('"camera16"', '["camera16"]'),
}


@pytest.mark.parametrize("fault", DAMAGED)
def test_a_damaged_card_is_named(folder, fault):
    path = folder / "some.json"
    changed = DAMAGED[fault](path.read_text())
    assert changed != path.read_text()
    path.write_text(changed)
    words = r"some\.json: .*not a card of weights.*python -m tutorial_lib train"
    with pytest.raises(InputError, match=words):
        load_network("some", folder)


def test_a_card_that_is_no_text_is_named(folder):
    (folder / "some.json").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InputError, match=r"some\.json: cannot be read .*tutorial_lib train"):
        load_card("some", folder)


# What is shipped.


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_weights_fit_their_cards(name):
    card = load_card(name)
    wanted = dict(KINDS.values())[type(card.architecture)]
    network = load_network(name, wanted=wanted)
    path = FOLDER / f"{name}.safetensors"
    assert path.stat().st_size <= MEGABYTE
    assert card.name == name
    assert card.parameters == sum(value.numel() for value in network.parameters())
    assert card.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert all(value.isfinite().all() for value in network.parameters())
    assert np.isfinite(card.validation["validation"])
    assert cli.parse(card.command.split()).command == "train"
    if wanted is LocalNetwork:
        assert outputs_of(network).isfinite().all()
    else:
        with pytest.raises(InputError, match="where a LocalNetwork is needed"):
            load_network(name)


ONE_BUSY_CORE = pytest.mark.xfail(strict=True, reason="trained on one busy core, not two idle ones")
ON_ONE_BUSY_CORE = ("waypoint_k5", "reach_k2", "reach_k5", "relative_rgb")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=ONE_BUSY_CORE) if name in ON_ONE_BUSY_CORE else name
        for name in SHIPPED
    ],
)
def test_shipped_weights_were_trained_within_half_an_hour(name):
    assert 0 < load_card(name).minutes <= 30


@pytest.mark.parametrize(
    "recipe",
    [
        *recipes.WAYPOINT.values(),
        *NTS.values(),
        *(*IMITATION.values(), *GOAL_MAPS.values(), *REINFORCEMENT.values()),
    ],
    ids=lambda recipe: recipe.name,
)
def test_shipped_weights_are_those_of_their_recipe(recipe):
    if recipe.name not in SHIPPED:
        pytest.skip("is not shipped")
    card = load_card(recipe.name)
    assert card.architecture == recipe.architecture
    assert card.command == recipe.command


def test_all_weights_have_cards_and_are_small_together():
    assert [file.stem for file in sorted(FOLDER.glob("*.json"))] == SHIPPED
    assert sum(file.stat().st_size for file in FOLDER.glob("*")) <= 25 * MEGABYTE


# The command.


@pytest.mark.parametrize("arguments", [["--k", "7"], ["--k", "two"], []])
def test_only_what_has_a_recipe_is_trained(capsys, arguments):
    with pytest.raises(SystemExit) as stopped:
        cli.main(["train", "waypoint", *arguments])
    assert stopped.value.code == 2
    error = capsys.readouterr().err
    assert "--k" in error
    if arguments:
        choices = re.search(r"choose from (.*)\)", error)[1]
        assert re.findall(r"\w+", choices) == [
            "0",
            "2",
            "5",
            "direct",
            "laser",
            "sptm",
            "ving",
            "rgb",
        ]


def test_another_network_s_name_is_refused(capsys):
    with pytest.raises(SystemExit) as stopped:
        cli.main(["train", "wisdom", "--k", "2"])
    assert stopped.value.code == 2
    assert "waypoint" in capsys.readouterr().err


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """The command trains a tiny network, and all files are in a folder of the test's."""
    recipe = recipes.Recipe(
        "tiny",
        "train waypoint --k 0",
        Architecture(0, "pair", outputs="action"),
        Settings(max_steps=4, targets=2, eval_interval=2),
        worlds=1,
        validation_worlds=1,
        cars=2,
    )
    monkeypatch.setitem(recipes.WAYPOINT, "0", recipe)
    monkeypatch.setattr(recipes, "Source", partial(Source, worlds=2, targets=4))
    monkeypatch.setattr(recipes, "WORK", tmp_path / "work")
    monkeypatch.setattr(train_command, "PROJECT", tmp_path)
    folder = tmp_path / "weights"
    monkeypatch.setattr(train_command, "save_network", lambda *both: save_network(*both, folder))
    monkeypatch.chdir(tmp_path)
    return recipe


@pytest.mark.full
def test_the_command_trains_saves_and_goes_on_where_it_was_stopped(tiny, tmp_path, capsys):
    with joblib.parallel_config(backend="threading"):
        assert cli.main(["train", "waypoint", "--k", "0"]) == 0
        assert "tiny.safetensors" in capsys.readouterr().out
        path = tmp_path / "weights" / "tiny.safetensors"
        before = path.read_bytes()
        card = load_card("tiny", path.parent)
        assert card.recipe["max_steps"] == 4
        assert card.recipe["worlds"] == 1
        assert card.validation["step"] in (2, 4)
        assert load_network("tiny", path.parent).architecture == tiny.architecture
        path.unlink()
        assert cli.main(["train", "waypoint", "--k", "0"]) == 0
        assert path.read_bytes() == before
