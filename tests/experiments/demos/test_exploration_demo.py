"""The demo of exploration with the true geometry in place of the network."""

import json
import types

import cv2
import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.cli import main
from tutorial_lib.commands.demo import EXPLORED
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import explorers
from tutorial_lib.experiments.demos import exploration_demo, exploration_film
from tutorial_lib.experiments.demos.ends import parse_end, room_names
from tutorial_lib.experiments.demos.exploration_demo import (
    ExplorationRecorder,
    draw_episode,
    episode_between,
    exploration_ending,
    explore_recorded,
    run_exploration_demo,
)
from tutorial_lib.experiments.demos.exploration_film import ExplorationFilm
from tutorial_lib.experiments.protocols.ghost_moments import ghost_moment
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.viz.canvas import colours
from tutorial_lib.world.generators import generate
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import TRAINING_SEEDS

FILES = ["demo.json", "demo.png", "demo.webm"]


@pytest.fixture(scope="module")
def recorded():
    """A task of one robot, its agent, and what was recorded; without noise."""
    scene = Scene(generate("office", 10_003, signs="wayfinding"))
    task = ExplorationTask(
        {"office": scene}, draw_episode("office", scene, 3), np.random.default_rng(1), noise=False
    )
    model = TrueGeometry(task)
    agent = NTSAgent(model, np.random.default_rng(2))
    recorder = ExplorationRecorder(task, agent, model)
    agent.start(task.goals())
    explore_recorded(task, agent, recorder)
    return scene, task, agent, recorder.moments


