"""Answers to notebook 01: the docstring of a wrong one is what the check must say of it."""

import math

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
    """your function changes its argument first"""
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
    """the turn is the turning rate times the seconds"""
    x, y, heading = _move(pose, speed, 0.0, seconds)
    return np.array([x, y, heading + speed * np.tan(steering) / wheelbase])


def bicycle_step__swaps_sine_and_cosine(pose, speed, steering, wheelbase, seconds):
    """cos belongs to x"""
    turn = speed * np.tan(steering) / wheelbase * seconds
    step = speed * seconds * np.array([np.sin(pose[2]), np.cos(pose[2]), 0.0])
    return pose + step + [0.0, 0.0, turn]


def bicycle_step__changes_its_argument(pose, speed, steering, wheelbase, seconds):
    """your function changes its argument pose"""
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
    """test u, on both sides"""
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
    """u has the wrong sign"""
    distance, share = _meet(origin, direction, start, end)
    return distance if 0 <= -share <= 1 and distance >= 0 else np.inf


def ray_segment__right_by_a_linear_system(origin, direction, start, end):
    system = np.column_stack([direction, start - end])
    if abs(np.linalg.det(system)) < 1e-12:
        return np.inf
    distance, share = np.linalg.solve(system, start - origin)
    return distance if distance >= 0 and 0 <= share <= 1 else np.inf


def wall_share__knows_no_half_pixels(depth, rows):
    """do not round the share"""
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


def to_local__returns_distance_and_angle(pose, points):
    """polar coordinates (distance and angle) came back; metres ahead and to"""
    o = points - pose[:2]
    return np.stack([np.hypot(*o.T), np.arctan2(o[:, 1], o[:, 0]) - pose[2]], axis=1)


def to_local__gives_left_first(pose, points):
    """left first, then ahead; it is metres ahead first, then metres to the left"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return ((points - pose[:2]) @ np.array([[c, -s], [s, c]]))[:, ::-1]


def to_local__subtracts_x_from_both(pose, points):
    """this needs only the shift: subtract x from x and y from y (-2.142 at"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return (points - pose[0]) @ np.array([[c, -s], [s, c]])


def to_local__drops_the_sign_of_the_heading(pose, points):
    """the sign of the heading is lost: a negative heading is a turn to the right"""
    c, s = np.cos(abs(pose[2])), np.sin(abs(pose[2]))
    return (points - pose[:2]) @ np.array([[c, -s], [s, c]])


def to_local__drops_what_is_behind(pose, points):
    """points behind the robot lie at a negative x; do not cut or drop the sign"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.maximum((points - pose[:2]) @ np.array([[c, -s], [s, c]]), [0, -np.inf])


def to_local__computes_y_from_the_new_x(pose, points):
    """the new x stands in the formula of the new y; keep the old offset until both are done"""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    o = points - pose[:2]
    o[:, 0] = c * o[:, 0] + s * o[:, 1]
    o[:, 1] = c * o[:, 1] - s * o[:, 0]
    return o


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


def compose__takes_degrees(first, second):
    """headings are in radians; do not convert them from degrees"""
    a = np.deg2rad(first[2])
    c, s = np.cos(a), np.sin(a)
    h = (first[2] + second[2] + np.pi) % (2 * np.pi) - np.pi
    return np.array(
        [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]
    )


def compose__wraps_only_above_pi(first, second):
    """headings above pi are wrapped, those below -pi are not"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = first[2] + second[2]
    if h > np.pi:
        h -= 2 * np.pi
    return np.array(
        [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]
    )


def compose__wraps_only_below_minus_pi(first, second):
    """headings below -pi are wrapped, those above pi are not"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = first[2] + second[2]
    if h < -np.pi:
        h += 2 * np.pi
    return np.array(
        [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]
    )


def compose__wraps_by_half_a_turn(first, second):
    """the heading is wrapped by half a turn; a whole turn is 2 pi"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = (first[2] + second[2] + np.pi / 2) % np.pi - np.pi / 2
    return np.array(
        [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]
    )


def compose__forgets_the_step_sideways(first, second):
    """a step sideways is lost: the second pose's y counts too"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = (first[2] + second[2] + np.pi) % (2 * np.pi) - np.pi
    return np.array([first[0] + c * second[0], first[1] + s * second[0], h])


def compose__turns_the_first_step(first, second):
    """the first pose stays where it is; it is the second step that is turned"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = (first[2] + second[2] + np.pi) % (2 * np.pi) - np.pi
    return np.array(
        [second[0] + c * first[0] - s * first[1], second[1] + s * first[0] + c * first[1], h]
    )


def compose__returns_a_list(first, second):
    """a list came back; return a numpy array"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = (first[2] + second[2] + np.pi) % (2 * np.pi) - np.pi
    return [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]


def compose__subtracts_the_headings(first, second):
    """the headings are subtracted; they add up"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = (first[2] - second[2] + np.pi) % (2 * np.pi) - np.pi
    return np.array(
        [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]
    )


def compose__clips_the_heading(first, second):
    """the heading is cut at -pi and pi; wrap it: 3.2 becomes 3.2 - 2 pi"""
    c, s = np.cos(first[2]), np.sin(first[2])
    h = np.clip(first[2] + second[2], -np.pi, np.pi)
    return np.array(
        [first[0] + c * second[0] - s * second[1], first[1] + s * second[0] + c * second[1], h]
    )


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


def bicycle_step__ignores_the_wheelbase(pose, speed, steering, wheelbase, seconds):
    """the wheelbase is an argument; do not write 0.3 into the formula"""
    x, y, h = pose
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            h + speed * np.tan(steering) / 0.3 * seconds,
        ]
    )


