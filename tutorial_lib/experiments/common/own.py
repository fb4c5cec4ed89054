"""A class of the user's own in an experiment, from "FILE.py:CLASS", and what it does wrong."""

import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from textwrap import shorten
from types import FunctionType, ModuleType
from typing import Any

from tutorial_lib.array_forms import quoted
from tutorial_lib.errors import InputError, words_of
from tutorial_lib.experiments.common.report import Fault
from tutorial_lib.learning.views import view_of
from tutorial_lib.reading.limits import MAX_TEXT
from tutorial_lib.reading.regular import read_bytes
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive
from tutorial_lib.world.sensors import Camera

CUSTOM = "custom"
"""The name of its rows."""
_TARGETS = {"view": None, "k": None, "prepare": "contexts"}
MEMBERS = {
    "agent": {"learn": "experiences", "start": "goals"},
    "explorer": {"start": "goals", "act": "observations, running"},
    "planner": {"plan": "observation, goals, topomap, excluded"},
    "localizer": {"localize": "observations, topomap"},
    "reachability": {"prepare": "targets", "probability": "observations, prepared"},
    "predictor": {**_TARGETS, "predict": "observations, targets"},
    "local controller": {**_TARGETS, "act": "observations, targets"},
    "controller": {"act": "observations, waypoints"},
}
"""What a class can be, see `tutorial_lib.interfaces`, and the members that make it that: what each
method is called with, in this order; None for what is no method."""
_WHOLE = ("agent", "explorer")
"""Those that are whole systems, and have members of their parts, too."""
OPTIONAL = {"explorer": {"look_for": "goals"}, "reachability": {"embed": "observations"}}
"""The same as in `MEMBERS`, for methods that it need not have."""
_RETURNED: dict[Path, FunctionType] = {}
"""By file of users' code, the method that returned last: what it gave is found wrong later."""


def load_own(where: str, seams: Sequence[str]) -> tuple[str, Any]:
    """An instance of the user's class, made without arguments, and what it is.

    Args:
        where: "FILE.py:CLASS".
        seams: what the experiment can compare, of `MEMBERS`; of several that fit the first counts.

    Raises:
        InputError: if there is no such file or class, if it cannot be instantiated, if it has the
            members of none of the seams, or if a method of it cannot be called as it will be.
    """
    part = guarded(where, _instantiate, where)
    missing = {seam: _missing(where, part, seam) for seam in seams}
    fits = [seam for seam in seams if not missing[seam]]
    other = next((seam for seam in _WHOLE if not _missing(where, part, seam)), None)
    if other and other not in seams:
        raise InputError(
            f"--agent {where}: is an {other}, with {' and '.join(MEMBERS[other])}; this experiment "
            f"compares what is a {' or a '.join(seams)}"
        )
    if fits:
        guarded(where, _check_methods, part, fits[0])
        return fits[0], part
    needed = "; ".join(f"{seam}: {', '.join(MEMBERS[seam])}" for seam in seams)
    begun = [seam for seam in seams if len(missing[seam]) < len(MEMBERS[seam])]
    nearest = min(begun, key=lambda seam: len(missing[seam]), default=None)
    lacks = f"; as {nearest} it lacks {', '.join(missing[nearest])}" if nearest else ""
    raise InputError(f"--agent {where}: has the methods of no component ({needed}){lacks}")


def _missing(where: str, part: Any, seam: str) -> list[str]:  # noqa: ANN401
    """The members that a user's object lacks to be what a seam takes."""
    return [name for name in MEMBERS[seam] if not guarded(where, hasattr, part, name)]


def load_robot(where: str) -> tuple[BicycleCar | DifferentialDrive, Camera]:
    """The body and the camera that a class or a function of the user's makes.

    It is called without arguments, and makes a body, or a pair of a body and a camera; with a body
    alone goes the usual camera.

    Args:
        where: "FILE.py:NAME".

    Raises:
        InputError: as `load_own` does, when it is no body that the controllers drive, and when the
            camera differs from the usual one in more than its whole degrees.
    """
    made = guarded(where, _instantiate, where, option="--robot")
    body, camera = made if isinstance(made, tuple) and len(made) == 2 else (made, Camera())
    if not isinstance(body, BicycleCar | DifferentialDrive):
        raise InputError(
            f"--robot {where}: made {quoted(body)}; give what makes a BicycleCar or a "
            "DifferentialDrive, or a pair of such a body and a Camera"
        )
    return body, guarded(where, view_of, camera, option="--robot").camera


