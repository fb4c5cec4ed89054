"""What a module may import: what is below it, and siblings that its package's order allows."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

LIBRARY = Path(__file__).resolve().parents[2] / "tutorial_lib"
LAYERS = (
    ("errors",),
    ("array_forms", "se2"),
    ("validation",),
    ("observation",),
    ("geometry", "interfaces", "files", "memory", "reading", "course", "environments"),
    ("parallel",),
    ("world",),
    ("driving",),
    ("exploration",),  # below learning, which trains on its labels and drives in its task
    ("learning",),
    ("topology",),
    ("agents",),
    ("viz",),
    ("experiments", "checks"),
    ("cli", "commands", "builder", "templates", "__main__"),
)
LAYER = {part: number for number, parts in enumerate(LAYERS) for part in parts}
DRAWING = {"matplotlib", "ipywidgets", "IPython", "PIL"}
NEVER = {part: DRAWING for part in LAYER if LAYER[part] < LAYER["viz"]}
NEVER["reading"] = DRAWING - {"PIL"}  # whose decoders read pictures
for part in ("driving", "learning", "topology", "exploration", "agents"):
    NEVER[part] = DRAWING | {"cv2"}  # the world may use it for grids and reading maps
SEPARATE = {
    "topology": {"learning", "exploration"},
    "exploration": {"learning", "topology"},
}

LOOP = {"geodesics", "metrics", "rollouts"}
STUDIES = ("meng2020", "nts", "ltvn", "race", "robustness", "benchmarks", "demos")
NOTEBOOKS = [f"nb{number:02}" for number in range(11)]
INSIDE = {
    "driving": {**dict.fromkeys(LOOP, LOOP), "control": LOOP, "data": LOOP | {"control"}},
    "topology": {
        "query": set(),
        "similarity": set(),
        "maintenance": set(),
        "mapping": {"query", "similarity", "maintenance"},
        "planner": {"query", "similarity", "mapping"},
        "motion_model": {"mapping"},
        "view_sensor": {"mapping"},
        "localization": {"motion_model"},
        "following": {"query"},
    },
    "viz": {"canvas": set(), "figures": {"canvas"}, "notebook": {"canvas", "figures"}},
    "experiments": {
        "common": set(),
        "protocols": {"common"},
        **{study: {"common", "protocols"} for study in STUDIES},
        "demos": {"common", "protocols", "race"},
        "registry": {"common", "protocols", *STUDIES},
        "failures": {"common", "protocols", "demos", *STUDIES},
        "leaderboard": {"common", "failures", *STUDIES},
        "provenance": {"common", "registry"},
        "results_page": {"common", "protocols", "provenance", *STUDIES},
    },
    "checks": {
        "framework": set(),
        "progress": {"framework"},
        "robot": {"framework"},
        "predictions": {"framework", "robot"},
        "league": {"framework"},
        "marking": {"framework"},
        "engine": {"framework"},
        **{notebook: {"framework", "engine"} for notebook in NOTEBOOKS},
    },
}
"""What each part of a package may import from the package, besides itself."""
APART = {
    f"tutorial_lib.experiments.{study}" for study in ("meng2020", "nts", "robustness", "benchmarks")
}
"""Each module is an experiment: it imports no other, only parts of itself (`table1_smoothing`)."""


def read_library():
    """Source by module name."""
    sources = {}
    for file in sorted(LIBRARY.rglob("*.py")):
        parts = list(file.relative_to(LIBRARY.parent).with_suffix("").parts)
        sources[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file.read_text()
    return sources


def imports(name, source, known):
    """Whole names of what a module imports, at its top or within."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            package = name if any(k.startswith(f"{name}.") for k in known) else parent(name)
            for _ in range(node.level - 1):
                package = parent(package)
            start = ".".join(filter(None, [package if node.level else "", node.module]))
            for alias in node.names:
                whole = f"{start}.{alias.name}"
                yield whole if whole in known else start


def parent(name):
    return name.rpartition(".")[0]


def part_of(name):
    """The package or module of the library to which a module belongs; "" for its root."""
    return [*name.split("."), ""][1]


def place_in(name):
    """The part of its package to which a module belongs; "" for the package's `__init__`."""
    return [*name.split("."), "", ""][2]