def bicycle_step__takes_the_sine(pose, speed, steering, wheelbase, seconds):
    """the turning rate has the tangent of the steering angle, not its sine"""
    x, y, h = pose
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            h + speed * np.sin(steering) / wheelbase * seconds,
        ]
    )


def bicycle_step__turns_the_same_way_in_reverse(pose, speed, steering, wheelbase, seconds):
    """in reverse the turn changes its sign too; do not take the speed without its sign"""
    x, y, h = pose
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            h + abs(speed) * np.tan(steering) / wheelbase * seconds,
        ]
    )


def bicycle_step__always_turns_left(pose, speed, steering, wheelbase, seconds):
    """the car always turns left; a negative steering angle turns it to the right"""
    x, y, h = pose
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            h + speed * np.tan(abs(steering)) / wheelbase * seconds,
        ]
    )


def bicycle_step__limits_the_steering(pose, speed, steering, wheelbase, seconds):
    """limit nothing here: the car's motors limit steering and speed before this function"""
    x, y, h = pose
    steering = np.clip(steering, -0.45, 0.45)
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            h + speed * np.tan(steering) / wheelbase * seconds,
        ]
    )


def bicycle_step__limits_the_speed(pose, speed, steering, wheelbase, seconds):
    """limit nothing here: the car's motors limit steering and speed before this function"""
    x, y, h = pose
    speed = np.clip(speed, -0.3, 0.8)
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            h + speed * np.tan(steering) / wheelbase * seconds,
        ]
    )


