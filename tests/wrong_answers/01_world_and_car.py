"""Answers to notebook 01: the docstring of a wrong one is what the check must say of it."""

import numpy as np

EYE, WALL, SLOPE = 0.25, 1.0, np.tan(np.pi / 6)


def to_local__turns_the_wrong_way(pose, points):
    """turned the wrong way"""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return (points - pose[:2]) @ np.array([[cos, sin], [-sin, cos]])


def to_local__forgets_to_shift(pose, points):
    """subtract the robot's position"""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return points @ np.array([[cos, -sin], [sin, cos]])


def to_local__turns_before_it_shifts(pose, points):
    """shift first, then turn"""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return points @ np.array([[cos, -sin], [sin, cos]]) - pose[:2]


def to_local__takes_degrees(pose, points):
    """radians"""
    cos, sin = np.cos(np.deg2rad(pose[2])), np.sin(np.deg2rad(pose[2]))
    return (points - pose[:2]) @ np.array([[cos, -sin], [sin, cos]])


def to_local__answers_one_point(pose, points):
    """shape (2,), but (5, 2) is needed"""
    return to_local__right_by_complex_numbers(pose, points)[0]


def to_local__returns_a_list(pose, points):
    """return a numpy array"""
    return to_local__right_by_complex_numbers(pose, points).tolist()


def to_local__right_by_complex_numbers(pose, points):
    offset = (points - pose[:2]) @ np.array([1, 1j]) * np.exp(-1j * pose[2])
    return np.column_stack([offset.real, offset.imag])


def compose__adds_the_numbers(first, second):
    """turn its step by the first heading"""
    return _wrapped(first + second)


def compose__swaps_the_order(first, second):
    """the order is reversed"""
    return compose__right_by_matrices(second, first)


def compose__forgets_to_wrap(first, second):
    """wrap"""
    x, y, _ = compose__right_by_matrices(first, second)
    return np.array([x, y, first[2] + second[2]])


def compose__keeps_the_second_heading(first, second):
    """headings add up"""
    x, y, _ = compose__right_by_matrices(first, second)
    return np.array([x, y, second[2]])


def compose__changes_its_argument(first, second):
    """changes its argument 1"""
    first[:] = compose__right_by_matrices(first, second)
    return first


def compose__turns_the_wrong_way(first, second):
    """R itself"""
    x, y, _ = compose__right_by_matrices(first * [1, 1, -1], second)
    return np.array([x, y, compose__right_by_matrices(first, second)[2]])


def compose__turns_by_both_headings(first, second):
    """first heading alone"""
    x, y, _ = compose__right_by_matrices(np.add(first, [0, 0, second[2]]), second)
    return np.array([x, y, compose__right_by_matrices(first, second)[2]])


def compose__wraps_into_the_full_turn(first, second):
    """not 0 to 2 pi"""
    x, y, heading = compose__right_by_matrices(first, second)
    return np.array([x, y, heading % (2 * np.pi)])


def compose__right_by_matrices(first, second):
    product = _matrix(first) @ _matrix(second)
    return np.array([*product[:2, 2], np.arctan2(product[1, 0], product[0, 0])])


def bicycle_step__multiplies_by_the_wheelbase(pose, speed, steering, wheelbase, seconds):
    """divide by the wheelbase"""
    return _move(pose, speed, speed * np.tan(steering) * wheelbase, seconds)


def bicycle_step__forgets_the_tangent(pose, speed, steering, wheelbase, seconds):
    """tan"""
    return _move(pose, speed, speed * steering / wheelbase, seconds)


def bicycle_step__turns_on_the_spot(pose, speed, steering, wheelbase, seconds):
    """turns even when it stands"""
    return _move(pose, speed, np.tan(steering) / wheelbase, seconds)


def bicycle_step__forgets_the_time(pose, speed, steering, wheelbase, seconds):
    """times the seconds"""
    x, y, heading = _move(pose, speed, 0.0, seconds)
    return np.array([x, y, heading + speed * np.tan(steering) / wheelbase])


def bicycle_step__swaps_sine_and_cosine(pose, speed, steering, wheelbase, seconds):
    """cos belongs to x"""
    turn = speed * np.tan(steering) / wheelbase * seconds
    step = speed * seconds * np.array([np.sin(pose[2]), np.cos(pose[2]), 0.0])
    return pose + step + [0.0, 0.0, turn]


def bicycle_step__changes_its_argument(pose, speed, steering, wheelbase, seconds):
    """changes its argument 1"""
    pose += bicycle_step__right_by_euler(pose, speed, steering, wheelbase, seconds) - pose
    return pose


def bicycle_step__moves_where_the_wheels_point(pose, speed, steering, wheelbase, seconds):
    """not along heading + steering"""
    moved = _move(
        np.add(pose, [0, 0, steering]), speed, speed * np.tan(steering) / wheelbase, seconds
    )
    return moved - [0, 0, steering]


