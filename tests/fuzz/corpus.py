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
    *(
        b"010",
        b"0o17",
        b"0_1",
        b"1e-1_0",
        b"1:30",
        b"0b11",
        b"-0x1",
        b".5",
        b"no",
        b"\xc3\xb4",
        b"\\",
    ),
    *(b"~/map.png", b"/nowhere/map.png", b"C:\\maps\\map.png", b"../map.png", b"raw", b"scale"),
    *(b"\nnegate: 0\n", b'"a": 1, "a": 2, ', b"tRNS", b"\xff\xd9", b"II*\0", b"P6 9 9 255\n"),
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


@cache
def method_bomb(method: int, megabytes: int = 600) -> bytes:
    """An `.npz` file of some kilobytes, compressed otherwise, that unpacks to so many megabytes."""
    out, small = io.BytesIO(), 1_000
    with zipfile.ZipFile(out, "w", method) as archive:
        archive.writestr("poses.npy", bytes(megabytes * 1_000_000))
    data = bytearray(out.getvalue())
    for mark, place in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):  # it says that it is small
        start = data.index(mark) + place
        data[start : start + 4] = struct.pack("<I", small)
    return bytes(data)


def _tiff(width: int, height: int, tile: int = 0, compression: int = 1) -> bytes:
    """A TIFF of one strip, or of tiles, whose header says anything at all."""
    body = zlib.compress(bytes(1_000_000)) if compression == 8 else bytes(64)
    place = {322: (4, tile), 323: (4, tile), 324: (4, 8), 325: (4, len(body))} if tile else {}
    place = place or {273: (4, 8), 278: (4, height), 279: (4, len(body))}
    tags = {256: (4, width), 257: (4, height), 258: (3, 8), 259: (3, compression), 262: (3, 1)}
    entries = sorted((tags | {277: (3, 1)} | place).items())
    packed = b"".join(struct.pack("<HHII", tag, kind, 1, v) for tag, (kind, v) in entries)
    head = struct.pack("<2sHI", b"II", 42, 8 + len(body))
    return head + body + struct.pack("<H", len(entries)) + packed + bytes(4)


def _jpeg(width: int, height: int, components: int = 1) -> bytes:
    """A JPEG whose header says anything at all, and nothing behind it."""
    frame = struct.pack(">BHHB", 8, height, width, components)
    frame += b"".join(bytes([i + 1, 0x44, 0]) for i in range(components))
    return b"\xff\xd8\xff\xc0" + struct.pack(">H", len(frame) + 2) + frame + b"\xff\xd9"


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
    ".jpg": (
        *(*_ANY, b"\xff\xd8\xff\xd9", b"\xff\xd8" + b"\xff\xe0\0\2" * 5_000),
        *(_jpeg(65_000, 65_000), _jpeg(4_096, 4_096, 4), _jpeg(0, 7)),
    ),
    ".tiff": (
        *(*_ANY, b"II*\0", b"MM\0*\0\0\0\x08\0\0", b"II*\0\x08\0\0\0\xff\xff"),
        *(_tiff(20_000, 20_000), _tiff(2**31, 2**31), _tiff(4_096, 4_096), _tiff(0, 3)),
        *(_tiff(4_096, 4_096, 20_000, 8), _tiff(9, 9, 2**30, 8), _tiff(4_096, 4_096, 0, 8)),
    ),
    ".ppm": (b"P6 20000 20000 255\n", b"P6 1 1 255\n\0\0", b"P3 1500 1500 255 " + b"1 " * 9_000),
    ".npz": (
        *(*_ANY, b"\x93NUMPY\x01\0", b"\x80\x04K*."),
        zip_bomb,
        lambda: method_bomb(zipfile.ZIP_BZIP2),
        lambda: method_bomb(zipfile.ZIP_LZMA),
        lambda: method_bomb(zipfile.ZIP_DEFLATED),
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
