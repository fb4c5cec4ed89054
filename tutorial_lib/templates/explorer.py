"""An explorer (`interfaces.ExplorerAgent`): looks for a picture in a place never seen."""

import numpy as np

STOP, FORWARD, LEFT, RIGHT = range(4)


class Mine:
    """Drives ahead, turns at walls, and stops where the panorama looks like the picture."""

    def start(self, goals):
        self.goals = goals.image.astype(float)
        self.rng = np.random.default_rng(0)
        self.turn = np.full(len(goals), LEFT)

    def act(self, observations, running):
        middle = observations.depth.shape[1] // 2  # column 0 looks backwards
        wall = np.nanmin(observations.depth[:, middle - 8 : middle + 8], axis=1) < 0.5
        self.turn = np.where(wall, self.turn, self.rng.integers(LEFT, RIGHT + 1, len(wall)))
        there = np.abs(observations.image - self.goals).mean(axis=(1, 2, 3)) < 12.0
        return np.where(there, STOP, np.where(wall, self.turn, FORWARD))
