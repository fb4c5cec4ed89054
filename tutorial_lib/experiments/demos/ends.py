"""Start and goal of a demo as a user gives them: a pose, or a room by its name."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from tutorial_lib.driving.geodesics import CLEARANCE, GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import Body
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene


@dataclass(frozen=True)
class End:
    """A start or a goal.

    Attributes:
        option: that it was given by, for messages.
        room: its name, or empty.
        pose: x, y and heading, or none.
    """

    option: str
    room: str = ""
    pose: tuple[float, float, float] | None = None

    def find(self, scene: Scene, paths: GridPaths, body: Body) -> Array:
        """Its pose (3,); the heading is NaN where a room leaves it open.

        Raises:
            InputError: when the room is unknown, or `body` cannot stand there or drive to there.
        """
        if self.pose is None:
            return np.append(self._roomiest(scene.plan, paths), np.nan)
        pose = np.array(self.pose)
        x, y, heading = pose
        where = f"{self.option}: at ({x:.2f}, {y:.2f}) heading {heading:.2f}"
        if not is_free(scene, body, pose[None])[0]:
            raise InputError(
                f"{where} the robot would be inside a wall, furniture or outside all rooms; "
                "choose another place"
            )
        node = paths.nearest(pose[:2])[0]
        if node < 0 or not paths.largest[node]:
            raise InputError(
                f"{where} the robot would be cut off from the rest of the plan; "
                "choose another place"
            )
        return pose

    def _roomiest(self, plan: FloorPlan, paths: GridPaths) -> Array:
        """The place (2,) in the room that is farthest from walls."""
        names = room_names(plan)
        known = [i for i, name in enumerate(names) if self.room in (name, plan.rooms[i].kind)]
        if not known:
            raise InputError(
                f"{self.option}: no room is called {self.room!r}; there are {', '.join(names)}"
            )
        # Off the walls a little.
        roomy = paths.largest & (paths.clearance > CLEARANCE + 0.1)
        for room in known:
            nodes = np.flatnonzero(plan.rooms[room].contains(paths.points) & roomy)
            if len(nodes):
                return paths.points[nodes[paths.clearance[nodes].argmax()]]
        raise InputError(f"{self.option}: no path leads into {self.room}; choose another room")


def parse_end(option: str, text: str) -> End:
    """What `--start` or `--goal` is given: x,y,heading, or a room's name.

    Raises:
        InputError: when it is neither.

    >>> parse_end("--goal", "kitchen").room
    'kitchen'
    >>> parse_end("--start", "1, 2.5, 0").pose
    (1.0, 2.5, 0.0)
    """
    parts = text.split(",")
    if len(parts) == 1 and text.strip() and _number(text) is None:
        return End(option, room=" ".join(text.split()))
    numbers = [_number(part) for part in parts]
    if len(numbers) != 3 or None in numbers:
        raise InputError(
            f"{option} {text}: give x,y,heading in metres and radians, or a room's name"
        )
    x, y, heading = (float(number) for number in numbers if number is not None)
    if abs(heading) > 2 * np.pi:
        raise InputError(f"{option} {text}: the heading is in radians; give -6.28 to 6.28")
    return End(option, pose=(x, y, heading))


def room_names(plan: FloorPlan) -> list[str]:
    """A name for each room: its kind, with a number where several are of it."""
    counts, seen, names = Counter(room.kind for room in plan.rooms), Counter[str](), []
    for room in plan.rooms:
        seen[room.kind] += 1
        alone = counts[room.kind] == 1
        names.append(room.kind if alone else f"{room.kind} {seen[room.kind]}")
    return names


def _number(text: str) -> float | None:
    """A finite number; None for any other text."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if np.isfinite(number) else None