def guarded(
    where: str,
    run: Callable[..., Any],
    *arguments: Any,  # noqa: ANN401
    option: str = "--agent",
) -> Any:  # noqa: ANN401
    """Call `run` with the user's agent; whatever their code raises becomes a clear message.

    Raises:
        InputError: with the file, the line and the error, in one line.
    """
    try:
        return run(*arguments)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise InputError(f"{option} {where}: {_fault(where, error)}") from error


def or_fault(where: str, run: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
    """The same, but a fault is returned and said at once on stderr: other rows are not lost."""
    try:
        return guarded(where, run, *arguments)
    except InputError as error:
        print(f"error: {error}; the other rows go on", file=sys.stderr, flush=True)
        return Fault(error)


def _instantiate(where: str) -> Any:  # noqa: ANN401
    file, _, name = where.rpartition(":")
    path = Path(file)
    if not file or not name.isidentifier():
        raise InputError("give FILE.py:CLASS, as in my_agent.py:MyPlanner")
    if not path.exists():
        raise InputError(f"there is no file {file}")
    read_bytes(path, MAX_TEXT, "give a file of Python code")
    spec = importlib.util.spec_from_file_location(f"custom_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{file} is no Python file; its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    folder = str(path.resolve().parent)  # last, so that none of its files hides another module
    if folder not in sys.path:
        sys.path.append(folder)
    spec.loader.exec_module(module)
    _watch(module, path.resolve())
    known = getattr(module, name, None)
    if known is None:
        raise InputError(f"{file} has no {name}")
    if not callable(known):
        raise InputError(f"{name} is {quoted(known)}; give the class itself, or a function")
    try:
        takes = inspect.signature(known)
    except ValueError:  # it has none, as what is not written in Python
        return known()
    try:
        takes.bind()
    except TypeError:
        words = shorten(str(takes), 100, placeholder=" ...")
        raise InputError(
            f"{name} is made without arguments, but takes {words}; give them defaults"
        ) from None
    return known()


def _check_methods(part: Any, seam: str) -> None:  # noqa: ANN401
    """Refuse a method that takes fewer or more arguments than it is called with."""
    for name, arguments in (MEMBERS[seam] | OPTIONAL.get(seam, {})).items():
        if arguments is None or not hasattr(part, name):
            continue
        method = getattr(part, name)
        if not callable(method):
            raise InputError(f"{name} of this {seam} is {quoted(method)}; make it a method")
        try:
            takes = inspect.signature(method, follow_wrapped=False)
        except (TypeError, ValueError):  # it has none, as what is not written in Python
            continue
        try:
            takes.bind(*arguments.split(", "))
        except TypeError:
            words = shorten(str(takes), 100, placeholder=" ...")
            raise InputError(
                f"{name} of this {seam} is called with ({arguments}), but takes {words}"
            ) from None


def _watch(module: ModuleType, file: Path) -> None:
    """Note which method of the classes of a module returned last."""
    _RETURNED.pop(file, None)
    for kind in list(vars(module).values()):
        if isinstance(kind, type) and kind.__module__ == module.__name__:
            for name, value in list(vars(kind).items()):
                if isinstance(value, FunctionType) and not name.startswith("__"):
                    setattr(kind, name, _noted(value, file))


def _noted(method: FunctionType, file: Path) -> Callable[..., Any]:
    @wraps(method)
    def call(*arguments: Any, **named: Any) -> Any:  # noqa: ANN401
        result = method(*arguments, **named)
        _RETURNED[file] = method
        return result

    vars(call)["__signature__"] = inspect.signature(method, follow_wrapped=False)
    return call


def _fault(where: str, error: BaseException) -> str:
    """The error, and the line of the user's file in which it was raised.

    What the library refuses after a method has returned is raised in none: then the method is
    named, and the line in which it begins.
    """
    file = Path(where.rpartition(":")[0]).resolve()
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename).resolve() == file
    ]
    # A SyntaxError has no frame in the file that it concerns.
    line = lines[-1] if lines else getattr(error, "lineno", None)
    words = str(error) if isinstance(error, InputError) else words_of(error)
    if line:
        return f"{file.name}, line {line}: {words}"
    method = _RETURNED.get(file)
    if method is None:
        return words
    return f"{file.name}, line {method.__code__.co_firstlineno}, after {method.__name__}: {words}"
