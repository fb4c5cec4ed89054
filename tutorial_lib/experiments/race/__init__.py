"""One race for all systems over the life of a robot in a building."""
