"""The demo of a life: a robot that knows a building better with every visit."""

import json

import pytest

from tutorial_lib.cli import main
from tutorial_lib.experiments.demos import visits_demo
from tutorial_lib.experiments.demos.visits_demo import run_visits_demo


@pytest.mark.full
def test_a_life_leaves_film_strip_and_figures(tmp_path):
    life = run_visits_demo(tmp_path, visits=2)
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "demo.json",
        "demo.png",
        "demo.webm",
    ]
    saved = json.loads((tmp_path / "demo.json").read_text())
    assert saved["reached"] is life.reached is True
    first, second = saved["visits"]
    assert first["nodes"] <= second["nodes"]
    assert second["drift"] > 4 * second["off"]  # walls correct the robot, not its odometry
    assert second["ending"].startswith("reached the goal, 0.")


@pytest.mark.parametrize("option", ["--explore", "--lifelong", "--seed=0"])
def test_options_that_do_not_count_are_refused(option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(visits_demo, "run_visits_demo", None)
    assert main(["demo", "--life", option]) == 2
    name = option.lstrip("-").partition("=")[0]
    assert f"--{name}" in capsys.readouterr().err
