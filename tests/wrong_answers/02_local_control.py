"""Answers to notebook 02: the docstring of a wrong one is what the check must say of it."""

import math
from copy import deepcopy
from dataclasses import replace

import numpy as np
import torch
from torch import nn


def goal_policy__pulls_harder_from_far_away(offsets, velocities, gain, damping, near):
    """divide the offset by its length"""
    return gain * offsets - damping * velocities, _identities(offsets)


def goal_policy__pushes_with_the_velocity(offsets, velocities, gain, damping, near):
    """it needs a minus"""
    return _pull(offsets, gain, near) + damping * velocities, _identities(offsets)


def goal_policy__forgets_the_damping(offsets, velocities, gain, damping, near):
    """the damping is missing"""
    return _pull(offsets, gain, near), _identities(offsets)


def goal_policy__never_fades(offsets, velocities, gain, damping, near):
    """within `near` the pull fades: divide by the distance or by `near`"""
    return _pull(offsets, gain, 1e-9) - damping * velocities, _identities(offsets)


def goal_policy__takes_one_length_for_all(offsets, velocities, gain, damping, near):
    """each offset has its own length"""
    pull = gain * offsets / max(np.linalg.norm(offsets), near)
    return pull - damping * velocities, _identities(offsets)


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


def obstacle_policy__holds_back_what_recedes(distances, closing, push, brake, weight, fade):
    """a receding obstacle only pushes"""
    return (push + brake * closing) / _limited(distances), _fading(distances, weight, fade)


def obstacle_policy__pulls_closer(distances, closing, push, brake, weight, fade):
    """it makes the distance grow"""
    away = (push + brake * np.maximum(closing, 0)) / _limited(distances)
    return -away, _fading(distances, weight, fade)


def obstacle_policy__divides_only_the_push(distances, closing, push, brake, weight, fade):
    """both divided by the distance"""
    away = push / _limited(distances) + brake * np.maximum(closing, 0)
    return away, _fading(distances, weight, fade)


def obstacle_policy__pushes_alike_at_any_distance(distances, closing, push, brake, weight, fade):
    """near obstacles push harder"""
    return push + brake * np.maximum(closing, 0), _fading(distances, weight, fade)


def obstacle_policy__divides_by_nothing(distances, closing, push, brake, weight, fade):
    """in the acceleration too, not only in the metric"""
    away = (push + brake * np.maximum(closing, 0)) / distances
    return away, weight * np.exp(-np.maximum(distances, 0.01) / fade)


def obstacle_policy__limits_nothing(distances, closing, push, brake, weight, fade):
    """0.01 m, in both"""
    away = (push + brake * np.maximum(closing, 0)) / distances
    return away, weight * np.exp(-distances / fade)


def obstacle_policy__limits_only_the_push(distances, closing, push, brake, weight, fade):
    """in the metric too"""
    away = (push + brake * np.maximum(closing, 0)) / _limited(distances)
    return away, weight * np.exp(-distances / fade)


def obstacle_policy__brakes_what_recedes(distances, closing, push, brake, weight, fade):
    """not the absolute value"""
    away = (push + brake * np.abs(closing)) / _limited(distances)
    return away, _fading(distances, weight, fade)


def obstacle_policy__limits_the_sum(distances, closing, push, brake, weight, fade):
    """limit the closing speed from below, not the sum"""
    away = np.maximum(push + brake * closing, 0) / _limited(distances)
    return away, _fading(distances, weight, fade)


def obstacle_policy__swaps_its_answers(distances, closing, push, brake, weight, fade):
    """give the accelerations first"""
    away = (push + brake * np.maximum(closing, 0)) / _limited(distances)
    return _fading(distances, weight, fade), away


def obstacle_policy__divides_only_the_brake(distances, closing, push, brake, weight, fade):
    """divide both terms by the distance"""
    away = push + brake * np.maximum(closing, 0) / _limited(distances)
    return away, _fading(distances, weight, fade)


def obstacle_policy__never_stops_caring(distances, closing, push, brake, weight, fade):
    """the metric fades with distance"""
    away = (push + brake * np.maximum(closing, 0)) / _limited(distances)
    return away, np.full(len(distances), weight)


def obstacle_policy__cares_more_for_the_far(distances, closing, push, brake, weight, fade):
    """the exponent is negative"""
    away = (push + brake * np.maximum(closing, 0)) / _limited(distances)
    return away, weight * np.exp(_limited(distances) / fade)


def obstacle_policy__right_one_by_one(distances, closing, push, brake, weight, fade):
    pairs = []
    for distance, speed in zip(distances, closing, strict=True):
        distance = distance if distance > 0.01 else 0.01
        force = push + brake * speed if speed > 0 else push
        pairs.append((force / distance, weight * np.e ** (-distance / fade)))
    away, metrics = np.array(pairs).T
    return away, metrics


