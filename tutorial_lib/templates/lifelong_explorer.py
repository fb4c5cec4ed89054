"""An explorer that goes on to other pictures (`interfaces.SequentialExplorer`), and remembers."""

import numpy as np

from tutorial_lib.agents import LifelongAgent, LifelongSettings
from tutorial_lib.learning.exploration_model import LearnedExploration


class Mine:
    """The combined agent of the library, which minds a long way to a ghost less."""

    def __init__(self):
        model, settings = LearnedExploration("nts_rgbd"), LifelongSettings(travel=0.01)
        self.usual = LifelongAgent(model, np.random.default_rng(0), settings)

    def start(self, goals):
        self.usual.start(goals)

    def look_for(self, goals):
        self.usual.look_for(goals)

    def act(self, observations, running):
        return self.usual.act(observations, running)