def bicycle_step__returns_the_rate_as_heading(pose, speed, steering, wheelbase, seconds):
    """the turning rate alone came back as heading; add the turn to the old heading"""
    x, y, h = pose
    return np.array(
        [
            x + speed * np.cos(h) * seconds,
            y + speed * np.sin(h) * seconds,
            speed * np.tan(steering) / wheelbase * seconds,
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


def bicycle_step__always_drives_along_x(pose, speed, steering, wheelbase, seconds):
    """the step runs along the heading, not always along x"""
    x, y, h = pose
    return np.array([x + speed * seconds, y, h + speed * np.tan(steering) / wheelbase * seconds])


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


def ray_segment__tests_only_the_end(origin, direction, start, end):
    """the ray passes before the wall's start there: u must not be negative"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and u <= 1 else np.inf


def ray_segment__tests_only_the_start(origin, direction, start, end):
    """the ray passes beyond the wall's end there: u must not be above 1"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and u >= 0 else np.inf


def ray_segment__forgets_t(origin, direction, start, end):
    """it is behind the robot: t must not be negative"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if 0 <= u <= 1 else np.inf


def ray_segment__misses_a_wall_it_starts_on(origin, direction, start, end):
    """a ray that starts on the wall hits it at 0 m: t = 0 counts"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if t > 0 and 0 <= u <= 1 else np.inf


def ray_segment__misses_the_exact_ends(origin, direction, start, end):
    """a ray that hits exactly an end of the wall hits it: u = 0 and u = 1 count"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and 0 < u < 1 else np.inf


def ray_segment__sees_walls_from_one_side_only(origin, direction, start, end):
    """which end is the start does not matter: the denominator may be negative"""
    if cross(direction, end - start) < 1e-12:
        return np.inf
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__takes_slanted_walls_for_parallel(origin, direction, start, end):
    """a small denominator is not zero: only 1e-12 or less counts as parallel"""
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


def ray_segment__returns_minus_one_for_a_miss(origin, direction, start, end):
    """a ray that misses returns np.inf, not -1"""
    if _parallel(direction, start, end):
        return -1.0
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and 0 <= u <= 1 else -1.0


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


def ray_segment__returns_zero_for_a_parallel_wall(origin, direction, start, end):
    """a parallel wall is missed: its answer, too, is np.inf"""
    if _parallel(direction, start, end):
        return 0.0
    t, u = _tu(origin, direction, start, end)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def ray_segment__measures_u_in_metres(origin, direction, start, end):
    """u is a share of the wall's length; do not divide b - a by its length"""
    wall = (end - start) / np.linalg.norm(end - start)
    n = cross(direction, wall)
    if abs(n) < 1e-12:
        return np.inf
    t = cross(start - origin, wall) / n
    u = cross(start - origin, direction) / n
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


def ray_segment__turns_the_offset_around(origin, direction, start, end):
    """a sign is wrong: the offset runs from the ray's origin to the wall's start, a - o"""
    if _parallel(direction, start, end):
        return np.inf
    t, u = _tu(origin, direction, start, end)
    t, u = -t, -u
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


def wall_share__looks_at_the_middle_of_a_pixel(depth, rows):
    """some pixels are partly covered; give the share, not 0 or 1"""
    h = 2 * SLOPE / rows
    c = SLOPE - h * (np.arange(rows) + 0.5)
    return ((c < 0.75 / depth) & (c > -0.25 / depth)).astype(float)


def wall_share__exceeds_one(depth, rows):
    """shares lie between 0 and 1; rows that the wall covers come out above 1"""
    h = 2 * SLOPE / rows
    u = SLOPE - h * np.arange(rows)
    return np.maximum((np.minimum(0.75 / depth, u) + 0.25 / depth) / h, 0)


def wall_share__returns_slopes(depth, rows):
    """divide the overlap by the height of a row, h, to get a share"""
    h = 2 * SLOPE / rows
    return _right_share(depth, rows) * h


def wall_share__ends_at_the_horizon(depth, rows):
    """the part of the wall below the horizon is lost: it ends at the slope"""
    h = 2 * SLOPE / rows
    u = SLOPE - h * np.arange(rows)
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(0, u - h)) / h, 0, 1)


def wall_share__makes_rows_half_as_high(depth, rows):
    """a row is h = 2s / rows high, since the image reaches from s down to -s"""
    h = SLOPE / rows
    u = SLOPE - h * np.arange(rows)
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(-0.25 / depth, u - h)) / h, 0, 1)


def wall_share__always_returns_16_rows(depth, rows):
    """shape (16,), but (64,) is needed"""
    return _right_share(depth, 16)


def wall_share__makes_rows_as_high_as_of_16(depth, rows):
    """the number of rows is an argument; a row is not always 2s / 16 high"""
    h = 2 * SLOPE / 16
    u = SLOPE - h * np.arange(rows)
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(-0.25 / depth, u - h)) / h, 0, 1)


