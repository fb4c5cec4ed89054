"""The demo of a map that mends itself."""

import json
import types

import cv2
import networkx as nx
import numpy as np
import pytest

from tutorial_lib.agents.ltvn_state import GOAL
from tutorial_lib.cli import main
from tutorial_lib.commands.demo import LIFELONG_REFUSES
from tutorial_lib.experiments.demos import lifelong_demo, recorder
from tutorial_lib.experiments.demos.lifelong_demo import STAGES, LifeFilm, Stage, run_lifelong_demo
from tutorial_lib.experiments.demos.moments import OnLivingMap, map_counts
from tutorial_lib.topology.maintenance import Maintenance, MaintenanceRules
from tutorial_lib.world.simulation import Sensors, Simulation

FILES = ["demo.json", "demo.png", "demo.webm"]
EDGE = {
    "waypoint": (1.0, 0.0, 0.0),
    "probability": 0.9,
    "length": 1.0,
    "variance": 0.04,
    "reverse": False,
    "cost": 1.0,
}


@pytest.fixture
def small(monkeypatch):
    """A life of four queries in a part of the office, of which two are filmed."""
    monkeypatch.setattr(lifelong_demo, "PLACES", 2)
    monkeypatch.setattr(lifelong_demo, "TRIP", (0, 1))
    monkeypatch.setattr(recorder, "EVERY", 60)
    for module in (recorder, lifelong_demo):
        monkeypatch.setattr(module, "FILM_RATE", 2.0)
    monkeypatch.setattr(lifelong_demo, "_SPARE", 0.0)
    return Stage(1, 1, True, 1.0), Stage(2, 3, False, 1.0), Stage(4, 4, False, 1.0)


