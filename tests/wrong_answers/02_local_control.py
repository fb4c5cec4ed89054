"""Answers to notebook 02: the docstring of a wrong one is what the check must say of it."""

import math
from copy import deepcopy
from dataclasses import replace

import numpy as np
import torch
from torch import nn


def goal_policy__gives_one_metric_for_all(offsets, velocities, gain, damping, near):
    """the metrics: shape (2, 2), but (4, 2, 2) is needed"""
    return _pull(offsets, gain, near) - damping * velocities, np.eye(2)


def goal_policy__forgets_the_metric(offsets, velocities, gain, damping, near):
    """return two things"""
    return _pull(offsets, gain, near) - damping * velocities


def goal_policy__right_point_by_point(offsets, velocities, gain, damping, near):
    flat, speeds = np.reshape(offsets, (-1, 2)), np.reshape(velocities, (-1, 2))
    found = []
    for (x, y), (vx, vy) in zip(flat, speeds, strict=True):
        share = gain / max(np.hypot(x, y), near)
        found.append([share * x - damping * vx, share * y - damping * vy])
    return np.reshape(found, np.shape(offsets)), _identities(offsets)


def obstacle_policy__right_one_by_one(distances, closing, push, brake, weight, fade):
    pairs = []
    for distance, speed in zip(distances, closing, strict=True):
        distance = distance if distance > 0.01 else 0.01
        force = push + brake * speed if speed > 0 else push
        pairs.append((force / distance, weight * np.e ** (-distance / fade)))
    away, metrics = np.array(pairs).T
    return away, metrics


def resolve__averages(policies):
    """the result is their mean, weighted with the metrics"""
    return np.mean([np.linalg.pinv(j) @ a for j, a, _ in policies], axis=0)


def resolve__has_no_damping(policies):
    """no policy constrains one direction: add 1e-6 to the diagonal"""
    force, metric = _sums(policies)
    return np.linalg.solve(metric, force)


def resolve__right_by_least_squares(policies):
    rows, wanted = [1e-3 * np.eye(2)], [np.zeros(2)]
    for jacobian, acceleration, metric in policies:
        values, vectors = np.linalg.eigh(metric)
        root = np.sqrt(np.maximum(values, 0))[:, None] * vectors.T
        rows.append(root @ jacobian)
        wanted.append(root @ acceleration)
    return np.linalg.lstsq(np.concatenate(rows), np.concatenate(wanted), rcond=None)[0]


def waypoint_label__stops_at_the_first_hidden_place(start, track, source, target, sees):
    """also if a post hides some places before it"""
    if target <= source:
        return _seen_from(start, track[target])
    found = None
    for frame in range(source + 1, target + 1):
        if not sees(start[:2], track[frame : frame + 1, :2])[0]:
            break
        found = _seen_from(start, track[frame])
    return found


def waypoint_label__has_no_case_for_a_target_behind(start, track, source, target, sees):
    """in sight: your code stops with IndexError"""
    places = track[source + 1 : target + 1]
    return _seen_from(start, places[np.flatnonzero(sees(start[:2], places[:, :2]))[-1]])


def waypoint_label__counts_so_and_stays_in_the_world(start, track, source, target, sees):
    """take the last that is in sight, as seen from start"""
    ok = np.flatnonzero(sees(start[:2], track[source + 1 : target + 1, :2]))
    return track[ok[-1], :2]


def waypoint_label__takes_the_last_of_nothing(start, track, source, target, sees):
    """there is no last place"""
    if target <= source:
        return _seen_from(start, track[target])
    places = track[source + 1 : target + 1]
    return _seen_from(start, places[np.flatnonzero(sees(start[:2], places[:, :2]))[-1]])


def waypoint_label__right_from_the_far_end(start, track, source, target, sees):
    if target <= source:
        return _seen_from(start, track[target])
    for frame in range(target, source, -1):
        if sees(start[:2], track[frame : frame + 1, :2])[0]:
            return _seen_from(start, track[frame])
    return None


def _pull(offsets, gain, near):
    distance = np.linalg.norm(offsets, axis=-1, keepdims=True)
    return gain * offsets / np.maximum(distance, near)


def _identities(offsets):
    return np.tile(np.eye(2), (*np.shape(offsets)[:-1], 1, 1))


def _sums(policies):
    force = sum(j.T @ m @ a for j, a, m in policies)
    return force, sum(j.T @ m @ j for j, _, m in policies)


def _seen_from(start, place):
    offset = (place[0] - start[0]) + 1j * (place[1] - start[1])
    turned = offset * np.exp(-1j * start[2])
    return np.array([turned.real, turned.imag])


def _eyes(offsets):
    return np.tile(np.eye(2), (*np.shape(offsets)[:-1], 1, 1))


def _toward(offsets, near):
    d = np.linalg.norm(offsets, axis=-1, keepdims=True)
    return offsets / np.maximum(d, near)


