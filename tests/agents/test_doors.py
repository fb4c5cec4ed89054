"""What is no experience, no goal or no plan is refused at once, by its name."""

from types import SimpleNamespace

import numpy as np
import pytest

from tutorial_lib.agents import MengAgent, RandomAgent, RemedyAgent, SPTMAgent
from tutorial_lib.driving import RMPController
from tutorial_lib.errors import InputError
from tutorial_lib.learning import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.topology.mapping.topomap import TopoMap


def asked(*_):
    raise AssertionError("a network was asked")


class Untouched:
    """A network that is not to be asked anything."""

    view, k = SimpleNamespace(), 2

    def __init__(self):
        self.prepare = self.predict = self.probability = self.embed = asked


@pytest.fixture(params=[MengAgent, RemedyAgent, SPTMAgent, RandomAgent])
def agent(request):
    nobody = Untouched()
    if request.param is RandomAgent:
        return RandomAgent(nobody, RMPController(), np.random.default_rng(0))
    more = {"similarity": nobody} if request.param is SPTMAgent else {}
    return request.param(predictor=nobody, reachability=nobody, **more)


def test_only_experiences_are_learned_from(agent, recorded):
    drives = recorded.experiences()
    wrong = {
        r"experiences\[0\]: Trajectory.*; give an Experience": list(recorded.trajectories),
        r"experiences\[1\]: Observation.*; give an Experience": [drives[0], drives[0].observations],
        r"experiences: Experience.*; give a list of Experience": drives[0],
        r"experiences\[0\]: array.*; give an Experience": recorded.poses,
    }
    for words, given in wrong.items():
        with pytest.raises(InputError, match=words):
            agent.learn(given)


def test_robots_are_sent_to_goals_only(agent, recorded, monkeypatch):
    monkeypatch.setattr(TopoMap, "__len__", lambda _: 1)  # as if it had learned something
    (goal,) = recorded.goals(np.array([40]), k=2)
    wrong = {
        r"goals\[0\]: Observation.*; give a Goals": [goal.observations],
        r"goals: Goals.*; give a list of Goals": goal,
        r"goals\[1\]: None; give a Goals": [goal, None],
        r"goals: Observation.*; give a list of Goals": goal.observations,
    }
    for words, given in wrong.items():
        with pytest.raises(InputError, match=words):
            agent.start(given)


def test_a_planner_that_returns_no_plan_is_named(recorded):
    networks = {
        "predictor": WaypointNetwork("waypoint_k2"),
        "reachability": ReachabilityNetwork("reach_k2"),
    }
    agent = MengAgent(planner=SimpleNamespace(plan=lambda *_: None), **networks)
    agent.learn(recorded.experiences()[:1])
    navigation = agent.start(recorded.goals(np.array([40]), k=2))
    with pytest.raises(InputError, match="planner: None; give a Plan"):
        navigation.act(recorded.observe(np.array([3])), np.array([0]))


def test_the_controller_is_the_library_s_unless_given():
    nobody = Untouched()
    assert MengAgent(predictor=nobody, reachability=nobody).controller == RMPController()


@pytest.mark.parametrize(
    ("number", "words"), [(99, "99; give one whole number from 0 to"), (-1, "-1"), (1.0, "1.0")]
)
def test_there_are_only_so_many_trajectories(recorded, number, words):
    for asked in (recorded.frames_of, recorded.experience):
        with pytest.raises(InputError, match=f"trajectory: {words}"):
            asked(number)
