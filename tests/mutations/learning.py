"""Learning: labels, batches, networks, losses, training, calibration."""

from tests.mutations import changes

MUTATIONS = [
    *changes("""
learning/calibration.py | learning/test_calibration.py
above the last knot the line goes on as it began
    np.maximum(logits - raw[-1], 0.0) * last -> np.maximum(logits - raw[-1], 0.0) * first
shares are drawn to one half twice as much
    (label[part].sum() + 0.5) / (len(part) + 1.0) -> (label[part].sum() + 1.0) / (len(part) + 2.0)
all bins count the same in the calibration error
    (gap * self.count).sum() / self.count.sum() -> gap.mean()

learning/labels.py | learning/test_labels.py
a line of sight is clear on one side only
    for side in (0.0, 1.0, -1.0): -> for side in (0.0, 1.0):

learning/losses.py | learning/test_training.py -k 'costs or better_than'
an error counts less where the prediction is far
    (1.0 + wanted.norm(dim=-1)) -> (1.0 + predicted.norm(dim=-1))

learning/losses.py | learning/test_reach_training.py
overlaps count as much as reachability
    + OVERLAP_WEIGHT * shares.sum(1) -> + shares.sum(1)

learning/encoders.py | learning/test_networks.py
the difference is added to the target
    other - difference -> other + difference

learning/views.py | learning/test_networks.py
a laser scan runs from right to left
    scan[..., _MIDDLE][..., ::-1] -> scan[..., _MIDDLE]

learning/batches.py | learning/test_training.py -k 'batch or block'
poses of the context are seen the wrong way round
    seen = relative(origins, poses) -> seen = relative(poses, origins)

learning/batches.py | learning/test_training.py -k 'batch or killed_training'
training goes on at the beginning of a block
    range(first % each if number == first // each else 0, each) -> range(0, each)

learning/reach_batches.py | learning/test_reach_batches.py
frames of two drives count as close in time
    np.where(own, np.abs(sources - target), FAR_IN_TIME) -> np.abs(sources - target)
one overlap is enough to learn where a picture was taken
    (overlap.min(axis=1) >= 0.1) -> (overlap.max(axis=1) >= 0.1)

learning/settings.py | learning/test_training.py -k 'is_over or better'
training ends a validation too late
    - 1 - self.best >= patience -> - 1 - self.best > patience

learning/settings.py | learning/test_training.py -k rate
the first step of the warm-up learns nothing
    min(1.0, (step + 1) / self.warmup_steps) -> min(1.0, step / self.warmup_steps)

learning/estimators.py | learning/test_estimators.py
images with a pixel in common are encoded as one
    (images[1:] == images[:-1]).all(axis=(1, 2, 3))
        -> (images[1:] == images[:-1]).any(axis=(1, 2, 3))

learning/estimators.py | learning/test_estimators.py -k 'embed or target'
a target is known by its last picture, not its middle one
    sorted({0, count // 2}) -> sorted({0, count - 1})

learning/mining.py | learning/test_reachability.py
pairs along one drive are never mined
    ~own | (np.abs( -> ~own & (np.abs(

learning/panorama_network.py | learning/test_panorama_network.py -k perfect_matches
all matches of columns count the same
    weight = (confidence * best).softmax(1) -> weight = (0.0 * best).softmax(1)

learning/panorama_network.py | learning/test_panorama_network.py -k goal_matters
blind scores see the goal as a whole
    hidden, pooled = self._judged(sources.local)
        -> hidden, pooled = self._judged(sources.local + goals.whole[:, None])

learning/panorama_encoder.py | learning/test_panorama_network.py -k 'renumbers or lie_about'
patches are numbered clockwise
    (5 - torch.arange(DIRECTIONS)) % DIRECTIONS -> (5 + torch.arange(DIRECTIONS)) % DIRECTIONS

learning/panorama_batches.py | learning/test_exploration_data.py -k mirror
a mirror keeps the bearing within a direction
    changed["offset"][groups] = -batch.offset[groups]
        -> changed["offset"][groups] = batch.offset[groups]

learning/exploration_losses.py | learning/test_exploration_training.py -k order
directions that are none count in the order
    logits.masked_fill(~possible, never).log_softmax(-1) -> logits.log_softmax(-1)

learning/exploration_model.py | learning/test_exploration_training.py -k relative_poses
a goal is as far as it is near
    RADIUS * (1.0 - nearness[:, 0]) -> RADIUS * nearness[:, 0]

learning/exploration_data.py | learning/test_exploration_data.py -k geodesics
directions are those of the goal
    (labels.lengths >= SHORTEST)[:, None] -> (labels.lengths >= SHORTEST)[None]

learning/exploration_policies.py | learning/test_imitation.py -k step_by_step
the imitating policy forgets what it did
    after = [state[:, :FEATURES], memory[0].numpy(), actions.astype(np.float32)]
        -> after = [state[:, :FEATURES], memory[0].numpy(), 0 * actions.astype(np.float32)]

learning/goal_map_network.py | learning/test_goal_map.py -k read_where
rows and columns of the map around a robot are exchanged
    at = (frontiers[..., :2] / (0.5 * CROP * RESOLUTION))[:, None]
        -> at = (frontiers[..., :2].flip(-1) / (0.5 * CROP * RESOLUTION))[:, None]

learning/exploration_policies.py | learning/test_goal_map.py -k any_number
a frontier that is far is as good as a near one
    -(frontiers[:, 2] + MAX_DISTANCE * (1.0 - scores[robots, place].astype(float)))
        -> -MAX_DISTANCE * (1.0 - scores[robots, place].astype(float))

learning/views.py | learning/test_estimators.py -k field_of_view
a network takes images of any camera of its size
    if seen.camera is not None and seen.camera != wanted:
        -> if seen.camera is not None and seen.camera.rows != wanted.rows:

learning/threads.py | learning/test_threads.py
the user's number of threads is not asked for
    if not by_environment and torch.get_num_threads() == _AT_IMPORT and not _told_mkl():
        -> if not by_environment:

learning/exploration_losses.py | learning/test_exploration_training.py -k scores_cost
a mean counts what is not counted
    torch.where(counted, values, 0.0).sum() / counted.sum().clamp(min=1)
        -> torch.where(counted, values, 0.0).mean()
scores fall below 0
    MAX_DISTANCE).clamp(min=0.0) -> MAX_DISTANCE)

learning/exploration_losses.py | learning/test_exploration_training.py -k in_the_mean
a single direction is a choice
    choice = possible.sum(1) > 1 -> choice = possible.sum(1) > 0

learning/exploration_losses.py | learning/test_exploration_training.py -k costs_its
near is far
    RADIUS * (1.0 - nearness)[:, None] * wanted -> RADIUS * nearness[:, None] * wanted

learning/exploration_data.py | learning/test_exploration_data.py
directions into a wall have metres
    (labels.lengths >= SHORTEST)[:, None] -> (labels.lengths >= 0.0)[:, None]

learning/exploration_data.py | learning/test_exploration_data.py -k too_far
far pairs have metres
    np.where(metres[..., -1] <= FARTHEST, -> np.where(metres[..., -1] <= 1e9,

learning/exploration_model.py | learning/test_exploration_training.py
offsets count twice
    half_bin = np.pi / DIRECTIONS -> half_bin = 2 * np.pi / DIRECTIONS

learning/goal_map_recipes.py | learning/test_goal_map.py -k one_frontier
a map with one frontier is a choice
    np.isfinite(whole["remaining"]).sum(axis=1) > 1
        -> np.isfinite(whole["remaining"]).sum(axis=1) > -1

learning/imitation_data.py | learning/test_imitation.py -k not_learned
steps after the end are used
    used = steps < length[:, None] -> used = steps <= length[:, None]
"""),
    (
        "steps that are none teach",
        "learning/imitation_network.py",
        '            _logits(network, batch)[used], batch.tensor("actions")[used]\n        )',
        (
            "            _logits(network, batch).flatten(0, 1), "
            'batch.tensor("actions").flatten()\n        )'
        ),
        "learning/test_imitation.py -k not_learned",
    ),
]
