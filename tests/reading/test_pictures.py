"""Pictures: the size in the header is checked first, and a damaged one is not decoded."""

import cv2
import numpy as np
import pytest

from tests.fuzz.corpus import _bmp, png
from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_PIXELS, MAX_PLAIN_PIXELS
from tutorial_lib.reading.pictures import decode_picture, read_picture

GREY = np.arange(12 * 7, dtype=np.uint8).reshape(12, 7) * 3


KINDS = [(".png", shape, kind) for shape in ((), (3,), (4,)) for kind in (np.uint8, np.uint16)]


@pytest.mark.parametrize(
    ("suffix", "shape", "kind"),
    [*KINDS, (".bmp", (), np.uint8), (".bmp", (3,), np.uint8), (".pgm", (), np.uint8)],
)
def test_pictures_are_read_as_they_were_saved(tmp_path, suffix, shape, kind):
    wanted = np.broadcast_to(GREY.reshape(12, 7, *[1] * len(shape)), (12, 7, *shape)).astype(kind)
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
    ],
)
def test_a_picture_that_is_too_large_is_refused_before_it_is_decoded(data, monkeypatch):
    monkeypatch.setattr(cv2, "imdecode", None)
    with pytest.raises(InputError, match=r"pixels, more than the [\d,]+ that are read; scale it"):
        decode_picture(data)
    assert MAX_PLAIN_PIXELS < MAX_PIXELS


@pytest.mark.parametrize(
    "data", [b"", b"GIF89a", b"\xff\xd8\xff\xe0", b"BM", b"\x89PNG", _bmp(4, 4)[:60]]
)
def test_another_kind_of_file_is_refused(data):
    with pytest.raises(InputError, match="no whole PGM, PNG or BMP"):
        decode_picture(data)


@pytest.mark.parametrize(
    "data", [png(0, 5), _bmp(0, 3), _bmp(-3, 3), b"P5 0 1 255 ", b"P5 1 1 0 x"]
)
def test_a_picture_of_no_size_is_refused(data):
    with pytest.raises(InputError, match=r"its .*header says"):
        decode_picture(data)


def test_any_bit_of_a_png_that_fell_over_is_noticed():
    whole = cv2.imencode(".png", GREY)[1].tobytes()
    wanted = decode_picture(whole).values
    for place in range(len(whole)):
        changed = bytearray(whole)
        changed[place] ^= 1 << place % 8
        with pytest.raises(InputError):
            decode_picture(bytes(changed))
    assert (decode_picture(whole + b"more").values == wanted).all()
