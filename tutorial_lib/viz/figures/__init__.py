"""Charts, panels, films, and pictures put together."""