def resolve__gives_the_force(policies):
    """that is the force"""
    return _sums(policies)[0]


def resolve__forgets_the_metrics(policies):
    """the metrics do not count"""
    force = sum(j.T @ a for j, a, _ in policies)
    metric = sum(j.T @ j for j, _, _ in policies)
    return np.linalg.solve(metric + 1e-6 * np.eye(2), force)


def resolve__forgets_the_metric_in_the_force(policies):
    """the force lacks the metric"""
    force = sum(j.T @ a for j, a, _ in policies)
    return np.linalg.solve(_sums(policies)[1] + 1e-6 * np.eye(2), force)


def resolve__averages(policies):
    """the result is their mean, weighted with the metrics"""
    return np.mean([np.linalg.pinv(j) @ a for j, a, _ in policies], axis=0)


def resolve__has_no_damping(policies):
    """no policy constrains one direction: add 1e-6 to the diagonal"""
    force, metric = _sums(policies)
    return np.linalg.solve(metric, force)


def resolve__solves_inside_the_loop(policies):
    """solve once, after the sums; do not add up what each policy wants"""
    wanted = np.zeros(2)
    for jacobian, acceleration, metric in policies:
        own = jacobian.T @ metric @ jacobian + 1e-6 * np.eye(2)
        wanted = wanted + np.linalg.solve(own, jacobian.T @ metric @ acceleration)
    return wanted


def resolve__forgets_the_jacobian(policies):
    """pull back with J"""
    force, total = np.zeros(2), 1e-6 * np.eye(2)
    for _, acceleration, metric in policies:
        force, total = force + metric @ acceleration, total + metric
    return np.linalg.solve(total, force)


def resolve__forgets_the_jacobian_of_the_force(policies):
    """pull back the force with J too"""
    force = sum(np.zeros(2) + m @ a for _, a, m in policies)
    return np.linalg.solve(_sums(policies)[1] + 1e-6 * np.eye(2), force)


def resolve__divides_by_the_number(policies):
    """the force is a sum, not a mean"""
    force, metric = _sums(policies)
    return np.linalg.solve(metric + 1e-6 * np.eye(2), force / len(policies))


def resolve__returns_inside_the_loop(policies):
    """is the return inside the loop?"""
    return resolve__right_by_least_squares(policies[:1])


def resolve__takes_a_pseudo_inverse(policies):
    """a pseudo-inverse leaves out the 1e-6"""
    force, metric = _sums(policies)
    return np.linalg.pinv(metric) @ force


def resolve__hears_only_the_last(policies):
    """only the last one counts"""
    return resolve__right_by_least_squares(policies[-1:])


def resolve__right_by_least_squares(policies):
    rows, wanted = [1e-3 * np.eye(2)], [np.zeros(2)]
    for jacobian, acceleration, metric in policies:
        values, vectors = np.linalg.eigh(metric)
        root = np.sqrt(np.maximum(values, 0))[:, None] * vectors.T
        rows.append(root @ jacobian)
        wanted.append(root @ acceleration)
    return np.linalg.lstsq(np.concatenate(rows), np.concatenate(wanted), rcond=None)[0]


def waypoint_label__always_takes_the_target(start, track, source, target, sees):
    """not in sight"""
    return _seen_from(start, track[target])


