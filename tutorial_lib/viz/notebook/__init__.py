"""Widgets and what shows pictures and films as the output of a cell."""
