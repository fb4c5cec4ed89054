import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread

from tutorial_lib.builder.standard import minutes_of
from tutorial_lib.experiments.common.agents import custom
from tutorial_lib.interfaces import Plan

HERE = Path(__file__).parents[2]
README = (HERE / "README.md").read_text(encoding="utf-8")


SNIPPETS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize(
    ("number", "said"),
    [(0, "[ True]"), (1, "m from the target"), (2, "['arrived']")],
)
def test_each_example_runs_alone(number, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(SNIPPETS[number], names)
    assert said in capsys.readouterr().out
    if number == 2:
        first, last = (names["drives"].poses[700], names["found"].last_poses[0])
        assert np.hypot(*(first - last)[:2]) < 0.5
        drives_used = {int(names["agent"].topomap.trajectory[v]) for v in names["plan"].vertices}
        assert len(drives_used) > 1
        picture = imread("drive.png")
        assert picture.shape[:2] == (720, 720)


def test_the_whole_system_takes_fifteen_lines():
    lines = [line for line in SNIPPETS[2].splitlines() if line and "import " not in line]
    assert len(lines) <= 15
    assert "experiments" not in SNIPPETS[2]


def test_a_planner_of_ones_own_is_compared(tmp_path):
    planner = SNIPPETS[3]
    assert planner.count("\n") < 30
    (tmp_path / "my_planner.py").write_text(planner)
    agent = custom(f"{tmp_path / 'my_planner.py'}:Doubtful")
    usual = Plan((1, 2), 0, (0.99, 0.99, 0.8))
    agent.planner.usual = SimpleNamespace(plan=lambda *arguments: usual)
    assert agent.planner.plan(None, None, None).refusal
    agent.planner.usual = SimpleNamespace(plan=lambda *arguments: Plan((), 0, (0.95,)))
    assert not agent.planner.plan(None, None, None).refusal
    assert "--agent my_planner.py:Doubtful" in README


def test_every_picture_and_page_that_is_linked_is_there():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert links
    for link in links:
        assert link.startswith("https://") or (HERE / link).exists(), link


def test_the_minutes_of_each_notebook_are_those_at_its_top():
    for source in sorted((HERE / "solutions").glob("[0-9][0-9]_*.py")):
        row = next(
            line for line in README.splitlines() if line.startswith(f"| {source.stem[:2]} |")
        )
        assert row.endswith(f"| {minutes_of(source)} |"), source.stem
