"""Doors of driving."""

from functools import cache

import numpy as np

from tests.conftest import make_trajectory
from tests.doors.arguments import (
    a,
    flag,
    floats,
    function,
    integers,
    number,
    several,
    text,
    whole,
)
from tests.doors.ground import in_folder
from tests.doors.walk import anything, call, numbers
from tests.doors.world import POINTS, POSES, rng, robots, scene
from tutorial_lib import driving
from tutorial_lib.driving import metrics
from tutorial_lib.driving.control import composed, oracle, rmp, rmp_arcs, smoothed
from tutorial_lib.driving.data import (
    demonstrations,
    episodes,
    perturbation,
    recorded_world,
    trajectories,
)
from tutorial_lib.world import BicycleCar, Camera

GOALS = np.array([[3.0, 2.5], [7.0, 3.0]])
RMP = driving.RMPController()
GAINS = (
    "goal_gain", "goal_damping", "push", "brake", "weight", "heading_gain", "heading_weight",
    "turning", "horizon", "lane", "lane_reach", "swing", "reverse_cost", "turn_cost", "go_on",
    "begin", "miss", "carrot", "arrived", "margin", "reserve", "crawl", "hurry", "settle",
    "authority",
)  # fmt: skip


class Straight:
    """A part that fits every interface."""

    view, k = None, 0
    arrived = given_up = np.zeros(2, dtype=bool)

    def prepare(self, contexts):
        return contexts

    def predict(self, observations, targets):
        return np.tile([1.0, 0.0], (len(observations), 1)), np.ones((len(observations), 2))

    def act(self, observations, targets):
        return np.tile([0.3, 0.0], (len(observations), 1))


@cache
def paths():
    return driving.GridPaths(scene().clearance)


@cache
def field():
    return paths().fields(GOALS, shortest=True)


@cache
def drives():
    points = [(1.5, 1.5), (8.0, 1.5), (8.0, 8.0)]
    return [make_trajectory(points), make_trajectory(points[::-1])]


@cache
def recorded():
    return driving.RecordedWorld(scene(), drives())


@cache
def four_episodes():
    return driving.draw_episodes(recorded(), paths(), 4, rng())


def goals(shape=("G", 2), **changes):
    return floats(GOALS, shape, refuses="huge, negative", **changes)


def indices(count, axes=("N",), **changes):
    return integers([0, 1], axes, least=0, most=count - 1, **changes)


def frames(**changes):
    return indices(len(recorded().poses), **changes)


def under_way():
    return {
        "observations": a(robots().observe()),
        "robots": indices(2, ("M",), refuses="longer M, shorter M, empty"),
    }


def drive_once(ends):
    simulation = robots()
    policy = driving.OraclePolicy(simulation, paths(), GOALS)
    return driving.rollout(simulation, policy, ends)


def trajectory_fields(count=3):
    steps = np.arange(count) * 0.1
    columns = {
        "poses": (np.zeros((count, 3)), ("T", 3)),
        "odometry": (np.zeros((count, 3)), ("T", 3)),
        "laser": (np.ones((count, 96), np.float32), ("T", "B")),
        "speed": (np.zeros(count), ("T",)),
        "steering": (np.zeros(count), ("T",)),
        "actions": (np.zeros((count, 2)), ("T", 2)),
        "timestamps": (steps, ("T",)),
    }
    return {
        name: floats(value, shape, dtype=value.dtype, empty=False)
        for name, (value, shape) in columns.items()
    }


