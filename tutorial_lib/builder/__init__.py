"""Builds notebooks from their sources, and mutates their solutions to try the checks."""

from tutorial_lib.builder.contact_sheet import contact_sheet, write_contact_sheet
from tutorial_lib.builder.guides import write_guides
from tutorial_lib.builder.mutants import Survivor, exercises, harmless, mutants, survivors
from tutorial_lib.builder.notebooks import (
    LARGEST,
    STUB,
    build,
    compact_imports,
    execute,
    for_students,
    read,
    stubbed,
    to_text,
    unmarked,
)
from tutorial_lib.builder.slides import write_slides

__all__ = [
    "LARGEST",
    "STUB",
    "Survivor",
    "build",
    "compact_imports",
    "contact_sheet",
    "execute",
    "exercises",
    "for_students",
    "harmless",
    "mutants",
    "read",
    "stubbed",
    "survivors",
    "to_text",
    "unmarked",
    "write_contact_sheet",
    "write_guides",
    "write_slides",
]
