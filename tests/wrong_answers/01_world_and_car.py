"""Answers to notebook 01: the docstring of a wrong one is what the check must say of it."""

import math

import numpy as np

EYE, WALL, SLOPE = 0.25, 1.0, np.tan(np.pi / 6)


def to_local__answers_one_point(pose, points):
    """shape (2,), but (5, 2) is needed"""
    return to_local__right_by_complex_numbers(pose, points)[0]


def to_local__returns_a_list(pose, points):
    """return a numpy array"""
    return to_local__right_by_complex_numbers(pose, points).tolist()


def to_local__right_by_complex_numbers(pose, points):
    offset = (points - pose[:2]) @ np.array([1, 1j]) * np.exp(-1j * pose[2])
    return np.column_stack([offset.real, offset.imag])


def compose__changes_its_argument(first, second):
    """your function changes its argument first"""
    first[:] = compose__right_by_matrices(first, second)
    return first


def compose__right_by_matrices(first, second):
    product = _matrix(first) @ _matrix(second)
    return np.array([*product[:2, 2], np.arctan2(product[1, 0], product[0, 0])])


def bicycle_step__changes_its_argument(pose, speed, steering, wheelbase, seconds):
    """your function changes its argument pose"""
    pose += bicycle_step__right_by_euler(pose, speed, steering, wheelbase, seconds) - pose
    return pose


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


def ray_segment__divides_by_zero(origin, direction, start, end):
    """parallel"""
    run = end - start
    if direction[0] * run[1] == direction[1] * run[0]:
        return np.nan
    return ray_segment__right_by_a_linear_system(origin, direction, start, end)


def ray_segment__right_by_a_linear_system(origin, direction, start, end):
    system = np.column_stack([direction, start - end])
    if abs(np.linalg.det(system)) < 1e-12:
        return np.inf
    distance, share = np.linalg.solve(system, start - origin)
    return distance if distance >= 0 and 0 <= share <= 1 else np.inf


def wall_share__right_by_intervals(depth, rows):
    return _share((WALL - EYE) / depth, -EYE / depth, rows)


def wall_share__right_by_many_small_rows(depth, rows):
    fine = SLOPE - (np.arange(rows * 4000) + 0.5) * 2 * SLOPE / (rows * 4000)
    inside = (fine < (WALL - EYE) / depth) & (fine > -EYE / depth)
    return inside.reshape(rows, 4000).mean(axis=1)


def _matrix(pose):
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[cos, -sin, pose[0]], [sin, cos, pose[1]], [0, 0, 1]])


def _move(pose, speed, turn_rate, seconds):
    step = speed * np.array([np.cos(pose[2]), np.sin(pose[2]), 0.0]) + [0.0, 0.0, turn_rate]
    return pose + step * seconds


def _share(top, bottom, rows):
    height = 2 * SLOPE / rows
    upper = SLOPE - np.arange(rows) * height
    return np.clip(np.minimum(top, upper) - np.maximum(bottom, upper - height), 0, height) / height


def to_local__answers_the_first_point_only(pose, points):
    """shape (1, 2), but (5, 2) is needed"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = points[0] - pose[:2]
    return np.array([[c * dx + s * dy, c * dy - s * dx]])


def to_local__returns_columns(pose, points):
    """shape (2, 5), but (5, 2) is needed"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = (points - pose[:2]).T
    return np.array([c * dx + s * dy, c * dy - s * dx])


def to_local__drops_an_axis(pose, points):
    """shape (2,), but (1, 2) is needed"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = (points - pose[:2]).T
    return np.stack([c * dx + s * dy, c * dy - s * dx], axis=1).squeeze()


def to_local__changes_the_points(pose, points):
    """your function changes its argument points"""
    points -= pose[:2]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return points @ np.array([[c, -s], [s, c]])


def to_local__rounds(pose, points):
    """your answers are rounded to 2 digits"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.round((points - pose[:2]) @ np.array([[c, -s], [s, c]]), 2)


