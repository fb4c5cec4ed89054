"""What did harm once, or could: values, pieces of text, whole files, arrays."""

import io
import re
import struct
import zipfile
import zlib
from functools import cache
from typing import Any

import numpy as np

WORD = re.compile(rb"-?[0-9][0-9.eE+-]*|[A-Za-z_]+")

VALUES: list[Any] = [
    *(None, True, False, 0, 1, -1, -5, 2, 7, 0.5, -0.0, 1e-300, 1e300, -1e300, 2**31, 2**64),
    *(10**400, 480.0, 1e7, 99_999, float("nan"), float("inf"), -float("inf")),
    *("", "a", "0", "1e5", "nan", "../up.npz", "/etc/passwd", "a\0b", "\ud800", "\x1b[2J", "é"),
    *([], {}, [[]], [1, 2], [0, 1, 2, 3], [[0, 1, 0.5, 0]], ["a"], [None], {"a": 1}),
    *("x" * 100_000, [0.0] * 1000, [[0, 1]] * 1000, [[1e300, 1e300], [-1e300, 0], [0, 1e300]]),
    *([[0, 0], [480, 0], [480, 480], [0, 480]], {"from": [0, 0], "to": [480, 0]}),
    lambda: nested(20),
    lambda: nested(90),
]
"""Of a JSON document."""


def nested(depth: int) -> Any:
    """A list in a list in a list …"""
    found: Any = []
    for _ in range(depth):
        found = [found]
    return found


SNIPPETS: list[bytes] = [
    *(b"", b" ", b"\n", b"\0", b"\xff", b"\xef\xbb\xbf", b'"', b"'", b"\\", b",", b":", b"{", b"}"),
    *(b"[", b"]", b"- ", b"? ", b"| ", b"%", b"@", b"#", b"`", b"\t", b"0", b"-1", b"1e999"),
    *(b"NaN", b"Infinity", b"-Infinity", b".inf", b".nan", b"null", b"true", b"~", b"1e300"),
    *(b"480", b"9" * 5_000, b"0x" + b"f" * 9_000, b"1:" * 4_000 + b"1.5", b"0b" + b"1" * 9_000),
    *(b"2001-99-99", b"2001-12-14t21:59:43.10-05:00", b"!!bool maybe", b"!!int x", b"!!binary a"),
    *(b"!!python/object/apply:os.system ['true']", b"!!timestamp 5", b"!!set {a}", b"&a [*a, *a]"),
    *(b"&a", b"*a", b"<<: {a: 1}", b"!<tag:yaml.org,2002:bool> x", b"? [a]\n: b\n", b"\\ud800"),
    *(b"[" * 2_000, b"{" * 2_000, b'{"a":' * 2_000, b"- " * 2_000, b'"\\' * 2_000, b"[" * 60_000),
    *(b"99999 99999", b"2147483647", b"20000 20000", b"a" * 20_000, b"IEND", b"PK\x05\x06"),
]
"""Pieces to be put into a file."""


def _aliases() -> bytes:
    """A YAML document that means a billion values."""
    lines = [b"a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [b"a%d: &a%d [%s]" % (n, n, b", ".join([b"*a%d" % (n - 1)] * 9)) for n in range(1, 10)]
    return b"\n".join(lines)


def _merges() -> bytes:
    lines = [b"a0: &a0 {k0: 1}"]
    lines += [
        b"a%d: &a%d {<<: [%s], k%d: 1}" % (n, n, b", ".join([b"*a%d" % (n - 1)] * 9), n)
        for n in range(1, 10)
    ]
    return b"\n".join(lines)


def png(
    width: int, height: int, body: bytes = b"", kind: int = 0, named: bytes = b"", depth: int = 8
) -> bytes:
    """A PNG whose header says anything at all; `named` is what it says to be transparent."""
    data = b"\x89PNG\r\n\x1a\n"
    head = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    clear = [(b"tRNS", named)] if named else []
    chunks = [(b"IHDR", head), *clear, (b"IDAT", zlib.compress(body, 1)), (b"IEND", b"")]
    for name, content in chunks:
        checksum = struct.pack(">I", zlib.crc32(name + content))
        data += struct.pack(">I", len(content)) + name + content + checksum
    return data


def _bmp(width: int, height: int) -> bytes:
    data = struct.pack("<2sIHHI", b"BM", 64, 0, 0, 54)
    data += struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, 0, 1, 1, 0, 0)
    return data + bytes(99)


