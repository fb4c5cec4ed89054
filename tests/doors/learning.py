"""Doors of learning: metrics, networks, what estimates behind the interfaces, and training."""

from functools import cache

import numpy as np
import torch

from tests.doors.arguments import (
    a,
    choice,
    flag,
    floats,
    integers,
    number,
    path,
    several,
    whole,
)
from tests.doors.driving import recorded
from tests.doors.walk import anything, call, numbers
from tutorial_lib import learning
from tutorial_lib.driving import PAPER_PERTURBATION
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning import calibration, labels, small_training, training
from tutorial_lib.learning.exploration_model import LearnedExploration
from tutorial_lib.learning.panorama_network import PanoramaArchitecture, PanoramaNetwork
from tutorial_lib.learning.weights import FOLDER
from tutorial_lib.world import PanoramicCamera

ROWS = np.array([0, 10])
SHARE = {"least": 0, "most": 1}


@cache
def network(outputs="waypoint"):
    torch.manual_seed(0)
    return learning.LocalNetwork(learning.Architecture(1, "pair", outputs=outputs)).eval()


@cache
def seen():
    return recorded().observe(ROWS)


@cache
def contexts():
    return np.random.default_rng(0).integers(0, 256, (2, 3, 16, 64, 3)).astype(np.uint8)


@cache
def estimator(kind):
    outputs = {"WaypointNetwork": "waypoint", "DirectNetwork": "action"}
    return getattr(learning, kind)(network(outputs.get(kind, "reachability")))


@cache
def panoramas():
    poses = recorded().poses[ROWS]
    image, depth = PanoramicCamera().look(recorded().scene, poses)
    still = np.zeros(2)
    return Observation(image, depth, np.ones((2, 96)), np.zeros((2, 3)), still, still)


@cache
def explores():
    torch.manual_seed(0)
    return LearnedExploration(PanoramaNetwork(PanoramaArchitecture("rgbd")))


@cache
def features():
    return explores().embed(panoramas())


@cache
def source():
    return learning.Source(
        [recorded()], learning.Architecture(1), worlds=1, targets=2, starts=1, clutter=0.0
    )


@cache
def batch():
    return source().block([0])


def named(value):
    """A network, or the name of weights; weights that are missing are tried elsewhere."""
    found = a(value)
    del found.trials["text"]
    return found


def tensor(value):
    """A tensor of floats."""
    return a(value)


def rows(name):
    return floats(features(), ("P", features().shape[1]), either="huge, bool, negative")


def estimators(kind):
    """The doors that all have in common."""
    made = estimator(kind)
    both = {"observations": a(seen())}
    return {
        kind: lambda: call(getattr(learning, kind), anything, network=named(made.network)),
        f"{kind}.prepare": lambda: call(made.prepare, anything, contexts=a(contexts())),
        f"{kind}.encode": lambda: call(made.encode, anything, **both),
        f"{kind}.compare": lambda: call(
            made.compare,
            current=tensor(made.encode(seen())),
            targets=a(made.prepare(contexts())),
        ),
        f"{kind}.outputs": lambda: call(made.outputs, **both, targets=a(made.prepare(contexts()))),
        f"{kind}.outputs_uncached": lambda: call(
            made.outputs_uncached, **both, contexts=a(contexts())
        ),
    }


def settings():
    return learning.Settings(max_steps=1, targets=1, warmup_steps=1, eval_interval=1)


def plan():
    return small_training.TrainingPlan(2, 0.1, 1, 1.0, 1, 1)


