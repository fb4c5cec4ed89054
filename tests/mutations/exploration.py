"""Exploration: labels, the task, local maps, the graph with ghosts, and noticing a goal."""

from tests.mutations import changes

MUTATIONS = [
    *changes("""
exploration/explorable.py | exploration/test_labels.py -k no_robot_can_stand
a wall just beyond the radius is overlooked
    ranges[n, ray] >= radius + CLEARANCE -> ranges[n, ray] >= radius

exploration/explorable.py | exploration/test_labels.py -k explorable
a detour counts as easy
    DETOUR * _unobstructed -> 1.3 * _unobstructed

exploration/labels.py | exploration/test_labels.py
a goal is visible through the nearest column
    columns % count, axis=1).max(axis=1) -> columns % count, axis=1).min(axis=1)
a goal near by is visible through a wall
    return (farthest > metres) & (metres <= radius) -> return metres <= radius
every direction has the score of the place itself
    self.metres(sources, goals)[:, :-1] / MAX_DISTANCE
        -> (self.metres(sources, goals)[:, -1:] + 0 * self.lengths[sources]) / MAX_DISTANCE
a goal is visible in its own column only
    np.arange(-half, half + 1) -> np.arange(0, 1)

exploration/bearings.py | exploration/test_bearings.py
the last bin is not followed by the first
    return bins.astype(np.intp) % directions -> return bins.astype(np.intp)
the columns of a panorama run the other way round
    turns = (np.pi - floats -> turns = (np.pi + floats

exploration/episodes.py | exploration/test_episodes.py -k succeeds_at_once
an episode may start where it succeeds
    axis=1) >= SUCCESS -> axis=1) >= 0.0

exploration/task.py | exploration/test_task.py
one that is done goes on
    actions = np.where(running, actions, STOP) -> actions = np.where(running, actions, actions)
to pass by the goal is enough
    self.success |= stopped & near -> self.success |= running & near
odometry is exact
    compose(self.odometry, motions + errors) -> compose(self.odometry, motions)

world/noise.py | exploration/test_task.py -k without_the_others
robots share one stream of noise
    self._streams = rng.spawn(robots) -> self._streams = [rng] * robots

world/noise.py | exploration/test_task.py -k peaks
all motions are of the first mode
    luck, side="right") -> 0 * luck, side="right")

exploration/task.py | exploration/test_task.py -k pocket
a pocket has no shortest path
    cut = np.flatnonzero(~np.isfinite(metres)) -> cut = np.flatnonzero(metres < 0)

exploration/motion.py | exploration/test_task.py -k wall
a robot stops before it touches anything
    if gap < radius and gap < before - 1e-9: -> if gap < 1.2 * radius and gap < before - 1e-9:

exploration/rewards.py | exploration/test_environment.py -k pays
the environment pays at every step
    else np.zeros(len(task)) -> else np.ones(len(task))

exploration/rewards.py | exploration/test_rewards.py -k exactly
progress is paid from the start on, again at every step
    before, self._metres = self._metres, self._distances(task.poses)
        -> before, self._metres = task.episodes.shortest, self._distances(task.poses)

exploration/many_environments.py | exploration/test_rewards.py -k lock_step
the next episode's start counts as progress
    self._rewards.paid(task, ~self._over) -> self._rewards.paid(task, self._over | True)

exploration/environment.py | exploration/test_environment.py -k pays
an episode that is over goes on
    if task.done[0]: -> if False:

exploration/grid_kernels.py | exploration/test_local_map.py -k raycaster
rays are entered beyond the reach
    far = min(length - resolution / 2, reach) -> far = length - resolution / 2

exploration/grid_kernels.py | exploration/test_local_map.py -k dijkstra
a knight's step looks at one of two cells
    return cost[row + half, column] > 0 and cost[row + half, column + right] > 0
        -> return cost[row + half, column] > 0

exploration/frontier.py | exploration/test_local_map.py -k walls_more_than_once
a frontier's metres count what is near walls several times
    RESOLUTION * path_length(parent, found[m, block], side)
        -> RESOLUTION * length[found[m, block]] / 29

exploration/local_map.py | exploration/test_local_map.py -k moves
a map forgets which side it moved to
    self.corners[robot] += np.array([right, up]) * RESOLUTION
        -> self.corners[robot] += np.array([up, right]) * RESOLUTION

exploration/local_policy.py | exploration/test_local_map.py -k policy
a robot turns away from its path
    turn = np.where(bearing > 0, LEFT, RIGHT) -> turn = np.where(bearing > 0, RIGHT, LEFT)

exploration/ghost_graph.py | exploration/test_ghost_graph.py -k in_sight
a ghost goes through walls
    if self._sees(node, poses[other, :2]) or self._sees(other, back[:2]): -> if True:

exploration/ghost_graph.py | exploration/test_ghost_graph.py
a panorama is read mirrored
    column_of(np.arctan2(place[1], place[0]), count)
        -> column_of(-np.arctan2(place[1], place[0]), count)
an edge leads one way
    self.edges[first][second], self.edges[second][first] = pose, inverse(pose)
        -> self.edges[first][second], self.edges[second][first] = pose, pose
paths over the graph have few edges, not few metres
    total = far + float(np.hypot(pose[0], pose[1])) -> total = far + 1.0

exploration/ghost_graph.py | exploration/test_ghost_graph.py -k invariants
no ghost is left in its direction
    self.place_of(ghost) - pose[:2]) < EXPLORED -> self.place_of(ghost) - pose[:2]) < 99.0

exploration/graph_update.py | exploration/test_global_policy.py -k entering
entering a node moves the robot
    compose(self._odometry, inverse(offset)) -> compose(self._odometry, offset)

exploration/goal_search.py | exploration/test_goal_search.py -k no_trace
a missed goal leaves what was left of the path
    self.found[lost], self.left[lost] = False, np.inf -> self.found[lost] = False

exploration/goal_search.py | exploration/test_goal_search.py -k remembered
one missed goal is remembered
    _REFUSED = 4 -> _REFUSED = 1

exploration/goal_search.py | exploration/test_goal_search.py
estimates of a goal are not averaged
    share = (weight / (weight + known))[:, None] -> share = (0 * weight / (weight + known))[:, None]
a robot stops where the goal seemed to be, though it does not see it there
    stop = there & self._sure[robots] -> stop = there
an estimate from far away replaces a better one
    np.where(self.found[mine] & ~apart, self._weight[mine], 0.0)
        -> np.where(self.found[mine] & apart, self._weight[mine], 0.0)
near its goal a robot looks no oftener
    (near & (moved > 0.1)) -> (near & (moved > 9.9))
all estimates of a goal weigh alike
    * metres) ** 2 -> * metres) ** 0
a goal that was missed is never believed again
    (gaps < _SAME).any(axis=1) & (metres > _NEAR) -> (gaps < _SAME).any(axis=1)
a robot stuck before its goal waits there
    stuck = found & (self.left[robots] < _AT_END) & ~stop
        -> stuck = found & (self.left[robots] < 0.0) & ~stop

agents/random_walk.py | agents/test_exploring.py -k neighbours
agents share one stream
    self._streams = self._rng.spawn(len(goals)) -> self._streams = [self._rng] * len(goals)

agents/frontier.py | agents/test_exploring.py -k closes_no_frontier
frontiers are closed on the way to a goal
    rows = np.flatnonzero(~self.search.found[sensed.robots]) -> rows = np.arange(len(sensed.robots))

agents/frontier.py | agents/test_exploring.py -k once_all
without a frontier the robot stays
    sights[0] if len(sights) else self._seen_place(robot) -> sights[0] if len(sights) else here

exploration/graph_update.py | exploration/test_global_policy.py
a robot that is localised in a node trusts its odometry more than F_R
    memory.enter(node, None if known else guess) -> memory.enter(node)
a robot needs no room to either side
    in_the_way = (ahead > 0) & (np.abs(aside) < _WIDE)
        -> in_the_way = (ahead > 0) & (np.abs(aside) < 0.02)
the likeliest node is entered however unlikely it is
    if likely[best] >= self._same: -> if likely[best] >= 0:
four nodes near by are too many
    if far[n] < BESIDE][:_TRIED] -> if far[n] < BESIDE][:1]
nodes far away are compared as well
    if far[n] < BESIDE] -> if far[n] < 99.0]

exploration/other_scores.py | agents/test_explorers.py -k other_scores
a direction looks like the goal where its patch looks like most of it
    .sum(axis=-1).max(axis=-1) -> .sum(axis=-1).mean(axis=-1)

exploration/turned_views.py | exploration/test_turned_views.py
a view is turned the other way
    (np.pi - borders - headings[:, None]) -> (np.pi - borders + headings[:, None])
a panorama's rows are taken for the camera's
    (1.0 - flatten * slopes) -> (1.0 - slopes + 0 * flatten)
a scan is not turned with the robot
    full_circle(laser.beams) + headings[:, None] -> full_circle(laser.beams) + 0 * headings[:, None]

exploration/global_policy.py | exploration/test_global_policy.py
a robot passes a node only where it stands on it
    > _PASSED: -> > 0.0:

exploration/frontier.py | exploration/test_local_map.py -k 'beyond or too_far or get_on or closed'
a crop repeats the map's rim
    np.where(inside, found, np.uint8(UNKNOWN)) -> found

exploration/local_map.py | exploration/test_local_map.py -k 'beyond or too_far or get_on or closed'
closing a place closes what was seen
    part[part == UNKNOWN] = OCCUPIED -> part[:] = OCCUPIED

exploration/exploring_robot.py | exploration/test_exploring_robot.py
a ghost that was explored is still gone to
    return ghost is None or (ghost.node, ghost.direction) in self.memory.graph.ghosts -> return True
"""),
    (
        "paths are kept when the graph has changed",
        "exploration/ghost_graph.py",
        "        self._paths.clear()\n",
        "",
        "exploration/test_ghost_graph.py -k invariants",
    ),
    (
        "poses are kept when the graph has changed",
        "exploration/ghost_graph.py",
        "        self._poses.clear()\n",
        "",
        "exploration/test_ghost_graph.py -k invariants",
    ),
    (
        "without a score, that of the first draw is kept",
        "agents/nts.py",
        "            scores = robot.rng.random(scores.shape)\n",
        "            pass\n",
        "agents/test_exploring.py -k as_likely",
    ),
    (
        "time spent on a goal counts against a ghost",
        "agents/nts.py",
        "                robot.interrupt()\n",
        "                pass\n",
        "agents/test_exploring.py -k time_spent",
    ),
    (
        "a ghost stays where a node stands in its direction",
        "exploration/ghost_graph.py",
        "                table.pop((node, direction), None)\n",
        "                pass\n",
        "exploration/test_ghost_graph.py",
    ),
    (
        "old paths are kept when two nodes are linked",
        "exploration/ghost_graph.py",
        "        self._forget_paths()\n        self._stands(first, pose)",
        "        self._stands(first, pose)",
        "exploration/test_global_policy.py",
    ),
    (
        "past the first node a robot goes straight to a ghost far away",
        "exploration/global_policy.py",
        "        memory.enter(other)\n",
        "        break\n",
        "exploration/test_global_policy.py",
    ),
    (
        "a ghost that was removed comes back from the reserve",
        "exploration/ghost_graph.py",
        (
            "        self.ghosts.pop((ghost.node, ghost.direction), None)\n        "
            "self.reserve.pop((ghost.node, ghost.direction), None)\n"
        ),
        "        self.ghosts.pop((ghost.node, ghost.direction), None)\n",
        "exploration/test_ghost_graph.py",
    ),
    (
        "directions into a wall are kept in reserve",
        "exploration/graph_update.py",
        "        free[free < _FREE] = 0.0\n",
        "",
        "exploration/test_global_policy.py",
    ),
    (
        "another goal is looked for only farther on",
        "exploration/goal_search.py",
        "        self._looked[:] = np.nan\n",
        "",
        "exploration/test_goal_search.py",
    ),
    (
        "a robot at a wall tries again at once",
        "exploration/local_policy.py",
        "np.where(blocked, _EVADE,",
        "np.where(blocked, 0,",
        "exploration/test_local_map.py -k 'beyond or too_far or get_on or closed'",
    ),
    (
        "a robot that turned too far turns back",
        "exploration/local_policy.py",
        "& (turn != last) &",
        "& (turn == last) &",
        "exploration/test_local_map.py -k 'beyond or too_far or get_on or closed'",
    ),
    (
        "time towards one node counts against the next",
        "exploration/exploring_robot.py",
        "            self._nearest, self._waited, self._target = np.inf, 0, target\n",
        "            self._target = target\n",
        "exploration/test_exploring_robot.py",
    ),
]
