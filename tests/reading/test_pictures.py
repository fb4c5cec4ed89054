"""Pictures: the size in the header is checked first, and a damaged one is not decoded."""

import struct

import cv2
import numpy as np
import pytest
from PIL import Image, ImageFile

from tests.fuzz.corpus import _bmp, png
from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_PIXELS, MAX_PLAIN_PIXELS
from tutorial_lib.reading.pictures import decode_picture, read_picture

GREY = np.arange(12 * 7, dtype=np.uint8).reshape(12, 7) * 3


def _of(suffix, width, height):
    """A JPEG or TIFF whose header says that it is as large."""
    data = bytearray(cv2.imencode(suffix, GREY)[1].tobytes())
    if suffix == ".jpg":
        start = data.index(b"\xff\xc0") + 5
        data[start : start + 4] = struct.pack(">HH", height, width)
        return bytes(data)
    (first,) = struct.unpack_from("<I", data, 4)
    for entry in range(struct.unpack_from("<H", data, first)[0]):
        place = first + 2 + 12 * entry
        tag = struct.unpack_from("<H", data, place)[0]
        if tag in (256, 257):  # width, height
            size = width if tag == 256 else height
            struct.pack_into("<HHII", data, place, tag, 4, 1, size)
    return bytes(data)


KINDS = [
    (suffix, shape, kind)
    for suffix in (".png", ".tiff")
    for shape in ((), (3,), (4,))
    for kind in (np.uint8, np.uint16)
    if suffix == ".png" or kind == np.uint8 or not shape  # Pillow has no others of 16 bits
]
OTHERS = [
    *((".bmp", (), np.uint8), (".bmp", (3,), np.uint8), (".pgm", (), np.uint8)),
    *((".pgm", (), np.uint16), (".ppm", (3,), np.uint8), (".ppm", (3,), np.uint16)),
]


@pytest.mark.parametrize(
    ("suffix", "shape", "kind"),
    [*KINDS, *OTHERS],
)
def test_pictures_are_read_as_they_were_saved(tmp_path, suffix, shape, kind):
    wanted = np.broadcast_to(GREY.reshape(12, 7, *[1] * len(shape)), (12, 7, *shape)).astype(kind)
    wanted = wanted + np.arange(shape[0], dtype=kind) if shape else wanted  # blue, green, red
    path = tmp_path / f"map{suffix}"
    assert cv2.imwrite(str(path), np.ascontiguousarray(wanted))
    found = read_picture(path)
    assert found.top == np.iinfo(kind).max
    assert found.values.shape[:2] == (12, 7)
    assert (found.values == wanted.reshape(12, 7, -1)).all()


@pytest.mark.parametrize(
    ("data", "top"),
    [
        (b"P5\n2 1\n255\n\x00\xff", 255),
        (b"P5 2 1 # two\n300 \x00\x00\x01\x2c", 300),
        (b"P2\n# plain\n2 1\n9\n0 # zero\n12\n", 9),
        (b"P2 2 1 9 -3 9", 9),
        (b"P5 2 1 9 \x00\x0c", 9),
        (b"P5 2 1 300 \x00\x00\x01\x90", 300),
    ],
)
def test_a_pgm_is_read_up_to_its_largest_value(data, top):
    found = decode_picture(data)
    assert found.top == top
    assert found.values.tolist() == [[[0], [top]]]


def test_a_deep_pgm_has_the_higher_byte_first():
    found = decode_picture(b"P5 3 1 1000 \x00\x05\x01\x00\x02\x03")
    assert found.values.ravel().tolist() == [5, 256, 515]


