"""Agents: over a map, by similarity, at random."""

from tests.mutations import changes

MUTATIONS = [
    *changes("""
agents/navigator.py | agents/test_agents.py
a refused plan is never taken, not even when under way
    (plan.probability > 0 and np.isfinite(self._lost_at[robot])) -> False
steps of searching count as seconds
    > SEARCH_TIME / STEP -> > SEARCH_TIME
the time spent searching is never forgotten
    self._searched[robot], self.plans[robot] = 0, plan -> self.plans[robot] = plan

agents/sptm.py | agents/test_agents.py
SPTM goes to the goal that is farthest
    goal = min( -> goal = max(
SPTM joins neighbours on a trajectory both ways
    abs(source - target) > 1 or -> abs(source - target) >= 1 or
SPTM keeps shortcuts that no longer hold
    for edge, times in driven.items() if not times]
        -> for edge, times in driven.items() if times < 0]

agents/random.py | agents/test_agents.py
a random agent needs only be near its goal
    near & (overlaps.mean(axis=1) > self._rules.visited) -> near & (overlaps.mean(axis=1) >= 0)

agents/remedy_navigation.py | agents/test_remedies.py
edges are biased from the first visit on
    np.maximum(self.visits[robot] - 1, 0) -> self.visits[robot]
a plan that was a guess is dropped at once
    elsewhere and self._agreed[robot] and not -> elsewhere and not
plans lead over turns as over edges that were driven
    excluded | self._turns_at -> excluded
a robot goes round for ever
    self.visits[robot, vertex] >= ENDLESS -> self.visits[robot, vertex] >= 99
to stay at a vertex counts as many visits
    if vertex == self._last[robot]: -> if vertex == -2:

agents/place_guess.py | agents/test_remedies.py
an unlikely start is worth as much as a likely one
    np.where(reach > self.p_query, reach, 0.0) * self.likely[columns]
        -> np.where(reach > self.p_query, reach, 0.0)
one of many twins is elsewhere
    float(belief[:OFF_MAP][near].sum()) / most -> float(belief[:OFF_MAP][near].sum())

agents/nts.py | agents/test_explorers.py -k remembered
a goal that the graph remembers is looked for anew
    robot.go_to(self._recalled(number)) -> robot.go_to(None)

agents/frontier.py | agents/test_explorers.py -k highest
the worst frontier is chosen
    np.lexsort((-scores, found.robots)) -> np.lexsort((scores, found.robots))

agents/imitation.py | agents/test_explorers.py -k imitating
a robot that imitates goes on after its end
    return np.where(running, actions, STOP) -> return np.where(actions >= 0, actions, STOP)

agents/returning.py | agents/test_returning.py -k shows_the_path
a robot remembers no way back
    turned(there[::-1], np.pi, -> turned(there[::-1], 0.0,

agents/returning.py | agents/test_returning.py -k takes_over
a robot without a path never explores
    actions = self._explorer.act(observations, running)
        -> actions = 0 * self._explorer.act(observations, running)

agents/blockades.py | agents/test_blockades.py
a stretch leads back to where it begins
    self._beside(ahead) - sources -> self._beside(ahead)
a robot waits where it once stood
    begins = moved | (self._seconds[robots] <= 0) -> begins = moved
what stands at the waypoint is in the way
    (along < far[:, None] - _SHORT) -> (along < far[:, None])
first steps are excluded wherever the robot is
    if np.linalg.norm(odometry[:2] - stretch.place) < _NEARBY: -> if True:
a robot that moved on waits no longer
    np.where(moved, 0.0, self._seconds[robots]) -> self._seconds[robots]

agents/navigator.py | agents/test_whereabouts.py
where a robot was seen counts for ever
    > _MOVED: -> > 99.0:
only the neighbours of a vertex are around it
    cutoff=_STEPS -> cutoff=1

agents/votes.py | agents/test_returning.py -k votes
all votes of a view support a place
    (agree[:, mine] * weights[mine]).max(axis=1) -> (agree[:, mine] * weights[mine]).sum(axis=1)

agents/nts.py | agents/test_exploring.py -k 'away_from or given_up'
a node is made at a node
    np.linalg.norm(memory.offset[:2]) >= _APART -> np.linalg.norm(memory.offset[:2]) >= 0.0

agents/nts.py | agents/test_exploring.py -k remembered_from
a goal seen by no node is remembered
    likely[best] < self._settings.search.visible -> likely[best] < -1.0

agents/frontier.py | agents/test_exploring.py -k 'away_from or given_up'
frontiers are closed that were seen meanwhile
    closed = over & is_open & ~self._returns[robots] -> closed = over & ~is_open
"""),
    (
        "only the edge that was not passed is excluded",
        "agents/blockades.py",
        "self._beside(before) - ahead\n        targets = self._beside(ahead) - sources",
        "before - ahead\n        targets = ahead - sources",
        "agents/test_agents.py",
    ),
    (
        "a vertex is to blame though the robot was elsewhere",
        "agents/remedy_navigation.py",
        "        if blameless:\n            self.plans[robot] = None\n",
        "",
        "agents/test_remedies.py",
    ),
    (
        "a robot has less time for each turn",
        "agents/returning.py",
        "            self._turning[mine] = 0\n",
        "",
        "agents/test_returning.py -k turn",
    ),
    (
        "a robot off the map begins where it last was",
        "agents/place_guess.py",
        "if self.off_map(robot) > 0.5:",
        "if self.off_map(robot) > 1.5:",
        "agents/test_remedies.py -k 'believed or last_four or reckons or between_vertices'",
    ),
    (
        "views are remembered for ever",
        "agents/place_guess.py",
        "self._views[robot][1 - _VIEWS :]",
        "self._views[robot]",
        "agents/test_remedies.py -k 'believed or last_four or reckons or between_vertices'",
    ),
    (
        "neighbouring vertices do not share their belief",
        "agents/place_guess.py",
        "self.filter.belief[robot, :OFF_MAP] @ self._near",
        "self.filter.belief[robot, :OFF_MAP]",
        "agents/test_remedies.py -k 'believed or last_four or reckons or between_vertices'",
    ),
    (
        "an old plan is worth as much after long dead reckoning",
        "agents/remedy_navigation.py",
        "left * _FADES**steps",
        "left",
        "agents/test_remedies.py -k 'believed or last_four or reckons or between_vertices'",
    ),
    (
        "between vertices a plan is dropped",
        "agents/remedy_navigation.py",
        "self._agreed[robot] and not (off_map and follows)",
        "self._agreed[robot]",
        "agents/test_remedies.py -k 'believed or last_four or reckons or between_vertices'",
    ),
]