def to_local__subtracts_x_from_both(pose, points):
    """this needs only the shift: subtract x from x and y from y (-2.142 at"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return (points - pose[0]) @ np.array([[c, -s], [s, c]])


def to_local__right_loop(pose, points):
    rows = []
    for x, y in points:
        distance = math.hypot(x - pose[0], y - pose[1])
        angle = math.atan2(y - pose[1], x - pose[0]) - pose[2]
        rows.append([distance * math.cos(angle), distance * math.sin(angle)])
    return np.array(rows)


def to_local__right_complex(pose, points):
    z = (points[:, 0] - pose[0] + 1j * (points[:, 1] - pose[1])) * np.exp(-1j * pose[2])
    return np.column_stack([z.real, z.imag])


def compose__returns_a_list(first, second):
    """a list came back; return a numpy array"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = (first[2] + second[2] + np.pi) % (2 * np.pi) - np.pi
    return [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]


def compose__right_matrices(first, second):
    def matrix(p):
        c, s = np.cos(p[2]), np.sin(p[2])
        return np.array([[c, -s, p[0]], [s, c, p[1]], [0, 0, 1]])

    m = matrix(first) @ matrix(second)
    return np.array([m[0, 2], m[1, 2], np.arctan2(m[1, 0], m[0, 0])])


def compose__right_ifs(first, second):
    x, y, a = (float(v) for v in first)
    u, v, b = (float(w) for w in second)
    total = a + b
    if total > math.pi:
        total -= 2 * math.pi
    elif total < -math.pi:
        total += 2 * math.pi
    z = complex(x, y) + complex(u, v) * complex(math.cos(a), math.sin(a))
    return np.array([z.real, z.imag, total])


def bicycle_step__ignores_the_seconds(pose, speed, steering, wheelbase, seconds):
    """another seconds never changes your answer; it should"""
    x, y, h = pose
    seconds = 0.1
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            h + speed * np.tan(steering) / wheelbase * seconds,
        ]
    )


def bicycle_step__returns_a_list(pose, speed, steering, wheelbase, seconds):
    """a list came back; return a numpy array"""
    x, y, h = pose
    return [
        x + speed * np.cos(h) * seconds,
        y + speed * np.sin(h) * seconds,
        h + speed * np.tan(steering) / wheelbase * seconds,
    ]


def bicycle_step__divides_by_zero_on_straights(pose, speed, steering, wheelbase, seconds):
    """with straight wheels the heading stays, and x grows by speed times"""
    x, y, h = pose
    r = wheelbase / np.tan(steering)
    n = h + speed / r * seconds
    return np.array([x + r * (np.sin(n) - np.sin(h)), y - r * (np.cos(n) - np.cos(h)), n])


def bicycle_step__right_turn_only_if_moving_forward(pose, speed, steering, wheelbase, seconds):
    x, y, heading = map(float, pose)
    rate = speed * math.tan(steering) / wheelbase
    if abs(rate) < 1e-9:
        return np.array(
            [
                x + speed * seconds * math.cos(heading),
                y + speed * seconds * math.sin(heading),
                heading,
            ]
        )
    r, new = speed / rate, heading + rate * seconds
    return np.array(
        [
            x + r * (math.sin(new) - math.sin(heading)),
            y + r * (math.cos(heading) - math.cos(new)),
            new,
        ]
    )


def bicycle_step__right_vector(pose, speed, steering, wheelbase, seconds):
    d = np.array([np.cos(pose[2]), np.sin(pose[2]), np.tan(steering) / wheelbase])
    new = pose + speed * seconds * d
    new[2] = np.arctan2(np.sin(new[2]), np.cos(new[2]))
    return new


def cross(p, q):
    return p[0] * q[1] - p[1] * q[0]


def _tu(o, d, a, b):
    w = b - a
    n = cross(d, w)
    return cross(a - o, w) / n, cross(a - o, d) / n


def _parallel(d, a, b):
    return abs(cross(d, b - a)) < 1e-12


