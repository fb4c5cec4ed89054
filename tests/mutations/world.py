"""The simulated world: bodies, rays, pictures, people, imported maps."""

from tests.mutations import changes

MUTATIONS = changes("""
world/bodies.py | world/test_bodies.py
a car's turning rate grows with the sine of its steering
    speed * np.tan(steering) / self.wheelbase], axis
        -> speed * np.sin(steering) / self.wheelbase], axis
the chord of an arc is too short
    np.sinc(turn / (2 * np.pi)) -> np.sinc(turn / np.pi)
a round robot's footprint lies inside its circle
    outer = self.radius / np.cos(np.pi / 12) -> outer = self.radius

world/floorplan.py | world/test_floorplan.py
furniture's material begins a side too late
    np.cumsum(lengths.ravel()) - lengths.ravel() -> np.cumsum(lengths.ravel())

world/fleet.py | world/test_simulation.py
who lets go of one of two things touches neither
    self.contacts[robot] -= concerned -> self.contacts[robot] = 0

world/simulation.py | world/test_simulation.py
speed in reverse is positive
    self.speed = motions[:, 0] / STEP -> self.speed = np.linalg.norm(motions[:, :2], axis=1) / STEP
a robot that is put down elsewhere drives on
    self.controls[robots], self.speed[robots] = 0.0, 0.0 -> self.speed[robots] = 0.0

world/noise.py | world/test_noise.py
robots of a fleet share one stream of odometry noise
    [np.random.default_rng(one) for one in self._seed.spawn(count)]
        -> [np.random.default_rng(self._seed)] * count
odometry repeats its errors
    self._noise[self._row - 1]) -> self._noise[0])
the last noise of those drawn at a time is skipped
    if self._row == len(self._noise): -> if self._row >= len(self._noise) - 1:
the heading drifts with the distance
    self.drift * np.sqrt(length) * -> self.drift * length *
motion and reading share their luck
    (luck[..., None] >= _BORDERS -> (luck[:, :1, None] >= _BORDERS

world/noise.py | world/test_simulation.py -k 'odometry or drifts'
the heading drifts in proportion to the distance
    self.drift * np.sqrt(length) -> self.drift * length

world/people.py | world/test_simulation.py
at the end of its route a person begins anew
    total - abs(walked[k] % (2 * total) - total) -> walked[k] % total
a person walks into a robot beside it
    (ahead > -0.7) -> (ahead > 0.7)

world/placing.py | world/test_simulation.py
a robot may start around a thin post
    free[number] = not _inside(footprint, local).any() -> free[number] = True

world/occupancy.py | world/test_occupancy.py
walls are drawn half a cell aside
    - origin) / resolution - 0.5 -> - origin) / resolution

world/sensors.py | world/test_sensors.py
walls are as high at the picture's edge as their distance says
    np.cos(self.fan.angles).astype(np.float32) -> np.ones_like(self.fan.angles).astype(np.float32)
depth runs from right to left
    np.ascontiguousarray(hits.distance[:, ::-1]) -> np.ascontiguousarray(hits.distance)

world/paint.py | world/test_sensors.py
all walls are equally bright
    light * shade / (last - first) -> light / (last - first)

world/ray_kernels.py | world/test_raycast.py -k disc
a disc is seen from inside
    if 0.0 <= t < distance -> if t < distance
along a disc is counted from the robot's heading
    math.atan2(hy, hx) + poses[pose, 2] -> math.atan2(hy, hx)

world/grid_kernels.py | world/test_raycast.py
walls beyond the nearest cells are missed
    cell * (_AROUND + min( -> cell * (_AROUND + 2 + min(

world/visibility.py | world/test_visibility.py
a view is twice as wide as it should be
    <= field_of_view / 2) -> <= field_of_view)
the two overlaps change places
    ((first, second), (second, first)) -> ((second, first), (first, second))

world/materials.py | world/test_sensors.py
gamma is undone instead of applied
    / 255.0) ** self.gamma -> / 255.0) ** (1 / self.gamma)

world/importers/regions.py | world/test_importers.py -k region
a point's region is all that is free
    return labels == label -> return free

world/importers/map_cells.py | world/test_importers.py
what is half transparent is known
    (levels[:, colours:] >= 1.0) -> (levels[:, colours:] > 0.0)

world/importers/surfaces.py | world/test_importers.py
obstacles share more of a strip than there is
    if used + length > SPAN: -> if used > SPAN:

world/importers/houseexpo.py | world/test_importers.py
an outline stays as it was drawn
    return points if area > 0 else points[::-1] -> return points

world/generators/wayfinding.py | world/test_wayfinding.py -k follows
signs do not lead: every accent is that of the root
    (start + span * depth) % 1.0 -> (start + span * 0.0) % 1.0

world/generators/wayfinding.py | world/test_wayfinding.py -k accent
a room has the accents of the floor at each wall, not of its door
    if room.kind not in PASSABLE and doors: -> if room.kind in PASSABLE and doors:

world/generators/wayfinding.py | world/test_wayfinding.py -k shifted
shifted accents are as bright as those that are trained on
    "shifted": (0.45, 0.60)} -> "shifted": (0.85, 0.95)}

world/generators/scanned.py | world/test_scanned.py -k falls
a scan may fall apart
    if count < 2 or largest < WHOLE * (clearance > 0).sum(): -> if count < 2:

world/generators/scanned.py | world/test_scanned.py -k angles
scans lie along the axes
    rng.uniform(-np.pi, np.pi) -> 0.0 * rng.uniform(-np.pi, np.pi)

world/worlds.py | world/test_worlds.py -k training
no training world has signs
    f"{name}/wayfinding" if with_signs else name -> name

world/generators/wayfinding.py | world/test_wayfinding.py
a room has the accent of its farthest door
    self.at(middles).min() -> self.at(middles).max()

world/generators/wayfinding.py | world/test_wayfinding.py -k rise
hues run one way in all worlds
    span, shade = sign * rng.uniform(*SPAN) -> span, shade = rng.uniform(*SPAN)
""")