def goal_policy__ignores_near(offsets, velocities, gain, damping, near):
    """another near never changes your answer; it should"""
    return gain * _toward(offsets, 0.35) - damping * velocities, _eyes(offsets)


def goal_policy__ignores_the_gain(offsets, velocities, gain, damping, near):
    """another gain never changes your answer; it should"""
    return 2.4 * _toward(offsets, near) - damping * velocities, _eyes(offsets)


def goal_policy__ignores_the_damping(offsets, velocities, gain, damping, near):
    """another damping never changes your answer; it should"""
    return gain * _toward(offsets, near) - 3.0 * velocities, _eyes(offsets)


def goal_policy__needs_rows(offsets, velocities, gain, damping, near):
    """your code stops with AxisError: axis 1 is out of bounds for array of dimension 1"""
    d = np.linalg.norm(offsets, axis=1)[:, None]
    return gain * offsets / np.maximum(d, near) - damping * velocities, _eyes(offsets)


def goal_policy__exchanges_its_answers(offsets, velocities, gain, damping, near):
    """the two are exchanged: give the accelerations first"""
    return _eyes(offsets), gain * _toward(offsets, near) - damping * velocities


def goal_policy__changes_velocities(offsets, velocities, gain, damping, near):
    """your function changes its argument velocities"""
    velocities *= damping
    return gain * _toward(offsets, near) - velocities, _eyes(offsets)


def goal_policy__right_where(offsets, velocities, gain, damping, near):
    d = np.sqrt((offsets**2).sum(axis=-1))[..., None]
    unit = np.divide(offsets, d, out=np.zeros_like(offsets, dtype=float), where=d > 0)
    pull = np.where(d > near, gain * unit, gain * offsets / near)
    return [pull - damping * velocities, np.zeros((*offsets.shape, 2)) + np.eye(2)]


def goal_policy__right_recursive(offsets, velocities, gain, damping, near):
    if offsets.ndim > 1:
        parts = [
            goal_policy__right_recursive(o, v, gain, damping, near)
            for o, v in zip(offsets, velocities, strict=False)
        ]
        return np.array([p[0] for p in parts]), np.array([p[1] for p in parts])
    length = max(float(np.hypot(offsets[0], offsets[1])), near)
    return np.array(
        [gain * o / length - damping * v for o, v in zip(offsets, velocities, strict=False)]
    ), np.eye(2)


def _near(distances):
    return np.maximum(distances, 0.01)


def obstacle_policy__ignores_fade(distances, closing, push, brake, weight, fade):
    """another fade never changes your answer; it should"""
    d = _near(distances)
    return (push + brake * np.maximum(closing, 0)) / d, weight * np.exp(-d / 0.08)


def obstacle_policy__changes_its_arguments(distances, closing, push, brake, weight, fade):
    """your function changes its argument distances"""
    distances[distances < 0.01] = 0.01
    return (push + brake * np.maximum(closing, 0)) / distances, weight * np.exp(-distances / fade)


def obstacle_policy__cuts_the_metric_off(distances, closing, push, brake, weight, fade):
    """only distances below 0.01 m are limited, and no obstacle is left out"""
    d = _near(distances)
    m = weight * np.exp(-d / fade)
    m[d > 0.5] = 0
    return (push + brake * np.maximum(closing, 0)) / d, m


def obstacle_policy__returns_lists(distances, closing, push, brake, weight, fade):
    """the accelerations: a list came back; return a numpy array"""
    d = _near(distances)
    return list((push + brake * np.maximum(closing, 0)) / d), list(weight * np.exp(-d / fade))


def obstacle_policy__right_mask(distances, closing, push, brake, weight, fade):
    d = distances.copy()
    d[d < 0.01] = 0.01
    a = push / d
    a[closing > 0] += brake * closing[closing > 0] / d[closing > 0]
    return [a, weight / np.exp(d / fade)]


def obstacle_policy__right_clip(distances, closing, push, brake, weight, fade):
    d = np.clip(distances, 0.01, None).astype(np.float64)
    c = 0.5 * (closing + np.abs(closing))
    return np.stack([(push + brake * c) / d, weight * np.power(np.e, -d / fade)])


def _total(policies):
    f, m = np.zeros(2), np.zeros((2, 2))
    for j, a, w in policies:
        f, m = f + j.T @ w @ a, m + j.T @ w @ j
    return f, m


def resolve__adds_too_much_to_the_diagonal(policies):
    """with J the identity its acceleration comes back as it is (1.98 at"""
    f, m = _total(policies)
    return np.linalg.solve(m + 1e-2 * np.eye(2), f)


def resolve__adds_for_every_policy(policies):
    """with J the identity its acceleration comes back as it is (1.998 at"""
    f, m = _total(policies)
    return np.linalg.solve(m + 1e-3 * len(policies) * np.eye(2), f)


