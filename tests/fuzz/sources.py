"""Agents of one's own that go wrong in every way that anybody thought of."""

from itertools import product

_ERRORS = {
    "value": "class Fault(ValueError): pass",
    "base": "class Fault(BaseException): pass",
    "exit": "Fault = SystemExit",
    "generator": "Fault = GeneratorExit",
    "mute": "class Fault(Exception):\n    def __str__(self): raise RuntimeError('no words')",
    "mute_base": "class Fault(BaseException):\n    def __str__(self): raise Fault('no words')",
    "group": "Fault = lambda words: ExceptionGroup(str(words), [ValueError(words)] * 3)",
    "recursion": "def Fault(words): return Fault(words)",
}
_WORDS = {
    "short": "'it went wrong'",
    "lines": "'one\\ntwo\\r\\nthree\\x1b[2J\\x00'",
    "long": "'many words ' * 10_000",
    "half": "'half a character \\ud800'",
    "bytes": "b'\\xff\\xfe'",
}
_AGENT = """
import numpy as np
{error}
{top}
class Agent:
    {body}
    def __init__(self):
        {init}
    def learn(self, experiences):
        {learn}
    def start(self, goals):
        return self
"""
_PLACES = ("top", "init", "learn", "getattr", "class_getattr")
_RETURNED = (
    "np.full((3, 2), 0.5)",
    "np.full((3, 2), 0.5 + 1j)",
    "[[0.1, 0.2], [1j, 0.0], [0.1, 0.2]]",
    "[[0.1, 0.2], [0.1], [0.1, 0.2]]",
    "np.full((3, 2), '0.5')",
    "np.full((3, 2), np.nan)",
    "np.full((3, 2), None)",
    "np.full((3, 3), 0.5)",
    "'0.5' * 3",
    "{'speed': 1}",
    "iter([1, 2])",
    "None",
    "type('Odd', (), {'__array__': lambda *_, **__: 1 / 0})()",
    "type('Odd', (), {'__len__': lambda _: 3, '__getitem__': lambda *_: 1 / 0})()",
    "np.array([['2020-01-01'] * 2] * 3, dtype='M8[D]')",
)
_WHOLE = (
    "",
    "\0",
    "class Agent: pass",
    "Agent = 5",
    "class Agent:\n    def __init__(self, needed): pass",
    "def Agent(): return Agent",
    "Agent = lambda: 1 / 0",
    "class Agent(",
    "raise" + " (" * 300,
    "x = " + "(" * 5_000,
    "import nothing_of_this_name",
    "# -*- coding: nonsense -*-",
    "class M(type):\n    def __call__(cls): raise BaseException\nclass Agent(metaclass=M): pass",
    "import sys\nsys.exit('one\\ntwo')",
    "exec(compile('1 / 0', 'a\\0b', 'exec'))",
)


def _filled(place: str = "", error: str = "value", words: str = "short", result: str = "") -> str:
    """The source of an agent that raises an error in a place, or returns something."""
    fault = f"raise Fault({_WORDS[words]})"
    parts = dict.fromkeys(("top", "body", "init"), "pass") | {"learn": f"return {result}"}
    if place == "getattr":
        parts["body"] = f"def __getattr__(self, name): {fault}"
        parts["learn"] = "return self.nothing"
    elif place == "class_getattr":
        parts["body"] = f"def __getattribute__(self, name): {fault}"
    elif place:
        parts[place] = fault
    return _AGENT.format(error=_ERRORS[error], **parts)


def agent_sources() -> list[str]:
    """Sources; the first one is in order."""
    return [
        *(_filled(result=result) for result in _RETURNED),
        *(_filled(*where) for where in product(_PLACES, _ERRORS, _WORDS)),
        *_WHOLE,
    ]