def misplaced(name, other):
    """Why a module may not import another of the same package, or None."""
    if name.startswith(f"{other}."):
        return "which is the `__init__` of its own package"
    allowed, place, theirs = INSIDE.get(part_of(name)), place_in(name), place_in(other)
    if allowed and place and place != theirs and theirs not in allowed.get(place, ()):
        return "which is not below it in their package"
    if parent(name) == parent(other) in APART and not other.startswith(f"{name}_"):
        return "which is another experiment"
    return None


def violations(sources):
    """What breaks the rules, a line each."""
    found, graph = [], {}
    for name, source in sources.items():
        part = part_of(name)
        graph[name] = set()
        for other in imports(name, source, sources):
            root, theirs = other.split(".")[0], part_of(other)
            if root == "tutorial_lib":
                graph[name].add(other)
                below = not theirs or LAYER.get(theirs, 99) < LAYER.get(part, 0)
                commands = LAYER.get(part) == LAYER.get(theirs) == len(LAYERS) - 1
                if not (below or theirs == part or commands):
                    found.append(f"{name} imports {other}, which is not below it")
                elif theirs == part != "" and (reason := misplaced(name, other)):
                    found.append(f"{name} imports {other}, {reason}")
                if theirs in SEPARATE.get(part, ()):
                    found.append(f"{name} imports {other}, which it never may")
            elif root == "torch" and part != "learning":
                found.append(f"{name} imports torch, which only learning may")
            elif root in NEVER.get(part, ()):
                found.append(f"{name} imports {root}, which draws")
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        found.append(f"cycle: {' -> '.join(error.args[1])}")
    return found


def test_every_module_has_a_layer():
    parts = {part_of(name) for name in read_library()} - {""}
    assert parts <= LAYER.keys()
    assert {"geometry", "world", "cli"} <= parts


@pytest.mark.parametrize("package", INSIDE)
def test_every_part_of_an_ordered_package_has_its_place(package):
    places = {place_in(name) for name in read_library() if part_of(name) == package} - {""}
    assert places <= INSIDE[package].keys()
    assert set().union(*INSIDE[package].values()) <= INSIDE[package].keys()


def test_the_library_keeps_to_the_layers():
    assert violations(read_library()) == []


def test_the_library_s_root_imports_nothing():
    source = (LIBRARY / "__init__.py").read_text()
    assert list(imports("tutorial_lib", source, {"tutorial_lib.cli"})) == []


@pytest.mark.parametrize(
    ("modules", "words"),
    [
        ({"world.x": "from tutorial_lib.driving import y", "driving.y": ""}, "not below"),
        ({"world.x": "def f():\n    import tutorial_lib.viz.figures.film"}, "not below"),
        ({"files": "from tutorial_lib.geometry import wrap", "geometry": ""}, "not below"),
        ({"driving.x": "from tutorial_lib import cli", "cli": ""}, "not below"),
        ({"driving.x": "from ..viz.film import strip", "viz.film": ""}, "not below"),
        ({"topology.x": "from tutorial_lib.exploration import y"}, "never may"),
        ({"exploration.x": "from tutorial_lib.topology.y import z"}, "never may"),
        ({"checks.x": "from tutorial_lib.experiments import y"}, "not below"),
        ({"topology.x": "from tutorial_lib.learning.weights import load"}, "never may"),
        ({"exploration.x": "import tutorial_lib.learning"}, "never may"),
        ({"agents.x": "import torch"}, "only learning"),
        ({"experiments.x": "from torch.nn import Linear"}, "only learning"),
        ({"world.x": "import matplotlib.pyplot as plt"}, "draws"),
        ({"agents.x": "import cv2"}, "draws"),
        ({"learning.x": "from IPython.display import display"}, "draws"),
        ({"world.x": "from .y import z", "world.y": "from tutorial_lib.world import x"}, "cycle"),
        ({"memory": "from tutorial_lib.files import write_text", "files": ""}, "not below"),
        ({"world": "from .x import y", "world.x": "from tutorial_lib.world import z"}, "own pack"),
        ({"viz.canvas.x": "from .. import show", "viz": "", "viz.canvas": ""}, "own package"),
        ({"viz.canvas.x": "from tutorial_lib.viz.canvas import Y", "viz.canvas": ""}, "own pack"),
        ({"driving.rollouts": "from tutorial_lib.driving.control.rmp import R"}, "in their pack"),
        ({"driving.metrics": "from tutorial_lib.driving.data import x"}, "in their package"),
        ({"driving.control.x": "from tutorial_lib.driving.data.y import z"}, "in their package"),
        ({"driving.stray": "from tutorial_lib.driving.metrics import z"}, "in their package"),
        ({"topology.query": "from tutorial_lib.topology.mapping.x import y"}, "in their package"),
        ({"topology.mapping.x": "from ..planner import y", "topology.planner": ""}, "in their"),
        ({"topology.mapping.x": "from tutorial_lib.topology.following.y import z"}, "in their"),
        ({"topology.following.x": "from tutorial_lib.topology.mapping import y"}, "in their"),
        ({"topology.following.x": "from tutorial_lib.topology.planner import y"}, "in their"),
        ({"viz.canvas.x": "from tutorial_lib.viz.figures.y import z"}, "in their package"),
        ({"viz.figures.x": "from tutorial_lib.viz.notebook import show"}, "in their package"),
        (
            {"experiments.common.x": "from tutorial_lib.experiments.protocols.y import z"},
            "in their",
        ),
        ({"experiments.protocols.x": "import tutorial_lib.experiments.meng2020.y"}, "in their"),
        ({"experiments.demos.x": "from tutorial_lib.experiments.meng2020.y import z"}, "in their"),
        ({"experiments.robustness.x": "from ..benchmarks import y"}, "in their package"),
        ({"experiments.meng2020.x": "from tutorial_lib.experiments.registry import y"}, "in their"),
        ({"experiments.meng2020.fig9": "from .table2 import WORLDS"}, "another experiment"),
        ({"experiments.meng2020.fig9": "from .table2_parts import x"}, "another experiment"),
        ({"checks.framework.x": "from tutorial_lib.checks.nb01.y import z"}, "in their package"),
        ({"checks.nb02.x": "from tutorial_lib.checks.nb01.y import z"}, "in their package"),
        ({"mystery": "import tutorial_lib.geometry"}, "not below"),
    ],
)
def test_a_forbidden_import_is_found(modules, words):
    sources = {f"tutorial_lib.{name}": source for name, source in modules.items()}
    assert any(words in line for line in violations(sources))