def wall_share__ignores_the_depth(depth, rows):
    """another depth never changes your answer; it should"""
    return _right_share(2.0, rows)


def wall_share__multiplies_by_the_depth(depth, rows):
    """the heights are multiplied by the depth; divide them"""
    return _right_share(1 / depth, rows)


def wall_share__divides_angles_evenly(depth, rows):
    """rows divide the range of slopes evenly, not the range of angles"""
    s = np.pi / 6
    h = 2 * s / rows
    u = s - h * np.arange(rows)
    return np.clip(
        (np.minimum(np.arctan(0.75 / depth), u) - np.maximum(-np.arctan(0.25 / depth), u - h)) / h,
        0,
        1,
    )


def wall_share__begins_one_row_too_low(depth, rows):
    """everything is one row too low: row 0 begins at the slope s itself"""
    h = 2 * SLOPE / rows
    u = SLOPE - h * (np.arange(rows) + 1)
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(-0.25 / depth, u - h)) / h, 0, 1)


def wall_share__spreads_the_rows_too_far(depth, rows):
    """rows lie h = 2s / rows apart; np.linspace(s, -s, rows) puts them 2s /"""
    u = np.linspace(SLOPE, -SLOPE, rows)
    h = 2 * SLOPE / rows
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(-0.25 / depth, u - h)) / h, 0, 1)


def wall_share__returns_a_list(depth, rows):
    """a list came back; return a numpy array"""
    return list(_right_share(depth, rows))


def wall_share__returns_the_share_of_the_rest(depth, rows):
    """that is the share of floor and ceiling; the wall's is 1 minus it"""
    return 1 - _right_share(depth, rows)


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


def to_local__drops_the_sign_of_y(pose, points):
    """points to the right of the robot lie at a negative y; do not drop the sign"""
    r = (points - pose[:2]) @ _rotation(pose[2])
    r[:, 1] = abs(r[:, 1])
    return r


def to_local__mixes_up_dx_and_dy(pose, points):
    """the formula of the new y is that of x with another sign; it is cos * dy - sin * dx"""
    o = points - pose[:2]
    c, s = (math.cos(pose[2]), math.sin(pose[2]))
    return np.stack([c * o[:, 0] + s * o[:, 1], c * o[:, 0] - s * o[:, 1]], 1)


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


def compose__takes_the_mean_heading(f, s):
    """the headings add up; do not take their mean"""
    xy = f[:2] + _rotation(f[2]) @ s[:2]
    return np.array([*xy, (f[2] + s[2]) / 2])


def compose__uses_only_the_distance(f, s):
    """the second pose's x and y are both needed, with their signs, not only its distance"""
    d = np.hypot(*s[:2])
    return np.array([f[0] + d * np.cos(f[2]), f[1] + d * np.sin(f[2]), _wrap(f[2] + s[2])])


def compose__returns_four_numbers(f, s):
    """shape (4,), but (3,) is needed"""
    xy = f[:2] + _rotation(f[2]) @ s[:2]
    return np.array([*xy, _wrap(f[2] + s[2]), 0])


def compose__forgets_the_heading(f, s):
    """shape (2,), but (3,) is needed"""
    return f[:2] + _rotation(f[2]) @ s[:2]


def compose__exchanges_x_and_y(f, s):
    """x and y of the turned step are exchanged"""
    xy = f[:2] + (_rotation(f[2]) @ s[:2])[::-1]
    return np.array([*xy, _wrap(f[2] + s[2])])


def compose__turns_by_half_of_the_second(f, s):
    """the step comes before the turn that the second heading makes; do not turn it by half"""
    xy = f[:2] + _rotation(f[2] + s[2] / 2) @ s[:2]
    return np.array([*xy, _wrap(f[2] + s[2])])


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


def bicycle_step__cannot_reverse(p, v, d, L, dt):
    """a car in reverse moves backwards; do not stop it, nor take the speed without its sign"""
    v = max(v, 0)
    return p + np.array([v * np.cos(p[2]), v * np.sin(p[2]), v * np.tan(d) / L]) * dt


