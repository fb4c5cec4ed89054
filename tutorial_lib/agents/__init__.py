"""Whole systems made of the pieces: they learn a building from drives and find their way in it."""
