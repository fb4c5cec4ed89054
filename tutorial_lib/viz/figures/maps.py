"""A topological map over the plan from above, and a drive that was planned over it."""

from numpy.typing import ArrayLike

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.interfaces import Plan
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import instance
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.topomaps import draw_plan, draw_topomap
from tutorial_lib.viz.figures.panels import faded
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.scene import Scene

_FADED = 0.6  # of the plan, under the map


def map_view(
    scene: Scene, topomap: TopoMap, poses: ArrayLike, bounds: ArrayLike | None = None
) -> PlanView:
    """The plan with a map on it; its walls stay dark.

    Args:
        scene: the world.
        topomap: of V vertices.
        poses: (V, 3) at which they were recorded.
        bounds: x0, y0, x1, y1 of the part that is shown; all unless given.
    """
    view = pale_view(scene, bounds)
    draw_topomap(view, view.base, topomap, poses)
    return view


def pale_view(scene: Scene, bounds: ArrayLike | None = None, side: int = 720) -> PlanView:
    """The plan made pale, so that a map on it stands out, `side` x `side` pixels; walls stay dark.

    `bounds` are those of `PlanView`.
    """
    view = PlanView(scene, side, side, bounds=bounds)
    view.base = faded(view.base, _FADED)
    for wall in scene.plan.walls:
        view.polyline(view.base, wall.reshape(2, 2), colours.SOLID, 1)
    return view


def drive_picture(
    recorded: RecordedWorld, topomap: TopoMap, plan: Plan, track: ArrayLike, goal: ArrayLike
) -> Picture:
    """A map, the path that was planned over it, and how the robot drove.

    Args:
        recorded: the drives from whose experiences the map was learned.
        topomap: the map.
        plan: a path over it.
        track: (T, 3) poses of the robot, which is shown at the last one.
        goal: (3,) pose at which the goal image was taken.
    """
    instance("topomap", topomap, TopoMap)
    poses = instance("recorded", recorded, RecordedWorld).poses_at(topomap.vertices.timestamps)
    track, goal = places_of("track", track, ("T", 3), empty=False), places_of("goal", goal, (3,))
    instance("plan", plan, Plan)
    view = map_view(recorded.scene, topomap, poses)
    picture = view.base.copy()
    draw_plan(view, picture, poses, plan.vertices, track[0], goal)
    view.polyline(picture, track[:, :2], colours.ROBOT, 2.5)
    view.robot(picture, track[-1], BicycleCar().footprint)
    return picture