@pytest.mark.full
def test_a_life_leaves_film_strip_and_figures(tmp_path, monkeypatch, small):
    frames, runs, said = [], [], []
    draw, run = LifeFilm.frame, lifelong_demo.run_queries

    def frame(self, moment, title, door, story):
        where = [] if moment.discs is None else moment.discs.circles[:, :2].tolist()
        frames.append((title, door, where, list(story), moment.ending))
        return draw(self, moment, title, door, story)

    def queries(building, trials, agent, **asked):
        runs.append((len(trials), asked["first"], list(asked["people"]), agent.upkeep.query))
        return run(building, trials, agent, **asked)

    monkeypatch.setattr(LifeFilm, "frame", frame)
    monkeypatch.setattr(lifelong_demo, "run_queries", queries)
    life = run_lifelong_demo(tmp_path, stages=small, say=said.append)

    saved = json.loads((tmp_path / "demo.json").read_text())
    assert sorted(p.name for p in tmp_path.iterdir()) == FILES
    assert tuple(saved["story"]) == life.story
    assert [one["number"] for one in saved["filmed"]] == [1, 4]
    assert [one["door"] for one in saved["filmed"]] == ["shut", "open"]
    assert saved["reached"] is all(one["reached"] for one in saved["filmed"])
    assert saved["geodesic"] > 3.0
    for one, sentence in zip(saved["filmed"], (life.story[0], life.story[2]), strict=True):
        start = f"query {one['number']}, door {one['door']}: {one['ending']}, after "
        assert sentence.startswith(start)
        counts = f"{one['edges']} edges, {one['pruned']} pruned, {one['returned']} returned"
        assert sentence.endswith(counts)
    assert (saved["others"][0]["first"], saved["others"][0]["last"]) == (2, 3)
    assert f"{saved['others'][0]['reached']} of 2 reach the goal" in life.story[1]

    # The shut door is there for the robot that is filmed, and only then.
    assert runs == [(2, 2, [], 1)]
    door = np.round(lifelong_demo.DOOR, 6).tolist()
    for title, word, where, _, _ in frames:
        assert (word, np.round(where, 6).tolist()) in (("shut", door), ("open", []))
        assert title == f"office 1: query {1 if word == 'shut' else 4} of 4, door {word}"
    # The story grows: what is under way, then how it ended, in front of the next.
    assert frames[0][3] == ["query 1, door shut: under way"]
    assert frames[-1][3] == list(life.story)
    endings = [ending for *_, ending in frames if ending]
    assert {*endings} == {one["ending"] for one in saved["filmed"]}

    film = cv2.VideoCapture(str(tmp_path / "demo.webm"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) >= 2 * 2 * 2 * recorder.FILM_RATE
    assert len(cv2.imread(str(tmp_path / "demo.png"))) > 2 * film.read()[1].shape[0]
    assert said[0].endswith(" s in all")
    assert [text.partition(";")[0] for text in said[1:]] == [
        "query 1 of 4, filmed, the door is shut",
        "queries 2 to 3, to other goals, the door is open",
        "query 4 of 4, filmed, the door is open",
        "writing the film",
    ]


def test_a_moment_shows_the_plan_over_vertices_and_the_map_s_counts(box):
    graph = nx.DiGraph()
    graph.add_edge(0, 1, **EDGE)
    graph.add_edge(1, 2, **EDGE)
    graph.add_edge(2, 1, **EDGE)
    upkeep = Maintenance(graph, MaintenanceRules(), 4.0, 0.04)
    vertices = np.array([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [3.0, 1.0, 0.0]])
    leg = types.SimpleNamespace(source=0, target=1, reverse=False)
    state = types.SimpleNamespace(path=[0, 1, 2], leg=leg)
    navigation = types.SimpleNamespace(states=[state], arrived=[False])
    goal, image = np.array([3.4, 1.0, 0.0]), np.zeros((64, 192, 3), np.uint8)
    moment = OnLivingMap(navigation, upkeep, vertices, goal, image, "open")
    simulation = Simulation(box, np.array([[1.5, 1.1, 0.0]]), sensors=Sensors(with_depth=True))
    shown = moment(simulation, np.zeros((1, 2)))
    assert shown.path.tolist() == [[1.5, 1.1], [2.0, 1.0], [3.0, 1.0], [3.4, 1.0]]
    lines = dict(shown.lines)
    assert (lines["door"], lines["robot"]) == ("open", "drives, p(edge) 0.90")
    assert (lines["edges of the map"], lines["pruned; returned"]) == ("3", "0; 0")

    upkeep.prune_edge((0, 1))
    upkeep.prune_edge((2, 1))
    upkeep.bring_back((2, 1))
    assert map_counts(upkeep) == {"edges": 2, "pruned": 1, "returned": 1}
    lines = dict(moment(simulation, np.zeros((1, 2))).lines)
    assert lines["robot"] == "drives"  # another robot has pruned its edge meanwhile
    leg.target = GOAL
    assert dict(moment(simulation, np.zeros((1, 2))).lines)["robot"] == "drives to the goal"
    state.leg, state.path = None, []
    shown = moment(simulation, np.zeros((1, 2)))
    assert dict(shown.lines)["robot"] == "looks around"
    assert len(shown.path) == 0


@pytest.mark.parametrize("option", LIFELONG_REFUSES)
def test_options_that_do_not_count_in_a_life_are_refused(option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    values = {"map": ["x.yaml"], "region": ["1,2"], "family": ["maze"], "seed": ["0"]}
    values |= {"start": ["kitchen"], "goal": ["kitchen"], "agent": ["mine.py:Mine"]}
    values |= {"robot": ["mine.py:small"]}
    assert main(["demo", "--lifelong", f"--{option}", *values.get(option, [])]) == 2
    error = capsys.readouterr().err
    assert f"--{option}: the demo cannot use it with --lifelong; leave it out" in error
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("reached", [True, False])
def test_the_command_tells_the_story_and_its_exit_code_the_end(reached, monkeypatch, capsys):
    story = "query 1, door open: stopped 3.0 m from the goal, after 9 s", "queries 2 to 9"
    life = types.SimpleNamespace(
        reached=reached,
        story=story,
        plan="office 1",
        rooms=("office 5", "office 4"),
        film="demo.webm",
        strip="demo.png",
    )
    monkeypatch.setattr(lifelong_demo, "run_lifelong_demo", lambda *_, **__: life)
    assert main(["demo", "--lifelong"]) == (0 if reached else 1)
    said = capsys.readouterr().out
    assert "office 1, from office 5 to office 4, three times:\n" in said
    assert all(f"  {line}\n" in said for line in story)


def test_a_life_has_a_hundred_queries_without_gaps_of_which_three_are_filmed():
    numbers = [n for stage in STAGES for n in range(stage.first, stage.last + 1)]
    assert numbers == [*range(1, 101)]
    assert [stage.first for stage in STAGES if stage.filmed] == [1, 10, 100]


@pytest.mark.full
def test_the_route_changes_with_the_door(tmp_path):
    life = run_lifelong_demo(tmp_path)
    first, tenth, hundredth = life.filmed
    assert life.reached
    assert tenth.driven > 1.2 * first.driven
    assert hundredth.driven < 1.15 * first.driven
    assert first.pruned == 0 < tenth.pruned
    assert hundredth.returned > 20
    assert all(one.reached >= 0.9 * (one.last - one.first + 1) for one in life.others[1:])
