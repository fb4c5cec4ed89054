from pathlib import Path

import pytest

from tutorial_lib.builder import survivors
from tutorial_lib.checks.framework import comparison, guard, topics

PROJECT = Path(__file__).resolve().parents[2]
SOURCES = [
    source
    for source in sorted((PROJECT / "solutions").glob("[0-9]*.py"))
    if "exercise=" in source.read_text(encoding="utf-8")
]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.stem)
def test_every_mutant_of_a_solution_is_rejected_or_is_no_mistake(monkeypatch, source):
    monkeypatch.setattr(guard, "SECONDS", 0.5)  # none that is right takes a third of it
    # Whether it is rejected counts here, and not which known mistake it is most like.
    monkeypatch.setattr(comparison, "_best", lambda *_: "")
    monkeypatch.setattr(topics, "_known", lambda *_: None)
    monkeypatch.setattr(topics, "_partly", lambda *_: "")
    known = PROJECT / "tests" / "harmless_mutants" / f"{source.stem}.json"
    for exercise, tried, passed in survivors(source, known):
        assert tried
        left = [survivor.change for survivor in passed if not survivor.reason]
        assert not left, exercise.name
