"""Interactive widgets: thin shells of ipywidgets around code that needs no Jupyter.

A pure function draws a state, a controller changes it (for the car, both are in `teleoperation`),
and a shell connects them to buttons and sliders. The callbacks need no browser either: click a
button with `.click()`, move a slider by its `.value`.
"""

import base64
import html
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import ipyevents
import ipywidgets
import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, listed, with_methods
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.film import png
from tutorial_lib.viz.notebook.teleoperation import (
    ACTIONS,
    TeleopController,
    presses_of,
    still_strip,
)

KEYS = {
    ("ArrowUp", False): "forward",
    ("ArrowLeft", False): "left",
    ("ArrowRight", False): "right",
    ("ArrowDown", False): "back",
    ("ArrowLeft", True): "back left",
    ("ArrowRight", True): "back right",
    (" ", False): "stop",
}
"""Buttons by key, and whether Shift is held."""


class Shell(ipywidgets.VBox):
    """A box that also leaves a static picture in the notebook.

    Both are in one output: a live notebook shows the widget, a static page the picture.
    """

    def __init__(self, children: Sequence[ipywidgets.Widget], still: Callable[[], Picture]) -> None:
        """Take the box's contents and the function that draws the static picture on display."""
        super().__init__(children)
        self.still = still

    def _repr_mimebundle_(self, **keywords: Any) -> dict[str, Any]:  # noqa: ANN401 - IPython's
        bundle = super()._repr_mimebundle_(**keywords) or {}
        return {**bundle, "image/png": base64.b64encode(png(self.still())).decode("ascii")}


class PressPanel(Shell):
    """Buttons, a picture and a line of text for a controller, see `presses`.

    Attributes:
        buttons: by name.
        picture: what is shown, as PNG.
        line: text about the state.
    """

    def __init__(
        self,
        controller: Any,  # noqa: ANN401 - see `presses`
        names: Sequence[str],
        still: Callable[[], Picture],
        wide: str = "14em",
    ) -> None:
        """Make a button for each name, `wide`; `still` draws the static picture."""
        self.controller = controller
        self.picture, self.line = ipywidgets.Image(format="png"), ipywidgets.HTML()
        self.buttons = {
            name: ipywidgets.Button(description=name, layout=ipywidgets.Layout(width=wide))
            for name in names
        }
        for button in self.buttons.values():
            button.on_click(lambda button: self.press(button.description))
        self.refresh()
        super().__init__([self.picture, self.line, *self._rows()], still)

    def press(self, name: str) -> None:
        """What happens when a button is pressed."""
        self.line.value = _words(f"{name} …")
        try:
            self.controller.press(name)
        except Exception as error:  # a callback has no cell to print in, so the error would be lost
            self.line.value = _words(f"{type(error).__name__}: {error}", "b")
        else:
            self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the controller's present picture and text."""
        _put(self.picture, self.controller.render())
        self.line.value = _words(self.controller.text)

    def _rows(self) -> list[ipywidgets.Widget]:
        """The buttons in rows."""
        return [ipywidgets.HBox([*self.buttons.values()])]


def presses(controller: Any) -> PressPanel:  # noqa: ANN401 - a protocol would be longer
    """Buttons that do something to what a controller shows, as a cell's last line.

    Args:
        controller: has `actions`, names of buttons; `press(name)`; `render()`, a picture (H, W, 3)
            uint8 RGB, which also stands on a static page; and a `text`.
    """
    with_methods("controller", controller, "press", "render")
    return PressPanel(controller, controller.actions, controller.render)


class TeleopPanel(PressPanel):
    """The same for a `TeleopController`.

    The arrow keys press buttons, too, while the pointer is on the picture; `KEYS` lists them.

    Attributes:
        buttons: by name, with "start again".
        hide_map: hides the map: then the camera and the laser are all there is.
    """

    def __init__(self, controller: TeleopController, rehearsal: Sequence[str]) -> None:
        """Connect buttons to `controller`; `rehearsal` are the presses of the static strip."""
        self.hide_map = ipywidgets.ToggleButton(description="hide the map")
        self.hide_map.observe(self.refresh, names="value")
        names = (*ACTIONS, "start again")
        super().__init__(controller, names, lambda: controller.rehearse(rehearsal, 2), "7.5em")
        self.keyboard = ipyevents.Event(
            source=self.picture, watched_events=["keydown"], prevent_default_action=True
        )
        self.keyboard.on_dom_event(self._typed)

    def press(self, name: str) -> None:
        """What happens when a button is pressed."""
        if name == "start again":
            self.controller.reset()
            self.refresh()
        else:
            super().press(name)

    def _rows(self) -> list[ipywidgets.Widget]:
        row = [*self.buttons.values(), self.hide_map]
        return [ipywidgets.HBox(row[:3]), ipywidgets.HBox(row[3:6]), ipywidgets.HBox(row[6:])]

    def _typed(self, event: Mapping[str, Any]) -> None:
        name = KEYS.get((event.get("key", ""), bool(event.get("shiftKey"))))
        if name:
            self.press(name)

    def refresh(self, *_: object) -> None:
        """Show the controller's present picture, perhaps without its map, and text."""
        _put(self.picture, self.controller.render(hide_map=self.hide_map.value))
        self.line.value = _words(self.controller.text)


