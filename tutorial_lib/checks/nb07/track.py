"""The check of the filter's loop over a recorded drive, in notebook 07."""

from collections.abc import Callable
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, calling, case, exercise, kind, parts
from tutorial_lib.checks.framework.answers import as_floats, returned
from tutorial_lib.checks.framework.wording import both, number_of
from tutorial_lib.checks.nb07.predict import predict
from tutorial_lib.checks.nb07.small_models import distance
from tutorial_lib.checks.nb07.track_stories import STORIES, Drive, Story
from tutorial_lib.checks.nb07.update import update
from tutorial_lib.geometry import Array
from tutorial_lib.topology.localization import FilterSettings

_TOLERANCE = 1e-9
"""Of beliefs."""
Answer = tuple[Array, list[int], list[int]]
"""Beliefs (T, V + 1), vertices of T steps, and the steps at which the robot looked."""


def formed(what: str, got: tuple[Any, list[int]], story: Story) -> Answer:
    """Beliefs, vertices and looks in the right form.

    Raises:
        WrongAnswer: when they are not what the cells below can use.
    """
    words = "return the beliefs and the vertices, one of each for every step"
    beliefs, vertices = parts(what, returned(what, got[0]), 2, words)
    return _beliefs(what, beliefs, story), _vertices(what, vertices, len(story.odometry)), got[1]


def _beliefs(what: str, beliefs: object, story: Story) -> Array:
    if not isinstance(beliefs, np.ndarray):
        words = "return an array of numpy, as np.array makes of a list of rows"
        raise WrongAnswer(f"{what}: the beliefs are {kind(beliefs)}; {words}")
    try:
        beliefs = as_floats(beliefs)
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what}: the beliefs are no array of numbers") from None
    shape = len(story.odometry), len(story.lengths)
    if beliefs.shape != shape:
        words = "append belief[0], a row, at each step" if beliefs.ndim == 3 else "one row a step"
        raise WrongAnswer(
            f"{what}: beliefs of shape {beliefs.shape}, but {shape} is right; {words}"
        )
    if np.isnan(beliefs).any():
        step = int(np.isnan(beliefs).any(axis=1).argmax())
        words = "is something divided by 0, or used before it is set?"
        raise WrongAnswer(f"{what}: from step {step} on beliefs are not numbers (nan); {words}")
    return beliefs


def _vertices(what: str, vertices: object, count: int) -> list[int]:
    if not isinstance(vertices, list | tuple | np.ndarray):
        raise WrongAnswer(f"{what}: the vertices are {kind(vertices)}; return a list of numbers")
    shape = vertices.shape if isinstance(vertices, np.ndarray) else (len(vertices),)
    if len(shape) != 1:
        raise WrongAnswer(f"{what}: vertices of shape {shape}, but ({count},) is right")
    if len(vertices) != count:
        raise WrongAnswer(
            f"{what}: the vertices have length {len(vertices)} for {number_of(count, 'step')}"
        )
    for step, vertex in enumerate(vertices):
        if isinstance(vertex, bool) or not isinstance(vertex, int | np.integer):
            words = (
                "whole numbers, -1 for off the map; np.zeros(T) makes floats, np.zeros(T, int) none"
            )
            raise WrongAnswer(
                f"{what}: at step {step} the vertex is {vertex!r}, {kind(vertex)}; "
                f"vertices are {words}"
            )
    return [int(vertex) for vertex in vertices]


def same(got: Answer, want: Answer, *_: object) -> bool:
    """Whether two answers are equally good."""
    return np.allclose(got[0], want[0], rtol=0, atol=_TOLERANCE) and got[1:] == want[1:]


def broken(got: Answer, want: Answer, story: Story) -> str:
    """Which part of the rule the first wrong step breaks."""
    if got[2] != want[2]:
        step = min(set(got[2]) ^ set(want[2]))
        if not step:
            return "the robot looks at the first step, since nothing is known yet"
        if step not in want[2]:
            return (
                "look only after a stride since the last prediction, or after rules.interval steps"
            )
        if _since(story, step) >= story.rules.stride:
            return "a robot that has moved a stride since its last prediction predicts, and looks"
        return "rules.interval steps after the last look the robot looks again, wherever it is"
    wrong = np.abs(got[0] - want[0]).max(axis=1) > _TOLERANCE
    if not wrong.any():
        return (
            "the vertex of a step follows from its belief: it stays while that is at least "
            "rules.hysteresis times the greatest; else the one with the greatest, -1 for the last"
        )
    step = int(wrong.argmax())
    if step not in want[2]:
        return "without a look the belief stays as it was; append a row of its own for each step"
    if not step:
        return (
            "the first prior is the same for all states, off the map as well; the likelihoods, at "
            "least rules.least, and rules.unknown behind them, all to the power of rules.sharpness"
        )
    if _since(story, step) >= story.rules.stride:
        return (
            "predict from the belief with the motion since the last prediction, and update that "
            "prior by what is seen at this step"
        )
    return "a look without a motion updates the prior of the last motion, which itself stays"


