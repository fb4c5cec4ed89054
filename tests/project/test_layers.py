"""What a module may import: only from below, and from its own package."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

LIBRARY = Path(__file__).resolve().parents[2] / "tutorial_lib"
LAYERS = (
    ("errors",),
    ("geometry", "interfaces", "files", "parallel"),
    ("world",),
    ("driving",),
    ("learning",),
    ("topology", "exploration"),
    ("agents",),
    ("viz",),
    ("experiments", "checks"),
    ("cli", "builder", "__main__"),
)
LAYER = {part: number for number, parts in enumerate(LAYERS) for part in parts}
DRAWING = {"matplotlib", "ipywidgets", "IPython", "PIL"}
NEVER = {part: DRAWING for part in LAYER if LAYER[part] < LAYER["viz"]}
for part in ("driving", "learning", "topology", "exploration", "agents"):
    NEVER[part] = DRAWING | {"cv2"}  # the world may use it for grids and reading maps
SEPARATE = {"topology": {"learning"}, "exploration": {"learning"}}


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
                if not (below or theirs == part or LAYER.get(part) == LAYER.get(theirs) == 9):
                    found.append(f"{name} imports {other}, which is not below it")
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
        ({"topology.x": "from tutorial_lib.exploration import y"}, "not below"),
        ({"exploration.x": "from tutorial_lib.topology.y import z"}, "not below"),
        ({"checks.x": "from tutorial_lib.experiments import y"}, "not below"),
        ({"topology.x": "from tutorial_lib.learning.weights import load"}, "never may"),
        ({"exploration.x": "import tutorial_lib.learning"}, "never may"),
        ({"agents.x": "import torch"}, "only learning"),
        ({"experiments.x": "from torch.nn import Linear"}, "only learning"),
        ({"world.x": "import matplotlib.pyplot as plt"}, "draws"),
        ({"agents.x": "import cv2"}, "draws"),
        ({"learning.x": "from IPython.display import display"}, "draws"),
        ({"world.x": "from .y import z", "world.y": "from tutorial_lib.world import x"}, "cycle"),
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
        "viz.film": "import cv2\nimport matplotlib",
        "experiments.demo": "from tutorial_lib.viz.figures.film import strip",
        "cli": "from tutorial_lib.experiments import demo",
        "__main__": "from tutorial_lib.cli import main",
    }
    sources = {f"tutorial_lib.{name}": source for name, source in modules.items()}
    assert violations(sources) == []
