"""Start and goal of one's own, as poses and as rooms."""

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.demos.ends import parse_end, room_names
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.generators import generate
from tutorial_lib.world.scene import Scene


@pytest.fixture(scope="module")
def flat():
    scene = Scene(generate("apartment", 0))
    return scene, GridPaths(scene.clearance)


@pytest.mark.parametrize("text", ["1,2", "1,2,x", "1,2,nan", "1,2,3,4", "", " ", "7", ",", "a,b,c"])
def test_what_is_neither_pose_nor_room_is_refused(text):
    with pytest.raises(InputError, match=r"--goal .*: give x,y,heading in metres and radians"):
        parse_end("--goal", text)


def test_degrees_are_noticed():
    with pytest.raises(InputError, match=r"--start 1,2,90: the heading is in radians"):
        parse_end("--start", "1,2,90")
    assert parse_end("--start", "-1e0, 2.5,-3.14").pose == (-1.0, 2.5, -3.14)


def test_rooms_of_one_kind_are_numbered(flat):
    names = room_names(flat[0].plan)
    assert len(set(names)) == len(names)
    assert {"hallway", "kitchen", "bedroom 1", "bedroom 10", "office 2"} <= {*names}


def test_a_room_stands_for_its_roomiest_place(flat):
    scene, paths = flat
    names = room_names(scene.plan)
    for name in ("kitchen", "bedroom 3"):
        x, y, heading = parse_end("--goal", name).find(scene, paths, BicycleCar())
        room = scene.plan.rooms[names.index(name)]
        assert room.contains([x, y])
        assert np.isnan(heading)
        inside = room.contains(paths.points) & paths.largest
        assert paths.clearance[inside].max() <= scene.clearance.at([x, y]) + 1e-6
    bedroom = parse_end("--goal", "bedroom").find(scene, paths, BicycleCar())
    assert np.array_equal(
        bedroom[:2], parse_end("--goal", "bedroom 1").find(scene, paths, BicycleCar())[:2]
    )


def test_a_pose_is_taken_as_it_is(flat):
    x, y, _ = parse_end("--goal", "kitchen").find(*flat, BicycleCar())
    found = parse_end("--goal", f"{x},{y},1.5").find(*flat, BicycleCar())
    assert found.tolist() == [x, y, 1.5]


def test_places_that_cannot_be_had_are_named(flat):
    scene, paths = flat
    wall = scene.plan.walls[0]
    inside = f"{wall[0]},{wall[1]},0"
    for text, words in {
        inside: r"--start: at \(.*\) heading 0\.00 the robot would be inside a wall",
        "1000,0,0": "outside all rooms; choose another place",
        "ballroom": "--start: no room is called 'ballroom'; there are hallway, bedroom 1,",
    }.items():
        with pytest.raises(InputError, match=words):
            parse_end("--start", text).find(scene, paths, BicycleCar())


def test_a_place_that_is_cut_off_is_named():
    box = make_box(8.0, 4.0)
    wall = np.array([[5.5, 0.0, 5.5, 4.0], [5.6, 4.0, 5.6, 0.0]])
    halves = type(box)(
        box.family,
        box.seed,
        np.concatenate([box.walls, wall]),
        (*box.wall_materials, *box.wall_materials[:2]),
        np.append(box.wall_offsets, [0.0, 0.0]),
        box.materials,
        box.rooms,
    )
    scene = Scene(halves)
    paths = GridPaths(scene.clearance)
    assert parse_end("--goal", "2,2,0").find(scene, paths, BicycleCar()).tolist() == [2.0, 2.0, 0.0]
    with pytest.raises(InputError, match=r"--goal: at .* cut off from the rest of the plan"):
        parse_end("--goal", "6.8,2,0").find(scene, paths, BicycleCar())