def test_what_is_allowed_is_let_through():
    modules = {
        "geometry": "import numpy as np",
        "world.scene": "import cv2\nfrom tutorial_lib.geometry import wrap",
        "world.makers.maze": "from tutorial_lib.world.scene import Scene",
        "learning.networks": "import torch.nn\nfrom tutorial_lib.world import scene",
        "agents.meng": "from tutorial_lib.learning.networks import Pair",
        "viz.figures.film": "import cv2\nimport matplotlib",
        "experiments.demos.demo": "from tutorial_lib.viz.figures.film import strip",
        "cli": "from tutorial_lib.experiments import registry",
        "__main__": "from tutorial_lib.cli import main",
    }
    sources = {f"tutorial_lib.{name}": source for name, source in modules.items()}
    assert violations(sources) == []


def test_what_a_package_s_order_allows_is_let_through():
    modules = {
        "driving": "from .data.recorded import R\nfrom tutorial_lib.driving.metrics import a",
        "driving.rollouts": "from tutorial_lib.driving.geodesics import y",
        "driving.data.recorded": "from tutorial_lib.driving.control.rmp import y",
        "topology.planner": "from tutorial_lib.topology.mapping import TopoMap",
        "topology.mapping": "from tutorial_lib.topology.mapping.topomap import TopoMap",
        "topology.mapping.topomap": "from tutorial_lib.topology.query import query",
        "topology.following.follower": "from tutorial_lib.topology.query import query",
        "viz": "from tutorial_lib.viz.notebook import show",
        "viz.canvas": "from tutorial_lib.viz.canvas import colours",
        "viz.canvas.colours": "",
        "viz.canvas.plan": "from tutorial_lib.viz.canvas import colours",
        "viz.notebook.x": "from tutorial_lib.viz.canvas import PlanView",
        "experiments.registry": "from tutorial_lib.experiments.meng2020 import table1",
        "experiments.meng2020.table1": "from .table1_smoothing import y",
        "experiments.meng2020.table1_smoothing": "from tutorial_lib.experiments.common import x",
        "experiments.robustness.x": "from tutorial_lib.experiments.protocols.y import z",
        "experiments.demos.one": "from tutorial_lib.experiments.demos.two import y",
        "checks.nb02.x": "from tutorial_lib.checks.framework import check",
        "checks.nb02.y": "from tutorial_lib.checks.nb02.x import z",
    }
    sources = {f"tutorial_lib.{name}": source for name, source in modules.items()}
    assert violations(sources) == []