def waypoint_label__stays_in_the_world(start, track, source, target, sees):
    """as seen from the start"""
    if target <= source:
        return track[target, :2]
    places = track[source + 1 : target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
    return places[seen[-1]] if len(seen) else None


def waypoint_label__takes_the_nearest(start, track, source, target, sees):
    """take the farthest"""
    if target <= source:
        return _seen_from(start, track[target])
    places = track[source + 1 : target + 1]
    seen = np.flatnonzero(sees(start[:2], places[:, :2]))
    return _seen_from(start, places[seen[0]]) if len(seen) else None


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


def waypoint_label__takes_the_greatest_distance(start, track, source, target, sees):
    """not the one at the greatest distance"""
    if target <= source:
        return _seen_from(start, track[target])
    places = track[source + 1 : target + 1]
    seen = sees(start[:2], places[:, :2])
    far = np.linalg.norm(places[:, :2] - start[:2], axis=1) * seen
    return _seen_from(start, places[far.argmax()]) if seen.any() else None


def waypoint_label__looks_for_a_way_back(start, track, source, target, sees):
    """do not search the places in between"""
    first, last = min(source, target), max(source, target)
    places = track[first + 1 : last + 1]
    seen = np.flatnonzero(sees(start[:2], places[:, :2]))
    if target <= source:
        places = track[target : source + 1]
        seen = np.flatnonzero(sees(start[:2], places[:, :2]))
        return _seen_from(start, places[seen[0]])
    return _seen_from(start, places[seen[-1]]) if len(seen) else None


def waypoint_label__ignores_the_target(start, track, source, target, sees):
    """not beyond the target"""
    if target <= source:
        return _seen_from(start, track[target])
    return _last_in_sight(start, track[source + 1 :], start, sees)


def waypoint_label__has_no_case_for_a_target_behind(start, track, source, target, sees):
    """in sight: your code stops with IndexError"""
    places = track[source + 1 : target + 1]
    return _seen_from(start, places[np.flatnonzero(sees(start[:2], places[:, :2]))[-1]])


def waypoint_label__looks_for_a_target_behind(start, track, source, target, sees):
    """yours looks whether it is in sight"""
    first = target if target <= source else source + 1
    return _last_in_sight(start, track[first : target + 1], start, sees)


def waypoint_label__takes_only_a_target_before_the_source(start, track, source, target, sees):
    """target <= source"""
    if target < source:
        return _seen_from(start, track[target])
    return _last_in_sight(start, track[source + 1 : target + 1], start, sees)


def waypoint_label__takes_the_source_too(start, track, source, target, sees):
    """the place of source itself is no candidate"""
    if target <= source:
        return _seen_from(start, track[target])
    return _last_in_sight(start, track[source : target + 1], start, sees)


def waypoint_label__looks_from_the_source(start, track, source, target, sees):
    """look from the start"""
    if target <= source:
        return _seen_from(start, track[target])
    return _last_in_sight(start, track[source + 1 : target + 1], track[source], sees)


def waypoint_label__counts_from_the_start_of_the_track(start, track, source, target, sees):
    """count from the first candidate"""
    ok = np.flatnonzero(sees(start[:2], track[source + 1 : target + 1, :2]))
    return _seen_from(start, track[ok[-1]])


def waypoint_label__counts_so_and_stays_in_the_world(start, track, source, target, sees):
    """take the last that is in sight, as seen from start"""
    ok = np.flatnonzero(sees(start[:2], track[source + 1 : target + 1, :2]))
    return track[ok[-1], :2]


def waypoint_label__is_one_frame_early(start, track, source, target, sees):
    """one frame too early"""
    ok = np.flatnonzero(sees(start[:2], track[source + 1 : target + 1, :2]))
    return _seen_from(start, track[source + ok[-1]])


def waypoint_label__leaves_out_the_target(start, track, source, target, sees):
    """the target itself is a candidate too"""
    if target <= source:
        return _seen_from(start, track[target])
    return _last_in_sight(start, track[source + 1 : target], start, sees)


def waypoint_label__takes_the_last_of_nothing(start, track, source, target, sees):
    """there is no last place"""
    if target <= source:
        return _seen_from(start, track[target])
    places = track[source + 1 : target + 1]
    return _seen_from(start, places[np.flatnonzero(sees(start[:2], places[:, :2]))[-1]])


def waypoint_label__makes_one_up(start, track, source, target, sees):
    """return None, not the target"""
    found = waypoint_label__right_from_the_far_end(start, track, source, target, sees)
    return _seen_from(start, track[target]) if found is None else found


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


def _limited(distances):
    return np.maximum(distances, 0.01)


def _fading(distances, weight, fade):
    return weight * np.exp(-_limited(distances) / fade)


def _sums(policies):
    force = sum(j.T @ m @ a for j, a, m in policies)
    return force, sum(j.T @ m @ j for j, _, m in policies)


def _seen_from(start, place):
    offset = (place[0] - start[0]) + 1j * (place[1] - start[1])
    turned = offset * np.exp(-1j * start[2])
    return np.array([turned.real, turned.imag])


def _last_in_sight(start, places, origin, sees):
    seen = np.flatnonzero(sees(origin[:2], places[:, :2]))
    return _seen_from(start, places[seen[-1]]) if len(seen) else None


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


def goal_policy__takes_the_minimum(offsets, velocities, gain, damping, near):
    """divide by the larger of distance and `near`, not by the smaller"""
    d = np.linalg.norm(offsets, axis=-1, keepdims=True)
    return gain * offsets / np.minimum(d, near) - damping * velocities, _eyes(offsets)


def goal_policy__stops_within_near(offsets, velocities, gain, damping, near):
    """within `near` the pull fades evenly; it does not stop at once"""
    d = np.linalg.norm(offsets, axis=-1, keepdims=True)
    pull = np.where(d < near, 0.0, gain * offsets / np.maximum(d, 1e-9))
    return pull - damping * velocities, _eyes(offsets)


def goal_policy__damps_by_the_speed(offsets, velocities, gain, damping, near):
    """the velocity is damped component by component, not its length"""
    speed = np.linalg.norm(velocities, axis=-1, keepdims=True)
    return gain * _toward(offsets, near) - damping * speed, _eyes(offsets)


def goal_policy__puts_gain_and_damping_in_one_bracket(offsets, velocities, gain, damping, near):
    """only the pull is multiplied by the gain, only the velocity by the damping"""
    return (gain - damping) * _toward(offsets, near) - velocities, _eyes(offsets)


def goal_policy__pushes_away(offsets, velocities, gain, damping, near):
    """it pushes away from the goal: the offset runs from the point to its goal"""
    return -gain * _toward(offsets, near) - damping * velocities, _eyes(offsets)


def goal_policy__puts_the_gain_into_the_metric(offsets, velocities, gain, damping, near):
    """the metric is the identity itself; the gain does not belong in it"""
    return gain * _toward(offsets, near) - damping * velocities, gain * _eyes(offsets)


def goal_policy__fills_the_metric_with_ones(offsets, velocities, gain, damping, near):
    """the metric is the identity: ones on the diagonal only"""
    return gain * _toward(offsets, near) - damping * velocities, np.ones((*np.shape(offsets), 2))


def goal_policy__needs_rows(offsets, velocities, gain, damping, near):
    """your code stops with AxisError: axis 1 is out of bounds for array of dimension 1"""
    d = np.linalg.norm(offsets, axis=1)[:, None]
    return gain * offsets / np.maximum(d, near) - damping * velocities, _eyes(offsets)


def goal_policy__exchanges_its_answers(offsets, velocities, gain, damping, near):
    """the two are exchanged: give the accelerations first"""
    return _eyes(offsets), gain * _toward(offsets, near) - damping * velocities


def goal_policy__adds_up_components(offsets, velocities, gain, damping, near):
    """divide by the length of the offset, not by the sum of its components"""
    d = np.abs(offsets).sum(-1, keepdims=True)
    return gain * offsets / np.maximum(d, near) - damping * velocities, _eyes(offsets)


def goal_policy__changes_velocities(offsets, velocities, gain, damping, near):
    """your function changes its argument velocities"""
    velocities *= damping
    return gain * _toward(offsets, near) - velocities, _eyes(offsets)


def goal_policy__divides_by_the_square(offsets, velocities, gain, damping, near):
    """divide by the length of the offset, not by its square"""
    d = (offsets**2).sum(-1, keepdims=True)
    return gain * offsets / np.maximum(d, near) - damping * velocities, _eyes(offsets)


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


def obstacle_policy__begins_at_10_centimetres(distances, closing, push, brake, weight, fade):
    """the smallest distance is 0.01 m, 1 cm, not 10 cm"""
    d = np.maximum(distances, 0.1)
    return (push + brake * np.maximum(closing, 0)) / d, weight * np.exp(-d / fade)


def obstacle_policy__ignores_fade(distances, closing, push, brake, weight, fade):
    """another fade never changes your answer; it should"""
    d = _near(distances)
    return (push + brake * np.maximum(closing, 0)) / d, weight * np.exp(-d / 0.08)


def obstacle_policy__adds_a_centimetre(distances, closing, push, brake, weight, fade):
    """0.01 m is the smallest distance; it is not added to every distance"""
    d = distances + 0.01
    return (push + brake * np.maximum(closing, 0)) / d, weight * np.exp(-d / fade)


def obstacle_policy__divides_by_the_square(distances, closing, push, brake, weight, fade):
    """divide by the distance itself, not by its square"""
    d = _near(distances)
    return (push + brake * np.maximum(closing, 0)) / d**2, weight * np.exp(-d / fade)


def obstacle_policy__fades_with_the_square(distances, closing, push, brake, weight, fade):
    """the exponent is the distance divided by `fade`, not squared"""
    d = _near(distances)
    return (push + brake * np.maximum(closing, 0)) / d, weight * np.exp(-((d / fade) ** 2))


def obstacle_policy__brakes_only_what_recedes(distances, closing, push, brake, weight, fade):
    """the brake acts while the distance shrinks (closing > 0), not while it grows"""
    d = _near(distances)
    return (push + brake * np.maximum(-closing, 0)) / d, weight * np.exp(-d / fade)


def obstacle_policy__pushes_only_what_comes_nearer(distances, closing, push, brake, weight, fade):
    """an obstacle pushes even if it does not come nearer: only the brake depends on closing"""
    d = _near(distances)
    return np.where(closing > 0, push + brake * closing, 0) / d, weight * np.exp(-d / fade)


def obstacle_policy__takes_the_push_for_the_brake(distances, closing, push, brake, weight, fade):
    """the brake is missing its own factor: it is brake, not push, that multiplies closing"""
    d = _near(distances)
    return (push + push * np.maximum(closing, 0)) / d, weight * np.exp(-d / fade)


def obstacle_policy__takes_the_nearest_for_all(distances, closing, push, brake, weight, fade):
    """each obstacle has its own distance; do not use the nearest one's for all"""
    d = np.full_like(distances, _near(distances).min())
    return (push + brake * np.maximum(closing, 0)) / d, weight * np.exp(-d / fade)


def obstacle_policy__divides_the_metrics_by_their_sum(
    distances, closing, push, brake, weight, fade
):
    """each metric stands alone; do not divide them by their sum"""
    d = _near(distances)
    m = np.exp(-d / fade)
    return (push + brake * np.maximum(closing, 0)) / d, weight * m / m.sum()


def obstacle_policy__drops_the_sign_of_the_distance(distances, closing, push, brake, weight, fade):
    """a negative distance is nearer than 0.01 m too: np.maximum, not the absolute value"""
    d = np.maximum(np.abs(distances), 0.01)
    return (push + brake * np.maximum(closing, 0)) / d, weight * np.exp(-d / fade)


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


def obstacle_policy__takes_the_fastest_for_all(distances, closing, push, brake, weight, fade):
    """each obstacle has its own closing speed; do not use the largest for all"""
    d = _near(distances)
    return (push + brake * max(closing.max(), 0)) / d, weight * np.exp(-d / fade)


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


def resolve__adds_to_the_whole_matrix(policies):
    """1e-6 belongs to the diagonal only: 1e-6 * np.eye(2)"""
    f, m = _total(policies)
    return np.linalg.solve(m + 1e-6, f)


def resolve__adds_for_every_policy(policies):
    """with J the identity its acceleration comes back as it is (1.998 at"""
    f, m = _total(policies)
    return np.linalg.solve(m + 1e-3 * len(policies) * np.eye(2), f)


def resolve__exchanges_j_and_its_transpose(policies):
    """J and J^T are exchanged: force J^T M a and metric J^T M J"""
    f, m = np.zeros(2), 1e-6 * np.eye(2)
    for j, a, w in policies:
        if j.shape[0] == 2:
            f, m = f + j @ w @ a, m + j @ w @ j.T
        else:
            f, m = f + j.T @ w @ a, m + j.T @ w @ j
    return np.linalg.solve(m, f)


def resolve__counts_the_metric_twice(policies):
    """the metric M counts twice; it stands once in the force and once in the metric"""
    f, m = np.zeros(2), 1e-6 * np.eye(2)
    for j, a, w in policies:
        f, m = f + j.T @ w @ w @ a, m + j.T @ w @ w @ j
    return np.linalg.solve(m, f)


def resolve__multiplies_instead_of_solving(policies):
    """the force is multiplied by the metric; solve metric @ u = force instead"""
    f, m = _total(policies)
    return (m + 1e-6 * np.eye(2)) @ f


def resolve__solves_with_the_diagonal(policies):
    """the diagonal of the metric is not enough; solve with the whole 2 x 2 matrix"""
    f, m = _total(policies)
    return f / (np.diag(m) + 1e-6)


def resolve__skips_policies_of_one_row(policies):
    """a wall has one row: J is (1, 2), a is (1,) and M is (1, 1); the same"""
    f, m = _total([p for p in policies if p[0].shape[0] == 2])
    return np.linalg.solve(m + 1e-6 * np.eye(2), f)


def resolve__adds_the_first_two_only(policies):
    """sum over all policies; only the first two count in yours"""
    f, m = _total(policies[:2])
    return np.linalg.solve(m + 1e-6 * np.eye(2), f)


def resolve__uses_the_diagonal_of_m(policies):
    """M is a whole matrix, not only its diagonal"""
    f, m = np.zeros(2), 1e-6 * np.eye(2)
    for j, a, w in policies:
        d = np.diag(np.diag(w))
        f, m = f + j.T @ d @ a, m + j.T @ d @ j
    return np.linalg.solve(m, f)


def resolve__returns_a_column(policies):
    """shape (2, 1), but (2,) is needed"""
    f, m = _total(policies)
    return np.linalg.solve(m + 1e-6 * np.eye(2), f[:, None])


def resolve__gives_up_where_a_direction_is_free(policies):
    """no policy constrains one direction: add 1e-6 to the diagonal (0 at"""
    f, m = _total(policies)
    if abs(np.linalg.det(m)) < 1e-3:
        return np.zeros(2)
    return np.linalg.solve(m, f)


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


def waypoint_label__counts_the_places_in_sight(start, track, source, target, sees):
    """the number of places in sight is no index: some before the last one may be hidden"""
    if target <= source:
        return _local(start, track[target])
    places = track[source + 1 : target + 1, :2]
    count = int(sees(start[:2], places).sum())
    return _local(start, places[count - 1]) if count else None


def waypoint_label__turns_the_wrong_way(start, track, source, target, sees):
    """turned the wrong way: to_local"""
    right = waypoint_label__right_backwards(start, track, source, target, sees)
    if right is None:
        return None
    return _local(start * [1, 1, -1], start[:2] + _world(start, right))


def _world(start, local):
    c, s = np.cos(start[2]), np.sin(start[2])
    return np.array([c * local[0] - s * local[1], s * local[0] + c * local[1]])


def waypoint_label__points_y_to_the_right(start, track, source, target, sees):
    """y points to the right here; it must be positive to the left: to_local"""
    right = waypoint_label__right_backwards(start, track, source, target, sees)
    return None if right is None else right * [1, -1]


def waypoint_label__answers_as_seen_from_the_source(start, track, source, target, sees):
    """as seen from the pose of frame `source`; it must be as seen from the start: to_local"""
    if target <= source:
        return _local(track[source], track[target])
    places = track[source + 1 : target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
    return _local(track[source], places[seen[-1]]) if len(seen) else None


def waypoint_label__searches_from_the_first_frame(start, track, source, target, sees):
    """nothing is in sight, so there is no last place; return None"""
    if target <= source:
        return _local(start, track[target])
    places = track[: target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
    return _local(start, places[seen[-1]]) if len(seen) else None


def waypoint_label__has_no_label_for_a_target_behind(start, track, source, target, sees):
    """a target behind is its own waypoint, in sight or not; yours gives"""
    if target <= source:
        return None
    return waypoint_label__right_backwards(start, track, source, target, sees)


def waypoint_label__returns_the_source_for_a_target_behind(start, track, source, target, sees):
    """a target behind is its own waypoint, in sight or not; yours gives the"""
    if target <= source:
        return _local(start, track[source])
    return waypoint_label__right_backwards(start, track, source, target, sees)


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


def waypoint_label__takes_the_source_for_a_candidate(start, track, source, target, sees):
    """the place of source itself is no candidate, and a target at the"""
    if target < source:
        return _local(start, track[target])
    places = track[source : target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
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


def goal_policy__rounds_the_length(o, v, g, b, n):
    """divide by the larger of length and `near`; far away `near` must not matter"""
    return (g * o / np.sqrt(_lengths(o) ** 2 + n**2) - b * v, _eyes(o))


def goal_policy__does_not_divide_within_near(o, v, g, b, n):
    """within `near` the pull is gain * offset / near; it is not divided by `near`"""
    return (
        np.where(_lengths(o) < n, g * o, g * o / np.maximum(_lengths(o), 1e-09)) - b * v,
        _eyes(o),
    )


def goal_policy__multiplies_the_damping_by_the_gain(o, v, g, b, n):
    """the damping does not belong inside the pull: the gain multiplies the pull alone"""
    return (g * (o / np.maximum(_lengths(o), n) - b * v), _eyes(o))


def goal_policy__divides_by_the_damping(o, v, g, b, n):
    """the velocity is multiplied by the damping, not divided by it"""
    return (g * o / np.maximum(_lengths(o), n) - v / b, _eyes(o))


def goal_policy__returns_numbers_as_metrics(o, v, g, b, n):
    """the metrics: shape (), but (2, 2) is needed"""
    return (g * o / np.maximum(_lengths(o), n) - b * v, np.ones(np.shape(o)[:-1]))


def goal_policy__puts_the_damping_into_the_metric(o, v, g, b, n):
    """the metric is the identity itself; the damping does not belong in it"""
    return (g * o / np.maximum(_lengths(o), n) - b * v, b * _eyes(o))


def goal_policy__weighs_only_the_direction_to_the_goal(o, v, g, b, n):
    """the metric weighs all directions equally, not only the one to the goal"""
    u = o / np.maximum(_lengths(o), 1e-09)
    return (g * o / np.maximum(_lengths(o), n) - b * v, u[..., :, None] * u[..., None, :])


def goal_policy__measures_along_the_wrong_axis(o, v, g, b, n):
    """each row has a length and a metric of its own: axis=-1 and keepdims=True"""
    return (g * o / np.maximum(np.linalg.norm(o, axis=0), n) - b * v, _eyes(o))


def goal_policy__damps_by_the_square(o, v, g, b, n):
    """the damping grows with the velocity itself, not with its square"""
    return (g * o / np.maximum(_lengths(o), n) - b * v * _lengths(v), _eyes(o))


def obstacle_policy__takes_the_minimum(d, c, p, b, w, f):
    """limit the distances from below: np.maximum(distances, 0.01), not np.minimum"""
    d = np.minimum(d, 0.01)
    return ((p + b * np.maximum(c, 0)) / d, w * np.exp(-d / f))


def obstacle_policy__begins_at_a_millimetre(d, c, p, b, w, f):
    """the smallest distance is 0.01 m, 1 cm, not 1 mm"""
    d = np.maximum(d, 0.001)
    return ((p + b * np.maximum(c, 0)) / d, w * np.exp(-d / f))


def obstacle_policy__exchanges_push_and_brake(d, c, p, b, w, f):
    """`push` and `brake` are exchanged: it is the brake that multiplies closing"""
    d = _near(d)
    return ((b + p * np.maximum(c, 0)) / d, w * np.exp(-d / f))


def obstacle_policy__exchanges_weight_and_fade(d, c, p, b, w, f):
    """`weight` and `fade` are exchanged: weight * exp(-distance / fade)"""
    d = _near(d)
    return ((p + b * np.maximum(c, 0)) / d, f * np.exp(-d / w))


def obstacle_policy__takes_powers_of_two(d, c, p, b, w, f):
    """the metric falls by the factor e every `fade` metres: np.exp, not powers of 2"""
    d = _near(d)
    return ((p + b * np.maximum(c, 0)) / d, w * 2 ** (-d / f))


def obstacle_policy__fades_along_a_line(d, c, p, b, w, f):
    """the metric fades exponentially, np.exp, not along a straight line"""
    d = _near(d)
    return ((p + b * np.maximum(c, 0)) / d, w * np.maximum(0, 1 - d / f))


def obstacle_policy__squares_the_closing_speed(d, c, p, b, w, f):
    """the brake multiplies the closing speed itself, not its square"""
    d = _near(d)
    return ((p + b * np.maximum(c, 0) ** 2) / d, w * np.exp(-d / f))


def obstacle_policy__adds_up_all_obstacles(d, c, p, b, w, f):
    """the accelerations: a float64 came back; return a numpy array"""
    d = _near(d)
    return (((p + b * np.maximum(c, 0)) / d).sum(), (w * np.exp(-d / f)).sum())


def obstacle_policy__returns_a_matrix(d, c, p, b, w, f):
    """the metrics: shape (3, 3), but (3,) is needed"""
    d = _near(d)
    return ((p + b * np.maximum(c, 0)) / d, np.diag(w * np.exp(-d / f)))


def obstacle_policy__weighs_its_acceleration(d, c, p, b, w, f):
    """the acceleration is not weighted with the metric here; `resolve` does that"""
    d = _near(d)
    m = w * np.exp(-d / f)
    return (m * (p + b * np.maximum(c, 0)) / d, m)


def resolve__inverts_number_by_number(P):
    """with J the identity its acceleration comes back as it is (2e+06 at"""
    F, M = _sums(P)
    return 1 / (M + 1e-06) @ F


def resolve__turns_the_force_around(P):
    """the sign is wrong: solve metric @ u = force, without a minus"""
    F, M = _sums(P)
    return -np.linalg.solve(M + 1e-06 * np.eye(2), F)


def resolve__returns_a_list(P):
    """a list came back; return a numpy array"""
    F, M = _sums(P)
    return list(np.linalg.solve(M + 1e-06 * np.eye(2), F))


def resolve__keeps_only_the_last_metric(P):
    """sum the metrics of all policies; only the last one counts in yours"""
    F = np.zeros(2)
    for j, a, m in P:
        F = F + j.T @ m @ a
        M = j.T @ m @ j
    return np.linalg.solve(M + 1e-06 * np.eye(2), F)


def resolve__keeps_only_the_last_force(P):
    """sum the forces of all policies; only the last one counts in yours"""
    M = np.zeros((2, 2))
    for j, a, m in P:
        F = j.T @ m @ a
        M = M + j.T @ m @ j
    return np.linalg.solve(M + 1e-06 * np.eye(2), F)


def resolve__adds_one_to_the_diagonal(P):
    """what you add to the diagonal must be 1e-6; 1 slows every policy down"""
    F, M = _sums(P)
    return np.linalg.solve(M + np.eye(2), F)


def resolve__hears_only_the_heaviest(P):
    """sum over all policies; only the one with the largest metric counts in yours"""
    j, a, m = max(P, key=lambda p: np.trace(p[2]))
    return np.linalg.solve(j.T @ m @ j + 1e-06 * np.eye(2), j.T @ m @ a)


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


def waypoint_label__takes_the_last_but_one(st, tr, a, b, sees):
    """that is the last place in sight but one; take the last"""
    return _labelled(st, tr, a, b, sees, lambda k: k[-2] if len(k) > 1 else k[-1])


def waypoint_label__takes_the_first_in_sight(st, tr, a, b, sees):
    """that is the first place in sight, or the first of all; take the last in sight"""
    if b <= a:
        return _local(st, tr[b])
    pts = tr[a + 1 : b + 1, :2]
    return _local(st, pts[np.argmax(sees(st[:2], pts))])


def waypoint_label__takes_the_last_hidden_place(st, tr, a, b, sees):
    """of frames source + 1 to target, take the last that is in sight, as seen from start"""
    if b <= a:
        return _local(st, tr[b])
    pts = tr[a + 1 : b + 1, :2]
    k = np.flatnonzero(~sees(st[:2], pts))
    return _local(st, pts[k[-1]]) if len(k) else _local(st, pts[-1])


def waypoint_label__takes_the_nearest_to_the_target(st, tr, a, b, sees):
    """the last place along the trajectory counts, not the one nearest to the target in metres"""
    if b <= a:
        return _local(st, tr[b])
    pts = tr[a + 1 : b + 1, :2]
    k = np.flatnonzero(sees(st[:2], pts))
    if not len(k):
        return None
    return _local(st, pts[k[np.argmin(np.linalg.norm(pts[k] - tr[b, :2], axis=1))]])


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


def waypoint_label__forgets_the_source_s_own_frame(st, tr, a, b, sees):
    """a target at the source's own frame is its own waypoint too: target <= source"""
    if b < a - 1:
        return _local(st, tr[b])
    return _labelled(st, tr, a, b, sees, lambda k: k[-1]) if b > a else None


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
    accum=False,
    step_before=False,
    eval_every_step=False,
    best_max=False,
    early_first=False,
    use_adam=False,
    no_step=False,
    clip_before=False,
    detach=False,
    evaluate_zero_mod=False,
    restore_first=False,
    mean_hist=True,
    two_steps=False,
    loss_twice=False,
    max_norm_fixed=None,
    interval_fixed=None,
    lr_floor=0.0,
    patience_rises=False,
    stop_le=False,
):
    hist, ls = ([], [])
    low, w, wait = (math.inf, None, 0)
    prev = math.inf
    if use_adam:
        opt = torch.optim.Adam(net.parameters(), plan.learning_rate)
    net.train()
    E = interval_fixed or plan.eval_interval
    for t in range(plan.max_steps):
        lr = (
            plan.learning_rate
            * min(1, (t + 1) / plan.warmup_steps)
            * (1 + math.cos(math.pi * t / plan.max_steps))
            / 2
        )
        for g in opt.param_groups:
            g["lr"] = max(lr, lr_floor)
        opt.zero_grad()
        batch = draw(t)
        loss = lossf(net, batch)
        if loss_twice:
            loss = lossf(net, batch)
        if step_before:
            opt.step()
        if clip_before:
            torch.nn.utils.clip_grad_norm_(net.parameters(), plan.max_norm)
        loss.backward()
        if not clip_before:
            torch.nn.utils.clip_grad_norm_(net.parameters(), max_norm_fixed or plan.max_norm)
        if not step_before and (not no_step):
            opt.step()
        if two_steps:
            opt.step()
        ls.append(loss.item())
        hit = t % E == 0 if evaluate_zero_mod else (t + 1) % E == 0
        if eval_every_step or hit or t + 1 == plan.max_steps:
            net.eval()
            with torch.no_grad():
                v = val(net)
            net.train()
            hist.append((t + 1, sum(ls) / len(ls), v))
            ls = []
            if patience_rises:
                wait = wait + 1 if v > prev else 0
                prev = v
                if v < low:
                    low = v
                    w = {k: x.clone() for k, x in net.state_dict().items()}
            elif v > low if best_max and low < math.inf else v < low:
                low = v
                w = {k: x.clone() for k, x in net.state_dict().items()}
                wait = 0
            else:
                wait += 1
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
    return _train(*c, max_norm_fixed=1.0)


def train_network__ignores_the_interval(*c):
    """evaluate after every plan.eval_interval steps: after [2, 4, 6, 8, 10, 12]"""
    return _train(*c, interval_fixed=4)


def train_network__limits_the_rate_from_below(*c):
    """the learning rate never changes: set group['lr'] of every group before the step"""
    return _train(*c, lr_floor=0.001)


def train_network__counts_rises_of_the_loss(*c):
    """training goes on, 20 steps, where it should end after 14: the"""
    return _train(*c, patience_rises=True)


def train_network__right_tn(*c):
    return _train(*c)


def goal_policy__damps_within_near_only(offsets, velocities, gain, damping, near):
    """the damping acts everywhere, not only within `near`"""
    close_by = np.linalg.norm(offsets, axis=-1, keepdims=True) < near
    return _pull(offsets, gain, near) - damping * velocities * close_by, _identities(offsets)


def goal_policy__damps_far_away_only(offsets, velocities, gain, damping, near):
    """the damping acts everywhere, not only farther away"""
    far = np.linalg.norm(offsets, axis=-1, keepdims=True) >= near
    return _pull(offsets, gain, near) - damping * velocities * far, _identities(offsets)


def goal_policy__damps_along_the_way(offsets, velocities, gain, damping, near):
    """works against the whole velocity"""
    speed = np.linalg.norm(velocities, axis=-1, keepdims=True)
    return _pull(offsets, 1.0, near) * (gain - damping * speed), _identities(offsets)


def resolve__adds_a_millionth_for_every_policy(policies):
    """1e-6 is added once, to the sum"""
    force, metric = np.zeros(2), np.zeros((2, 2))
    for j, a, m in policies:
        force, metric = force + j.T @ m @ a, metric + j.T @ m @ j + 1e-6 * np.eye(2)
    return np.linalg.solve(metric, force) if policies else force


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
