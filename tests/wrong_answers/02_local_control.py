"""Answers to notebook 02: the docstring of a wrong one is what the check must say of it."""

import numpy as np


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
    """within `near` the pull fades"""
    return _pull(offsets, gain, 1e-9) - damping * velocities, _identities(offsets)


def goal_policy__takes_one_length_for_all(offsets, velocities, gain, damping, near):
    """each offset has its own length"""
    pull = gain * offsets / max(np.linalg.norm(offsets), near)
    return pull - damping * velocities, _identities(offsets)


def goal_policy__gives_one_metric_for_all(offsets, velocities, gain, damping, near):
    """metrics of four points: shape (2, 2), but (4, 2, 2) is needed"""
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
    """do not average"""
    return np.mean([np.linalg.pinv(j) @ a for j, a, _ in policies], axis=0)


def resolve__has_no_damping(policies):
    """no policy constrains one direction: add 1e-6 to the diagonal"""
    force, metric = _sums(policies)
    return np.linalg.solve(metric, force)


def resolve__solves_inside_the_loop(policies):
    """solve once, after the sums; do not add up"""
    wanted = np.zeros(2)
    for jacobian, acceleration, metric in policies:
        own = jacobian.T @ metric @ jacobian + 1e-6 * np.eye(2)
        wanted = wanted + np.linalg.solve(own, jacobian.T @ metric @ acceleration)
    return wanted


def resolve__solves_inside_the_loop_undamped(policies):
    """solve once, after the sums: one policy alone"""
    return np.mean([np.linalg.solve(*_sums([policy])[::-1]) for policy in policies], axis=0)


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


def resolve__right_by_pinv(policies):
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
    """do not stop at the first hidden one"""
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
    """in sight: a target behind is its own waypoint, in sight or not"""
    places = track[source + 1 : target + 1]
    return _seen_from(start, places[np.flatnonzero(sees(start[:2], places[:, :2]))[-1]])


def waypoint_label__looks_for_a_target_behind(start, track, source, target, sees):
    """hidden: a target behind is its own waypoint, in sight or not"""
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
    """places[seen[-1]]; and give it as seen from the start"""
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
    """there is no waypoint"""
    found = waypoint_label__right_from_the_far_end(start, track, source, target, sees)
    return _seen_from(start, track[target]) if found is None else found


def waypoint_label__right_from_the_far_end(start, track, source, target, sees):
    if target <= source:
        return _seen_from(start, track[target])
    for frame in range(target, source, -1):
        if sees(start[:2], track[frame : frame + 1, :2])[0]:
            return _seen_from(start, track[frame])
    return None


def split_first_layer__forgets_the_difference(weights):
    """it belongs to both halves"""
    return weights[:, :3], weights[:, 3:6]


def split_first_layer__adds_it_twice(weights):
    """tgt enters the difference with a minus"""
    return weights[:, :3] + weights[:, 6:], weights[:, 3:6] + weights[:, 6:]


def split_first_layer__swaps_the_halves(weights):
    """cur comes first"""
    return split_first_layer__right_by_a_matrix(weights)[::-1]


def split_first_layer__takes_every_third_channel(weights):
    """the channels are stacked"""
    own, other, difference = (weights[:, i::3] for i in range(3))
    return own + difference, other - difference


def split_first_layer__keeps_only_the_difference_for_tgt(weights):
    """only D changes its sign"""
    return weights[:, :3] + weights[:, 6:], -weights[:, 6:]


def split_first_layer__splits_the_filters(weights):
    """weights for cur: shape"""
    own, other, _ = np.array_split(weights, 3, axis=0)
    return own, other


def split_first_layer__right_by_a_matrix(weights):
    # Nine channels as a linear map of the six of both pictures.
    stack = np.zeros((9, 6))
    for channel in range(3):
        stack[channel, channel] = stack[3 + channel, 3 + channel] = 1.0
        stack[6 + channel, channel], stack[6 + channel, 3 + channel] = 1.0, -1.0
    both = np.einsum("fchw,cd->fdhw", weights, stack)
    return both[:, :3], both[:, 3:]


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