@cache
def zip_bomb(megabytes: int = 600, members: int = 1, honest: bool = True) -> bytes:
    """An `.npz` file of some kilobytes whose arrays have so many megabytes of zeros."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for number in range(members):
            head = io.BytesIO()
            count = megabytes * 125_000 if honest else 10**15
            form = {"descr": "<f8", "fortran_order": False, "shape": (count,)}
            np.lib.format.write_array_header_2_0(head, form)
            with archive.open(f"poses{number or ''}.npy", "w", force_zip64=True) as member:
                member.write(head.getvalue())
                for _ in range(megabytes if honest else 1):
                    member.write(bytes(1_000_000))
    return out.getvalue()


def _many_members() -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for number in range(3_000):
            archive.writestr(f"{number}.npy", b"")
    return out.getvalue()


def _millions_of_trajectories() -> bytes:
    """Trajectories of one frame each."""
    count, out = 300_000, io.BytesIO()
    rows = {name: np.zeros((count, 3)) for name in ("poses", "odometry")}
    rows |= {name: np.zeros(count) for name in ("speed", "steering", "timestamps")}
    rows |= {"laser": np.zeros((count, 1), np.float32), "actions": np.zeros((count, 2))}
    names = {"world": np.full(count, "a"), "seed": np.zeros(count, int)}
    offsets = {"offsets": np.arange(count + 1), "version": np.array(1)}
    np.savez_compressed(out, **rows, **names, **offsets)
    return out.getvalue()


def _checkerboard(side: int, square: int) -> bytes:
    """A PGM of free and occupied squares."""
    row = np.arange(side) // square % 2
    return b"P5\n%d %d\n255\n" % (side, side) + ((row[:, None] ^ row) * 254).astype("u1").tobytes()


def _comb(side: int) -> bytes:
    """A PGM of one free region with an outline as long as can be."""
    cells = np.zeros((side, side), np.uint8)
    cells[:, ::12] = cells[:, 1::12] = cells[:, 2::12] = cells[:6] = 254
    return b"P5\n%d %d\n255\n" % (side, side) + cells.tobytes()


def _round_house(corners: int) -> bytes:
    angle = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    points = np.round(np.stack([20 * np.cos(angle), 20 * np.sin(angle)], axis=1), 6).tolist()
    boxes = [[-20, -20, 20, 20]] * (corners // 5)
    return repr({"verts": points, "room_category": {"Hall": boxes}}).replace("'", '"').encode()


_ANY: tuple[Any, ...] = (
    *(b"", b"\0", b"hello", bytes(range(256)) * 40, b"PK\x05\x06" + bytes(18)),
    lambda: b"a" * 5_000_000,
)
BY_SUFFIX: dict[str, tuple[Any, ...]] = {
    ".json": (
        *(*_ANY, b"null", b"[]", b"{}", b"7", b'"text"', b"NaN", b"[[],", b"\xff\xfe\0{"),
        *(b"[" * 200_000, b'{"a":' * 200_000, b"[" * 60_000, b'"' + b'\\"' * 200_000),
        b"\xef\xbb\xbf{}",
        lambda: b"[" + b"[]," * 100_000 + b"[]]",
        lambda: b"[0" + b",0" * 10_000_000 + b"]",
        lambda: _round_house(800),
        lambda: _round_house(20_000),
    ),
    ".yaml": (*_ANY, b"a: " * 20_000, b"[" * 60_000, b"- " * 30_000, _aliases, _merges),
    ".png": (
        *_ANY,
        lambda: png(20_000, 20_000),
        lambda: png(2**31 - 1, 2**31 - 1),
        lambda: png(65_000, 65_000, bytes(1_000_000), 6),
        lambda: png(4_096, 4_096, bytes(4_096 * 4_097)),
    ),
    ".bmp": (*_ANY, b"BM" + bytes(60), lambda: _bmp(30_000, 30_000), lambda: _bmp(-1, -(2**31))),
    ".pgm": (
        *(*_ANY, b"P5\n0 0\n255\n", b"P2 1 1 1", b"P5 20000 20000 255\n", b"P2 4000 4000 255 1 2"),
        b"P5 100000 100000 65535\n" + bytes(99),
        lambda: _checkerboard(2_000, 1),
        lambda: _checkerboard(2_000, 12),
        lambda: _checkerboard(600, 20),
        lambda: _comb(4_096),
        lambda: _comb(500),
    ),
    ".npz": (
        *(*_ANY, b"\x93NUMPY\x01\0", b"\x80\x04K*."),
        zip_bomb,
        lambda: zip_bomb(1, 5, honest=False),
        lambda: zip_bomb(1, 1, honest=False),
        _many_members,
        _millions_of_trajectories,
    ),
    ".pt": (*_ANY, b"sha256 ", b"\x80\x04K*."),
    ".safetensors": _ANY,
    ".ipynb": (*_ANY, b"[" * 200_000),
}
"""What to put in place of a file, by what its name ends in."""
WHOLE = [item for items in BY_SUFFIX.values() for item in items]
"""Files to be put in place of another."""


def altered(array: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    """Another array in the place of one; None for none."""
    kinds = ["f2", "f4", "f8", "i1", "i4", "i8", "u8", "?", "c16", "U3", "U0", "M8[s]", "V4", ">f8"]
    values = [0, -1, 1, 5, np.nan, np.inf, 1e300, -1e9, 0.5, 2**40]
    choice = int(rng.integers(9))
    if choice == 0:
        return None
    if choice == 1:
        with np.errstate(all="ignore"):
            try:
                return array.astype(str(rng.choice(kinds)))
            except (TypeError, ValueError):
                return np.zeros(array.shape, "M8[s]")
    if choice == 2:
        return array[: int(rng.integers(len(array) + 1))] if array.ndim else array[None]
    if choice == 3:
        return np.concatenate([array, array]) if array.ndim else np.array([array] * 2)
    if choice == 4:
        return array[..., None] if rng.random() < 0.5 else array.reshape(-1)
    if choice == 5:
        return np.empty((0, *array.shape[1:]), array.dtype)
    if choice == 6:
        return np.asfortranarray(np.flip(array))
    changed = array.copy()
    with np.errstate(all="ignore"):
        value = np.array(values[int(rng.integers(len(values)))]).astype(changed.dtype)
    if choice == 7 or not changed.size:
        changed[...] = value
    else:
        changed.reshape(-1)[int(rng.integers(changed.size))] = value
    return changed
