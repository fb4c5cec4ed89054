"""Doors of agents: whole systems, with a map and without."""

from functools import cache

import numpy as np

from tests.doors import exploration as places
from tests.doors import topology as maps
from tests.doors.arguments import (
    Argument,
    a,
    choice,
    flag,
    flags,
    floats,
    integers,
    number,
    several,
    whole,
)
from tests.doors.driving import paths
from tests.doors.walk import anything, call
from tests.doors.world import robots
from tests.made_up_maps import numbered
from tutorial_lib import agents
from tutorial_lib.agents.ltvn_state import TravelSettings
from tutorial_lib.agents.returning import ReturnSettings
from tutorial_lib.exploration import TrueGeometry
from tutorial_lib.exploration.goal_search import SearchSettings
from tutorial_lib.interfaces import Experience, Goals
from tutorial_lib.topology import (
    DijkstraPlanner,
    FilterSettings,
    FollowerSettings,
    MaintenanceRules,
    MapSettings,
    SamplingRules,
)
from tutorial_lib.topology.mapping.turn_edges import TurnSettings


class View:
    """Sees what the observations show."""

    def of(self, observations):
        return observations.image


class Robot(maps.Everywhere):
    """All parts of an agent in one."""

    view, k = View(), 0

    def prepare(self, contexts):
        return np.zeros(len(contexts))

    def start(self, goals):
        return np.zeros(len(goals))

    def act(self, observations, state):
        if np.ndim(state) == 1:
            return np.zeros(len(observations), dtype=int), state
        return np.zeros((len(observations), 2))


ROBOT = Robot()
SEEN = numbered([0, 1, 2])


def experience():
    return Experience(SEEN, np.arange(3.0))


def goals():
    return Goals(SEEN[2], SEEN.image[2:][:, None])


class Posed(Robot):
    """A model of reachability and pose: all is a metre ahead."""

    def predict(self, observations, targets):
        count = len(observations)
        return np.full(count, 0.99), np.tile([1.0, 0.0, 0.0], (count, 1))


POSED = Posed()


def learned_ltvn():
    agent = agents.LTVNAgent(model=POSED)
    agent.learn([experience()])
    return agent


def rng():
    return np.random.default_rng(0)


def parts():
    """Arguments of all agents with a map."""
    return {
        "predictor": a(ROBOT),
        "controller": a(ROBOT),
        "reachability": a(ROBOT),
        "follower": a(FollowerSettings()),
        "replan_time": number(240.0, least=0, infinite=True),
    }


def meng_parts():
    return parts() | {
        "planner": a(DijkstraPlanner()),
        "settings": a(MapSettings()),
        "p_sparsify": number(0.99, least=0, most=1),
        "turns": a(TurnSettings(), optional=True),
    }


def made(kind, arguments, **more):
    return kind(**{name: one.value for name, one in arguments.items()}, **more)


def meng(kind=agents.MengAgent):
    agent = made(kind, meng_parts() | {"turns": Argument(None)})
    agent.learn([experience()])
    return agent


def sptm():
    agent = made(agents.SPTMAgent, parts(), similarity=ROBOT)
    agent.learn([experience()])
    return agent


def random_agent():
    return agents.RandomAgent(ROBOT, ROBOT, rng())


@cache
def task():
    return places.task()


def model_of(one):
    return TrueGeometry(one)


def explorer(make):
    """An agent in a task of its own, started."""
    one = places.task()
    agent = make(model_of(one), one)
    agent.start(one.goals())
    return agent, one


EXPLORERS = {
    "NTSAgent": lambda model, one: agents.NTSAgent(model, rng()),
    "FrontierAgent": lambda model, one: agents.FrontierAgent(model),
    "RandomWalkAgent": lambda model, one: agents.RandomWalkAgent(model, rng()),
    "OracleExplorer": lambda model, one: agents.OracleExplorer(one),
    "ImitationAgent": lambda model, one: agents.ImitationAgent(ROBOT),
    "LifelongAgent": lambda model, one: agents.LifelongAgent(model, rng()),
}