def ray_segment__sees_walls_from_one_side_only(origin, direction, start, end):
    """which end is the start does not matter: the denominator may be negative"""
    if cross(direction, end - start) < 1e-12:
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__takes_slanted_walls_for_parallel(origin, direction, start, end):
    """a small denominator is not zero: only what is below 1e-12 counts as parallel"""
    if abs(cross(direction, end - start)) < 0.05:
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__ends_at_20_metres(origin, direction, start, end):
    """the function has no largest range: far hits count, too (inf came"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if 0 <= t <= 20 and 0 <= u <= 1 else np.inf


def ray_segment__returns_none(origin, direction, start, end):
    """nothing came back; a ray that misses returns np.inf"""
    if _parallel(direction, start, end):
        return None
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and 0 <= u <= 1 else None


def ray_segment__returns_the_point(origin, direction, start, end):
    """a point came back; return how far away it is, one number"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return origin + t * direction if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__divides_by_a_singular_matrix(origin, direction, start, end):
    """your code stops with LinAlgError"""
    matrix = np.column_stack([direction, start - end])
    t, u = np.linalg.solve(matrix, start - origin)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__measures_to_the_nearest_end(origin, direction, start, end):
    """solve for t and u by the two fractions above; t is the answer (1.953"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    if t < 0 or not 0 <= u <= 1:
        return np.inf
    return min(np.linalg.norm(start - origin), np.linalg.norm(end - origin))


def ray_segment__changes_its_arguments(origin, direction, start, end):
    """your function changes its argument start"""
    end -= start
    start -= origin
    n = cross(direction, end)
    if abs(n) < 1e-12:
        return np.inf
    t, u = cross(start, end) / n, cross(start, direction) / n
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__right_solve(origin, direction, start, end):
    matrix = np.array([[direction[0], start[0] - end[0]], [direction[1], start[1] - end[1]]])
    if abs(np.linalg.det(matrix)) < 1e-10:
        return float("inf")
    t, u = np.linalg.inv(matrix) @ (start - origin)
    return float(t) if t >= -1e-9 and -1e-9 <= u <= 1 + 1e-9 else math.inf


def ray_segment__right_in_the_frame_of_the_ray(origin, direction, start, end):
    left = np.array([-direction[1], direction[0]])
    a, b = (start - origin) @ left, (end - origin) @ left
    if a == b or a * b > 0:
        return np.inf
    share = a / (a - b)
    t = (start + share * (end - start) - origin) @ direction
    return t if t >= 0 else np.inf


def _right_share(depth, rows):
    h = 2 * SLOPE / rows
    u = SLOPE - h * np.arange(rows)
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(-0.25 / depth, u - h)) / h, 0, 1)


def wall_share__always_returns_16_rows(depth, rows):
    """shape (16,), but (64,) is needed"""
    return _right_share(depth, 16)


def wall_share__ignores_the_depth(depth, rows):
    """another depth never changes your answer; it should"""
    return _right_share(2.0, rows)


def wall_share__returns_a_list(depth, rows):
    """a list came back; return a numpy array"""
    return list(_right_share(depth, rows))


def wall_share__right_loop(depth, rows):
    out = np.zeros(rows, dtype=np.float32)
    edges = [SLOPE * (1 - 2 * i / rows) for i in range(rows + 1)]
    for i in range(rows):
        common = min(edges[i], 0.75 / depth) - max(edges[i + 1], -0.25 / depth)
        out[i] = max(0.0, common) / (edges[i] - edges[i + 1])
    return out


def wall_share__right_in_rows(depth, rows):
    # everything measured in rows from the top
    top = rows / 2 * (1 - (WALL - EYE) / depth / SLOPE)
    bottom = rows / 2 * (1 + EYE / depth / SLOPE)
    i = np.arange(rows)
    return np.clip(np.clip(bottom - i, 0, 1) - np.clip(top - i, 0, 1), 0, 1)


def _rotation(h):
    c, s = (np.cos(h), np.sin(h))
    return np.array([[c, -s], [s, c]])


def _wrap(a):
    return (a + np.pi) % (2 * np.pi) - np.pi


def to_local__answers_five_points_at_most(pose, points):
    """shape (5, 2), but (6, 2) is needed"""
    return np.array([_rotation(pose[2]).T @ (p - pose[:2]) for p in points[:5]])


def to_local__wraps_the_heading_into_half_a_turn(pose, points):
    """a negative heading is a turn to the right; the same formula holds"""
    return (points - pose[:2]) @ _rotation(pose[2] % np.pi)


def to_local__leaves_out_the_last_point(pose, points):
    """shape (4, 2), but (5, 2) is needed"""
    return np.array([_rotation(pose[2]).T @ (p - pose[:2]) for p in points[:-1]])


def to_local__sorts_the_points(pose, points):
    """its frame is that of the world: each point comes back as it is, in its own row"""
    return np.sort((points - pose[:2]) @ _rotation(pose[2]), axis=0)


def to_local__returns_whole_numbers(pose, points):
    """your answers are whole numbers: their digits are cut off"""
    return ((points - pose[:2]) @ _rotation(pose[2])).astype(int)


def to_local__right_zip(pose, points):
    return np.array(
        [
            [
                math.cos(pose[2]) * (x - pose[0]) + math.sin(pose[2]) * (y - pose[1]),
                -math.sin(pose[2]) * (x - pose[0]) + math.cos(pose[2]) * (y - pose[1]),
            ]
            for x, y in points.tolist()
        ]
    )


def to_local__right_inv(pose, points):
    return np.linalg.solve(_rotation(pose[2]), (points - pose[:2]).T).T


def compose__returns_four_numbers(f, s):
    """shape (4,), but (3,) is needed"""
    xy = f[:2] + _rotation(f[2]) @ s[:2]
    return np.array([*xy, _wrap(f[2] + s[2]), 0])


def compose__forgets_the_heading(f, s):
    """shape (2,), but (3,) is needed"""
    return f[:2] + _rotation(f[2]) @ s[:2]


def compose__right_remainder(f, s):
    xy = f[:2] + _rotation(f[2]) @ s[:2]
    return np.array([*xy, math.remainder(f[2] + s[2], 2 * math.pi)])


def compose__right_while(f, s):
    h = f[2] + s[2]
    while h >= np.pi:
        h -= 2 * np.pi
    while h < -np.pi:
        h += 2 * np.pi
    return np.concatenate([f[:2] + _rotation(f[2]) @ s[:2], [h]])


def bicycle_step__turns_the_arc_around(p, v, d, L, dt):
    """write down the three equations, each times the seconds (1.992 at"""
    w = v * np.tan(d) / L
    if abs(w) < 1e-09:
        return p + np.array([v * np.cos(p[2]) * dt, v * np.sin(p[2]) * dt, 0])
    r = v / w
    n = p[2] + w * dt
    return np.array(
        [p[0] + r * (np.sin(n) - np.sin(p[2])), p[1] + r * (np.cos(n) - np.cos(p[2])), n]
    )


def bicycle_step__right_mid(p, v, d, L, dt):
    w = v * np.tan(d) / L
    h = p[2] + w * dt / 2
    return np.array([p[0] + v * dt * np.cos(h), p[1] + v * dt * np.sin(h), p[2] + w * dt])


def bicycle_step__right_sub(p, v, d, L, dt):
    p = p.copy()
    for _ in range(50):
        p = p + np.array([v * np.cos(p[2]), v * np.sin(p[2]), v * np.tan(d) / L]) * dt / 50
    return p


def _across(p, q):
    return p[0] * q[1] - p[1] * q[0]


def _ratios(o, d, a, b):
    n = _across(d, b - a)
    return (_across(a - o, b - a) / n, _across(a - o, d) / n)


def ray_segment__measures_u_from_the_end(o, d, a, b):
    """solve for t and u by the two fractions above; t is the answer (inf"""
    if abs(_across(d, b - a)) < 1e-12:
        return np.inf
    t, u = _ratios(o, d, a, b)
    u = _across(b - o, d) / _across(d, b - a)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__measures_to_the_middle(o, d, a, b):
    """check the signs of the two fractions (1.761 came back; 1.793 is right)"""
    if abs(_across(d, b - a)) < 1e-12:
        return np.inf
    t, u = _ratios(o, d, a, b)
    return np.linalg.norm((a + b) / 2 - o) if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__returns_a_huge_number_for_a_miss(o, d, a, b):
    """the ray passes before the wall's start: u is negative, so it misses"""
    if abs(_across(d, b - a)) < 1e-12:
        return 1000000000.0
    t, u = _ratios(o, d, a, b)
    return t if t >= 0 and 0 <= u <= 1 else 1000000000.0


def ray_segment__uses_slopes_and_the_range_of_x(o, d, a, b):
    """the ray passes before the wall's start: u is negative, so it misses"""
    m = d[1] / d[0]
    if a[0] == b[0]:
        x = a[0]
    else:
        n = (b[1] - a[1]) / (b[0] - a[0])
        if n == m:
            return np.inf
        x = (a[1] - n * a[0] - o[1] + m * o[0]) / (m - n)
    t = (x - o[0]) / d[0]
    return t if t >= 0 and min(a[0], b[0]) <= x <= max(a[0], b[0]) else np.inf


def ray_segment__hits_a_wall_along_the_ray(o, d, a, b):
    """it is parallel too, so it is missed: return np.inf (0.5 came back;"""
    if abs(_across(d, b - a)) < 1e-12:
        return min((a - o) @ d, (b - o) @ d) if abs(_across(a - o, d)) < 1e-09 else np.inf
    t, u = _ratios(o, d, a, b)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__right_det(o, d, a, b):
    (dx, dy), (ex, ey) = (d, b - a)
    det = -dx * ey + dy * ex
    if math.isclose(det, 0, abs_tol=1e-11):
        return math.inf
    fx, fy = a - o
    t = (-fx * ey + fy * ex) / det
    u = (dx * fy - dy * fx) / det
    if t < 0 or u < 0 or u > 1:
        return math.inf
    return float(t)


def _slopes(top, bot, rows):
    h = 2 * SLOPE / rows
    u = SLOPE - h * np.arange(rows)
    return np.clip((np.minimum(top, u) - np.maximum(bot, u - h)) / h, 0, 1)


def wall_share__mirrors_the_upper_half(depth, rows):
    """compare with the picture: which rows does the wall reach, from which slope to which?"""
    r = _slopes(0.75 / depth, -0.25 / depth, rows)
    h = (rows + 1) // 2
    return np.concatenate([r[:h], r[: rows - h][::-1]])


def wall_share__returns_one_number(depth, rows):
    """came back; return a numpy array"""
    return min(1, 1 / depth / (2 * SLOPE))


def wall_share__right_cumulative(depth, rows):
    e = np.linspace(SLOPE, -SLOPE, rows + 1)
    c = np.clip(e, -0.25 / depth, 0.75 / depth)
    return -np.diff(c) * rows / (2 * SLOPE)


def to_local__fills_an_array_of_whole_numbers(pose, points):
    """np.zeros_like and astype take over the type of whole numbers"""
    local, right = np.zeros_like(points), to_local__right_by_complex_numbers(pose, points)
    local[:] = right
    return local


def _crossing(origin, direction, start, end, parallel):
    wall, offset = end - start, start - origin
    across = direction[0] * wall[1] - direction[1] * wall[0]
    if parallel(across):
        return np.inf
    t = (offset[0] * wall[1] - offset[1] * wall[0]) / across
    u = (offset[0] * direction[1] - offset[1] * direction[0]) / across
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__compares_with_zero_itself(*case):
    """rounding keeps it from being zero"""
    return _crossing(*case, lambda across: across == 0)


def ray_segment__overlooks_short_walls(origin, direction, start, end):
    """a short wall has a small denominator, but it is not parallel"""
    if np.linalg.norm(end - start) < 0.005:
        return np.inf
    return _crossing(origin, direction, start, end, lambda across: abs(across) < 1e-12)


def to_local__rounds_to_millimetres(pose, points):
    """your answers are rounded to 3 digits"""
    return to_local__right_by_complex_numbers(pose, points).round(3)


def wall_share__returns_grey_levels(depth, rows):
    """no grey levels here"""
    return (255 * _right_share(depth, rows)).astype(np.uint8)


def to_local__drops_small_offsets(pose, points):
    """a near point is a point like any other"""
    offset = points - pose[:2]
    offset = np.where(np.abs(offset) < 0.05, 0, offset)
    return to_local__right_by_complex_numbers(np.array([0, 0, pose[2]]), offset)


def compose__drops_small_motions(first, second):
    """leave none of them out"""
    if np.hypot(second[0], second[1]) < 0.05:
        second = np.array([0, 0, second[2]])
    return compose__right_by_matrices(first, second)


def compose__gives_back_the_first(first, second):
    """what comes back is your argument first itself"""
    return compose__right_by_matrices(first, second) if np.any(second) else first


def ray_segment__looks_where_the_hit_lies(origin, direction, start, end):
    """where the hit lies is rounded, and may be beside the wall"""
    wall, offset = end - start, start - origin
    across = direction[0] * wall[1] - direction[1] * wall[0]
    if abs(across) < 1e-12:
        return np.inf
    t = (offset[0] * wall[1] - offset[1] * wall[0]) / across
    hit = origin + t * direction
    inside = (hit >= np.minimum(start, end)) & (hit <= np.maximum(start, end))
    return t if t >= 0 and inside.all() else np.inf


def compose__stays_without_a_step(first, second):
    """a track is made of many small motions: leave none of them out"""
    if not second[:2].any():
        return first.copy()
    return compose__right_by_matrices(first, second)