def bicycle_step__counts_the_seconds_twice(p, v, d, L, dt):
    """the turn is the rate times the seconds, once; the seconds count twice in yours"""
    return p + np.array([v * np.cos(p[2]) * dt, v * np.sin(p[2]) * dt, v * np.tan(d) / L * dt * dt])


def bicycle_step__forgets_the_wheelbase(p, v, d, L, dt):
    """the wheelbase is missing: the turning rate is divided by it"""
    return p + np.array([v * np.cos(p[2]), v * np.sin(p[2]), v * np.tan(d)]) * dt


def bicycle_step__takes_the_tangent_of_degrees(p, v, d, L, dt):
    """np.tan takes radians, and the steering angle is in radians; do not convert it"""
    return p + np.array([v * np.cos(p[2]), v * np.sin(p[2]), v * np.tan(np.rad2deg(d)) / L]) * dt


def bicycle_step__turns_before_it_moves(p, v, d, L, dt):
    """x and y use the heading after the turn; take the one at the start of the step"""
    h = p[2] + v * np.tan(d) / L * dt
    return np.array([p[0] + v * np.cos(h) * dt, p[1] + v * np.sin(h) * dt, h])


def bicycle_step__moves_the_front_axle(p, v, d, L, dt):
    """v is the speed of the rear axle, so the step and the turn have no"""
    return (
        p
        + np.array([v * np.cos(p[2]) * np.cos(d), v * np.sin(p[2]) * np.cos(d), v * np.sin(d) / L])
        * dt
    )


def bicycle_step__reverses_forwards(p, v, d, L, dt):
    """a car in reverse moves backwards; take the speed with its sign"""
    return p + np.array([abs(v) * np.cos(p[2]), abs(v) * np.sin(p[2]), v * np.tan(d) / L]) * dt


def bicycle_step__divides_by_the_seconds(p, v, d, L, dt):
    """divided by the seconds; a rate is multiplied by them"""
    return p + np.array([v * np.cos(p[2]), v * np.sin(p[2]), v * np.tan(d) / L]) / dt


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


def ray_segment__joins_the_conditions_by_or(o, d, a, b):
    """both conditions must hold, t >= 0 and 0 <= u <= 1; one alone is not enough"""
    if abs(_across(d, b - a)) < 1e-12:
        return np.inf
    t, u = _ratios(o, d, a, b)
    return t if t >= 0 or 0 <= u <= 1 else np.inf


def ray_segment__takes_the_size_of_u(o, d, a, b):
    """u must not be negative: test 0 <= u, not its absolute value"""
    if abs(_across(d, b - a)) < 1e-12:
        return np.inf
    t, u = _ratios(o, d, a, b)
    return t if t >= 0 and abs(u) <= 1 else np.inf


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


def ray_segment__returns_false_for_a_miss(o, d, a, b):
    """a ray that misses returns np.inf, not 0"""
    if abs(_across(d, b - a)) < 1e-12:
        return False
    t, u = _ratios(o, d, a, b)
    return t if t >= 0 and 0 <= u <= 1 else False


def ray_segment__limits_t_to_one(o, d, a, b):
    """t is a distance in metres; it has no upper limit, and only u ends at 1"""
    if abs(_across(d, b - a)) < 1e-12:
        return np.inf
    t, u = _ratios(o, d, a, b)
    return t if 0 <= t <= 1 and 0 <= u <= 1 else np.inf


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


def wall_share__puts_the_eye_as_high_as_the_rest(depth, rows):
    """the eye is 0.25 m above the floor: the wall ends 0.25 m below it, not 0.75 m"""
    return _slopes(0.75 / depth, -0.75 / depth, rows)


def wall_share__divides_only_the_lower_end(depth, rows):
    """the upper end of the wall lies at 0.75 / depth"""
    return _slopes(0.75, -0.25 / depth, rows)


def wall_share__divides_only_the_upper_end(depth, rows):
    """the lower end of the wall is not divided by the depth"""
    return _slopes(0.75 / depth, -0.25, rows)


def wall_share__drops_partly_covered_pixels(depth, rows):
    """a pixel that is partly covered counts as well; give the share, not only whole pixels"""
    return np.floor(_slopes(0.75 / depth, -0.25 / depth, rows))


