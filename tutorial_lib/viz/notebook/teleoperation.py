"""Teleoperation of a car: a pure function that draws it, and a controller without Jupyter."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.se2 import arc_length, wrap
from tutorial_lib.validation import flag, instance, instances, one_of, whole
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import places_of
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.figures.dashboard import Moment, draw_laser, draw_map
from tutorial_lib.viz.figures.panels import camera_picture, side_by_side, stacked
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import check_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation

MAP, SIDE, MARGIN = 520, 414, 14
ACTIONS = {
    "left": (0.5, 0.45),
    "forward": (0.5, 0.0),
    "right": (0.5, -0.45),
    "back left": (-0.3, 0.45),
    "back": (-0.3, 0.0),
    "back right": (-0.3, -0.45),
    "stop": (0.0, 0.0),
}
"""Each button's speed in m/s and steering in rad."""
STILL, ALONE = 960, 720
"""Pixels: the width of a static strip, and the most that a picture alone in its row has."""
READABLE = 0.55
"""How much of their size the pictures of a strip keep at least."""


def teleop_picture(view: PlanView, moment: Moment, *, hide_map: bool = False) -> Picture:
    """The plan, the camera's image and the laser scan of a moment, 962 x 548 pixels.

    `view` must be `MAP` x `MAP` pixels. `hide_map` leaves the place of the plan empty.
    """
    picture = np.full((MAP + 2 * MARGIN, MAP + SIDE + 2 * MARGIN, 3), colours.PAPER, np.uint8)
    if hide_map:
        label(picture, "the map is hidden", MAP // 2 - 80, MAP // 2)
    else:
        picture[MARGIN : MARGIN + MAP, :MAP] = draw_map(view, moment)
    left, top, high = MAP + 2 * MARGIN, MARGIN, round(SIDE / 3)
    label(picture, "camera", left, top + 18)
    top += 28
    picture[top : top + high, left : left + SIDE] = camera_picture(
        moment.observation.image[0], SIDE, smooth=True
    )
    top += high + 16
    label(picture, "laser, 4 m around", left, top + 18)
    side = MAP + MARGIN - top - 28
    picture[top + 28 : top + 28 + side, left : left + side] = draw_laser(moment, side)
    for i, (name, value) in enumerate(moment.lines):
        label(picture, name, left + side + 14, top + 44 + 62 * i, 0.5, colours.SOLID)
        label(picture, value, left + side + 14, top + 70 + 62 * i)
    return picture


class TeleopController:
    """A car that drives a few steps at each press of a button; the world waits in between.

    Attributes:
        simulation: the car and its world.
        track: its positions (2,), one for each control step.
    """

    def __init__(
        self, scene: Scene, pose: ArrayLike, people: Sequence[Person] = (), steps: int = 5
    ) -> None:
        """Put a car into a scene.

        Args:
            scene: the world.
            pose: (3,) where the car starts.
            people: in the scene.
            steps: control steps of 0.1 s that a press lasts.

        Raises:
            InputError: when the car cannot stand there, or `steps` is less than 1.
        """
        self.scene = instance("scene", scene, Scene)
        self.people = instances("people", people, Person)
        self.steps = whole("steps", steps, least=1)
        self._start = places_of("pose", pose, (3,)).copy()
        check_free(scene, BicycleCar(), self._start[None], "pose")
        self.view = PlanView(scene, MAP, MAP)
        self.reset()

    def reset(self) -> None:
        """Put the car and all people back to their start."""
        sensors = Sensors(camera=Camera(rows=64, columns=192))
        self.simulation = Simulation(
            self.scene, self._start[None], people=self.people, sensors=sensors
        )
        self.track = [self.simulation.poses[0, :2]]

    def press(self, name: str) -> None:
        """Drive for `steps` control steps with the action of the button `name`.

        Raises:
            InputError: when there is no such button.
        """
        one_of("name", name, ACTIONS)
        for _ in range(self.steps):
            self.simulation.step([ACTIONS[name]])
            self.track.append(self.simulation.poses[0, :2])

    @property
    def moment(self) -> Moment:
        """The present state, ready to be drawn."""
        simulation = self.simulation
        x, y, heading = simulation.poses[0]
        lines = (
            ("time", f"{simulation.seconds:.1f} s"),
            ("speed", f"{simulation.speed[0]:+.2f} m/s"),
            ("steering", f"{np.rad2deg(simulation.controls[0, 1]):+.0f} deg"),
            ("heading", f"{np.rad2deg(wrap(heading)):+.0f} deg"),
        )
        return Moment(
            pose=np.array([x, y, heading]),
            footprint=simulation.body.footprint,
            observation=simulation.observe(),
            track=np.array(self.track),
            path=np.empty((0, 2)),
            goal=None,
            discs=simulation.discs,
            lines=lines,
        )

    @property
    def text(self) -> str:
        """One line about the state."""
        driven = arc_length(self.track)[-1]
        words = f"{driven:.1f} m driven in {self.simulation.seconds:.1f} s."
        if self.simulation.touching[0]:
            return f"{words} The car is touching something: go back."
        return words

    def render(self, *, hide_map: bool = False) -> Picture:
        """A picture of the present state."""
        hide_map = flag("hide_map", hide_map)
        return teleop_picture(self.view, self.moment, hide_map=hide_map)

    def rehearse(self, presses: Sequence[str], count: int = 3) -> Picture:
        """A strip of what a fresh car shows during some presses; this car does not move.

        Args:
            presses: names of buttons.
            count: pictures, from before the first press to after the last.
        """
        presses, count = presses_of("presses", presses), whole("count", count, least=1, most=100)
        fresh = TeleopController(self.scene, self._start, self.people, self.steps)
        shown = set(np.linspace(0, len(presses), count).round().astype(int).tolist())
        pictures, titles = [], []
        for i, name in enumerate(["", *presses]):
            if name:
                fresh.press(name)
            if i in shown:
                pictures.append(fresh.render())
                titles.append(f"after {i} presses" if i else "at the start")
        return still_strip(pictures, titles)


def presses_of(name: str, presses: Sequence[str]) -> tuple[str, ...]:
    """Names of buttons, or an `InputError`."""
    return tuple(one_of(name, press, ACTIONS) for press in instances(name, presses, str))


def still_strip(pictures: Sequence[Picture], titles: Sequence[str]) -> Picture:
    """Pictures beside each other, at most `STILL` pixels wide.

    They stand in as many rows as it takes for each to keep `READABLE` of its size.
    """
    width, count = max(picture.shape[1] for picture in pictures), len(pictures)
    fitting = (n for n in range(count, 1, -1) if STILL / n - 16 >= READABLE * width)
    columns = next(fitting, 1)
    scale = min(1.0, min(STILL / columns - 16, ALONE) / width)
    height = round(max(picture.shape[0] for picture in pictures) * scale)
    empty = -count % columns  # places at the end of the last row
    shown = [*pictures, *[np.full_like(pictures[-1], 255)] * empty]
    named = [*titles, *[""] * empty]
    places = [slice(i, i + columns) for i in range(0, count, columns)]
    return stacked([side_by_side(shown[row], named[row], height=height) for row in places])
