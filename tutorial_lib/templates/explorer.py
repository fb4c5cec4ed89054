"""An explorer (`interfaces.ExplorerAgent`): looks for a picture in a place never seen."""

import numpy as np

STOP, FORWARD, LEFT, RIGHT = range(4)


class Mine:
    """Drives ahead, turns at walls, and stops where the panorama looks like the picture."""

    def start(self, goals):
        self.goals = goals.image.astype(float)
        self.rng = np.random.default_rng(0)
        self.turning = np.zeros(len(goals), dtype=int)  # actions that are left of a turn
        self.side = np.full(len(goals), LEFT)

    def act(self, observations, running):
        columns = observations.depth.shape[1]
        front = slice(columns // 4, 3 * columns // 4)  # column 0 looks backwards
        wall = np.nanmin(observations.depth[:, front], axis=1) < 0.45
        begins = wall & (self.turning == 0)
        self.turning = np.where(begins, self.rng.integers(3, 13, len(wall)), self.turning)
        self.side = np.where(begins, self.rng.integers(LEFT, RIGHT + 1, len(wall)), self.side)
        turns = self.turning > 0
        self.turning -= turns
        # The picture was taken with another heading: compare it with every turn of the panorama.
        seen = observations.image.astype(float)
        gaps = [
            np.abs(np.roll(seen, shift, axis=2) - self.goals).mean(axis=(1, 2, 3))
            for shift in range(0, columns, 4)
        ]
        there = np.min(gaps, axis=0) < 25.0
        return np.where(there, STOP, np.where(turns, self.side, FORWARD))
