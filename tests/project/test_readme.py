import re
from pathlib import Path
from types import SimpleNamespace

from tutorial_lib.builder.standard import minutes_of
from tutorial_lib.experiments.common.agents import custom
from tutorial_lib.interfaces import Plan

HERE = Path(__file__).parents[2]
README = (HERE / "README.md").read_text(encoding="utf-8")


def test_the_examples_run(capsys):
    first, second, _ = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    names = {}
    exec(first, names)
    assert "[ True]" in capsys.readouterr().out
    exec(second, names)
    assert "m from the target" in capsys.readouterr().out


def test_a_planner_of_ones_own_is_compared(tmp_path):
    *_, planner = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
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
    for source in sorted((HERE / "solutions").glob("0[1-9]_*.py")):
        row = next(line for line in README.splitlines() if f"notebooks/{source.stem}.ipynb" in line)
        assert row.endswith(f"| {minutes_of(source)} |"), source.stem