def _since(story: Story, step: int) -> float:
    """Metres from the pose of the last prediction before a step."""
    last = story.odometry[0]
    for pose in story.odometry[1:step]:
        last = pose if distance(last, pose) >= story.rules.stride else last
    return distance(last, story.odometry[step])


def _due(story: Story, looks: list[int], step: int) -> str:
    """How far, and how long, the robot has gone since it predicted and looked."""
    if not step:
        return "the first one: nothing is known yet, so look"
    last = max((look for look in looks if look < step), default=0)
    return (
        f"{_since(story, step):.2f} m since the last prediction, rules.stride is "
        f"{story.rules.stride:g} m; {number_of(step - last, 'step')} since the last look, "
        f"rules.interval is {story.rules.interval}"
    )


def difference(got: Answer, want: Answer, story: Story) -> str:
    """The first step at which something is wrong."""
    if got[2] != want[2]:
        step = min(set(got[2]) ^ set(want[2]))
        words = "must look there" if step in want[2] else "looks without need"
        return f"at step {step} yours {words} ({_due(story, want[2], step)})"
    apart = np.abs(got[0] - want[0])
    wrong = apart.max(axis=1) > _TOLERANCE
    if wrong.any():
        step = int(wrong.argmax())
        state = int(apart[step].argmax())
        name = "off the map" if state == len(story.lengths) - 1 else f"vertex {state}"
        mine, right = both(got[0][step, state], want[0][step, state], 3)
        return (
            f"at step {step} the belief in {name} is {right}, yours {mine} "
            f"({_due(story, want[2], step)})"
        )
    step = next(i for i, pair in enumerate(zip(got[1], want[1], strict=True)) if pair[0] != pair[1])
    return f"at step {step} the robot is at {want[1][step]}, in yours at {got[1][step]}"


def track(
    odometry: Array,
    look: Callable[[int], Array],
    lengths: Array,
    onward: Array,
    rules: FilterSettings,
) -> tuple[Array, list[int]]:
    """Beliefs (T, V + 1) of a robot, and its vertex, at each step of a drive; see the exercise."""
    count = len(lengths)
    belief = prior = np.full((1, count), 1.0 / count)
    last, waited, vertex = odometry[0], rules.interval, -1
    beliefs, vertices = [], []
    for step, pose in enumerate(odometry):
        motion = distance(last, pose)
        far = motion >= rules.stride
        if far:
            prior = predict(belief, np.array([motion]), lengths, onward)
            last = pose
        waited += step > 0
        if far or waited >= rules.interval:
            seen = np.maximum(look(step), rules.least)
            likelihood = np.append(seen, rules.unknown) ** rules.sharpness
            belief = update(prior, likelihood[None])
            waited = 0
        best = int(belief[0].argmax())
        if belief[0, vertex] < rules.hysteresis * belief[0, best]:
            vertex = -1 if best == count - 1 else best
        beliefs.append(belief[0])
        vertices.append(vertex)
    return np.array(beliefs), vertices


