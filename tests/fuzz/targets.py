"""Every loader, files that it reads, and what it makes of them as plain data."""

from pathlib import Path
from typing import Any

from tests.fuzz.learned import (
    BUILDING,
    Indifferent,
    Trained,
    contents,
    loaded_weights,
    make_agent,
    make_topomap,
    write_weights,
)
from tests.fuzz.outcome import Target
from tests.fuzz.plain import plain
from tests.fuzz.sources import agent_sources
from tests.fuzz.writers import (
    draw_map,
    write_board,
    write_drives,
    write_glossary,
    write_house,
    write_notebook,
    write_outcomes,
    write_plan,
    write_result,
)
from tutorial_lib.builder.page import read_glossary
from tutorial_lib.checks.progress import progress
from tutorial_lib.driving.data.rollout_outcomes import load_outcomes
from tutorial_lib.driving.data.trajectories import load_trajectories
from tutorial_lib.experiments.common.agents import custom
from tutorial_lib.experiments.common.own import guarded
from tutorial_lib.experiments.common.results import load_result
from tutorial_lib.experiments.demos.learned_map import keep_learned, load_learned
from tutorial_lib.experiments.leaderboard import page_of, read_board, text_of
from tutorial_lib.topology.mapping.storage import load_map, save_map
from tutorial_lib.world.importers import import_map
from tutorial_lib.world.simulation import checked_actions


def _run_agent(folder: Path) -> Any:
    """Import an agent, and do with it what experiments do."""
    where = f"{folder / 'agent.py'}:Agent"
    component = custom(where)

    def use() -> list[Any]:
        return checked_actions(component.learn([]), 3).tolist()

    return guarded(where, use)


def _shown(path: Path) -> tuple[str, str]:
    board = read_board(path)
    return text_of(board), page_of(board)


def _own_agent(folder: Path) -> None:
    (folder / "agent.py").write_text(agent_sources()[0], encoding="utf-8")


def targets() -> list[Target]:
    """All of them."""
    trained = Trained()
    ros = {
        "ros_png": (".png", {}),
        "ros_rgba": (".rgba.png", {"mode": "scale"}),
        "ros_pgm": (".pgm", {}),
        "ros_plain": (".txt.pgm", {}),
        "ros_bmp": (".bmp", {}),
        "ros_ppm": (".ppm", {"negate": '"no"'}),
        "ros_raw": (".tiff", {"mode": "raw"}),
        "ros_jpeg": (".jpg", {"image": r"C:\maps\map.jpg"}),
        "ros_clear": (".clear.png", {"free_thresh": 0.5, "occupied_thresh": 0.5}),
    }
    return [
        Target("plan", write_plan, lambda folder: plain(import_map(folder / "plan.json"))),
        Target("houseexpo", write_house, lambda folder: plain(import_map(folder / "house.json"))),
        *(
            Target(
                name,
                draw_map(suffix, **keys),
                lambda folder: plain(import_map(folder / "map.yaml")),
                (".png",),
            )
            for name, (suffix, keys) in ros.items()
        ),
        Target(
            "trajectories",
            write_drives,
            lambda folder: plain(load_trajectories(folder / "drives.npz")),
            (".npz",),
        ),
        Target(
            "outcomes",
            write_outcomes,
            lambda folder: plain(load_outcomes(folder / "outcomes.npz", "recipe 1")),
            (".npz",),
        ),
        Target(
            "map",
            lambda folder: save_map(folder / "flat.npz", make_topomap()),
            lambda folder: contents(load_map(folder / "flat.npz", Indifferent())),
            (".npz",),
        ),
        Target(
            "learned_map",
            lambda folder: keep_learned(BUILDING, make_agent(), folder),
            lambda folder: contents((load_learned(BUILDING, make_agent(), folder) or [None])[0]),
            (".npz",),
        ),
        Target(
            "weights",
            write_weights,
            loaded_weights,
            (".safetensors", ".json"),
        ),
        Target("checkpoint", trained.save, trained.load, (".pt",)),
        Target("results", write_result, lambda folder: plain(load_result("table", folder))),
        Target("leaderboard", write_board, lambda folder: _shown(folder / "board.json")),
        Target("notebook", write_notebook, lambda folder: plain(progress(folder))),
        Target("glossary", write_glossary, lambda folder: plain(read_glossary(folder))),
        Target("agent", _own_agent, _run_agent),
    ]