def explores(name):
    """The doors that all explorers have in common."""

    def start():
        agent, one = explorer(EXPLORERS[name])
        return call(agent.start, goals=a(one.goals()))

    def act():
        agent, one = explorer(EXPLORERS[name])
        running = flags([True, True], ("N",), refuses="longer N, shorter N, empty")
        return call(agent.act, observations=a(one.observe()), running=running)

    return {f"{name}.start": start, f"{name}.act": act}


def learns(name, make):
    """The doors that all agents with a map have in common."""
    return {
        f"{name}.learn": lambda: call(
            make().learn, experiences=several([experience()], takes="empty")
        ),
        f"{name}.start": lambda: call(
            make().start, anything, goals=several([goals()], empty=False)
        ),
    }


def plans(make):
    return call(
        make().find_path,
        anything,
        observation=a(SEEN[0]),
        goals=a(goals()),
        excluded=a({(0, 1)}),
    )


def navigation():
    return agents.OracleNavigation(robots(), paths(), places.GOALS)


def back():
    return agents.ReturningAgent(meng())


def look_for(name):
    def make():
        agent, one = explorer(EXPLORERS[name])
        return call(agent.look_for, goals=a(one.goals()))

    return make


DOORS = {
    "FrontierAgent": lambda: call(
        agents.FrontierAgent,
        anything,
        model=a(model_of(task())),
        settings=a(SearchSettings(), optional=True),
        scorer=a(None, optional=True),
        reach=number(4.0, least=0),
        recalls=flag(False),
        rng=a(rng(), optional=True),
    ),
    "ImitationAgent": lambda: call(agents.ImitationAgent, anything, policy=a(ROBOT)),
    "NTSAgent": lambda: call(
        agents.NTSAgent,
        anything,
        model=a(model_of(task())),
        rng=a(rng()),
        settings=a(agents.NTSSettings(), optional=True),
    ),
    "NTSAgent.look_for": look_for("NTSAgent"),
    "FrontierAgent.look_for": look_for("FrontierAgent"),
    "LifelongAgent.look_for": look_for("LifelongAgent"),
    "LifelongAgent": lambda: call(
        agents.LifelongAgent,
        anything,
        model=a(model_of(task())),
        rng=a(rng()),
        settings=a(agents.LifelongSettings(), optional=True),
    ),
    "LifelongSettings": lambda: call(
        agents.LifelongSettings,
        exploring=a(agents.NTSSettings()),
        recalls_looks=flag(True),
        metric=flag(True),
        travel=number(0.02, least=0),
        relocates=flag(True),
    ),
    "NTSSettings": lambda: call(
        agents.NTSSettings,
        anything,
        use_graph=flag(True),
        use_score=flag(True),
        closes_loops=flag(False),
        same_node=number(0.5, least=0),
        explorable=number(0.5, least=0),
        directions=whole(12, least=1),
        radius=number(3.0, above=0, most=50),
        search=a(SearchSettings()),
    ),
    "OracleExplorer": lambda: call(agents.OracleExplorer, anything, task=a(task())),
    "RandomWalkAgent": lambda: call(
        agents.RandomWalkAgent,
        anything,
        model=a(model_of(task())),
        rng=a(rng()),
        settings=a(SearchSettings(), optional=True),
    ),
    **explores("NTSAgent"),
    **explores("LifelongAgent"),
    **explores("FrontierAgent"),
    **explores("RandomWalkAgent"),
    **explores("OracleExplorer"),
    **explores("ImitationAgent"),
    "OracleNavigation": lambda: call(
        agents.OracleNavigation,
        anything,
        simulation=a(robots()),
        paths=a(paths()),
        goals=floats(
            places.GOALS,
            ("N", 3),
            refuses="longer N, shorter N, empty",
            either="huge, shorter axis 1",
        ),
    ),
    "OracleNavigation.act": lambda: call(
        navigation().act,
        observations=a(robots().observe()),
        robots=integers([0, 1], ("M",), least=0, most=1, refuses="longer M, shorter M, empty"),
    ),
    "LTVNAgent": lambda: call(
        agents.LTVNAgent,
        model=a(POSED),
        controller=a(ROBOT),
        backing=a(ROBOT),
        rules=a(SamplingRules()),
        maintenance=Argument(MaintenanceRules()),
        travel=a(TravelSettings()),
        apart=number(0.6, least=0),
        turned=number(0.7, least=0),
        seed=whole(0, least=0),
    ),
    "LTVNAgent.learn": lambda: call(
        agents.LTVNAgent(model=POSED).learn, experiences=several([experience()], empty=False)
    ),
    "LTVNAgent.start": lambda: call(learned_ltvn().start, goals=several([goals()], empty=False)),
    "MendingMengAgent": lambda: call(
        agents.MendingMengAgent, anything, **meng_parts(), maintenance=a(MaintenanceRules())
    ),
    "MendingMengAgent.find_path": lambda: plans(lambda: meng(agents.MendingMengAgent)),
    "MendingMengAgent.insert": lambda: call(
        meng(agents.MendingMengAgent).insert, anchors=a(meng().sparsified(experience()))
    ),
    "MendingMengAgent.sparsified": lambda: call(
        meng(agents.MendingMengAgent).sparsified, anything, experience=a(experience())
    ),
    **learns("MendingMengAgent", lambda: meng(agents.MendingMengAgent)),
    "MengAgent": lambda: call(agents.MengAgent, anything, **meng_parts()),
    "MengAgent.find_path": lambda: plans(meng),
    "MengAgent.insert": lambda: call(meng().insert, anchors=a(meng().sparsified(experience()))),
    "MengAgent.sparsified": lambda: call(meng().sparsified, anything, experience=a(experience())),
    **learns("MengAgent", meng),
    "RandomAgent": lambda: call(
        agents.RandomAgent, anything, predictor=a(ROBOT), controller=a(ROBOT), rng=a(rng())
    ),
    **learns("RandomAgent", random_agent),
    "Remedies": lambda: call(
        agents.Remedies,
        sequence=flag(True),
        replan=flag(True),
        cycles=flag(True),
        filter=flag(True),
    ),
    "Remedies.named": lambda: call(agents.Remedies.named, name=choice("all")),
    "RemedyAgent": lambda: call(
        agents.RemedyAgent,
        anything,
        **meng_parts(),
        remedies=a(agents.Remedies()),
        filter_settings=a(FilterSettings()),
    ),
    "RemedyAgent.find_path": lambda: plans(lambda: meng(agents.RemedyAgent)),
    "RemedyAgent.guess": lambda: call(
        meng(agents.RemedyAgent).guess, anything, robots=whole(1, least=0)
    ),
    "RemedyAgent.insert": lambda: call(
        meng(agents.RemedyAgent).insert, anchors=a(meng().sparsified(experience()))
    ),
    "RemedyAgent.sparsified": lambda: call(
        meng(agents.RemedyAgent).sparsified, anything, experience=a(experience())
    ),
    "RemedyAgent.with_remedies": lambda: call(
        meng(agents.RemedyAgent).with_remedies, anything, remedies=a(agents.Remedies())
    ),
    **learns("RemedyAgent", lambda: meng(agents.RemedyAgent)),
    "ReturningAgent": lambda: call(
        agents.ReturningAgent,
        anything,
        memory=a(meng()),
        explorer=a(None, optional=True),
        settings=a(ReturnSettings(), optional=True),
    ),
    "SPTMAgent": lambda: call(
        agents.SPTMAgent,
        anything,
        **parts(),
        similarity=a(ROBOT),
        every=whole(20, least=1),
        s_shortcut=number(0.99, least=0, most=1),
        window=whole(2, least=0),
    ),
    "SPTMAgent.find_path": lambda: plans(sptm),
    "SPTMAgent.join": lambda: call(sptm().join, s_shortcut=number(0.99, least=0, most=1)),
    **learns("SPTMAgent", sptm),
}
NEEDS = "needs a map of turned panoramas, see `tests/agents/test_returning.py`"
USED = "takes a map that `SampledMap` and `build` made"
WITHOUT = {
    "ReturningAgent.start": NEEDS,
    "ReturningAgent.act": NEEDS,
    "LTVNAgent.use": USED,
    "LTVNAgent.twin": USED,
}