@pytest.mark.parametrize(
    "data",
    [
        png(20_000, 20_000),
        png(2**31 - 1, 2**31 - 1),
        _bmp(30_000, -30_000),
        b"P5 20000 20000 255\n",
        b"P5 999999999 999999999 65535\n",
        b"P2 4000 4000 255 1",
        b"P5 4097 4096 255 " + bytes(4_097 * 4_096),
        b"P6 20000 20000 255\n",
        b"P3 1000 1000 255 1",
        _of(".tiff", 20_000, 20_000),
        _of(".tiff", 100_000, 100_000),
        _of(".jpg", 65_000, 65_000),
        _of(".jpg", 5_000, 5_000),
    ],
)
def test_a_picture_that_is_too_large_is_refused_before_it_is_decoded(data, monkeypatch):
    monkeypatch.setattr(cv2, "imdecode", None)
    monkeypatch.setattr(ImageFile.ImageFile, "load", None)
    with pytest.raises(InputError, match=r"more than the [\d,]+ (pixels )?that are read; scale it"):
        decode_picture(data)
    assert MAX_PLAIN_PIXELS < MAX_PIXELS


@pytest.mark.parametrize(
    "data",
    [
        *(b"", b"GIF89a", b"\xff\xd8\xff\xe0", b"BM", b"\x89PNG", _bmp(4, 4)[:60], b"II*\0", b"P7"),
        png(4, 4, bytes(20), named=b"\0"),  # half of a grey
    ],
)
def test_another_kind_of_file_is_refused(data):
    with pytest.raises(InputError, match="no whole PGM, PPM, PNG, BMP, JPEG or TIFF picture"):
        decode_picture(data)


def test_a_ppm_has_red_first():
    for data in (b"P6 1 1 255 \1\2\3", b"P3 1 1 255 1 2 3"):
        assert decode_picture(data).values.tolist() == [[[3, 2, 1]]]


@pytest.mark.parametrize(
    "data", [png(0, 5), _bmp(0, 3), _bmp(-3, 3), b"P5 0 1 255 ", b"P5 1 1 0 x"]
)
def test_a_picture_of_no_size_is_refused(data):
    with pytest.raises(InputError, match=r"its .*header says"):
        decode_picture(data)


@pytest.mark.parametrize("suffix", [".jpg", ".tiff", ".ppm", ".pgm"])
def test_a_picture_that_was_cut_off_anywhere_is_refused(suffix):
    whole = cv2.imencode(suffix, np.dstack([GREY] * 3) if suffix == ".ppm" else GREY)[1].tobytes()
    assert decode_picture(whole).values.shape[:2] == GREY.shape
    needed = len(whole) - 4 * (suffix == ".tiff")  # at whose end is said that there is no other
    for size in {*range(0, needed, 7), needed - 1}:
        with pytest.raises(InputError):
            decode_picture(whole[:size])


@pytest.mark.parametrize("mode", ["1", "P", "CMYK", "LA", "RGBA"])
def test_a_tiff_of_other_pixels_is_read_as_grey_or_colour(mode, tmp_path):
    grey = np.where(GREY > 100, 255, 0).astype(np.uint8)
    Image.fromarray(grey).convert(mode).save(tmp_path / "map.tiff")
    found = read_picture(tmp_path / "map.tiff")
    colours = 1 if mode in ("1", "LA") else 3
    assert (found.values[..., :colours] == grey[..., None]).all()
    assert (found.values[..., colours:] == 255).all()


@pytest.mark.parametrize("mode", ["F", "I"])
def test_pixels_of_32_bits_are_refused(mode, tmp_path):
    Image.fromarray(GREY).convert(mode).save(tmp_path / "map.tiff")
    with pytest.raises(InputError, match=f"of the kind {mode}; save them as 8 or 16 bits"):
        read_picture(tmp_path / "map.tiff")


def test_any_bit_of_a_png_that_fell_over_is_noticed():
    whole = cv2.imencode(".png", GREY)[1].tobytes()
    wanted = decode_picture(whole).values
    for place in range(len(whole)):
        changed = bytearray(whole)
        changed[place] ^= 1 << place % 8
        with pytest.raises(InputError):
            decode_picture(bytes(changed))
    assert (decode_picture(whole + b"more").values == wanted).all()
