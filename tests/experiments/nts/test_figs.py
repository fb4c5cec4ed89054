"""Figs. 3, 4, 9 and 10 with the true geometry in place of the network."""

import json

import cv2
import numpy as np
import pytest

from tests.conftest import in_turn
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import explorers
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.nts import figs
from tutorial_lib.experiments.nts.figs import LISTS, NUMBERS, Settings
from tutorial_lib.experiments.nts.figs_pictures import pictures
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.world.worlds import scene_of

SETTINGS = Settings(panoramas=2, places=40, geometry=True)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Rows and notes of one world, and the folder with the pictures."""
    folder = tmp_path_factory.mktemp("figs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(figs, "for_each", in_turn)
        rows, notes = figs.run(Options(worlds=(10_100,)), SETTINGS)
    return rows, notes, folder


def of(made, figure):
    return [row for row in made[0] if row["figure"] == figure]


@pytest.mark.full
def test_all_rows_have_the_same_columns_and_lists_are_only_in_the_json(made):
    rows, notes, _ = made
    assert [row["figure"] for row in rows] == [3, 3, 4, 4, 9, 9, 9, 9, 10, 10]
    keys = [(row["figure"], row["world"], row["case"]) for row in rows]
    assert len(set(keys)) == len(keys)
    wanted = ["figure", "world", "case", "what", *NUMBERS, *LISTS]
    assert all(list(row) == wanted for row in rows)
    report = Report("nts_figs", 0, (10_100,), False, 1.0, rows, tuple(notes))
    assert "[" not in report.as_text()
    assert json.loads(json.dumps(report.as_dict()))["rows"] == rows


@pytest.mark.full
def test_with_true_geometry_predictions_are_labels(made):
    for row in of(made, 3):
        assert row["agree"] == 12
        assert row["scores"] == row["truth"]
        assert sum(row["explorable"]) >= 2
    for row in of(made, 4):
        assert np.allclose(row["scores"], row["truth"], atol=2e-3)
        assert (row["chosen"], row["regret"]) == (row["best"], 0.0)


def test_two_goals_lie_in_other_rooms_and_other_directions_of_the_same_place(made):
    first, second = of(made, 4)
    assert first["pose"] == second["pose"]
    assert first["what"] != second["what"]
    turn = abs(first["best"] - second["best"])
    assert min(turn, 12 - turn) >= 3
    scene = scene_of(first["world"])
    labels = PanoramaLabels(scene, [first["pose"], first["goal"], second["goal"]])
    assert labels.explorable[0].tolist() == first["explorable"]
    metres = labels.metres(np.zeros(2, int), np.array([1, 2]))
    assert ((metres[:, -1] >= 5.0) & (metres[:, -1] < 10.0)).all()
    for row, far in zip((first, second), metres[:, :-1], strict=True):
        assert far[row["best"]] == far[np.array(row["explorable"])].min()


def test_the_first_ghost_depends_on_the_goal(made):
    rows = of(made, 10)
    for row, same in zip(rows, of(made, 4), strict=True):
        assert (row["pose"], row["goal"], row["best"]) == (same["pose"], same["goal"], same["best"])
        assert row["chosen"] == row["best"]
        (moment,) = row["moments"]
        assert len(moment["nodes"]) == 1
        assert np.allclose(moment["nodes"][0], row["pose"][:2], atol=1e-3)
        assert row["success"]
        assert 0.5 < row["spl"] <= 1.0
        assert row["nodes"] >= 1
        assert len(row["track"]) == row["steps"] + 1


def test_fig9_runs_one_episode_four_times(made):
    rows = of(made, 9)
    assert [row["what"] for row in rows] == [
        *("nts, noise", "nts, no noise", "fbe, noise", "fbe, no noise"),
    ]
    assert len({(*row["pose"], *row["goal"]) for row in rows}) == 1
    for row in rows:
        assert np.allclose(row["track"][0], row["pose"][:2], atol=1e-3)
        assert len(row["track"]) == row["steps"] + 1
    moments = rows[0]["moments"]
    assert len(moments) == len(rows[1]["moments"]) == 4
    assert rows[2]["moments"] == rows[3]["moments"] == []
    assert [m["step"] for m in moments][0::3] == [0, rows[0]["steps"] - 1]
    assert len(moments[-1]["nodes"]) == rows[0]["nodes"] >= len(moments[0]["nodes"]) == 1
    # Without noise odometry is exact, so the graph lies where the robot was.
    exact = rows[1]
    gap = np.array(exact["moments"][-1]["nodes"])[:, None] - np.array(exact["track"])
    assert np.linalg.norm(gap, axis=2).min(axis=1).max() < 0.01


@pytest.mark.full
def test_pictures_are_left_and_are_drawn_from_the_rows_alone(made):
    rows, notes, folder = made
    names = ["nts_fig10.png", "nts_fig3.png", "nts_fig4.png", "nts_fig9.png"]
    assert sorted(path.name for path in folder.iterdir()) == names
    assert all(name in notes[-1] for name in names)
    again = pictures(json.loads(json.dumps(rows)))
    for name, picture in again.items():
        saved = cv2.imread(str(folder / f"nts_{name}.png"))[..., ::-1]
        assert np.array_equal(saved, picture)
        assert picture.std() > 10
    assert pictures([]) == {}


def test_without_weights_nothing_is_run(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(explorers, "FOLDER", tmp_path)
    monkeypatch.setattr(figs, "run_world", None)
    with pytest.raises(InputError, match="train nts --sensor rgbd makes them"):
        figs.EXPERIMENT.report(Options())
    assert list(tmp_path.iterdir()) == []
