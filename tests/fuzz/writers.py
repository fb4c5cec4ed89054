"""Writes a file of each kind, as it should be, into a folder."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tests.conftest import make_box, make_trajectory
from tests.fuzz.corpus import png
from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes, save_outcomes
from tutorial_lib.driving.data.trajectories import save_trajectories
from tutorial_lib.experiments.common.report import Report
from tutorial_lib.experiments.leaderboard import Entry, text_of
from tutorial_lib.world.plan_json import save_plan


def draw_map(suffix: str, **keys: Any) -> Callable[[Path], None]:
    """Writes a ROS map with a picture of this suffix."""

    def make(folder: Path) -> None:
        cells = np.full((40, 48), 205, np.uint8)
        cells[4:36, 4:44] = 254
        cells[14:20, 20:30] = 0
        path = folder / f"map{suffix}"
        if suffix == ".txt.pgm":
            rows = "\n".join(" ".join(map(str, row)) for row in cells.tolist())
            path.write_text(f"P2\n# plain\n48 40\n255\n{rows}\n", encoding="ascii")
        elif suffix == ".pgm":
            path.write_bytes(b"P5\n48 40\n255\n" + cells.tobytes())
        elif suffix == ".clear.png":
            body = b"".join(b"\0" + row.tobytes() for row in cells)
            path.write_bytes(png(48, 40, body, named=b"\0\xcd"))  # 205 is transparent
        elif suffix == ".tiff":
            per_cent = np.choose(cells // 100, [100, 100, 255])
            per_cent[cells == 254] = 0
            assert cv2.imwrite(str(path), per_cent.astype(np.uint8))
        elif suffix == ".ppm":
            assert cv2.imwrite(str(path), np.dstack([cells] * 3))
        elif suffix == ".rgba.png":
            opaque = np.full_like(cells, 255)
            assert cv2.imwrite(str(path), np.dstack([cells, cells, cells, opaque]))
        else:
            assert cv2.imwrite(str(path), cells)
        content = {
            "image": path.name,
            "resolution": 0.1,
            "origin": [-1.0, -2.0, 0.0],
            "negate": 0,
            "occupied_thresh": 0.65,
            "free_thresh": 0.196,
            **keys,
        }
        lines = [f"{key}: {value}" for key, value in content.items()]
        (folder / "map.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")

    return make


def write_house(folder: Path) -> None:
    verts = [[0, 0], [8, 0], [8, 3.5], [6, 3.5], [6, 7], [0, 7]]
    rooms = {"Kitchen": [[0, 0, 4, 3.5]], "Bedroom": [0, 3.5, 6, 7], "Hall": [[4, 0, 8, 3.5]]}
    content = {"id": "a1", "room_num": 3, "verts": verts, "room_category": rooms}
    (folder / "house.json").write_text(json.dumps(content), encoding="utf-8")


def write_plan(folder: Path) -> None:
    save_plan(make_box(4.0, 3.0, pillars=[(2.0, 1.5, 0.3)]), folder / "plan.json")


def write_drives(folder: Path) -> None:
    lines = [[(0, 0), (1, 0)], [(0, 0), (0, 1), (0.5, 1.0)]]
    save_trajectories(folder / "drives.npz", [make_trajectory(line) for line in lines])


def write_outcomes(folder: Path) -> None:
    count, rng = 12, np.random.default_rng(0)
    pairs = ReachabilityPairs(
        rng.normal(size=(count, 3)), np.arange(count), rng.random((count, 2)), rng.random(count)
    )
    driven, reached = np.arange(count) % 3 > 0, np.arange(count) % 3 == 1
    outcomes = RolloutOutcomes(pairs, driven, reached, driven & ~reached, driven * 2.5)
    save_outcomes(folder / "outcomes.npz", outcomes, "recipe 1")


def write_result(folder: Path) -> None:
    rows = [{"method": name, "trials": 40, "success": 0.5, "low": None} for name in ("a", "b")]
    report = Report("table", 0, (1, 2), False, 1.5, rows, ("a note",)).as_dict()
    (folder / "table.json").write_text(json.dumps(report, indent=1), encoding="utf-8")


def write_board(folder: Path) -> None:
    row = {"condition": "clean", "success": 0.5, "low": 0.25, "high": None}
    run = {"experiment": "meng_table1", "quick": True, "worlds": (20_000,)}
    entries = [
        Entry(seam="controller", name="mine.py:Mine", sha="0a" * 32, rows=[row], **run),
        Entry(name="k5", sha="1b" * 32, rows=[row, row], **run),
        Entry(name="bad.py:Mine", sha="", quick=False, fault="bad.py, line 3: it broke"),
    ]
    (folder / "board.json").write_text(text_of(entries), encoding="utf-8")


def write_notebook(folder: Path) -> None:
    cells = [{"metadata": {"exercise": name}, "source": [], "outputs": []} for name in ("a", "b")]
    content = {"cells": [*cells, {"metadata": {}, "source": ["x"]}], "nbformat": 4}
    (folder / "01_some.ipynb").write_text(json.dumps(content), encoding="utf-8")


def write_glossary(folder: Path) -> None:
    content = {"pose": {"meaning": "where", "symbol": "x"}, "anchor": {"meaning": "a frame"}}
    (folder / "glossary.json").write_text(json.dumps(content), encoding="utf-8")
