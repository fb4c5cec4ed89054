"""The name that a student gives the robot in notebook 00, kept beside the answers."""

from tutorial_lib.checks.framework import record
from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance

DEFAULT = "Rover"
"""The robot's name until it's given another."""
_LONGEST = 20  # letters of a name, which stands in titles


def name_robot(name: str) -> str:
    """Give the robot a name; the notebooks use it from then on.

    Returns:
        The name, without spaces around it.

    Raises:
        InputError: when it is empty, too long or not printable, or cannot be kept.
    """
    short = instance("name", name, str).strip()
    if not (short.isprintable() and 0 < len(short) <= _LONGEST):
        raise InputError(f"name: {name!r}; give 1 to {_LONGEST} letters")
    record.keep_robot(short)
    return short


def robot_name() -> str:
    """The name that the robot was given, or `DEFAULT`.

    Raises:
        InputError: when the file that keeps it is damaged.
    """
    return record.robot() or DEFAULT
