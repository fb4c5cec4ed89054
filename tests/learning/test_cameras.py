"""Networks for a camera of other degrees: their view, their names, and what they learn from."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch

from tutorial_lib import cli
from tutorial_lib.commands import train as train_command
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION
from tutorial_lib.driving.data.reachability_pairs import reachability_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.learning import outcome_data, reach_recipes, recipes
from tutorial_lib.learning.batches import Source
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.reach_batches import ProximitySource
from tutorial_lib.learning.reach_recipes import REACHABILITY, SPTM, VING
from tutorial_lib.learning.recipes import WAYPOINT
from tutorial_lib.learning.training import Settings
from tutorial_lib.learning.views import VIEWS, CameraView, DepthView, view_named, view_of
from tutorial_lib.learning.waypoint_pairs import draw_waypoint_pairs
from tutorial_lib.learning.weights import load_card, load_network, save_network
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.visibility import mutual_overlap

torch.set_num_threads(1)  # so small are they here that two threads are slower
NARROW = float(np.deg2rad(90.0))
POSES = np.array([[2.0, 5.0, 0.3], [5.0, 2.0, 2.0], [8.0, 8.0, -2.0]])
RECIPES = (*WAYPOINT.values(), *REACHABILITY.values(), SPTM, VING)
OF_CAMERA = [recipe for recipe in RECIPES if recipe.architecture.view != "laser"]


# Views.


def test_a_view_of_other_degrees_is_what_such_a_camera_sees(pillars):
    view = view_named("camera16_90")
    assert view == CameraView(degrees=90)
    assert view.camera == Camera(field_of_view=NARROW)
    shown = view.render(pillars, POSES)
    assert (shown == Camera(field_of_view=NARROW).look(pillars, POSES)[0]).all()
    assert (shown != CameraView().render(pillars, POSES)).any()


@pytest.mark.parametrize("degrees", [21, 90, 119, 121, 170])
@pytest.mark.parametrize("kind", [CameraView, partial(CameraView, 64), DepthView])
def test_names_lead_back_to_their_views(kind, degrees):
    view = kind(degrees=degrees)
    assert view_named(view.name) == view
    assert type(view_named(view.name)) is type(view)
    assert view.name.endswith(f"_{degrees}")
    assert Architecture(2, view=view.name).looks_at == view


def test_usual_views_keep_their_names_and_cameras():
    assert list(VIEWS) == ["camera16", "camera64", "laser", "rgbd16"]
    for name, view in VIEWS.items():
        assert view_named(name) == view
        assert view.name == name
    assert CameraView(degrees=120) == CameraView() == view_of(Camera())
    assert CameraView().camera == Camera()
    assert VIEWS["camera64"].camera == Camera(rows=64)


@pytest.mark.parametrize(
    "name",
    [
        *("camera17", "camera16_120", "camera16_090", "camera16_20", "camera16_171", "laser_90"),
        *("camera16_", "camera16_90_90", "camera16_９０", "_90", "", 3, None, ["camera16"]),
    ],
)
def test_other_names_are_refused(name):
    with pytest.raises(InputError, match=r"view .*; give one of camera16, .* camera16_90"):
        view_named(name)
    with pytest.raises(InputError, match=r"^network: view .*; give one of camera16"):
        Architecture(2, view=name)


@pytest.mark.parametrize("degrees", [20, 171, 90.5, "90", True, None])
def test_other_degrees_are_refused(degrees):
    with pytest.raises(InputError, match="degrees"):
        CameraView(degrees=degrees)


def test_the_view_of_a_camera_differs_in_its_degrees_alone():
    assert view_of(Camera(field_of_view=np.pi / 2)) == CameraView(degrees=90)
    for angle in range(21, 171):  # whoever turned them into radians
        near = np.nextafter(angle * np.pi / 180.0, 9.0)
        assert view_of(Camera(field_of_view=float(near))).degrees == angle
    for camera, words in (
        (Camera(rows=64), "rows=64.*field_of_view alone"),
        (Camera(columns=32, field_of_view=NARROW), "columns=32.*field_of_view alone"),
        (Camera(slope=0.7), "slope=0.7.*field_of_view alone"),
        (Camera(field_of_view=float(np.deg2rad(20.0))), "camera: 20 degrees; give"),
        (Camera(field_of_view=float(np.deg2rad(171.0))), "camera: 171 degrees; give"),
        (Camera(field_of_view=1.5), r"camera: 85\.9437 degrees; give .*whole degrees"),
        (3, "camera"),
    ):
        with pytest.raises(InputError, match=words):
            view_of(camera)


# Recipes.


@pytest.mark.parametrize("recipe", OF_CAMERA, ids=lambda recipe: recipe.name)
def test_a_recipe_of_other_degrees_differs_in_what_it_looks_through(recipe):
    other, usual = recipe.with_degrees(90), recipe.architecture
    assert recipe.with_degrees(120) == recipe
    assert other.name == f"{recipe.name}_90"
    assert other.command == f"{recipe.command} --degrees 90"
    assert other.architecture == replace(usual, view=f"{usual.view}_90")
    begins = [getattr(one, "start", getattr(one, "controller", "")) for one in (recipe, other)]
    assert begins[1] == (f"{begins[0]}_90" if begins[0] else "")
    kept = {"name", "command", "architecture", "start", "controller"}
    same = [{k: v for k, v in vars(one).items() if k not in kept} for one in (recipe, other)]
    assert same[0] == same[1]


@pytest.mark.parametrize(
    ("words", "error"),
    [
        ("waypoint --k laser --degrees 90", "--degrees: laser_k2 looks at the laser"),
        ("reachability --k laser --degrees 90", "--degrees: reach_laser looks at the laser"),
        ("waypoint --k 2 --degrees 20", "--degrees: 20; give one whole number from 21 to 170"),
        ("reachability --k 2 --degrees 171", "--degrees: 171; give one whole number"),
        (
            "waypoint --k 5 --degrees 91",
            "no waypoint_k2 for a camera of 91 degrees; train it: "
            "python -m tutorial_lib train waypoint --k 2 --degrees 91\n",
        ),
        (
            "reachability --k 5 --degrees 91",
            "no waypoint_k5 for a camera of 91 degrees; train it: "
            "python -m tutorial_lib train waypoint --k 5 --degrees 91\n",
        ),
    ],
)
def test_what_cannot_be_trained_is_refused_before_anything_is_recorded(
    words, error, capsys, monkeypatch
):
    for module, name in ((recipes, "train_local"), (reach_recipes, "train_reachability")):
        monkeypatch.setattr(module, name, None)
    assert cli.main(["train", *words.split()]) == 2
    assert error in capsys.readouterr().err


# What they learn from.


@pytest.fixture
def tiny(recorded, tmp_path, monkeypatch):
    """The command trains for a few steps in a world that is recorded already."""
    short = Settings(max_steps=4, targets=2, eval_interval=2)
    monkeypatch.setitem(WAYPOINT, "2", replace(WAYPOINT["2"], settings=short))
    known = train_command.NETWORKS["reachability"]
    monkeypatch.setitem(known, "sptm", replace(SPTM, settings=short))
    for module in (recipes, reach_recipes):
        monkeypatch.setattr(module, "recorded_worlds_of", lambda *given: [recorded])
    taught = []

    def source(kind, *given, **more):
        made = kind(*given, worlds=1, targets=4, **more)
        taught.append(made)
        return made

    monkeypatch.setattr(recipes, "Source", partial(source, Source))
    monkeypatch.setattr(reach_recipes, "ProximitySource", partial(source, ProximitySource))
    monkeypatch.setattr(recipes, "WORK", tmp_path / "work")
    (tmp_path / "work").mkdir()
    monkeypatch.setattr(train_command, "PROJECT", tmp_path)
    folder = tmp_path / "weights"
    monkeypatch.setattr(train_command, "save_network", lambda *both: save_network(*both, folder))
    return taught


@pytest.mark.parametrize(
    ("words", "name"),
    [("waypoint --k 2", "waypoint_k2"), ("reachability --k sptm", "sptm")],
)
def test_the_command_trains_for_the_camera_and_its_card_says_so(tiny, tmp_path, words, name):
    folder = tmp_path / "weights"
    assert cli.main(["train", *words.split(), "--degrees", "90"]) == 0
    assert sorted(file.name for file in folder.iterdir()) == [
        f"{name}_90.json",
        f"{name}_90.safetensors",
    ]
    card = load_card(f"{name}_90", folder)
    assert card.command == f"train {words} --degrees 90"
    assert card.architecture.view == "camera16_90"
    assert card.camera["field_of_view"] == pytest.approx(NARROW, abs=1e-6)
    assert load_network(card.name, folder).architecture.looks_at == CameraView(degrees=90)
    assert [made.architecture.view for made in tiny] == ["camera16_90"]
    assert cli.main(["train", *words.split(), "--degrees", "120"]) == 0
    assert load_card(name, folder).command == f"train {words}"
    assert [made.architecture.view for made in tiny[1:]] == ["camera16"]


def test_pairs_are_drawn_alike_and_their_images_and_overlaps_are_the_camera_s(recorded):
    usual = Source([recorded], Architecture(1), worlds=1, targets=6, vary=False, clutter=0.0)
    narrow = replace(usual, architecture=Architecture(1, view="camera16_90"))
    one, two = usual.block([0]), narrow.block([0])
    for name in ("waypoint", "turn", "context_poses", "weight"):
        assert (getattr(one, name) == getattr(two, name)).all()
    assert (one.current != two.current).any()
    assert (one.overlap != two.overlap).any()
    rng = np.random.default_rng(0)
    pairs = draw_waypoint_pairs(recorded, 6, 4, 1, PAPER_PERTURBATION, rng, field_of_view=NARROW)
    starts, goals = pairs.starts.reshape(-1, 3), np.repeat(pairs.goals, 4, axis=0)
    wanted = mutual_overlap(recorded.scene.caster, starts, goals, NARROW)
    assert (pairs.labels.overlap == wanted).all()


def test_reachability_learns_from_what_its_controller_sees(recorded, monkeypatch):
    torch.manual_seed(0)
    narrow = LocalNetwork(Architecture(0, view="camera16_90")).eval()
    made = outcome_data.WaypointNetwork
    monkeypatch.setattr(outcome_data, "WaypointNetwork", lambda name: made(narrow))
    driven = []
    monkeypatch.setattr(outcome_data, "roll_out_pairs", lambda *given: driven.append(given))
    outcome_data.outcomes_in(recorded, "office/1/standard", "waypoint_k0_90", 3)
    _, pairs, _, camera = driven[0]
    assert camera == Camera(field_of_view=NARROW)
    again = reachability_pairs(
        recorded, GridPaths(recorded.scene.clearance), pairs.starts, pairs.targets, NARROW
    )
    assert (pairs.overlap == again.overlap).all()
