"""Checksums over everything that a file says: any bit that fell over is noticed."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from tutorial_lib.errors import InputError

CHECKSUM = "checksum"
"""The key of a JSON document under which its checksum stands."""
_MARK = b"sha256 "
_HEADING = len(_MARK) + 64 + 1


def with_checksum(content: Mapping[str, Any]) -> dict[str, Any]:
    """A mapping for JSON, and last in it the SHA-256 of everything else."""
    return {**content, CHECKSUM: _digest(content)}


def without_checksum(content: Mapping[str, Any]) -> dict[str, Any]:
    """What `with_checksum` was given, from what was read.

    Raises:
        InputError: when something was changed since.
    """
    rest = {key: value for key, value in content.items() if key != CHECKSUM}
    if content.get(CHECKSUM) != _digest(rest):
        raise InputError("damaged, or changed by hand (its checksum differs)")
    return rest


def sealed(payload: bytes) -> bytes:
    """Bytes with their SHA-256 in a line before them."""
    return _MARK + hashlib.sha256(payload).hexdigest().encode() + b"\n" + payload


def unsealed(data: bytes) -> bytes:
    """The bytes that `sealed` was given.

    Raises:
        InputError: when there is no checksum, or anything was changed since.
    """
    payload = data[_HEADING:]
    if not data.startswith(_MARK):
        raise InputError("without a checksum: damaged, or of an older version")
    if sealed(payload) != data:
        raise InputError("damaged (its checksum differs)")
    return payload


def _digest(content: Mapping[str, Any]) -> str:
    """Of a mapping as JSON, however it is laid out."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
