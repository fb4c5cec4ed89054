"""What several commands need: the course's folder, and the exit codes."""

from tutorial_lib.course import CHECKOUT

PROJECT = CHECKOUT
CLOSED_PIPE, INTERRUPTED, WRONG_INPUT, MISSED = 141, 130, 2, 1