def bicycle_step__right_by_euler(pose, speed, steering, wheelbase, seconds):
    return _move(pose, speed, speed * np.tan(steering) / wheelbase, seconds)


def bicycle_step__right_on_the_arc(pose, speed, steering, wheelbase, seconds):
    x, y, heading = pose
    turn = speed * np.tan(steering) / wheelbase * seconds
    if abs(turn) < 1e-9:
        return _move(pose, speed, 0.0, seconds)
    radius = speed * seconds / turn
    dx = radius * (np.sin(heading + turn) - np.sin(heading))
    dy = radius * (np.cos(heading) - np.cos(heading + turn))
    return np.array([x + dx, y + dy, heading + turn])


def ray_segment__takes_the_wall_for_endless(origin, direction, start, end):
    """beyond its ends"""
    distance, _ = _meet(origin, direction, start, end)
    return distance if distance >= 0 else np.inf


def ray_segment__looks_backwards(origin, direction, start, end):
    """behind the robot"""
    distance, share = _meet(origin, direction, start, end)
    return abs(distance) if 0 <= share <= 1 else np.inf


def ray_segment__answers_the_place_on_the_wall(origin, direction, start, end):
    """how far along the wall"""
    distance, share = _meet(origin, direction, start, end)
    return share if 0 <= share <= 1 and distance >= 0 else np.inf


def ray_segment__divides_by_zero(origin, direction, start, end):
    """parallel"""
    run = end - start
    if direction[0] * run[1] == direction[1] * run[0]:
        return np.nan
    return ray_segment__right_by_a_linear_system(origin, direction, start, end)


def ray_segment__turns_the_wall_around(origin, direction, start, end):
    """inf, but 1.5 is right"""
    distance, share = _meet(origin, direction, start, end)
    return distance if 0 <= -share <= 1 and distance >= 0 else np.inf


def ray_segment__right_by_a_linear_system(origin, direction, start, end):
    system = np.column_stack([direction, start - end])
    if abs(np.linalg.det(system)) < 1e-12:
        return np.inf
    distance, share = np.linalg.solve(system, start - origin)
    return distance if distance >= 0 and 0 <= share <= 1 else np.inf


def wall_share__knows_no_half_pixels(depth, rows):
    """partly covered"""
    return np.round(wall_share__right_by_intervals(depth, rows))


def wall_share__stands_on_its_head(depth, rows):
    """row 0 is the top"""
    return wall_share__right_by_intervals(depth, rows)[::-1]


def wall_share__puts_the_eye_in_the_middle(depth, rows):
    """eye is 0.25 m above the floor"""
    return _share(0.5 / depth, -0.5 / depth, rows)


def wall_share__forgets_the_depth(depth, rows):
    """divide the heights by the depth"""
    return _share(WALL - EYE, -EYE, rows)


def wall_share__is_not_clipped(depth, rows):
    """between 0 and 1"""
    top, bottom, height = (WALL - EYE) / depth, -EYE / depth, 2 * SLOPE / rows
    upper = SLOPE - np.arange(rows) * height
    return (np.minimum(top, upper) - np.maximum(bottom, upper - height)) / height


def wall_share__forgets_the_eye(depth, rows):
    """0.75 m above the eye"""
    return _share(WALL / depth, -EYE / depth, rows)


def wall_share__right_by_intervals(depth, rows):
    return _share((WALL - EYE) / depth, -EYE / depth, rows)


def wall_share__right_by_many_small_rows(depth, rows):
    fine = SLOPE - (np.arange(rows * 4000) + 0.5) * 2 * SLOPE / (rows * 4000)
    inside = (fine < (WALL - EYE) / depth) & (fine > -EYE / depth)
    return inside.reshape(rows, 4000).mean(axis=1)


def _wrapped(pose):
    return np.array([pose[0], pose[1], (pose[2] + np.pi) % (2 * np.pi) - np.pi])


def _matrix(pose):
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[cos, -sin, pose[0]], [sin, cos, pose[1]], [0, 0, 1]])


def _move(pose, speed, turn_rate, seconds):
    step = speed * np.array([np.cos(pose[2]), np.sin(pose[2]), 0.0]) + [0.0, 0.0, turn_rate]
    return pose + step * seconds


def _meet(origin, direction, start, end):
    run, offset = end - start, start - origin
    across = direction[0] * run[1] - direction[1] * run[0]
    if abs(across) < 1e-12:
        return np.inf, np.inf
    distance = (offset[0] * run[1] - offset[1] * run[0]) / across
    return distance, (offset[0] * direction[1] - offset[1] * direction[0]) / across


def _share(top, bottom, rows):
    height = 2 * SLOPE / rows
    upper = SLOPE - np.arange(rows) * height
    return np.clip(np.minimum(top, upper) - np.maximum(bottom, upper - height), 0, height) / height