def test_the_demo_leaves_film_strip_and_figures(tmp_path, capsys):
    plan = generate("apartment", 10_000, signs="wayfinding")
    outcome = run_exploration_demo(plan, 0, tmp_path, geometry=True, say=print)
    saved = json.loads((tmp_path / "demo.json").read_text())
    assert saved["reached"] is outcome.reached is True
    assert (saved["difficulty"], saved["plan"]) == ("hard", "apartment 10000")
    assert saved["travelled"] > saved["geodesic"] - 1.0 > 4.0
    assert saved["nodes"] >= 2
    assert saved["ending"] == outcome.ending
    assert saved["ending"].startswith("reached the goal, 0.")
    film = cv2.VideoCapture(str(tmp_path / "demo.webm"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) > saved["steps"] / exploration_demo.EVERY
    assert cv2.imread(str(tmp_path / "demo.png")).std() > 10
    assert sorted(p.name for p in tmp_path.iterdir()) == FILES
    said = capsys.readouterr().out
    assert said.index("exploring") < said.index("writing the film")


def test_a_moment_holds_the_graph_where_the_robot_believes_it_to_be(recorded):
    _, task, agent, moments = recorded
    robot = agent.robots[0]
    start = task.path[0][0]
    for moment in moments:
        graph = moment.graph
        assert len(graph.ghosts) == len(graph.hosts) == len(graph.scores)
        # Each ghost is 3 m from its node, in the direction that its number names.
        assert np.allclose(np.linalg.norm(graph.ghosts - graph.nodes[graph.hosts], axis=1), 3.0)
        # Without noise nodes are places at which the robot was.
        track = np.array(task.path)[:, 0, :2]
        cos, sin = np.cos(start[2]), np.sin(start[2])
        nodes = graph.nodes @ np.array([[cos, sin], [-sin, cos]]) + start[:2]
        gap = np.linalg.norm(nodes[:, None] - track, axis=2).min(axis=1)
        assert gap.max() < 1e-6
        if len(graph.path):
            assert np.allclose(graph.path[0], moment.odometry[:2])
            if graph.chosen >= 0:
                assert np.allclose(graph.path[-1], graph.ghosts[graph.chosen])
    first, last = moments[0], moments[-1]
    assert len(first.graph.nodes) == 1
    assert len(last.graph.nodes) == len(robot.memory.graph)
    assert len(last.graph.edges) >= len(last.graph.nodes) - 1
    assert (last.grid > 0).sum() > (first.grid > 0).sum() > 0
    assert last.goal_seen is not None
    assert dict(last.lines)["the robot"].startswith("reached the goal, 0.")
    assert first.lines[0] == ("action", "0 of 500")


def test_a_robot_without_a_graph_has_an_empty_moment(recorded):
    agent = NTSAgent(recorded[2]._model, np.random.default_rng(0))
    agent.start(recorded[1].goals())
    moment = ghost_moment(agent.robots[0], np.zeros(3))
    assert len(moment.nodes) == len(moment.ghosts) == len(moment.path) == 0
    assert moment.here == moment.chosen == -1


def test_a_frame_shows_robot_goal_and_ghosts(recorded):
    scene, task, _, moments = recorded
    start, goal = task.path[0][0], task.goal_poses[0]
    film = ExplorationFilm(scene, moments, start, goal, "a title")
    first, last = film[0], film[len(film) - 1]
    assert first.shape == last.shape == (1000, 1260, 3)

    def shown(picture, colour):
        return (picture == colour).all(axis=2).sum()

    plans = slice(320, 960)
    known, truth = (slice(20, 620), slice(640, 1240))
    for frame in (first, last):
        for part in (known, truth):
            assert shown(frame[plans, part], colours.ROBOT) > 50
        assert shown(frame[plans, truth], colours.GOAL) > 50
    assert shown(first[plans, known], colours.GOAL) == 0  # it has not seen it yet
    assert shown(last[plans, known], colours.GOAL) > 50
    unseen = [shown(frame[plans, known], exploration_film.UNSEEN) for frame in (first, last)]
    assert unseen[0] > unseen[1] > 0


def test_episodes_are_as_hard_as_the_world_allows():
    assert draw_episode("box", Scene(make_box(6.0, 4.0)), 0).difficulty in (("hard",), ("medium",))
    assert draw_episode("box", Scene(make_box(3.2, 2.2)), 0).difficulty == ("easy",)
    with pytest.raises(InputError, match=r"no two places 1\.5 m apart .*; give a larger map"):
        draw_episode("box", Scene(make_box(1.2, 1.2)), 0)


def test_the_command_names_what_is_missing_or_cannot_be_used(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(explorers, "FOLDER", tmp_path)
    assert main(["demo", "--explore"]) == 2
    assert "python -m tutorial_lib train nts --sensor rgbd makes them" in capsys.readouterr().err
    for option in ("--oracle", "--learn"):
        assert main(["demo", "--explore", option]) == 2
        assert f"{option}: the demo cannot use it with --explore" in capsys.readouterr().err
    assert main(["demo", "--explore", "--seed", "-1"]) == 2
    assert "seed" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_command_explores_a_plan_in_which_no_network_learned(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    plans = []

    def run(plan, seed, folder, *, say, name, start, goal):
        assert (name, start) == ("office 10004", None)
        plans.append((plan, goal))
        ends = (0.0, 0.0, 0.0), (7.0, 0.0, 0.0)
        return exploration_demo.Explored(
            *(False, "no steps left, 3.4 m from the goal", "demo --explore", name, seed, *ends),
            *("hard", 500, 9.0, 7.5, 0.0, 0, 9, 2),
        )

    monkeypatch.setattr(exploration_demo, "run_exploration_demo", run)
    office = ["demo", "--explore", "--family", "office", "--seed", "4", "--goal", "office 2"]
    assert main(office) == 1
    ((plan, goal),) = plans
    assert (plan.family, plan.seed, goal.room) == ("office", 10_004, "office 2")
    said = capsys.readouterr().out
    assert "no steps left, 3.4 m from the goal, after 500 actions and 9.0 m" in said


def test_the_usual_exploration_leads_from_room_to_room_with_a_choice():
    """Without the network; which ghosts it chooses was looked at in the film."""
    plan = generate("apartment", TRAINING_SEEDS.stop + EXPLORED, signs="wayfinding")
    scene = Scene(plan)
    episode = draw_episode("usual", scene, EXPLORED)
    ends = np.stack([episode.starts[0, :2], episode.goals[0, :2]])
    rooms = [[room.kind for room in plan.rooms if room.contains(end)] for end in ends]
    assert rooms == [["bedroom"], ["living"]]
    assert episode.difficulty == ("hard",)


def test_an_episode_leads_between_the_places_asked_for():
    plan = generate("apartment", 10_003)
    scene, where = Scene(plan), room_names(plan)
    start, goal = parse_end("--start", where[1]), parse_end("--goal", where[2])
    episode = episode_between("x", scene, start, goal, 0)
    assert plan.rooms[1].contains(episode.starts[0, :2])
    assert plan.rooms[2].contains(episode.goals[0, :2])
    x, y, heading = episode.starts[0].tolist()
    exact = parse_end("--start", f"{x!r},{y!r},{heading!r}")
    again = episode_between("x", scene, exact, None, 1)
    assert np.array_equal(again.starts, episode.starts)
    assert 5.0 <= again.shortest[0] < 10.0
    backward = episode_between("x", scene, None, goal, 1)
    assert np.array_equal(backward.goals[0, :2], episode.goals[0, :2])
    with pytest.raises(InputError, match=r"--goal: 0\.0 m from the start; choose places 1 m apart"):
        episode_between("x", scene, start, parse_end("--goal", where[1]), 0)


def test_every_ending_of_an_exploration_is_said():
    task = types.SimpleNamespace(
        poses=np.zeros((1, 3)), goal_poses=np.array([[3.4, 0.0, 0.0]]), success=[False], steps=[500]
    )
    assert exploration_ending(task) == "no steps left, 3.4 m from the goal"
    task.steps = [77]
    assert exploration_ending(task) == "stopped 3.4 m from the goal"
    task.success, task.poses = [True], np.array([[3.0, 0.0, 0.0]])
    assert exploration_ending(task) == "reached the goal, 0.40 m from it"
