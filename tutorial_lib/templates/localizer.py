"""A localizer (`interfaces.Localizer`): at which vertices of the map may the robot be?"""

import numpy as np


class Mine:
    """May be wherever RE predicts that it can drive to from here."""

    def localize(self, observations, topomap):
        belief = np.zeros((len(observations), len(topomap)))
        for robot in range(len(observations)):
            seen = observations[[robot]]
            near = topomap.nearby(seen, count=64)[0]
            reach = topomap.vertices.into(seen, np.zeros_like(near), near)
            belief[robot, np.searchsorted(topomap.alive, near)] = reach
        return belief
