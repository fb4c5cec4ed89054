"""Charts, panels and films."""