def teleop(
    controller: TeleopController,
    rehearsal: Sequence[str] = ("forward", "forward", "left", "left", "left", "forward"),
) -> TeleopPanel:
    """Buttons that drive the car, as a cell's last line."""
    with_methods("controller", controller, "press", "reset", "render", "rehearse")
    return TeleopPanel(controller, presses_of("rehearsal", rehearsal))


Control = ipywidgets.Dropdown | ipywidgets.IntSlider | ipywidgets.FloatSlider


class SliderPanel(Shell):
    """Sliders, a picture and a line of text; see `sliders`.

    Attributes:
        controls: the sliders and menus by name.
        picture: what is shown, as PNG.
        line: text about the values.
    """

    def __init__(
        self,
        render: Callable[..., tuple[Picture, str]],
        ranges: dict[str, tuple[float, float, float, float] | Sequence[str]],
        labels: Mapping[str, str],
    ) -> None:
        """Make a control for each range and draw the first picture."""
        self._render = render
        self._labels = {name: labels.get(name, name.replace("_", " ")) for name in ranges}
        self.controls = {
            name: _control(name, self._labels[name], span) for name, span in ranges.items()
        }
        self.picture, self.line = ipywidgets.Image(format="png"), ipywidgets.HTML()
        self._show(*render(**self.values))
        for control in self.controls.values():
            control.observe(self._changed, names="value")
        super().__init__([*self.controls.values(), self.picture, self.line], self._strip)

    @property
    def values(self) -> dict[str, Any]:
        """The present values of the controls."""
        return {name: control.value for name, control in self.controls.items()}

    def _changed(self, _: object) -> None:
        try:
            self._show(*self._render(**self.values))
        except Exception as error:  # a callback has no cell to print in, so the error would be lost
            self.line.value = _words(f"{type(error).__name__}: {error}", "b")

    def _show(self, picture: Picture, text: str) -> None:
        _put(self.picture, picture)
        self.line.value = _words(text)

    def _strip(self) -> Picture:
        """The pictures at the first control's low, present and high value."""
        name, control = next(iter(self.controls.items()))
        if isinstance(control, ipywidgets.Dropdown):
            chosen = list(control.options)[:3]
        else:
            chosen = sorted({control.min, control.value, control.max})
        pictures, titles = [], []
        for value in chosen:
            pictures.append(self._render(**{**self.values, name: value})[0])
            shown = value if isinstance(value, str) else f"{value:g}"
            titles.append(f"{self._labels[name]}: {shown}")
        return still_strip(pictures, titles)


def sliders(
    render: Callable[..., tuple[Picture, str]],
    labels: Mapping[str, str] | None = None,
    **ranges: tuple[float, float, float, float] | Sequence[str],
) -> SliderPanel:
    """Sliders that change a picture and a line of numbers, as a cell's last line.

    Args:
        render: called as ``render(**values)``; returns a picture (H, W, 3) uint8 RGB and a text.
        labels: by argument, what stands beside its control, with its unit, as in "push, m/s²"; the
            argument's name unless given.
        ranges: for each argument of `render` either ``(low, high, step, value)`` for a slider,
            of whole numbers if all four are, or a list of words for a menu.

    Raises:
        InputError: when a range is neither, or there is none.
    """
    if not ranges:
        raise InputError("sliders: no range; give name=(low, high, step, value)")
    if not callable(render):
        raise InputError(f"render: {render!r}; give a function")
    labels = {} if labels is None else instance("labels", labels, Mapping)
    return SliderPanel(render, ranges, labels)


def _control(name: str, label: str, span: tuple[float, ...] | Sequence[str]) -> Control:
    look = {
        "description": label,
        "style": {"description_width": "16em"},
        "layout": ipywidgets.Layout(width="40em", max_width="100%"),
    }
    advice = f"sliders: {name}={span!r}; give (low, high, step, value) or words"
    given = listed(f"sliders: {name}", span, "(low, high, step, value) or words")
    if given and all(isinstance(word, str) for word in given):
        return ipywidgets.Dropdown(options=given, value=given[0], **look)
    real = [n for n in given if isinstance(n, int | float | np.integer | np.floating)]
    if not len(real) == len(given) == 4:
        raise InputError(advice)
    low, high, step, value = real
    if not (-np.inf < low <= value <= high < np.inf and 0 < step < np.inf):
        raise InputError(advice)
    if all(isinstance(number, int | np.integer) for number in real):
        return ipywidgets.IntSlider(value=value, min=low, max=high, step=step, **look)
    digits = len(f"{step:g}".partition(".")[2])  # as many as the step has
    return ipywidgets.FloatSlider(
        value=value, min=low, max=high, step=step, readout_format=f".{digits}f", **look
    )


def _put(image: ipywidgets.Image, picture: Picture) -> None:
    """Show a picture at its own size, or smaller where the page is narrower."""
    # In a box an image would otherwise be stretched to the width of the page.
    image.layout.width, image.layout.max_width = f"{picture.shape[1]}px", "100%"
    image.value = png(picture)


def _words(text: str, tag: str = "span") -> str:
    return f'<{tag} style="font-size:1.1em;white-space:pre-line">{html.escape(text)}</{tag}>'