def wall_share__mirrors_the_upper_half(depth, rows):
    """compare with the picture: which rows does the wall reach, from which slope to which?"""
    r = _slopes(0.75 / depth, -0.25 / depth, rows)
    h = (rows + 1) // 2
    return np.concatenate([r[:h], r[: rows - h][::-1]])


def wall_share__divides_by_the_sum(depth, rows):
    """each row has a share of its own; do not divide them by their sum"""
    r = _slopes(0.75 / depth, -0.25 / depth, rows)
    return r / r.sum()


def wall_share__divides_by_the_largest(depth, rows):
    """a far wall covers no row completely; do not divide by the largest share"""
    r = _slopes(0.75 / depth, -0.25 / depth, rows)
    return r / r.max()


def wall_share__ends_the_image_at_slope_1(depth, rows):
    """the image ends at the slope tan 30 degrees (`slope`), not at 1"""
    h = 2 / rows
    u = 1 - h * np.arange(rows)
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(-0.25 / depth, u - h)) / h, 0, 1)


def wall_share__takes_60_degrees_up_and_down(depth, rows):
    """the image ends at the slope tan 30 degrees (`slope`), half of its field of view of 60"""
    s = np.tan(np.pi / 3)
    h = 2 * s / rows
    u = s - h * np.arange(rows)
    return np.clip((np.minimum(0.75 / depth, u) - np.maximum(-0.25 / depth, u - h)) / h, 0, 1)


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


def compose__wraps_everything(first, second):
    """only the heading is wrapped; x and y are metres"""
    cos, sin = np.cos(first[2]), np.sin(first[2])
    x, y = cos * second[0] - sin * second[1], sin * second[0] + cos * second[1]
    together = np.array([first[0] + x, first[1] + y, first[2] + second[2]])
    return (together + np.pi) % (2 * np.pi) - np.pi


def compose__takes_an_arcsine(first, second):
    """arcsin knows headings up to a quarter turn only"""
    x, y, heading = compose__right_by_matrices(first, second)
    return np.array([x, y, np.arcsin(np.sin(heading))])


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


def wall_share__lays_rows_at_even_angles(depth, rows):
    """these lie at even angles"""
    edges = np.tan(np.linspace(np.pi / 6, -np.pi / 6, rows + 1))
    common = np.minimum(edges[:-1], 0.75 / depth) - np.maximum(edges[1:], -0.25 / depth)
    return np.maximum(common, 0) / (edges[:-1] - edges[1:])


def wall_share__forgets_where_the_wall_begins(depth, rows):
    """the rows below it show the floor"""
    edges = np.linspace(SLOPE, -SLOPE, rows + 1)
    return np.maximum(np.minimum(edges[:-1], 0.75 / depth) - edges[1:], 0) * rows / (2 * SLOPE)


def wall_share__takes_absolute_overlaps(depth, rows):
    """make it 0, not positive"""
    edges = np.linspace(SLOPE, -SLOPE, rows + 1)
    common = np.minimum(edges[:-1], 0.75 / depth) - np.maximum(edges[1:], -0.25 / depth)
    return np.minimum(np.abs(common) * rows / (2 * SLOPE), 1)


def wall_share__makes_two_halves(depth, rows):
    """the horizon runs through the middle of a row"""
    h = 2 * SLOPE / rows
    above = np.clip(0.75 / depth / h - np.arange(rows // 2), 0, 1)
    below = np.clip(0.25 / depth / h - np.arange(rows - rows // 2), 0, 1)
    return np.concatenate([above[::-1], below])


def to_local__rounds_to_millimetres(pose, points):
    """your answers are rounded to 3 digits"""
    return to_local__right_by_complex_numbers(pose, points).round(3)


def to_local__sends_the_heading_through_an_arctan(pose, points):
    """takes half a turn from some"""
    heading = np.arctan(np.tan(pose[2]))
    return to_local__right_by_complex_numbers(np.array([*pose[:2], heading]), points)


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
