"""The 2D world: floor plans, rays, sensors, bodies and their motion."""