def resolve__skips_policies_of_one_row(policies):
    """a wall has one row: J is (1, 2), a is (1,) and M is (1, 1); the same"""
    f, m = _total([p for p in policies if p[0].shape[0] == 2])
    return np.linalg.solve(m + 1e-6 * np.eye(2), f)


def resolve__returns_a_column(policies):
    """shape (2, 1), but (2,) is needed"""
    f, m = _total(policies)
    return np.linalg.solve(m + 1e-6 * np.eye(2), f[:, None])


def resolve__changes_metrics(policies):
    """your function changes the policies; make new arrays"""
    f, m = np.zeros(2), 1e-6 * np.eye(2)
    for j, a, w in policies:
        w += 1e-9
        f, m = f + j.T @ w @ a, m + j.T @ w @ j
    return np.linalg.solve(m, f)


def resolve__empties_the_list(policies):
    """your function changes the list of policies; only read it"""
    f, m = np.zeros(2), 1e-6 * np.eye(2)
    while policies:
        j, a, w = policies.pop()
        f, m = f + j.T @ w @ a, m + j.T @ w @ j
    return np.linalg.solve(m, f)


def resolve__right_stacked(policies):
    rows = [np.zeros((0, 2))] + [j for j, _, _ in policies]
    big = np.concatenate(rows)
    a = np.concatenate([np.zeros(0)] + [np.atleast_1d(a) for _, a, _ in policies])
    m = np.zeros((len(a), len(a)))
    at = 0
    for j, _, w in policies:
        m[at : at + len(j), at : at + len(j)] = w
        at += len(j)
    return np.linalg.inv(big.T @ m @ big + 1e-6 * np.eye(2)) @ (big.T @ m @ a)


def resolve__right_einsum(policies):
    m, f = np.diag([1e-6, 1e-6]), np.zeros(2)
    for j, a, w in policies:
        m += np.einsum("ki,kl,lj->ij", j, w, j)
        f += np.einsum("ki,kl,l->i", j, w, a)
    det = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    return np.array([m[1, 1] * f[0] - m[0, 1] * f[1], m[0, 0] * f[1] - m[1, 0] * f[0]]) / det


def _local(start, place):
    c, s = np.cos(start[2]), np.sin(start[2])
    d = place[:2] - start[:2]
    return np.array([c * d[0] + s * d[1], c * d[1] - s * d[0]])


