"""Checks of the exercises: plain functions that notebooks and pytest call alike."""
