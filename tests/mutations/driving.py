"""Driving: geodesics, control, closed loops, and what is recorded of them."""

from tests.mutations import changes

MUTATIONS = [
    *changes("""
driving/geodesics.py | driving/test_geodesics.py
a knight's step looks at one of the two cells
    for half in _between(down, right): -> for half in _between(down, right)[:1]:
the dislike of walls is linear
    self.clearance / comfort) ** 2 -> self.clearance / comfort)
a waypoint may lie beyond one that is hidden
    np.logical_and.accumulate(sight.reshape(near[1:].shape) & near[1:], axis=0)
        -> sight.reshape(near[1:].shape) & near[1:]

driving/geodesics.py | driving/test_geodesics.py -k to_the_last_bit
a bucket of distances is wider than an edge
    _BUCKETS, _WIDTH = 4, 0.9 -> _BUCKETS, _WIDTH = 4, 1.9

driving/control/oracle.py | driving/control/test_oracle.py -k narrow
a robot that turns first and gets stuck stays stuck
    self._other[robots] ^= stuck -> self._other[robots] &= stuck

driving/control/oracle.py | driving/control/test_oracle.py -k behind
a robot turns wherever its first waypoint is
    (np.abs(bearings) > BEHIND) -> (np.abs(bearings) > 0.0)

driving/control/oracle.py | driving/control/test_oracle.py -k cannot
a robot that cannot turn tries for ever
    (np.abs(bearings) > AHEAD) & ~late -> np.abs(bearings) > AHEAD

driving/control/rmp.py | driving/control/test_rmp.py
a car at rest believes that steering will not turn it
    np.maximum(np.abs(controls[:, 0]), self.authority) -> np.abs(controls[:, 0])
a car does not slow down while its wheels turn
    steerings - controls[:, 1]) > self.settle -> steerings - controls[:, 1]) > 4 * self.settle

driving/control/rmp_arcs.py | driving/control/test_rmp.py
the way to brake is taken for half as long
    np.sqrt(2 * braking * stop) -> np.sqrt(4 * braking * stop)

driving/control/arc_kernels.py | driving/control/test_rmp.py
a car that backs up turns round as soon as it may
    (0.5 * miss if leaving else miss) -> miss
a metre in reverse costs as much as one ahead
    back = reverse_cost * distance + -> back = distance +

driving/metrics.py | driving/test_metrics.py
the step of a collision does not count
    track[: collided_at + 1] -> track[:collided_at]

driving/rollouts.py | driving/test_rollouts.py
standing still is added up
    np.where(moved, 0.0, self._still + STEP) -> np.where(moved, self._still, self._still + STEP)

driving/data/perturbation.py | driving/data/test_episodes.py
a shift aside has no limit
    np.clip(rng.normal(0.0, self.aside, count), -self.most, self.most)
        -> rng.normal(0.0, self.aside, count)
a perturbed pose may lie behind a wall
    good &= scene.caster.sees(tried[:, :2], poses[missing, :2]) -> good &= True

driving/data/recorded_world.py | learning/test_labels.py
targets lie behind where they should lie ahead
    self.frame_at(np.repeat(frames, starts), -ahead)
        -> self.frame_at(np.repeat(frames, starts), ahead)

driving/data/recorded_world.py | driving/data/test_episodes.py
a context's pictures are in reverse order
    CONTEXT_INTERVAL * np.arange(-k, k + 1) -> CONTEXT_INTERVAL * np.arange(k, -k - 1, -1)

driving/data/trajectories.py | driving/data/test_trajectories.py
the frame at the given length is left out
    np.searchsorted(self.arc_length, metres)
        -> np.searchsorted(self.arc_length, metres, side='right')

driving/data/reachability_pairs.py | driving/data/test_reachability_pairs.py
one small overlap is enough to be far and occluded
    (self.geodesic > FAR) & (self.overlap < SEEN).all(axis=1)
        -> (self.geodesic > FAR) & (self.overlap < SEEN).any(axis=1)

driving/data/demonstrations.py | driving/data/test_demonstrations.py -k goals
goals of demonstrations may be as far as they like
    np.flatnonzero((far >= nearest) & (far <= FARTHEST))
        -> np.flatnonzero((far >= nearest) & (far < np.inf))

driving/data/episodes.py | driving/data/test_episodes.py
an obstacle may leave no room beside a wall
    gap = np.minimum(gap, scene.clearance.at(line)) -> gap = np.minimum(gap, np.inf)
an episode may start at its target
    found & (gap >= REACHED) -> found & (gap >= 0)

driving/control/smoothed.py | driving/control/test_smoothed.py
the oldest waypoint has the newest one's share
    before + self.share * (newest - before) -> newest + self.share * (before - newest)
the average is kept in the frame of the robot
    newest = to_world(observations.odometry, predicted) -> newest = predicted
robots share their averages
    self._averages[robots] = average -> self._averages[: len(robots)] = average

experiments/meng2020/table1.py | experiments/meng2020/test_table1.py -k smooths
C of Table I does not smooth
    "k5": by_smoothed_waypoints(WaypointNetwork("waypoint_k5"))
        -> "k5": by_smoothed_waypoints(WaypointNetwork("waypoint_k5"), 1.0)

experiments/protocols/local_control.py | experiments/meng2020/test_table1.py -k drifts
odometry is exact in Table I
    odometry_noise=Odometry(seed=self.seed).noise(NAVIGATING)
        -> odometry_noise=Odometry(False).noise(NAVIGATING)

driving/control/rmp.py | driving/control/test_same_body.py -k action
a controller drives the body that it was made for, whatever the robots are
    if body is None or body == self.body: -> if body is None or body is not self.body:

driving/data/recorded_world.py | driving/data/test_experiences.py
experiences begin at the same time
    return Experience(seen, self.begins[trajectory] +
        -> return Experience(seen, 0.0 * self.begins[trajectory] +
"""),
    (
        "who strays from a path may come back to it",
        "driving/metrics.py",
        "if gap.min() > STRAYED:\n            break",
        "if gap.min() > STRAYED:\n            continue",
        "driving/test_metrics.py",
    ),
]
