"""The two parts of what an RMP policy returns."""

from typing import Any

from tutorial_lib.checks.framework.check import WrongAnswer


def two_parts(what: str, answer: object) -> tuple[Any, Any]:
    """The two parts of what a policy gives."""
    if answer is None:
        raise WrongAnswer(f"{what}: your function returned nothing; is a return missing?")
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise WrongAnswer(f"{what}: return two things, the accelerations and the metrics")
    return answer[0], answer[1]
