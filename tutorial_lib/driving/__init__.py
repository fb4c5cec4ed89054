"""Driving: geodesics, controllers that need no learning, and what they record."""
