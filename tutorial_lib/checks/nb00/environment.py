"""The check of the installation, in notebook 00."""

import sys
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement

from tutorial_lib.course import CHECKOUT, is_checkout

PROJECT = "topological-visual-navigation"
_FIX = "in the course's folder: python3 start.py setup"
_FIX_INSTALLED = "install the course again: python -m pip install FILE.whl"


def check_environment() -> bool:
    """Print what is installed, and the fix for whatever is missing.

    Returns:
        Whether nothing is missing.
    """
    version = ".".join(map(str, sys.version_info[:3]))
    python = Path(sys.executable)
    shown = python.relative_to(CHECKOUT) if python.is_relative_to(CHECKOUT) else python
    print(f"Python {version} at {shown}")
    faults = find_faults()
    for fault in faults:
        print(f"✗ {fault}\n  fix: {_FIX if is_checkout() else _FIX_INSTALLED}")
    if not faults:
        print("✓ every package is there, in a version that fits: you are ready to go")
    return not faults


def find_faults() -> list[str]:
    """What is missing or of the wrong version, a line each."""
    try:
        requirements = [Requirement(line) for line in metadata.requires(PROJECT) or ()]
    except metadata.PackageNotFoundError:
        return ["the course itself is not installed in this Python"]
    faults = []
    for requirement in requirements:
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
            continue
        try:
            found = metadata.version(requirement.name)
        except metadata.PackageNotFoundError:
            faults.append(f"{requirement.name} is missing")
            continue
        if not requirement.specifier.contains(found, prereleases=True):
            faults.append(f"{requirement.name} {found} does not fit {requirement.specifier}")
    return faults
