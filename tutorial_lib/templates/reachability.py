"""RE (`interfaces.Reachability`): how probable is it that C reaches a target?"""

from tutorial_lib.learning import ReachabilityNetwork


class Mine:
    """The network that comes with the library, a little less sure of itself."""

    def __init__(self):
        self.usual = ReachabilityNetwork("reach_k5")

    def prepare(self, targets):
        return self.usual.prepare(targets)

    def probability(self, observations, prepared):
        return 0.999 * self.usual.probability(observations, prepared)

    def embed(self, observations):  # for retrieval; without it a map takes much longer to build
        return self.usual.embed(observations)
