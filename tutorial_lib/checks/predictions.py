"""Predictions that a student commits to, and what is shown then.

A prediction stands below a picture that answers it. Who clicks an option, or calls `commit`, sees
their own choice, what the robot does, what is right, and why a wrong answer tempts. The robot is
called by its name. The first choice is kept in `my_answers`, shown by ``progress``, and never
marked.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any

import numpy as np

from tutorial_lib.checks.framework import record
from tutorial_lib.checks.robot import robot_name
from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, instances, one_of
from tutorial_lib.viz.canvas.given import Picture, picture_of
from tutorial_lib.viz.figures.panels import TITLE, line_of_text, stacked
from tutorial_lib.viz.notebook.display import STATIC
from tutorial_lib.viz.notebook.widgets import PressPanel

_LETTER = 8  # pixels of a letter of a static picture's text
_GAP = 4  # pixels between a static picture and its text
_NARROWEST = 560  # pixels of a static picture, or its text would be cut into too many lines


@dataclass(eq=False)
class Prediction:
    """A question with a few options; as a cell's last line it is shown with a button for each.

    Attributes:
        notebook: its number, as in "05".
        name: under which the choice is kept, and by which a cell calls `commit`.
        ask: the question.
        options: what each letter stands for.
        right: the letter of the right option.
        robot: what the robot does, or thinks, as a sentence.
        tempting: the letter of the wrong option that tempts most.
        because: why it tempts, and why it is wrong, as a sentence or two.
        before: the picture (H, W, 3) that answers the question.
        after: the picture that shows the answer; `before` unless given.
        choice: the letter that was chosen last; empty before.

    Raises:
        InputError: when there are not two to four options, or a letter is none of them.
    """

    notebook: str
    name: str
    ask: str
    options: Mapping[str, str]
    right: str = field(repr=False)
    robot: str = field(repr=False)
    tempting: str = field(repr=False)
    because: str = field(repr=False)
    before: Picture = field(repr=False)
    after: Picture | None = field(default=None, repr=False)
    choice: str = field(default="", init=False)
    _answer_picture: Picture = field(init=False, repr=False)
    _panel: PressPanel | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        if not 2 <= len(instance("options", self.options, Mapping)) <= 4:
            raise InputError(f"options: {len(self.options)}; give two to four")
        instances("options", list(self.options.values()), str)
        one_of("right", self.right, self.options)
        one_of("tempting", self.tempting, self.options)
        if self.tempting == self.right:
            raise InputError(f"tempting: {self.tempting!r} is right; give a wrong option")
        self.before = picture_of("before", self.before)
        after = self.before if self.after is None else picture_of("after", self.after)
        self.after = self._answer_picture = after
        self.choice = record.predictions(self.notebook).get(self.name, {}).get("choice", "")
        if self.choice not in self.options:
            self.choice = ""

    def commit(self, choice: str) -> Prediction:
        """Choose an option, keep the choice unless there is one already, and show the answer.

        Raises:
            InputError: when there is no such option.
        """
        self.press(choice)
        self.panel.refresh()
        return self

    @property
    def actions(self) -> tuple[str, ...]:
        """The letters, for the buttons."""
        return tuple(self.options)

    def press(self, choice: str) -> None:
        """What a button does; see `commit`.

        Raises:
            InputError: when there is no such option, or the choice cannot be kept.
        """
        self.choice = one_of("choice", choice, self.options)
        record.keep_prediction(self.notebook, self.name, choice, self.right)

    def render(self) -> Picture:
        """The picture that is asked about, or the one that shows the answer."""
        return self._answer_picture if self.choice else self.before

    @property
    def text(self) -> str:
        """The question, or the answer, in a few lines."""
        if not self.choice:
            first = self.actions[0]
            hint = f'Click a letter, or run {self.name}.commit("{first}") in a cell of your own.'
            return "\n".join([self.ask, *self._listed(), hint])
        own = f"You: {self.choice}, {self.options[self.choice]}"
        return "\n".join(
            [own + (". Right!" if self.choice == self.right else "."), *self._answer()]
        )

    @property
    def panel(self) -> PressPanel:
        """Picture, text and buttons; one for all cells that show the prediction."""
        if self._panel is None:
            self._panel = PressPanel(self, self.actions, self._still, "5em")
        return self._panel

    def _repr_mimebundle_(self, **keywords: Any) -> dict[str, Any]:  # noqa: ANN401 - IPython's
        return self.panel._repr_mimebundle_(**keywords) | {"text/plain": self.text}

    def _listed(self) -> list[str]:
        return [f"{letter}: {words}" for letter, words in self.options.items()]

    def _answer(self) -> list[str]:
        right = f"The right answer is {self.right}: {self.options[self.right]}."
        return [
            f"{robot_name()}: {self.robot}",
            *([right] if self.choice != self.right else []),
            f"{self.tempting} tempts: {self.because}",
        ]

    def _still(self) -> Picture:
        """The picture above its text; on a page that is stored, with the answer."""
        told = bool(self.choice) or not os.environ.get(STATIC)
        lines = self.text.split("\n") if told else [self.ask, *self._listed(), *self._answer()]
        picture = self.render() if told else self._answer_picture
        wide = max(picture.shape[1], _NARROWEST)
        text = np.concatenate([line_of_text(line, wide) for line in _fitted(lines, wide)])
        return stacked([picture, text], gap=_GAP)


def without_text(still: Picture, text: str) -> Picture:
    """The picture of a prediction's static page without the text that stands below it."""
    lines = len(_fitted(text.split("\n"), still.shape[1]))
    return still[: len(still) - lines * TITLE - _GAP]


def _fitted(lines: list[str], width: int) -> list[str]:
    """Lines that are cut where they would not fit into so many pixels."""
    return [part for line in lines for part in wrap(line, width // _LETTER)]
