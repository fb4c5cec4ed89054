"""What a demo's film shows of one moment: of agents with a map, and of an oracle."""

from dataclasses import dataclass, replace

import numpy as np

from tutorial_lib.agents.ltvn_navigation import LTVNNavigation
from tutorial_lib.agents.ltvn_state import GOAL
from tutorial_lib.agents.navigator import MapNavigation
from tutorial_lib.driving.geodesics import DistanceFields
from tutorial_lib.se2 import Array, arc_length
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.maintenance import Maintenance
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.dashboard import Moment
from tutorial_lib.world.sensors import Camera, PanoramicCamera
from tutorial_lib.world.simulation import Simulation

SHARP = Camera(rows=64, columns=192)
"""For the film; the network looks at 16 x 64 pixels."""


def sharp(camera: Camera | PanoramicCamera | None) -> Camera:
    """What shows on the film what a camera sees; as the usual one where it is none of its kind."""
    if not isinstance(camera, Camera):
        return SHARP
    return replace(SHARP, field_of_view=camera.field_of_view)


@dataclass(frozen=True)
class BySight:
    """Moments of an agent that navigates over a map.

    Attributes:
        navigation: of the agent.
        vertices: (V, 3) poses at which the map's vertices were recorded.
        goal: (3,) pose at which the goal image was taken.
        image: of the goal.
        map: name of the map's file.
    """

    navigation: MapNavigation
    vertices: Array
    goal: Array
    image: Picture
    map: str

    def __call__(self, simulation: Simulation, track: Array) -> Moment:
        """The plan over its anchors to the goal, and its probability."""
        plans, memory = self.navigation.history[0], self.navigation.follower.memory
        here, count = max(int(memory.active[0]), 0), len(plans[-1].vertices)
        ahead = [self.vertices[vertex, :2] for vertex in plans[-1].vertices[here:]]
        path = np.stack([simulation.poses[0, :2], *ahead, self.goal[:2]])
        searches = self.navigation.plans[0] is None
        doing = "searches" if searches else State(memory.state[0]).name.replace("_", " ").lower()
        lines = (
            ("time", f"{simulation.seconds:.1f} s"),
            ("probability of the plan", f"{plans[-1].probability:.1%}"),
            ("anchor", f"{min(here + 1, count)} of {count}" if here < count else "the goal"),
            ("state", doing),
            ("map", self.map),
        )
        return _moment(simulation, track, path, self.goal, lines, self.image)


@dataclass(frozen=True)
class OnLivingMap:
    """Moments of an agent whose map mends itself.

    Attributes:
        navigation: of the agent.
        upkeep: of its map.
        vertices: (V, 3) poses at which the map's images were taken.
        goal: (3,) pose at which the goal image was taken.
        image: of the goal.
        door: whether it is open, in words.
    """

    navigation: LTVNNavigation
    upkeep: Maintenance
    vertices: Array
    goal: Array
    image: Picture
    door: str

    def __call__(self, simulation: Simulation, track: Array) -> Moment:
        """The plan over vertices to the goal, and the edge that is driven."""
        state, path = self.navigation.states[0], np.empty((0, 2))
        if state.path:
            ahead = self.vertices[state.path[1:], :2]
            path = np.concatenate([simulation.poses[0, None, :2], ahead, self.goal[None, :2]])
        counts = map_counts(self.upkeep)
        lines = (
            ("time", f"{simulation.seconds:.1f} s"),
            ("door", self.door),
            ("robot", self._doing()),
            ("edges of the map", f"{counts['edges']}"),
            ("pruned; returned", f"{counts['pruned']}; {counts['returned']}"),
        )
        return _moment(simulation, track, path, self.goal, lines, self.image)

    def _doing(self) -> str:
        """What the robot does, in words."""
        if self.navigation.arrived[0]:
            return "is there"
        leg = self.navigation.states[0].leg
        if leg is None:
            return "looks around"
        if leg.target == GOAL:
            return "drives to the goal"
        edge = self.upkeep.graph.get_edge_data(leg.source, leg.target)
        words = "reverses" if leg.reverse else "drives"
        return words if edge is None else f"{words}, p(edge) {edge['probability']:.2f}"


def map_counts(upkeep: Maintenance) -> dict[str, int]:
    """Edges of a map, edges that are pruned now, and how often one has returned so far."""
    return {
        "edges": upkeep.graph.number_of_edges(),
        "pruned": len(upkeep.pruned),
        "returned": sum(event.kind == "returned" for event in upkeep.events),
    }


@dataclass(frozen=True)
class ByOracle:
    """Moments of an oracle, which knows the floor plan and its pose.

    Attributes:
        fields: of distances to the goal.
        image: of the goal.
    """

    fields: DistanceFields
    image: Picture

    def __call__(self, simulation: Simulation, track: Array) -> Moment:
        """The geodesic to the goal, and its length."""
        path = self.fields.path(simulation.poses[0, :2])
        lines = (
            ("time", f"{simulation.seconds:.1f} s"),
            ("to go", f"{arc_length(path)[-1]:.1f} m"),
            ("speed", f"{simulation.speed[0]:+.2f} m/s"),
            ("steering", f"{np.rad2deg(simulation.controls[0, 1]):+.0f} deg"),
        )
        return _moment(simulation, track, path, self.fields.goals[0], lines, self.image)


def _moment(
    simulation: Simulation,
    track: Array,
    path: Array,
    goal: Array,
    lines: tuple[tuple[str, str], ...],
    image: Picture,
) -> Moment:
    pose = simulation.poses[0]
    seen = simulation.observe()
    image_now = sharp(seen.camera).look(simulation.scene, pose[None], simulation.discs)[0]
    return Moment(
        pose,
        simulation.body.footprint,
        replace(seen, image=image_now),
        track,
        path,
        goal[:2],
        simulation.discs,
        lines,
        image,
    )
