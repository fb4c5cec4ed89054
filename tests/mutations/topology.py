"""The topological map: anchors, edges, plans, and following them."""

from tests.mutations import changes

MUTATIONS = [
    *changes("""
topology/mapping/change_detection.py | topology/mapping/test_change_detection.py
what a robot sees is compared from where it believes to be
    _is_before(to_world(robot, points), mapped) -> _is_before(to_world(start, points), mapped)
walls that are gone are no sign of another place
    gone.mean() > _ELSEWHERE -> gone.mean() > 1.0
what a laser saw beside a point does not count
    np.array([-1, 0, 1]) -> np.array([0, 0, 0])
the last part of the path with something new is found
    int(on.any(axis=0).argmax()) -> int(on.any(axis=0).nonzero()[0][-1])
walls around an obstacle belong to it
    seen.points[seen.new & around] -> seen.points[around]

topology/mapping/insertion.py | topology/mapping/test_reuse.py
any edge of the map stands for an anchor, wherever it lies
    allowed & (self._out[anchor] > least) -> allowed & (self._out[anchor] >= 0)
an edge that leads back along its trajectory stands for an anchor
    place[source] < place[target] -> place[source] != place[target]
vertices behind a reused edge believe that they lie one place earlier
    np.cumsum(self.sources >= 0) -> np.cumsum(self.sources >= len(self.path))

topology/mapping/edge_rules.py | topology/mapping/test_reuse.py
the probability of the edge itself does not count
    into[edges[:, 0]], probabilities, onward -> into[edges[:, 0]], np.ones(len(edges)), onward

topology/following/transitions.py | topology/following/test_follower.py
the next anchor need not be near
    settings.p_follow) & (overlap > settings.near) -> settings.p_follow) | (overlap > settings.near)
of two anchors the one behind wins
    0.5 * (offsets > 0) -> 0.5 * (offsets < 0)

topology/following/heading_search.py | topology/following/test_follower.py
a robot turns back at any loss of overlap
    (overlap < best - _WORSE) -> (overlap < best)
the best overlap is forgotten at the next look
    overlap, np.maximum(best, overlap)) -> overlap, overlap)

topology/following/anchor_paths.py | topology/following/test_follower.py
the smaller of two overlaps counts, not their mean
    len(rows)).mean(axis=1) -> len(rows)).min(axis=1)

topology/following/follower.py | topology/following/test_doubts.py
RE of the next anchor is forgotten
    memory.aim(robots[moved], after[moved]) -> memory.aim(robots[moved])

topology/following/state.py | topology/following/test_doubts.py
a doubt outlives dead reckoning
    self.active[robots], self.doubted[robots] = sighted, 0.0 -> self.active[robots] = sighted
a doubt never ends
    (self.doubted[robots] > 0)) & ~(probability > settings.p_follow) -> (self.doubted[robots] > 0))

topology/following/state.py | topology/following/test_follower.py
stalled time is forgotten at once
    >= settings.calm -> >= 0

topology/following/follower.py | topology/following/test_follower.py
the lookout stays as narrow as it begins
    width[robots] + 1, settings.widest) -> width[robots] + 1, 1)

topology/mapping/edge_rules.py | topology/mapping/test_edge_rules.py
a vertex is reused by the sum of both probabilities
    np.where(fits, into * onward, -1.0) -> np.where(fits, into + onward, -1.0)
a vertex may be reused twice by one trajectory
    (place > place[vertex]) -> (place >= place[vertex])
one look without a vertex is enough to remove it
    unseen[first : last + 1, inner].all(axis=0) -> unseen[first : last + 1, inner].any(axis=0)

topology/mapping/edge_search.py | topology/mapping/test_edge_rules.py
the search for edges goes along both trajectories at once only
    ((1, 1), (-1, -1), (0, 1), (0, -1)) -> ((1, 1), (-1, -1))

topology/mapping/insertion.py | topology/mapping/test_topomap.py
only one anchor that sees both neighbours shows that a vertex is outdated
    _PASSING = 2 -> _PASSING = 0
the edge that was driven is searched, too
    ~np.isin(own - own[:, None], (0, 1)) -> ~np.isin(own - own[:, None], (0,))

topology/mapping/sparsify.py | topology/mapping/test_sparsify.py
later frames make up for one that is out of reach
    int(holds.argmin()) -> int(holds.sum())

topology/mapping/topomap.py | topology/mapping/test_topomap.py
an edge's last probability counts, not its highest
    max(probability, old["probability"]) -> probability
vertices of other trajectories are renumbered on removal
    if self.trajectory[vertex] == trajectory: -> if self.trajectory[vertex] >= 0:

topology/mapping/growing_batch.py | topology/mapping/test_edge_rules.py
what was joined comes back in the order of the batches
    joined(parts)[np.argsort(order)] -> joined(parts)[order]

topology/mapping/retrieval.py | topology/mapping/test_edge_rules.py
likeness looks from one picture only
    cosines.max(axis=3).mean(axis=1) + cosines.max(axis=1).mean(axis=2)
        -> 2 * cosines.max(axis=3).mean(axis=1)

topology/planner.py | topology/test_planner.py
the goal is believed as easily as any edge from here
    _add(graph, finishes, self.p_goal) -> _add(graph, finishes, min(self.p_goal, self.p_query))
an edge needs to be as probable as the threshold, not more
    if probability > least: -> if probability >= least:

topology/similarity.py | topology/test_similarity.py
a target is compared by its first picture
    images[:, images.shape[1] // 2] -> images[:, 0]

topology/localization.py | topology/test_localization.py
all belief leaves a vertex at once
    leave = 1.0 - np.exp(-motion[:, None] / model.lengths)
        -> leave = motion[:, None] / model.lengths > 0
standing still, the same evidence counts again
    update(self._prior[robots], likelihood) -> update(self.belief[robots], likelihood)
a localized robot changes its vertex at any difference
    stays = belief[rows, before] >= hysteresis * belief[rows, best]
        -> stays = belief[rows, before] >= belief[rows, best]
a sequence of views may not stay at a vertex
    total = look + np.maximum(total, come) -> total = look + come
a slow robot never moves on
    self._pose[robots[far]] = odometry[far] -> self._pose[robots] = odometry
a motion of just a stride is too short
    far = motion >= self -> far = motion > self
likelihoods are as sharp as they come
    ** settings.sharpness -> ** 1.0
a view may exclude a vertex
    np.maximum(self.sensor(observations), settings.least) -> self.sensor(observations)

topology/motion_model.py | topology/test_localization.py
the belief moves along edges on which a robot turns
    for v, w, edge in edges if "turn" not in edge] -> for v, w, edge in edges]
back is as likely as ahead
    (1.0 - BACK) * ahead + BACK * behind -> BACK * ahead + (1.0 - BACK) * behind
odometry of two drives is compared
    if topomap.trajectory[v] != topomap.trajectory[w]: -> if v == w:
neighbours lie ahead only
    return near | near.T -> return near

topology/mapping/turn_edges.py | topology/mapping/test_turn_edges.py
a robot turns back to the same side
    -pose[2]) -> pose[2])
of several turns the one that fits worst is kept
    np.argsort(-turns.scores -> np.argsort(turns.scores
colours are compared however far away they are
    laser[:, beams] < _SEEN -> laser[:, beams] < 99.0
any place may be turned at
    near = np.linalg.norm(poses[:, :2], axis=1) < settings.reach
        -> near = np.linalg.norm(poses[:, :2], axis=1) < 99.0

topology/mapping/scan_matching.py | topology/mapping/test_turn_edges.py
one scan's word is enough
    return np.minimum(there, back) -> return np.maximum(there, back)

topology/mapping/image_pool.py | topology/mapping/test_sampling_map.py -k length
a turn counts half in the size of a motion
    np.sqrt(arc**2 + 2 * turn**2) -> np.sqrt(arc**2 + turn**2)
"""),
    (
        "an edge on which a robot turns stands for an anchor",
        "topology/mapping/insertion.py",
        'and "turn" not in edge',
        "",
        "topology/mapping/test_reuse.py",
    ),
    (
        "RE of two anchors is compared",
        "topology/following/state.py",
        "        self.trusted[robots] = probability\n\n",
        "\n",
        "topology/following/test_doubts.py",
    ),
    (
        "the digest of a map ignores values",
        "topology/mapping/storage.py",
        "digest.update(np.ascontiguousarray(arrays[name]).reshape(-1).view(np.uint8).data)",
        "",
        "topology/mapping/test_storage.py",
    ),
    (
        "from off the map a robot never returns",
        "topology/motion_model.py",
        (
            "    onward[count, :count] = 1.0 / max(count, 1)\n    onward[count, count] = "
            "0.0 if count else 1.0\n"
        ),
        "    onward[count, count] = 1.0\n",
        "topology/test_localization.py",
    ),
    (
        "turning is no motion",
        "topology/motion_model.py",
        "+ TURN * np.abs(motion[..., 2])",
        "",
        "topology/test_localization.py",
    ),
    (
        "a wall behind a wall contradicts",
        "topology/mapping/scan_matching.py",
        "            if far > max(one, other) + _TOLERANCE:\n                continue",
        (
            "            if far > max(one, other) + _TOLERANCE:\n                bad += "
            "1\n                continue"
        ),
        "topology/mapping/test_turn_edges.py",
    ),
]