DOORS = {
    # geodesics
    "GridPaths": lambda: call(
        driving.GridPaths,
        anything,
        grid=a(scene().clearance),
        clearance=number(0.25, least=0, refuses="huge"),
        comfort=number(0.6, above=0),
        caution=number(4.0, least=0),
    ),
    "GridPaths.nearest": lambda: call(paths().nearest, numbers, points=floats(POINTS, (..., 2))),
    "GridPaths.fields": lambda: call(
        paths().fields,
        anything,
        goals=goals(takes="fewer axes"),
        shortest=flag(True),
    ),
    "GridPaths.metres_to": lambda: call(
        paths().metres_to, numbers, goals=goals(takes="fewer axes")
    ),
    "GridPaths.between": lambda: call(
        paths().between, numbers, starts=floats(POINTS, ("N", 2)), goals=goals(("N", 2))
    ),
    "DistanceFields.distance": lambda: call(
        field().distance,
        numbers,
        points=floats(POINTS, ("N", 2)),
        goals=indices(2, takes="no axes, fewer axes"),
    ),
    "DistanceFields.path": lambda: call(
        field().path,
        start=floats(POINTS[0], (2,), refuses="huge, negative"),
        goal=whole(0, least=0, most=1),
    ),
    "DistanceFields.waypoints": lambda: call(
        field().waypoints,
        points=floats(POINTS, ("N", 2)),
        goals=indices(2),
        caster=a(scene().caster),
        reach=number(2.0, least=0),
    ),
    # metrics
    "time_limit": lambda: call(
        metrics.time_limit, numbers, geodesic=floats([1.0], least=0, infinite=True)
    ),
    "spl": lambda: call(
        metrics.spl,
        success=floats([1.0, 0.0], ("N",), least=0, most=1),
        shortest=floats([1.0, 2.0], ("N",), least=0),
        travelled=floats([1.0, 2.0], ("N",), least=0),
    ),
    "walls_crossed": lambda: call(
        metrics.walls_crossed,
        caster=a(scene().caster),
        poses=floats(np.stack([POSES, POSES + 0.1]), ("T", "N", 3)),
    ),
    "covered": lambda: call(
        metrics.covered,
        path=floats(POINTS, ("P", 2), empty=False, takes="longer axis 1", refuses="huge"),
        track=floats(POINTS, ("T", 2), empty=False, takes="longer axis 1"),
        collided_at=whole(1, least=0, optional=True),
    ),
    # rollouts
    "rollout": lambda: call(
        lambda **given: driving.rollout(**given).seconds,
        simulation=a(robots()),
        policy=a(Straight()),
        ends=a(driving.ReachGoals(GOALS, 1.0)),
        record=function(lambda *given: None, optional=True),
    ),
    "ReachGoals": lambda: call(
        driving.ReachGoals,
        anything,
        goals=floats(GOALS, ("N", 2)),
        limit=floats([5.0, 5.0], ("N",), least=0, takes="no axes, fewer axes"),
        reached=number(0.3, above=0),
        settle=flag(False),
    ),
    "ReachGoals.after_step": lambda: call(
        driving.ReachGoals(GOALS, 5.0).after_step,
        simulation=a(robots()),
        seconds=floats([0.1, 0.1], (2,), least=0),
        before=floats(POSES, (2, 3)),
    ),
    "NavigationEnds": lambda: call(
        driving.NavigationEnds,
        anything,
        navigation=a(Straight()),
        limit=floats([5.0, 5.0], ("N",), least=0, takes="no axes, fewer axes, more axes"),
    ),
    "NavigationEnds.check_start": lambda: call(
        driving.NavigationEnds(Straight(), 5.0).check_start,
        anything,
        policy=Straight.act,
        count=whole(2, least=0),
    ),
    "NavigationEnds.after_step": lambda: call(
        driving.NavigationEnds(Straight(), 5.0).after_step,
        simulation=a(robots()),
        seconds=floats([0.1, 0.1], (2,), least=0),
        before=POSES,
    ),
    "geodesic_limit": lambda: call(
        driving.geodesic_limit,
        paths=a(paths()),
        starts=floats(POINTS, ("N", 2), takes="longer axis 1", refuses="huge, negative"),
        goals=goals(("N", 2)),
    ),
    # control
    "checked_waypoints": lambda: call(
        composed.checked_waypoints,
        waypoints=floats(POINTS, (2, 2)),
        robots=whole(2, least=0, refuses="huge"),
    ),
    "ComposedController": lambda: call(
        driving.ComposedController, anything, predictor=a(Straight()), controller=a(RMP)
    ),
    "ComposedController.act": lambda: call(
        driving.ComposedController(Straight(), RMP).act,
        observations=a(robots().observe()),
        targets=[0, 0],
    ),
    "RandomWaypoints": lambda: call(composed.RandomWaypoints, anything, rng=a(rng())),
    "RandomWaypoints.predict": lambda: call(
        composed.RandomWaypoints(rng()).predict, observations=a(robots().observe()), targets=None
    ),
    "TargetPolicy": lambda: call(
        driving.TargetPolicy, anything, controller=a(Straight()), targets=[0, 1]
    ),
    "TargetPolicy.act": lambda: call(
        driving.TargetPolicy(Straight(), np.zeros(2)).act, **under_way()
    ),
    "SmoothedPolicy": lambda: call(
        smoothed.SmoothedPolicy,
        anything,
        predictor=a(Straight()),
        controller=a(RMP),
        targets=[0, 1],
        share=number(0.3, above=0, most=1),
    ),
    "SmoothedPolicy.act": lambda: call(
        smoothed.SmoothedPolicy(Straight(), RMP, np.zeros(2)).act, **under_way()
    ),
    "OraclePolicy": lambda: call(
        driving.OraclePolicy,
        anything,
        simulation=a(robots()),
        paths=a(paths()),
        goals=goals((2, 2)),
        controller=a(RMP, optional=True),
    ),
    "OraclePolicy.act": lambda: call(
        driving.OraclePolicy(robots(), paths(), GOALS).act, **under_way()
    ),
    "OraclePolicy.waypoints": lambda: call(
        driving.OraclePolicy(robots(), paths(), GOALS).waypoints, robots=indices(2, ("M",))
    ),
    "TurnFirst": lambda: call(
        oracle.TurnFirst, anything, oracle=a(driving.OraclePolicy(robots(), paths(), GOALS))
    ),
    "goal_policy": lambda: call(
        rmp.goal_policy,
        offsets=floats(POINTS, (..., 2)),
        velocities=floats(POINTS, (..., 2)),
        gain=number(2.0),
        damping=number(3.0),
        near=number(0.3, above=0),
    ),
    "obstacle_policy": lambda: call(
        rmp.obstacle_policy,
        distances=floats([1.0, 2.0]),
        closing=floats([0.1, 0.1]),
        push=number(0.1),
        brake=number(0.1),
        weight=number(0.3),
        fade=number(0.1, above=0),
    ),
    "heading_policy": lambda: call(
        rmp.heading_policy,
        steerings=floats([0.1, 0.2]),
        wanted=floats([0.1, 0.2]),
        gain=number(6.0),
        weight=number(1.0),
    ),
    "point_jacobian": lambda: call(rmp.point_jacobian, points=floats(POINTS, (..., 2))),
    "control_jacobian": lambda: call(
        rmp.control_jacobian, numbers, body=a(BicycleCar()), controls=floats(POINTS * 0.1, (..., 2))
    ),
    "pull_back": lambda: call(
        rmp.pull_back,
        numbers,
        jacobians=floats(np.ones((3, 2, 2)), (..., 2, 2)),
        accelerations=floats(np.ones((3, 2)), (..., 2)),
        metrics=floats(np.ones((3, 2, 2)), (..., 2, 2)),
    ),
    "resolve": lambda: call(
        rmp.resolve,
        numbers,
        forces=floats(np.ones((3, 2)), (..., 2)),
        metrics=floats(np.tile(np.eye(2), (3, 1, 1)), (..., 2, 2)),
        damping=number(1e-6, above=0),
    ),
    "RMPController": lambda: call(
        driving.RMPController,
        anything,
        body=a(BicycleCar()),
        **{name: number(getattr(RMP, name), least=0) for name in GAINS},
        **{name: number(getattr(RMP, name), above=0) for name in ("near", "fade", "braking")},
    ),
    "RMPController.act": lambda: call(
        RMP.act,
        observations=a(robots().observe()),
        waypoints=floats(POINTS * 0.2, (2, 2)),
    ),
    "RMPController.for_robots": lambda: call(RMP.for_robots, observations=a(robots().observe())),
    "cover": lambda: call(rmp_arcs.cover, body=a(BicycleCar())),
    # recorded data
    "Trajectory": lambda: call(
        trajectories.Trajectory,
        anything,
        world=text("box"),
        seed=whole(0, least=0),
        **trajectory_fields(),
    ),
    "Trajectory.since": lambda: call(
        drives()[0].since, anything, metres=number(1.0, least=0, refuses="huge")
    ),
    "save_trajectories": lambda: in_folder(
        trajectories.save_trajectories, trajectories=several(drives())
    ),
    "RecordedWorld": lambda: call(
        driving.RecordedWorld,
        anything,
        scene=a(scene()),
        trajectories=several(drives(), empty=False),
    ),
    "RecordedWorld.frames_of": lambda: call(
        recorded().frames_of, trajectory=whole(1, least=0, most=1)
    ),
    "RecordedWorld.context": lambda: call(
        recorded().context, frames=frames(), k=whole(2, least=0, refuses="huge")
    ),
    "RecordedWorld.observe": lambda: call(
        recorded().observe, frames=frames(), camera=a(Camera(), optional=True)
    ),
    "RecordedWorld.experience": lambda: call(
        recorded().experience,
        anything,
        trajectory=whole(1, least=0, most=1),
        camera=a(Camera(), optional=True),
    ),
    "RecordedWorld.goals": lambda: call(
        recorded().goals,
        anything,
        frames=frames(),
        k=whole(2, least=0, refuses="huge"),
        camera=a(Camera(), optional=True),
    ),
    "RecordedWorld.poses_at": lambda: call(
        recorded().poses_at, times=floats([0.0, 0.3], ("N",), refuses="negative, huge")
    ),
    "export_recording": lambda: in_folder(
        driving.export_recording,
        "drives.npz",
        recorded=a(recorded()),
        camera=a(Camera(), optional=True),
    ),
    "RecordedWorld.frame_at": lambda: call(
        recorded().frame_at, frames=frames(), ahead=floats([0.5, -0.5], ("N",))
    ),
    "RecordedWorld.draw": lambda: call(
        recorded().draw,
        targets=whole(3, least=0, refuses="huge"),
        starts=whole(2, least=0, refuses="huge"),
        rng=a(rng()),
        close=number(0.5, least=0, most=1),
    ),
    "frames_around": lambda: call(
        recorded_world.frames_around,
        frames=integers([0, 10], ("N",), least=0),
        k=whole(2, least=0, refuses="huge"),
        first=integers([0, 0], ("N",), least=0, takes="no axes, fewer axes"),
        last=integers([12, 12], ("N",), least=0, takes="no axes, fewer axes"),
    ),
    "Perturbation": lambda: call(
        perturbation.Perturbation,
        **{name: number(0.3, least=0) for name in ("aside", "most", "turn", "wide_turn")},
        wide=number(0.4, least=0, most=1),
        beside=number(0.2, least=0, most=1),
        farthest=number(2.5, least=0),
    ),
    "Perturbation.apply": lambda: call(
        driving.PAPER_PERTURBATION.apply, numbers, poses=floats(POSES, ("N", 3)), rng=a(rng())
    ),
    "perturbed": lambda: call(
        driving.perturbed,
        numbers,
        scene=a(scene()),
        poses=floats(POSES, ("N", 3)),
        perturbation=a(driving.PAPER_PERTURBATION),
        rng=a(rng()),
        body=a(BicycleCar(), optional=True),
    ),
    "draw_episodes": lambda: call(
        driving.draw_episodes,
        anything,
        recorded=a(recorded()),
        paths=a(paths()),
        count=whole(2, least=0, refuses="huge"),
        rng=a(rng()),
        least=number(-1.0, either="huge"),
        fewer=flag(True),
    ),
    "with_obstacles": lambda: call(
        episodes.with_obstacles,
        anything,
        episodes=a(four_episodes()),
        each=whole(1, least=1, refuses="huge"),
        count=whole(2, least=0),
        rng=a(rng()),
    ),
    "reachability_pairs": lambda: call(
        driving.reachability_pairs,
        numbers,
        recorded=a(recorded()),
        paths=a(paths()),
        starts=floats(POSES, ("N", 3)),
        targets=frames(),
        field_of_view=number(2.0, above=0, most=2 * np.pi),
    ),
    "draw_reachability_pairs": lambda: call(
        driving.draw_reachability_pairs,
        numbers,
        recorded=a(recorded()),
        paths=a(paths()),
        targets=whole(2, least=0, refuses="huge"),
        rng=a(rng()),
        perturbation=a(driving.PAPER_PERTURBATION),
        field_of_view=number(2.0, above=0, most=2 * np.pi),
    ),
    "demonstrate": lambda: call(
        driving.demonstrate,
        anything,
        world=text("box"),
        scene=a(scene()),
        count=whole(1, least=0, refuses="huge"),
        seed=whole(1, least=0),
        controller=a(RMP, optional=True),
        odometry_noise=a(None, optional=True),
    ),
    "demonstrate_between": lambda: call(
        driving.demonstrate_between,
        anything,
        world=text("box"),
        scene=a(scene()),
        paths=a(paths()),
        starts=floats(POSES[:1], ("N", 3), refuses="negative"),
        goals=floats(GOALS[:1], ("N", 2), refuses="huge, negative"),
        seed=whole(1, least=0),
        odometry_noise=a(None, optional=True),
        body=a(BicycleCar(), optional=True),
    ),
    "demonstrate_on": lambda: call(
        demonstrations.demonstrate_on,
        anything,
        world=text("box"),
        scene=a(scene()),
        paths=a(paths()),
        start=floats(POSES[:1], (1, 3), refuses="negative"),
        goals=floats(GOALS[:1], ("G", 2), empty=False, refuses="huge, negative, shorter G"),
        seed=whole(1, least=0),
        odometry_noise=a(None, optional=True),
        body=a(BicycleCar(), optional=True),
    ),
    "world_seed": lambda: call(
        demonstrations.world_seed,
        seed=whole(1, least=0),
        world=text("box"),
        count=whole(1, least=0),
    ),
}
WITHOUT = {}
