"""Any bit that fell over is noticed."""

import json

import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.reading.checksums import sealed, unsealed, with_checksum, without_checksum

CONTENT = {"name": "größer", "numbers": [1, 2.5, None, True], "inner": {"b": 1, "a": [0.1 + 0.2]}}


def test_what_was_sealed_is_read_again():
    for payload in (b"", b"abc", bytes(range(256)) * 9):
        assert unsealed(sealed(payload)) == payload
    again = json.loads(json.dumps(with_checksum(CONTENT), indent=1))
    assert list(again)[-1] == "checksum"
    assert without_checksum(again) == CONTENT


def test_any_single_bit_is_noticed():
    data = sealed(b"weights")
    for place in range(len(data)):
        for bit in range(8):
            changed = bytearray(data)
            changed[place] ^= 1 << bit
            with pytest.raises(InputError, match="checksum"):
                unsealed(bytes(changed))
    for size in range(len(data)):
        with pytest.raises(InputError, match="checksum"):
            unsealed(data[:size])


@pytest.mark.parametrize(
    "change",
    [
        {"name": "grosser"},
        {"numbers": [1.0, 2.5, None, True]},
        {"numbers": [True, 2.5, None, True]},
        {"inner": {"b": 1, "a": [0.3]}},
        {"more": None},
        {"checksum": None},
        {"checksum": ""},
    ],
)
def test_any_change_of_a_document_is_noticed(change):
    with pytest.raises(InputError, match="its checksum differs"):
        without_checksum(with_checksum(CONTENT) | change)
    with pytest.raises(InputError, match="its checksum differs"):
        without_checksum(CONTENT)
