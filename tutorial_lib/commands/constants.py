"""What several commands need: the course's folder, and the exit codes."""

from tutorial_lib.course import CHECKOUT

PROJECT = CHECKOUT
INTERRUPTED, WRONG_INPUT, MISSED = 130, 2, 1