MISTAKES = """
standing still, the same evidence counts again and again in yours: update the prior of the last
motion, not the belief
    update(prior, -> update(belief,
at rest a look begins again with the prior of the last motion, not with the belief: the same
evidence counts once
    update(prior, -> update(prior if far else belief,
each look begins with the prior; yours forgets all that was believed before
    update(prior, -> update(np.full((1, count), 1.0 / count),
predict from the belief after the last look, not from the prior before it
    predict(belief, -> predict(prior,
look at the first step, too: nothing is known yet
    odometry[0], rules.interval, -> odometry[0], 0,
looking costs time: look after a stride or after rules.interval steps, not at each
    if far or waited >= rules.interval: -> if True:
a robot that has not moved looks all the same after rules.interval steps
    waited >= rules.interval: -> waited >= rules.interval and not step:
wait rules.interval steps from one look to the next, not one more: the step right after
a look counts, too
    odometry[0], rules.interval, -> odometry[0], rules.interval + 1,
    waited >= rules.interval -> waited > rules.interval
wait rules.interval steps from one look to the next, not one less
    odometry[0], rules.interval, -> odometry[0], rules.interval - 1,
    waited >= rules.interval -> waited >= rules.interval - 1
after any look the steps of waiting are counted from 0, also after one because of a motion
    waited = 0 -> waited = waited if far else 0
predict once the robot has moved a stride since the last prediction, not at each step
    motion >= rules.stride -> motion > 0
at first, measure the motion from where the robot is at step 0, odometry[0], not from (0, 0, 0)
    vertex = odometry[0] -> vertex = np.zeros(3)
measure the motion from the pose of the last prediction, not from the step before
    waited += step > 0 -> last, waited = pose, waited + (step > 0)
measure the motion from the pose of the last prediction; yours measures it from the start
    last = pose -> pass
measure from the pose of the last prediction to this one; yours adds up the steps between, so that
going to and fro counts as going far
    motion = distance(last, pose)
        -> motion = driven = driven + distance(odometry[max(step - 1, 0)], pose)
    last = pose -> driven = 0.0
    last, waited, vertex = -> driven = 0.0; last, waited, vertex =
turning counts as well: distance(last, pose), not the coordinates alone
    distance(last, pose) -> np.hypot(*(pose - last)[:2])
a motion of just a stride is enough: >=
    motion >= -> motion >
predict with the motion that was measured, not with the stride
    np.array([motion]) -> np.array([rules.stride])
a picture may always deceive: no likelihood below rules.least
    rules.least -> 0.0
off the map any view has the likelihood rules.unknown; append it
    rules.unknown -> 0.0
off the map is the last state: append rules.unknown behind the vertices, not before them
    np.append(seen, rules.unknown) -> np.append(rules.unknown, seen)
first no likelihood below rules.least, then the power; yours has it the other way round
    look(step), -> look(step) ** rules.sharpness,
    (seen, rules.unknown) ** rules.sharpness -> (seen, rules.unknown**rules.sharpness)
all likelihoods to the power of rules.sharpness, that of being off the map as well
    (seen, rules.unknown) ** rules.sharpness -> (seen**rules.sharpness, rules.unknown)
the likelihoods to the power of rules.sharpness
    ** rules.sharpness -> ** 1
return the beliefs, after the look, not the priors
    beliefs.append(belief[0]) -> beliefs.append(prior[0])
off the map is the last state; the robot may be there: vertex -1
    belief[0].argmax() -> belief[0, :-1].argmax()
the robot is off the map where that belief is the greatest, however small; yours waits until it is
above a half
    best = int(belief[0].argmax())
        -> best = count - 1 if belief[0, -1] > 0.5 else int(belief[0, :-1].argmax())
the greatest belief may be that of being off the map: look for it among all states
    belief[0].argmax() -> belief[0, :-1].argmax()
    rules.hysteresis * belief[0, best] -> rules.hysteresis * belief.max()
off the map is a state like the others: the robot stays there, too, while that has rules.hysteresis
times the best belief
    if belief[0, vertex] < -> if vertex == -1 or belief[0, vertex] <
rules.least is for the vertices: off the map the likelihood is rules.unknown, even below it
    (seen, rules.unknown) -> (seen, max(rules.unknown, rules.least))
a belief of just rules.hysteresis times the greatest keeps the vertex: >=
    belief[0, vertex] < -> belief[0, vertex] <=
rules.hysteresis is not always 0.5
    rules.hysteresis * -> 0.5 *
headings jump at half a turn: distance(last, pose) takes the short way round
    distance(last, pose) -> np.hypot(*(pose - last)[:2]) + 0.5 * abs(pose[2] - last[2])
small motions count as well, where rules.stride is small
    distance(last, pose) -> distance(last, pose) * (distance(last, pose) >= 0.05)
nothing is known at first: the vertex begins at -1, and 0 is the first vertex
    rules.interval, -1 -> rules.interval, 0
off the map the vertex is -1, not the number of the last state
    -1 if best == count - 1 else best -> best
the robot stays at its vertex while that has rules.hysteresis times the best belief
    rules.hysteresis * -> 2.0 *
the robot leaves its vertex once another one is clearly more probable
    rules.hysteresis * -> 0.0 *
compare the old vertex's belief with the best one's times rules.hysteresis, not with
rules.hysteresis itself
    rules.hysteresis * belief[0, best] -> rules.hysteresis
"""


def _play(tracks: Callable[..., Any], story: Story) -> tuple[Any, list[int]]:
    """What comes back, and at which steps the function looked."""
    drive = Drive(story)
    odometry, lengths, onward = (a.copy() for a in (story.odometry, story.lengths, story.onward))
    got = tracks(odometry, drive.look, lengths, onward, story.rules)
    for name, given in (("odometry", odometry), ("lengths", lengths), ("onward", onward)):
        if not np.array_equal(given, getattr(story, name)):
            raise WrongAnswer(f"your function changes its argument {name}; make a new array")
    drive.demand_untouched()
    return got, drive.log


_MOTION = "predict takes the motion as an array of one, np.array([metres])"
_SAID = {
    "invalid index to scalar": f"is a number where an array is needed? {_MOTION}",
    "is not subscriptable": f"is a number where an array is needed? {_MOTION}",
    "array is 0-dimensional": _MOTION,
    "truth value of an array": "an array stands where one number is needed. Is the vertex always a "
    "number? It is -1 off the map and at first; belief[0, None] is a whole array",
    "NoneType": "is something None? The vertex is always a number, -1 off the map and at first",
}


_HINTS: dict[type[Exception], str] = {
    TypeError: "look(step) takes the number of a step, predict and update arrays of one row",
    ValueError: "belief and prior have one row, (1, V + 1); the motion is an array of one",
    IndexError: "belief has one row: belief[0] is that of the robot",
}


check_track = exercise(
    track,
    {name: case(story) for name, story in STORIES.items()},
    MISTAKES,
    about="Drives along a row, at standstill, among twins, off the map, and with a kidnapping.",
    example=case(
        np.zeros((40, 3)), lambda step: np.full(5, 0.5), np.ones(6), np.eye(6), FilterSettings()
    ),
    calls=20,
    run=_play,
    invoke=calling(_HINTS, _SAID, _play),
    form=formed,
    same=same,
    difference=difference,
    broken=broken,
)
