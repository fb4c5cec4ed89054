"""Drawing on the floor plan."""
