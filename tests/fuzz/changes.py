"""How a file is altered: its bytes, what its text says, its arrays, what it is at all."""

import hashlib
import io
import json
import os
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.fuzz import corpus
from tutorial_lib.reading.checksums import CHECKSUM, sealed, unsealed, with_checksum

Rng = np.random.Generator
BYTES = "bytes"
"""Of a change after which a sealed file may not load as anything but what was saved."""
MEANT = "meant"
"""Of one that puts the file's checksums right again, as somebody could who means it."""


def _span(data: bytes, rng: Rng) -> tuple[int, int]:
    first = int(rng.integers(len(data) + 1))
    return first, min(len(data), first + int(rng.geometric(0.1)))


def flip(data: bytes, rng: Rng) -> bytes:
    """Let one bit fall over."""
    changed = bytearray(data)
    changed[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def scatter(data: bytes, rng: Rng) -> bytes:
    """Set some bytes to anything."""
    changed = np.frombuffer(data, np.uint8).copy()
    places = rng.integers(len(changed), size=int(rng.integers(1, 9)))
    changed[places] = rng.integers(256, size=len(places))
    return changed.tobytes()


def cut(data: bytes, rng: Rng) -> bytes:
    """Cut the end off."""
    return data[: int(rng.integers(len(data)))]


def remove(data: bytes, rng: Rng) -> bytes:
    """Take a part out."""
    first, last = _span(data, rng)
    return data[:first] + data[last:]


def repeat(data: bytes, rng: Rng) -> bytes:
    """Say a part several times."""
    first, last = _span(data, rng)
    return data[:first] + data[first:last] * int(rng.integers(2, 200)) + data[last:]


def insert(data: bytes, rng: Rng) -> bytes:
    """Put something in between."""
    at = int(rng.integers(len(data) + 1))
    return data[:at] + _any_of(corpus.SNIPPETS, rng) + data[at:]


def blank(data: bytes, rng: Rng) -> bytes:
    """Overwrite a part with zeros."""
    first, last = _span(data, rng)
    return data[:first] + bytes(last - first) + data[last:]


def swap(data: bytes, rng: Rng) -> bytes:
    """Exchange two parts."""
    a, b, c = sorted(int(place) for place in rng.integers(len(data) + 1, size=3))
    return data[:a] + data[b:c] + data[a:b] + data[c:]


def enlarge(data: bytes, rng: Rng) -> bytes:
    """Write a number where a size may stand."""
    form = str(rng.choice(["<I", ">I", "<H", ">H", "<Q", ">Q"]))
    number = int(_any_of([0, 1, 2**15, 2**16 - 1, 2**31 - 1, 2**32 - 1, 2**63 - 1, 30_000], rng))
    packed = struct.pack(form, number % 2 ** (8 * struct.calcsize(form)))
    at = int(rng.integers(max(len(data) - len(packed), 0) + 1))
    return data[:at] + packed + data[at + len(packed) :]


def reword(data: bytes, rng: Rng) -> bytes:
    """Put something else for a word or a number of a text."""
    words = list(corpus.WORD.finditer(data))
    if not words:
        return flip(data, rng)
    word = words[int(rng.integers(len(words)))]
    return data[: word.start()] + _any_of(corpus.SNIPPETS, rng) + data[word.end() :]


def replace_whole(data: bytes, rng: Rng) -> bytes:
    """Something else altogether."""
    return _any_of(corpus.WHOLE, rng)


RAW: tuple[Callable[[bytes, Rng], bytes], ...] = (
    *(flip,) * 4,
    *(scatter, cut, remove, repeat, insert, blank, swap, enlarge, enlarge, reword, reword),
    replace_whole,
)


def alter_json(path: Path, rng: Rng, value: Any = None) -> str:
    """Put another value, a random one unless given, somewhere into a JSON document."""
    content = json.loads(path.read_bytes())
    known = isinstance(content, dict) and CHECKSUM in content
    parent, key = _place_in(content, rng)
    value = _any_of(corpus.VALUES, rng) if value is None else value
    change = int(rng.integers(5))
    if parent is None:
        content = value
    elif change == 0:
        del parent[key]
    elif change == 1 and isinstance(parent, list):
        parent.insert(key, parent[key])
    elif change == 1:
        parent[str(value)[:40]] = parent.pop(key)
    else:
        parent[key] = value
    meant = known and isinstance(content, dict) and rng.random() < 0.7
    if meant:
        content.pop(CHECKSUM, None)
        content = with_checksum(content)
    path.write_text(json.dumps(content), encoding="utf-8", errors="surrogatepass")
    return MEANT if meant or not known else BYTES


def _place_in(content: Any, rng: Rng) -> tuple[Any, Any]:
    """A container within a document, and a key in it; None for the document itself."""
    parent, key = None, None
    while isinstance(content, dict | list) and content and (parent is None or rng.random() < 0.7):
        keys = list(content) if isinstance(content, dict) else range(len(content))
        parent, key = content, keys[int(rng.integers(len(keys)))]
        content = parent[key]
    return (None, None) if rng.random() < 0.02 else (parent, key)


def alter_arrays(path: Path, rng: Rng, array: Any = None) -> str:
    """Put another array, or none, into an `.npz` file, whose own checksums are then right."""
    with np.load(path) as file:
        arrays = dict(file)
    name = str(rng.choice(list(arrays)))
    changed = corpus.altered(arrays[name], rng) if array is None else array
    if changed is None:
        del arrays[name]
    else:
        arrays[name] = changed
    _tell_the_digest(arrays)
    write = np.savez_compressed if rng.random() < 0.5 else np.savez
    with path.open("wb") as out:
        write(out, **arrays)
    return MEANT


def _tell_the_digest(arrays: dict[str, Any]) -> None:
    """Let a map's digest be that of its altered arrays."""
    from tutorial_lib.topology.mapping import storage

    if {"graph", "digest"} <= arrays.keys():
        said = {name: array for name, array in arrays.items() if name not in ("version", "digest")}
        arrays["digest"] = storage._digest(said)


def alter_sealed(path: Path, rng: Rng) -> str:
    """Alter what is behind a seal, and seal it again."""
    change = RAW[int(rng.integers(len(RAW)))]
    path.write_bytes(sealed(change(unsealed(path.read_bytes()), rng)))
    return MEANT


def alter_weights(path: Path, rng: Rng) -> str:
    """Put another tensor, or none, or one of another kind, into weights whose card agrees."""
    from safetensors.numpy import load_file, save

    if rng.random() < 0.5:
        tensors = load_file(path)
        name = str(rng.choice(list(tensors)))
        changed = corpus.altered(tensors[name], rng)
        if changed is None or changed.dtype.kind not in "biufc" or changed.dtype == ">f8":
            del tensors[name]
        else:
            tensors[name] = np.ascontiguousarray(changed)
        data = save(tensors)
    else:
        kinds = [b"F4", b"F6_E2M3", b"F8_E4M3", b"F8_E8M0", b"BF16", b"F32", b"I64", b"C64", b"U16"]
        data = path.read_bytes()
        places = [found.start() for found in re.finditer(rb'"F16"', data)]
        at = int(rng.choice(places))
        data = data[:at] + b'"%s"' % _any_of(kinds, rng) + data[at + 5 :]
        length = int.from_bytes(data[:8], "little") + len(data) - path.stat().st_size
        data = length.to_bytes(8, "little") + data[8:]
    path.write_bytes(data)
    card = path.with_suffix(".json")
    content = json.loads(card.read_bytes()) | {"sha256": hashlib.sha256(data).hexdigest()}
    content.pop(CHECKSUM, None)
    card.write_text(json.dumps(with_checksum(content)))
    return MEANT


def alter_state(path: Path, rng: Rng) -> str:
    """Put something else somewhere into the state of a training, and seal it again."""
    import torch

    state = torch.load(io.BytesIO(unsealed(path.read_bytes())), weights_only=True)
    parent, key = _place_in(state, rng)
    if parent is None:
        state = _any_of(corpus.VALUES, rng)
    elif isinstance(parent[key], torch.Tensor) and rng.random() < 0.8:
        changed = corpus.altered(parent[key].numpy(), rng)
        if changed is None or changed.dtype.kind not in "biufc" or changed.dtype == ">f8":
            del parent[key]
        else:
            parent[key] = torch.from_numpy(np.ascontiguousarray(changed))
    elif rng.random() < 0.2:
        del parent[key]
    else:
        parent[key] = _any_of(corpus.VALUES, rng)
    buffer = io.BytesIO()
    torch.save(state, buffer)
    path.write_bytes(sealed(buffer.getvalue()))
    return MEANT


def make_special(path: Path, rng: Rng) -> str:
    """Put something that is no file, or a huge one, in the file's place."""
    path.unlink()
    kind = int(rng.integers(8))
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.symlink_to("/dev/zero")
    elif kind == 2:
        path.symlink_to("/dev/tty")
    elif kind == 3:
        path.mkdir()
    elif kind == 4:
        path.symlink_to(path.name)  # a circle
    elif kind == 5:
        pipe = path.with_name("pipe")
        os.mkfifo(pipe)
        path.symlink_to(pipe)
    elif kind == 6:
        path.touch()
        os.truncate(path, 200_000_000_000)  # none of which is on the disk
    return BYTES  # 7: missing


def alter(path: Path, rng: Rng) -> tuple[str, str]:
    """Alter a file somehow: the name of the change, and of its kind."""
    dice = rng.random()
    if dice < 0.03:
        return "special", make_special(path, rng)
    if dice < 0.4 and path.suffix in (".json", ".ipynb"):
        return "json", alter_json(path, rng)
    if dice < 0.4 and path.suffix == ".npz":
        return "arrays", alter_arrays(path, rng)
    if dice < 0.15 and path.suffix == ".pt":
        return "sealed", alter_sealed(path, rng)
    if dice < 0.6 and path.suffix == ".pt":
        return "state", alter_state(path, rng)
    if dice < 0.5 and path.suffix == ".safetensors":
        return "weights", alter_weights(path, rng)
    change = RAW[int(rng.integers(len(RAW)))]
    path.write_bytes(change(path.read_bytes(), rng))
    # What replaces a whole file may be whole itself, with checksums of its own.
    return change.__name__, MEANT if change is replace_whole else BYTES


def _any_of(choices: Any, rng: Rng) -> Any:
    found = choices[int(rng.integers(len(choices)))]
    return found() if callable(found) else found