DOORS = {
    "Architecture": lambda: call(
        learning.Architecture,
        k=whole(2, least=0, most=20),
        encoder=choice("pair"),
        view=choice("camera16"),
        outputs=choice("reachability"),
    ),
    "Calibration": lambda: call(
        calibration.Calibration,
        raw=floats([0.0, 1.0], ("K",)),
        mended=floats([0.0, 1.0], ("K",)),
    ),
    **estimators("WaypointNetwork"),
    **estimators("DirectNetwork"),
    **estimators("ReachabilityNetwork"),
    "WaypointNetwork.predict": lambda: call(
        estimator("WaypointNetwork").predict,
        observations=a(seen()),
        targets=a(estimator("WaypointNetwork").prepare(contexts())),
    ),
    "WaypointNetwork.predict_uncached": lambda: call(
        estimator("WaypointNetwork").predict_uncached,
        observations=a(seen()),
        contexts=a(contexts()),
    ),
    "DirectNetwork.act": lambda: call(
        estimator("DirectNetwork").act,
        observations=a(seen()),
        targets=a(estimator("DirectNetwork").prepare(contexts())),
    ),
    "ReachabilityNetwork": lambda: call(
        learning.ReachabilityNetwork,
        anything,
        network=named(network("reachability")),
        calibration=a(calibration.Calibration(), optional=True),
    ),
    "ReachabilityNetwork.embed": lambda: call(
        estimator("ReachabilityNetwork").embed, observations=a(seen())
    ),
    "ReachabilityNetwork.embed_targets": lambda: call(
        estimator("ReachabilityNetwork").embed_targets,
        prepared=a(estimator("ReachabilityNetwork").prepare(contexts())),
    ),
    "ReachabilityNetwork.logits": lambda: call(
        estimator("ReachabilityNetwork").logits,
        observations=a(seen()),
        prepared=a(estimator("ReachabilityNetwork").prepare(contexts())),
    ),
    "ReachabilityNetwork.probability": lambda: call(
        estimator("ReachabilityNetwork").probability,
        observations=a(seen()),
        prepared=a(estimator("ReachabilityNetwork").prepare(contexts())),
    ),
    "LearnedExploration": lambda: call(
        LearnedExploration,
        anything,
        network=named(explores().network),
        calibration=a(calibration.Calibration(), optional=True),
    ),
    "LearnedExploration.embed": lambda: call(explores().embed, observations=a(panoramas())),
    "LearnedExploration.ranges": lambda: call(explores().ranges, observations=a(panoramas())),
    "LearnedExploration.explorable": lambda: call(explores().explorable, features=rows("features")),
    "LearnedExploration.relative": lambda: call(
        explores().relative, anything, sources=rows("sources"), goals=rows("goals")
    ),
    "LearnedExploration.same_node": lambda: call(
        explores().same_node, anything, sources=rows("sources"), goals=rows("goals")
    ),
    "LearnedExploration.scores": lambda: call(
        explores().scores, anything, sources=rows("sources"), goals=rows("goals")
    ),
    "LocalNetwork": lambda: call(
        learning.LocalNetwork, anything, architecture=a(learning.Architecture(1))
    ),
    "LocalNetwork.compare": lambda: call(
        network().compare,
        anything,
        current=tensor(torch.zeros(2, 48, 1, 32)),
        targets=tensor(torch.zeros(2, 3, 48, 1, 32)),
    ),
    "LocalNetwork.embed": lambda: call(
        network().embed, anything, encoded=tensor(torch.zeros(2, 48, 1, 32))
    ),
    "LocalNetwork.encode_current": lambda: call(
        network().encode_current, anything, images=tensor(torch.zeros(2, 3, 16, 64))
    ),
    "LocalNetwork.encode_targets": lambda: call(
        network().encode_targets, anything, contexts=tensor(torch.zeros(2, 3, 3, 16, 64))
    ),
    "LocalNetwork.forward": lambda: call(
        network().forward,
        anything,
        current=tensor(torch.zeros(2, 3, 16, 64)),
        contexts=tensor(torch.zeros(2, 3, 3, 16, 64)),
    ),
    "PairEncoder": lambda: call(
        learning.PairEncoder,
        anything,
        channels=whole(3, least=1, most=1_000),
        rows=whole(16, least=1, most=1_000),
    ),
    "PairEncoder.compare": lambda: call(
        network().encoder.compare,
        anything,
        current=tensor(torch.zeros(2, 48, 1, 32)),
        targets=tensor(torch.zeros(2, 3, 48, 1, 32)),
    ),
    "PairEncoder.current": lambda: call(
        network().encoder.current, anything, images=tensor(torch.zeros(2, 3, 16, 64))
    ),
    "PairEncoder.target": lambda: call(
        network().encoder.target, anything, images=tensor(torch.zeros(2, 3, 16, 64))
    ),
    "Settings": lambda: call(
        learning.Settings,
        max_steps=whole(10, least=0),
        targets=whole(2, least=1),
        learning_rate=number(0.1, least=0),
        warmup_steps=whole(2, least=1),
        eval_interval=whole(2, least=1),
        patience=whole(2, least=1),
        threads=whole(1, least=1),
        seed=whole(0, least=0),
    ),
    "Settings.learning_rate_at": lambda: call(
        settings().learning_rate_at, step=whole(0, least=0, most=0)
    ),
    "Source": lambda: call(
        learning.Source,
        anything,
        recorded_worlds=several([recorded()], empty=False),
        architecture=a(learning.Architecture(1)),
        demonstrator=a(None, optional=True),
        perturbation=a(PAPER_PERTURBATION),
        worlds=whole(1, least=1),
        targets=whole(1, least=1),
        starts=whole(1, least=1),
        close=number(0.3, **SHARE),
        clutter=number(0.3, **SHARE),
        vary=flag(True),
    ),
    "Source.block": lambda: call(source().block, anything, seed=integers([0, 1], ("N",), least=0)),
    "TrainingPlan": lambda: call(
        small_training.TrainingPlan,
        numbers,
        max_steps=whole(10, least=1),
        learning_rate=number(0.1, least=0),
        warmup_steps=whole(2, least=1),
        max_norm=number(1.0, least=0, infinite=True),
        eval_interval=whole(2, least=1),
        patience=whole(2, least=1),
    ),
    "all_logits": lambda: call(
        learning.all_logits,
        reachability=a(estimator("ReachabilityNetwork")),
        recorded=a(recorded()),
        starts=floats(recorded().poses[ROWS], ("N", 3), empty=False, either="huge, bool, negative"),
        targets=integers([5, 6], ("N",), least=0, most=len(recorded().poses) - 1),
    ),
    "auc": lambda: call(
        calibration.auc,
        anything,
        scores=floats([0.1, 0.9], ("N",), infinite=True, empty=False),
        came_true=floats([0.0, 1.0], ("N",), empty=False, **SHARE),
    ),
    "brier": lambda: call(
        calibration.brier,
        predicted=floats([0.1, 0.9], ("N",), empty=False, **SHARE),
        came_true=floats([0.0, 1.0], ("N",), empty=False, **SHARE),
    ),
    "reliability": lambda: call(
        calibration.reliability,
        predicted=floats([0.1, 0.9], ("N",), empty=False, **SHARE),
        came_true=floats([0.0, 1.0], ("N",), empty=False, **SHARE),
        bins=whole(2, least=1, most=2),
    ),
    "sigmoid": lambda: call(calibration.sigmoid, logits=floats([0.0, 1.0], infinite=True)),
    "logit": lambda: call(
        calibration.logit, numbers, probability=floats([0.5, 1.0], (...,), **SHARE)
    ),
    "fit_temperature": lambda: call(
        calibration.fit_temperature,
        logits=floats([-1.0, 1.0], ("N",), empty=False),
        came_true=floats([0.0, 1.0], ("N",), empty=False, **SHARE),
    ),
    "fit_isotonic": lambda: call(
        calibration.fit_isotonic,
        logits=floats(np.linspace(-1, 1, 50), ("N",), empty=False, either="bool"),
        came_true=floats(np.linspace(0, 1, 50), ("N",), empty=False, **SHARE),
        knots=whole(20, least=4),
    ),
    "by_waypoints": lambda: call(
        learning.by_waypoints, anything, predictor=a(estimator("WaypointNetwork"))
    ),
    "encoded": lambda: call(
        learning.encoded,
        anything,
        network=a(estimator("WaypointNetwork")),
        recorded=a(recorded()),
        frames=integers([3, 4], ("N",), least=0, most=len(recorded().poses) - 1),
    ),
    "load_card": lambda: call(learning.load_card, name=named("waypoint_k2"), folder=path(FOLDER)),
    "train": lambda: call(
        learning.train,
        anything,
        architecture=a(learning.Architecture(1)),
        source=a(source()),
        validation=a([batch()]),
        settings=a(settings()),
        checkpoint=path(None, optional=True),
        init_from=a(None, optional=True),
        objective=a(training.LOCAL),
    ),
    "total_loss": lambda: call(
        training.total_loss, anything, network=a(network()), batch=a(batch())
    ),
    "validate": lambda: call(
        training.validate, network=a(network()), validation=several([batch()], empty=False)
    ),
    "use_threads": lambda: call(learning.use_threads, count=whole(1, least=1, most=4096)),
    # What is public in its module.
    "learning_rate_at": lambda: call(
        small_training.learning_rate_at, step=whole(1, least=0, most=2), plan=a(plan())
    ),
    "in_clear_sight": lambda: call(
        labels.in_clear_sight,
        caster=a(recorded().scene.caster),
        origins=floats([[2.0, 2.0]], (..., 2), refuses="more axes, fewer axes"),
        points=floats([[3.0, 3.0]], (..., 2), refuses="more axes, fewer axes"),
    ),
    "label": lambda: call(
        labels.label,
        caster=a(recorded().scene.caster),
        starts=floats(recorded().poses[ROWS], ("N", 3)),
        goals=floats(recorded().poses[ROWS], ("N", 3)),
        waypoints=floats(recorded().poses[ROWS, :2], ("N", 2)),
        field_of_view=number(2.0, above=0, most=2 * np.pi),
    ),
}
WITHOUT = {"Reliability": "a result: what `reliability` measured"}
