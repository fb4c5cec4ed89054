"""What several commands need: the course's folder, and the exit codes."""

from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
CLOSED_PIPE, INTERRUPTED, WRONG_INPUT, MISSED = 141, 130, 2, 1
