"""From a waypoint or a geodesic to an action."""