def waypoint_label__returns_zeros_for_nothing(start, track, source, target, sees):
    """nothing is in sight, so there is no last place; return None"""
    if target <= source:
        return _local(start, track[target])
    places = track[source + 1 : target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
    return _local(start, places[seen[-1]]) if len(seen) else np.zeros(2)


def waypoint_label__takes_the_mean(start, track, source, target, sees):
    """of frames source + 1 to target, take the last that is in sight, as seen from start"""
    if target <= source:
        return _local(start, track[target])
    places = track[source + 1 : target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
    return _local(start, places[seen].mean(axis=0)) if len(seen) else None


def waypoint_label__searches_from_the_first_frame(start, track, source, target, sees):
    """nothing is in sight, so there is no last place; return None"""
    if target <= source:
        return _local(start, track[target])
    places = track[: target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
    return _local(start, places[seen[-1]]) if len(seen) else None


def waypoint_label__returns_three_numbers(start, track, source, target, sees):
    """shape (3,), but (2,) is needed"""
    right = waypoint_label__right_backwards(start, track, source, target, sees)
    return None if right is None else np.append(right, 0.0)


def waypoint_label__returns_an_index(start, track, source, target, sees):
    """a frame's index came back; return its place, an array (2,)"""
    if target <= source:
        return target
    seen = np.flatnonzero(sees(start[:2], track[source + 1 : target + 1, :2]))
    return source + 1 + seen[-1] if len(seen) else None


def waypoint_label__ends_at_3_metres(start, track, source, target, sees):
    """the last place in sight counts, also if a post hides some places before it"""
    right = waypoint_label__right_backwards(start, track, source, target, sees)
    if right is None or target <= source:
        return right
    n = np.linalg.norm(right)
    return right if n <= 3 else right * 3 / n


def waypoint_label__passes_poses_to_sees(start, track, source, target, sees):
    """sees(place, points) takes a place (2,) first, not an array (3,):"""
    if target <= source:
        return _local(start, track[target])
    places = track[source + 1 : target + 1]
    seen = np.flatnonzero(sees(start, places))
    return _local(start, places[seen[-1]]) if len(seen) else None


def waypoint_label__returns_nan_for_nothing(start, track, source, target, sees):
    """nothing is in sight, so there is no last place; return None"""
    right = waypoint_label__right_backwards(start, track, source, target, sees)
    return np.full(2, np.nan) if right is None else right


def waypoint_label__right_backwards(start, track, source, target, sees):
    if target <= source:
        return _local(start, track[target])
    for i in reversed(range(source + 1, target + 1)):
        if bool(np.all(sees(start[:2], track[i : i + 1, :2]))):
            return _local(start, track[i])
    return None


def waypoint_label__right_mask(start, track, source, target, sees):
    chosen = track[target]
    if target > source:
        visible = np.asarray(sees(np.array(start[:2]), track[:, :2].copy()), bool)
        frames = np.arange(len(track))
        good = frames[visible & (frames > source) & (frames <= target)]
        if good.size == 0:
            return None
        chosen = track[good.max()]
    z = complex(*(chosen[:2] - start[:2])) * np.exp(-1j * start[2])
    return np.array([z.real, z.imag])


def _loop(
    network,
    optimizer,
    draw_batch,
    loss_of,
    validate,
    plan,
    *,
    rate=None,
    late_rate=False,
    zero=True,
    clip="norm",
    train_first=True,
    train_again=True,
    evaluate=True,
    no_grad=True,
    last=True,
    copy=True,
    restore=True,
    end_eval=True,
    better="<",
    patience=True,
    reset=True,
    training="mean",
    entry=lambda step, training, validation: (step, training, validation),
    first=0,
    redraw=False,
    backward=True,
    begin_with_evaluation=False,
):
    def right(step):
        warm = min(1, (step + 1) / plan.warmup_steps)
        return plan.learning_rate * warm * (1 + math.cos(math.pi * step / plan.max_steps)) / 2

    history, losses, everything = [], [], []
    best, waited, weights = math.inf, 0, network.state_dict()
    if train_first:
        network.train()
    if begin_with_evaluation:
        history.append((0, 0.0, validate(network)))
    fixed = draw_batch(0) if redraw == "fixed" else None
    for step in range(plan.max_steps):
        if not late_rate:
            optimizer.param_groups[0]["lr"] = (rate or (lambda s, p: right(s)))(step, plan)
        if zero:
            optimizer.zero_grad()
        batch = fixed if redraw == "fixed" else draw_batch(step + first)
        loss = loss_of(network, batch)
        if backward:
            loss.backward()
        if clip == "norm":
            nn.utils.clip_grad_norm_(network.parameters(), plan.max_norm)
        elif clip == "value":
            nn.utils.clip_grad_value_(network.parameters(), plan.max_norm)
        elif clip == "each":
            for p in network.parameters():
                nn.utils.clip_grad_norm_([p], plan.max_norm)
        elif clip == "always":
            total = torch.sqrt(sum((p.grad**2).sum() for p in network.parameters()))
            for p in network.parameters():
                p.grad *= plan.max_norm / total
        optimizer.step()
        if clip == "after":
            nn.utils.clip_grad_norm_(network.parameters(), plan.max_norm)
        if late_rate:
            optimizer.param_groups[0]["lr"] = right(step)
        losses.append(loss if training == "tensor" else loss.item())
        everything.append(loss.item())
        done = step + 1
        if done % plan.eval_interval and not (last and done == plan.max_steps):
            continue
        if evaluate:
            network.eval()
        if no_grad:
            with torch.no_grad():
                value = validate(network)
        else:
            value = validate(network)
        if train_again:
            network.train()
        shown = {
            "mean": sum(losses) / len(losses),
            "last": losses[-1],
            "sum": sum(losses),
            "all": sum(everything) / len(everything),
            "tensor": sum(losses) / len(losses),
        }
        history.append(entry(done, shown[training], value))
        losses = []
        if value < best or (better == "<=" and value <= best):
            best, waited = value, 0 if reset else waited
            weights = deepcopy(network.state_dict()) if copy else network.state_dict()
        else:
            waited += 1
            if patience and waited >= plan.patience:
                break
    if restore:
        network.load_state_dict(weights)
    if end_eval:
        network.eval()
    return history


def train_network__keeps_the_rate(*case):
    """the learning rate never changes: set group['lr'] of every group before the step"""
    return _loop(*case, rate=lambda s, p: p.learning_rate)


def train_network__skips_the_warmup(*case):
    """the learning rate lacks the warm-up: min(1, (step + 1) / warmup_steps)"""
    return _loop(
        *case, rate=lambda s, p: p.learning_rate * (1 + math.cos(math.pi * s / p.max_steps)) / 2
    )


def train_network__never_decays(*case):
    """the learning rate does not decay: the half cosine is missing"""
    return _loop(*case, rate=lambda s, p: p.learning_rate * min(1, (s + 1) / p.warmup_steps))


def train_network__begins_with_rate_zero(*case):
    """the warm-up is one step late: (step + 1) / warmup_steps; step 0 must learn, too"""
    return _loop(
        *case,
        rate=lambda s, p: (
            p.learning_rate
            * min(1, s / p.warmup_steps)
            * (1 + math.cos(math.pi * s / p.max_steps))
            / 2
        ),
    )


def train_network__decays_after_the_warmup(*case):
    """the cosine begins at step 0, not after the warm-up: step / max_steps"""

    def rate(s, p):
        if s < p.warmup_steps:
            return p.learning_rate * (s + 1) / p.warmup_steps
        return (
            p.learning_rate
            * (1 + math.cos(math.pi * (s - p.warmup_steps) / (p.max_steps - p.warmup_steps)))
            / 2
        )

    return _loop(*case, rate=rate)


def train_network__decays_below_zero(*case):
    """the decay is (1 + cos) / 2; the plain cosine falls to -1"""
    return _loop(
        *case,
        rate=lambda s, p: (
            p.learning_rate * min(1, (s + 1) / p.warmup_steps) * math.cos(math.pi * s / p.max_steps)
        ),
    )


def train_network__takes_degrees(*case):
    """np.cos takes radians: pi, not 180"""
    return _loop(
        *case,
        rate=lambda s, p: (
            p.learning_rate
            * min(1, (s + 1) / p.warmup_steps)
            * (1 + math.cos(180 * s / p.max_steps))
            / 2
        ),
    )


def train_network__forgets_the_highest_rate(*case):
    """multiply by plan.learning_rate, the highest rate"""
    return _loop(
        *case,
        rate=lambda s, p: (
            min(1, (s + 1) / p.warmup_steps) * (1 + math.cos(math.pi * s / p.max_steps)) / 2
        ),
    )


def train_network__decays_one_step_early(*case):
    """the cosine is one step early: it takes step / max_steps, and begins with 1"""
    return _loop(
        *case,
        rate=lambda s, p: (
            p.learning_rate
            * min(1, (s + 1) / p.warmup_steps)
            * (1 + math.cos(math.pi * (s + 1) / p.max_steps))
            / 2
        ),
    )


def train_network__sets_the_rate_after_the_step(*case):
    """the rate is set after the step, so that every step uses that of the step before it"""
    return _loop(*case, late_rate=True)


def train_network__never_zeroes(*case):
    """old gradients are added to the new ones: optimizer.zero_grad() before backward()"""
    return _loop(*case, zero=False)


def train_network__never_clips(*case):
    """a gradient that is too long stays so: torch.nn.utils.clip_grad_norm_ with max_norm"""
    return _loop(*case, clip="")


def train_network__clips_values(*case):
    """shorten the whole gradient, do not cut each number: clip_grad_norm_, no value"""
    return _loop(*case, clip="value")


def train_network__clips_each(*case):
    """max_norm limits the gradient of all parameters together, not of each tensor alone"""
    return _loop(*case, clip="each")


def train_network__stretches_short_gradients(*case):
    """only gradients longer than max_norm are shortened; the others stay as they are"""
    return _loop(*case, clip="always")


def train_network__forgets_backward(*case):
    """the gradients are all zero: loss.backward() comes after zero_grad(), before step()"""
    return _loop(*case, backward=False)


def train_network__forgets_train(*case):
    """the network learns in evaluation mode: network.train() before the first step"""
    return _loop(*case, train_first=False, train_again=False)


def train_network__stays_in_evaluation(*case):
    """after an evaluation the network must go on in training mode: network.train()"""
    return _loop(*case, train_again=False)


def train_network__validates_in_training_mode(*case):
    """evaluate in evaluation mode: network.eval() before validate(network)"""
    return _loop(*case, evaluate=False)


def train_network__validates_with_gradients(*case):
    """an evaluation needs no gradients: validate within torch.no_grad()"""
    return _loop(*case, no_grad=False)


def train_network__skips_the_last_evaluation(*case):
    """evaluate after the last step, too, where it does not end an interval"""
    return _loop(*case, last=False)


def train_network__keeps_no_copy(*case):
    """the network must end with the weights of its best evaluation; the"""
    return _loop(*case, copy=False)


def train_network__ends_in_training_mode(*case):
    """in the end the network must be in evaluation mode: network.eval()"""
    return _loop(*case, end_eval=False)


def train_network__prefers_later_equals(*case):
    """the network must end with the weights of its best evaluation; the"""
    return _loop(*case, better="<=")


def train_network__has_no_patience(*case):
    """training goes on, 20 steps, where it should end after 8: the"""
    return _loop(*case, patience=False)


def train_network__never_resets_patience(*case):
    """training ends after 8 steps, where it should make 14"""
    return _loop(*case, reset=False)


def train_network__ends_one_evaluation_early(*case):
    """training ends after 6 steps, where it should make 8"""

    return _loop(*case[:-1], replace(case[-1], patience=case[-1].patience - 1))


def train_network__ends_one_evaluation_late(*case):
    """training goes on, 16 steps, where it should end after 8: the"""

    return _loop(*case[:-1], replace(case[-1], patience=case[-1].patience + 1))


def train_network__reports_the_last_loss(*case):
    """the training loss is the mean of all losses since the last evaluation"""
    return _loop(*case, training="last")


def train_network__reports_the_sum_of_losses(*case):
    """the training loss is the mean since the last evaluation, not the sum:"""
    return _loop(*case, training="sum")


def train_network__never_empties_the_list(*case):
    """the training loss is the mean since the last evaluation; empty the list after it"""
    return _loop(*case, training="all")


def train_network__keeps_tensors(*case):
    """the history holds a tensor with its gradients; keep the number, loss.item()"""
    return _loop(*case, training="tensor")


def train_network__swaps_losses(*case):
    """in the history the training loss comes before the validation loss"""
    return _loop(*case, entry=lambda s, t, v: (s, v, t))


def train_network__counts_from_zero(*case):
    """the history's steps are [3. 7.], but [4. 8.] is right; count the steps made, from 1"""
    return _loop(*case, entry=lambda s, t, v: (s - 1, t, v))


def train_network__returns_validation_losses_only(*case):
    """the history's entries are three numbers: step, training loss, validation loss"""
    return _loop(*case, entry=lambda s, t, v: v)


def train_network__begins_with_step_one(*case):
    """the first step is step 0: draw_batch(0)"""
    return _loop(*case, first=1)


def train_network__draws_one_batch_for_all(*case):
    """draw a batch in every step, and compute its loss once: loss_of(network, batch)"""
    return _loop(*case, redraw="fixed")


def train_network__evaluates_first(*case):
    """the first evaluation comes after eval_interval steps, not before the first step"""
    return _loop(*case, begin_with_evaluation=True)


def train_network__returns_nothing(*case):
    """nothing came back; return the history"""
    _loop(*case)


def train_network__returns_the_network(network, *rest):
    """a Network came back; return the history"""
    _loop(network, *rest)
    return network


def train_network__right_with_a_scheduler(network, optimizer, draw_batch, loss_of, validate, plan):
    def factor(step):
        return min((step + 1) / plan.warmup_steps, 1.0) * (
            0.5 + 0.5 * np.cos(np.pi * step / plan.max_steps)
        )

    schedule = torch.optim.lr_scheduler.LambdaLR(optimizer, factor)
    history, step, total, since = [], 0, 0.0, 0
    kept, best_at = {}, 0
    while step < plan.max_steps:
        network.train()
        network.zero_grad(set_to_none=False)
        loss = loss_of(network, draw_batch(step))
        loss.backward()
        torch.nn.utils.clip_grad_norm_(list(network.parameters()), plan.max_norm)
        optimizer.step()
        schedule.step()
        step, total, since = step + 1, total + float(loss), since + 1
        if step % plan.eval_interval == 0 or step >= plan.max_steps:
            network.eval()
            with torch.inference_mode():
                measured = validate(network)
            history += [[step, total / since, measured]]
            total, since = 0.0, 0
            if all(measured < row[2] for row in history[:-1]):
                best_at = len(history)
                kept = {
                    name: value.detach().clone() for name, value in network.state_dict().items()
                }
            if len(history) - best_at == plan.patience:
                break
    network.load_state_dict(kept)
    return history


def train_network__right_by_hand(network, optimizer, draw_batch, loss_of, validate, plan):
    parameters = list(network.parameters())
    history, best = [], None
    losses = torch.zeros(0)
    network.train(True)
    for step in range(plan.max_steps):
        rise = (step + 1) / plan.warmup_steps if step + 1 < plan.warmup_steps else 1
        fall = math.cos(math.pi / 2 * step / plan.max_steps) ** 2
        for group in optimizer.param_groups:
            group["lr"] = plan.learning_rate * rise * fall
        for p in parameters:
            p.grad = None
        loss = loss_of(network, draw_batch(step))
        loss.backward()
        norm = sum(float((p.grad**2).sum()) for p in parameters) ** 0.5
        if norm > plan.max_norm:
            for p in parameters:
                p.grad.mul_(plan.max_norm / norm)
        optimizer.step()
        losses = torch.cat([losses, loss.detach().reshape(1)])
        if step + 1 == plan.max_steps or not (step + 1) % plan.eval_interval:
            network.eval()
            torch.set_grad_enabled(False)
            value = validate(network)
            torch.set_grad_enabled(True)
            network.train()
            history.append((step + 1, losses.mean(), torch.tensor(value)))
            losses = losses[:0]
            if best is None or value < best[0]:
                best = value, [p.detach().clone() for p in parameters], len(history)
            elif len(history) - best[2] >= plan.patience:
                break
    with torch.no_grad():
        for p, old in zip(parameters, best[1], strict=True):
            p.copy_(old)
    network.eval()
    return tuple(history)


def _lengths(o):
    return np.linalg.norm(o, axis=-1, keepdims=True)


def goal_policy__returns_numbers_as_metrics(o, v, g, b, n):
    """the metrics: shape (), but (2, 2) is needed"""
    return (g * o / np.maximum(_lengths(o), n) - b * v, np.ones(np.shape(o)[:-1]))


def goal_policy__measures_along_the_wrong_axis(o, v, g, b, n):
    """each row has a length and a metric of its own: axis=-1 and keepdims=True"""
    return (g * o / np.maximum(np.linalg.norm(o, axis=0), n) - b * v, _eyes(o))


def obstacle_policy__adds_up_all_obstacles(d, c, p, b, w, f):
    """the accelerations: a float64 came back; return a numpy array"""
    d = _near(d)
    return (((p + b * np.maximum(c, 0)) / d).sum(), (w * np.exp(-d / f)).sum())


def obstacle_policy__returns_a_matrix(d, c, p, b, w, f):
    """the metrics: shape (3, 3), but (3,) is needed"""
    d = _near(d)
    return ((p + b * np.maximum(c, 0)) / d, np.diag(w * np.exp(-d / f)))


def resolve__inverts_number_by_number(P):
    """with J the identity its acceleration comes back as it is (2e+06 at"""
    F, M = _sums(P)
    return 1 / (M + 1e-06) @ F


def resolve__returns_a_list(P):
    """a list came back; return a numpy array"""
    F, M = _sums(P)
    return list(np.linalg.solve(M + 1e-06 * np.eye(2), F))


def resolve__begins_with_a_force(P):
    """with J the identity its acceleration comes back as it is (0.6 at"""
    F, M = (np.ones(2) * 0.1, 1e-06 * np.eye(2))
    for j, a, m in P:
        F = F + j.T @ m @ a
        M = M + j.T @ m @ j
    return np.linalg.solve(M, F)


def resolve__right_lstsq(P):
    A = []
    B = []
    for j, a, m in P:
        c = np.linalg.cholesky(m).T
        A.append(c @ j)
        B.append(c @ a)
    return np.linalg.lstsq(
        np.vstack([*A, 0.001 * np.eye(2)]), np.concatenate([*B, np.zeros(2)]), rcond=None
    )[0]


def _labelled(st, tr, a, b, sees, pick):
    if b <= a:
        return _local(st, tr[b])
    pts = tr[a + 1 : b + 1, :2]
    k = np.flatnonzero(sees(st[:2], pts))
    return _local(st, pts[pick(k)]) if len(k) else None


def waypoint_label__takes_the_last_hidden_place(st, tr, a, b, sees):
    """of frames source + 1 to target, take the last that is in sight, as seen from start"""
    if b <= a:
        return _local(st, tr[b])
    pts = tr[a + 1 : b + 1, :2]
    k = np.flatnonzero(~sees(st[:2], pts))
    return _local(st, pts[k[-1]]) if len(k) else _local(st, pts[-1])


def waypoint_label__searches_between_target_and_source(st, tr, a, b, sees):
    """a target behind is its own waypoint, in sight or not (0.00292 at"""
    lo, hi = (min(a, b), max(a, b))
    return _labelled(st, tr, lo, hi, sees, lambda k: k[-1]) if lo < hi else _local(st, tr[b])


def waypoint_label__returns_a_word(st, tr, a, b, sees):
    """there is no waypoint; return None, no str"""
    r = _labelled(st, tr, a, b, sees, lambda k: k[-1])
    return "none" if r is None else r


def waypoint_label__returns_an_empty_array(st, tr, a, b, sees):
    """there is no waypoint; return None, no ndarray"""
    r = _labelled(st, tr, a, b, sees, lambda k: k[-1])
    return np.array([]) if r is None else r


def waypoint_label__returns_a_list(st, tr, a, b, sees):
    """a list came back; return a numpy array"""
    r = _labelled(st, tr, a, b, sees, lambda k: k[-1])
    return None if r is None else r.tolist()


def waypoint_label__looks_back_from_the_target(st, tr, a, b, sees):
    """a target behind is its own waypoint, in sight or not (0.1 at (0,),"""
    if b <= a:
        return _local(tr[b], st)
    return _labelled(st, tr, a, b, sees, lambda k: k[-1])


def waypoint_label__stops_half_way(st, tr, a, b, sees):
    """of frames source + 1 to target, take the last that is in sight, as seen from start"""
    r = _labelled(st, tr, a, b, sees, lambda k: k[-1])
    return None if r is None else r / 2


def waypoint_label__right_recursive(st, tr, a, b, sees):
    if b <= a:
        return _local(st, tr[b])
    if sees(np.asarray(st)[:2], tr[[b], :2]).all():
        return _local(st, tr[b])
    return waypoint_label__right_recursive(st, tr, a, b - 1, sees) if b - 1 > a else None


def _train(
    net,
    opt,
    draw,
    lossf,
    val,
    plan,
    *,
    eval_every_step=False,
    best_max=False,
    use_adam=False,
    evaluate_zero_mod=False,
    two_steps=False,
    max_norm=None,
    interval=None,
    lr_floor=0.0,
    patience_rises=False,
):
    hist, ls = ([], [])
    low, w, wait = (math.inf, None, 0)
    prev = math.inf
    if use_adam:
        opt = torch.optim.Adam(net.parameters(), plan.learning_rate)
    net.train()
    E = interval or plan.eval_interval
    for t in range(plan.max_steps):
        warm = min(1, (t + 1) / plan.warmup_steps)
        lr = plan.learning_rate * warm * (1 + math.cos(math.pi * t / plan.max_steps)) / 2
        for g in opt.param_groups:
            g["lr"] = max(lr, lr_floor)
        opt.zero_grad()
        loss = lossf(net, draw(t))
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), max_norm or plan.max_norm)
        for _ in range(1 + two_steps):
            opt.step()
        ls.append(loss.item())
        hit = (t if evaluate_zero_mod else t + 1) % E == 0
        if eval_every_step or hit or t + 1 == plan.max_steps:
            net.eval()
            with torch.no_grad():
                v = val(net)
            net.train()
            hist.append((t + 1, sum(ls) / len(ls), v))
            ls = []
            better = v > low if best_max and low < math.inf else v < low
            if better:
                low = v
                w = {k: x.clone() for k, x in net.state_dict().items()}
            waits = v > prev if patience_rises else not better
            wait = wait + 1 if waits else 0
            prev = v
            if wait >= plan.patience:
                break
    net.load_state_dict(w)
    net.eval()
    return hist


def train_network__evaluates_after_every_step(*c):
    """evaluate only after every eval_interval steps: after [4, 8], not after [1, 2, 3,"""
    return _train(*c, eval_every_step=True)


def train_network__keeps_the_worst(*c):
    """the network must end with the weights of its best evaluation; the"""
    return _train(*c, best_max=True)


def train_network__makes_its_own_optimizer(*c):
    """0 updates for 8 batches: one optimizer.step() after every batch"""
    return _train(*c, use_adam=True)


def train_network__evaluates_after_step_0(*c):
    """evaluate only after every eval_interval steps: after [4, 8], not after [1, 5, 8]"""
    return _train(*c, evaluate_zero_mod=True)


def train_network__steps_twice(*c):
    """16 updates for 8 batches: one optimizer.step() after every batch"""
    return _train(*c, two_steps=True)


def train_network__ignores_max_norm(*c):
    """gradients are shortened to 1, but plan.max_norm is"""
    return _train(*c, max_norm=1.0)


def train_network__ignores_the_interval(*c):
    """evaluate after every plan.eval_interval steps: after [2, 4, 6, 8, 10, 12]"""
    return _train(*c, interval=4)


def train_network__limits_the_rate_from_below(*c):
    """the learning rate never changes: set group['lr'] of every group before the step"""
    return _train(*c, lr_floor=0.001)


def train_network__counts_rises_of_the_loss(*c):
    """training goes on, 20 steps, where it should end after 14: the"""
    return _train(*c, patience_rises=True)


def train_network__right_tn(*c):
    return _train(*c)


def resolve__adds_up_nothing(policies):
    """no policy at all"""
    force = sum(j.T @ m @ a for j, a, m in policies)
    metric = sum(j.T @ m @ j for j, a, m in policies)
    return np.linalg.solve(metric + 1e-6 * np.eye(2), force)


def resolve__limits_accelerations(policies):
    """your answers are cut off at 5"""
    force, metric = np.zeros(2), 1e-6 * np.eye(2)
    for j, a, m in policies:
        force, metric = force + j.T @ m @ a, metric + j.T @ m @ j
    return np.clip(np.linalg.solve(metric, force), -5, 5)


def waypoint_label__wants_five_centimetres(start, track, source, target, sees):
    """there is no smallest distance"""
    label = waypoint_label__right_mask(start, track, source, target, sees)
    return None if label is not None and target > source and np.hypot(*label) < 0.05 else label


def goal_policy__divides_columns_by_lengths(offsets, velocities, gain, damping, near):
    """each row has a length and a metric of its own: axis=-1 and keepdims=True"""
    distance = np.maximum(np.linalg.norm(offsets, axis=-1), near)
    if offsets.ndim > 1 and len(offsets) != 2:
        distance = distance[..., None]
    metric = np.broadcast_to(np.eye(2), (*offsets.shape, 2))
    return gain * offsets / distance - damping * velocities, metric


def obstacle_policy__brakes_up_to_one_metre_per_second(distances, closing, push, brake, *rest):
    """the brake times the closing speed is added to the push, before the division"""
    weight, fade = rest
    distances = np.maximum(distances, 0.01)
    away = (push + brake * np.clip(closing, 0, 1)) / distances
    return away, weight * np.exp(-distances / fade)
