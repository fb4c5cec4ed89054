"""A controller, C_RMP (`interfaces.Controller`): drives to a waypoint."""

import numpy as np


class Mine:
    """Pure pursuit: steers along the arc to the waypoint, slowly, and stops before walls."""

    def act(self, observations, waypoints):
        body, (x, y) = observations.body, np.asarray(waypoints).T
        curvature = 2 * y / np.maximum(x**2 + y**2, 0.01)
        steering = np.arctan(body.wheelbase * curvature)
        steering = np.clip(steering, -body.max_steering, body.max_steering)
        middle = observations.laser.shape[1] // 2  # of its beams, over the full circle
        ahead = np.nanmin(observations.laser[:, middle - 8 : middle + 8], axis=1)
        forward = np.where(ahead > 0.6, 0.4, 0.0)
        speed = np.where(x > 0, forward, -0.2)
        return np.stack([speed, np.where(x > 0, steering, -steering)], axis=1)
