"""The commands of the command line, a file each; only the one that is asked for is imported."""

from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
INTERRUPTED, WRONG_INPUT, MISSED = 130, 2, 1
"""Exit codes."""
