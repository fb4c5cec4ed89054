"""Agents: over a map, by similarity, at random."""

TESTS = "agents/test_agents.py"
MUTATIONS = [
    (
        "only the edge that was not passed is excluded",
        "agents/blockades.py",
        "self._beside(before) - ahead\n        targets = self._beside(ahead) - sources",
        "before - ahead\n        targets = ahead - sources",
        TESTS,
    ),
    (
        "a refused plan is never taken, not even when under way",
        "agents/navigator.py",
        "(plan.probability > 0 and np.isfinite(self._lost_at[robot]))",
        "False",
        TESTS,
    ),
    (
        "steps of searching count as seconds",
        "agents/navigator.py",
        "> SEARCH_TIME / STEP",
        "> SEARCH_TIME",
        TESTS,
    ),
    (
        "the time spent searching is never forgotten",
        "agents/navigator.py",
        "self._searched[robot], self.plans[robot] = 0, plan",
        "self.plans[robot] = plan",
        TESTS,
    ),
    (
        "SPTM goes to the goal that is farthest",
        "agents/sptm.py",
        "goal = min(",
        "goal = max(",
        TESTS,
    ),
    (
        "SPTM joins neighbours on a trajectory both ways",
        "agents/sptm.py",
        "abs(source - target) > 1 or",
        "abs(source - target) >= 1 or",
        TESTS,
    ),
    (
        "SPTM keeps shortcuts that no longer hold",
        "agents/sptm.py",
        "for edge, times in driven.items() if not times]",
        "for edge, times in driven.items() if times < 0]",
        TESTS,
    ),
    (
        "a random agent needs only be near its goal",
        "agents/random.py",
        "near & (overlaps.mean(axis=1) > self._rules.visited)",
        "near & (overlaps.mean(axis=1) >= 0)",
        TESTS,
    ),
]
