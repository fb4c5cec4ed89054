"""What a robot sees that was not there when the map was made; walls never count."""

import numpy as np
import pytest

from tests.conftest import make_box
from tests.world.test_sensors import free_poses
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import to_world
from tutorial_lib.se2 import compose, inverse, relative
from tutorial_lib.topology.mapping.change_detection import Changes, changes, first_on_path
from tutorial_lib.world.people import Crowd, Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Laser
from tutorial_lib.world.worlds import scene_of

WORLDS = ("apartment/10000/standard", "office/10000/standard", "loop_corridor/10000/standard")
AHEAD = np.array([[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [3.0, 0.0, 0.0]])


def drawn(world, count=40):
    """Poses of images, and of robots beside them that believe to be elsewhere (all (N, 3))."""
    scene, rng = scene_of(world), np.random.default_rng(7)
    images = free_poses(scene, count, 7, 0.5)
    off = rng.uniform(-1, 1, (count, 3)) * (0.25, 0.25, 0.15)
    wrong = rng.uniform(-1, 1, (count, 3)) * (0.25, 0.25, 0.15)
    robots = compose(images, off)
    return scene, images, robots, compose(relative(robots, images), wrong)


@pytest.mark.parametrize("world", WORLDS)
def test_where_nothing_changed_nothing_is_found_and_the_image_s_pose_is_put_right(world):
    scene, images, robots, believed = drawn(world)
    mapped, lasers = Laser().scan(scene, images), Laser().scan(scene, robots)
    found = [changes(*one) for one in zip(lasers, mapped, believed, strict=True)]
    assert sum(seen is not None for seen in found) >= 0.9 * len(images)
    for seen, image, robot in zip(found, images, robots, strict=True):
        if seen is None:
            continue
        there = relative(robot, image)
        assert np.hypot(*(seen.image - there)[:2]) < 0.15
        turns = np.linspace(-np.pi, np.pi, 24, endpoint=False)
        for turn in turns:
            path = compose(np.array([0.0, 0.0, turn]), AHEAD)
            assert first_on_path(seen, path) is None


@pytest.mark.parametrize("world", WORLDS)
def test_a_person_on_the_path_is_found_on_its_part_and_nothing_but_the_person(world):
    scene, images, robots, believed = drawn(world)
    mapped, tried = Laser().scan(scene, images), 0
    for image, robot, belief, scan in zip(images, robots, believed, mapped, strict=True):
        free = Laser().scan(scene, robot[None])[0]
        beam = int(free.argmax())
        heading = -np.pi + (beam + 0.5) * 2 * np.pi / len(free)
        path = compose(np.array([0.0, 0.0, heading]), AHEAD)
        place = compose(robot, path[1])[:2] + 0.5 * np.array(
            [np.cos(robot[2] + heading), np.sin(robot[2] + heading)]
        )
        seen_from_image = Laser().scan(scene, image[None])[0]
        if free.max() < 3.5 or hidden(image, place, seen_from_image):
            continue
        people = Crowd([Person(place[None], speed=0.0)])
        laser = Laser().scan(scene, robot[None], people.discs)[0]
        seen = changes(laser, scan, belief)
        found = None if seen is None else first_on_path(seen, path)
        if found is None:
            continue
        tried += 1
        part, points = found
        assert part == 1
        gaps = np.hypot(*(to_world(robot, points) - place).T)
        assert gaps.max() < Person.radius + 0.05
    assert tried >= 10


def hidden(image, place, laser):
    """Whether the image's laser was near a wall in the direction of a place."""
    x, y, _ = compose(inverse(image), np.append(place, 0.0))
    beam = int((np.arctan2(y, x) + np.pi) / (2 * np.pi) * len(laser))
    return laser[np.arange(beam - 2, beam + 3) % len(laser)].min() < np.hypot(x, y) + 0.6


@pytest.mark.parametrize("world", WORLDS)
def test_a_robot_that_is_elsewhere_finds_nothing_or_hardly_ever(world):
    scene, images, _, believed = drawn(world, 60)
    lasers, mapped = Laser().scan(scene, images), Laser().scan(scene, np.roll(images, 1, axis=0))
    false = 0
    for laser, scan, belief in zip(lasers, mapped, believed, strict=True):
        seen = changes(laser, scan, belief)
        false += seen is not None and first_on_path(seen, AHEAD) is not None
    assert false <= 1


def test_it_is_the_first_part_with_something_new_that_counts():
    wall = np.column_stack([np.linspace(-3, 3, 61), np.full(61, 2.0)])
    person = np.array([[2.0, 0.0], [2.0, 0.1], [2.4, 0.0]])
    points = np.vstack([wall, person])
    new = np.append(np.zeros(len(wall), bool), np.ones(len(person), bool))
    seen = Changes(np.zeros(3), points, new)
    part, found = first_on_path(seen, AHEAD)
    assert part == 1
    np.testing.assert_array_equal(found, person)
    assert first_on_path(seen, AHEAD[:2]) is None
    assert first_on_path(seen, compose(np.array([0.0, 0.0, 0.4]), AHEAD)) is None
    # Of two obstacles it is the first that counts.
    nearer = np.vstack([points, [[0.8, 0.0], [0.8, 0.1]]])
    both = Changes(seen.image, nearer, np.append(new, [True, True]))
    part, found = first_on_path(both, AHEAD)
    assert part == 0
    np.testing.assert_array_equal(found, nearer[-2:])
    # Much else is new: the scans do not show the same place.
    strange = Changes(seen.image, points, new | (points[:, 0] < -2.0))
    assert first_on_path(strange, AHEAD) is None


@pytest.mark.parametrize(
    ("laser", "mapped", "image", "name"),
    [
        ((96,), (95,), (3,), "mapped"),
        ((96,), (96,), (2,), "image"),
        ((1, 96), (96,), (3,), "laser"),
    ],
)
def test_arrays_of_other_shapes_are_refused_by_name(laser, mapped, image, name):
    with pytest.raises(InputError, match=name):
        changes(np.ones(laser), np.ones(mapped), np.zeros(image))


def test_where_something_of_the_image_is_gone_nothing_is_said():
    scene, here = Scene(make_box()), np.array([[5.0, 5.0, 0.0]])
    people = [Person(np.array([place]), speed=0.0) for place in ((5.8, 5.0), (5.0, 5.8))]
    laser, mapped = (Laser().scan(scene, here, Crowd(some).discs)[0] for some in ([], people))
    assert changes(mapped, mapped, np.zeros(3)) is not None
    assert changes(laser, mapped, np.zeros(3)) is None
    seen = changes(mapped, laser, np.zeros(3))
    assert seen is not None
    assert seen.any


def test_one_point_is_no_obstacle():
    points, new = np.array([[1.0, 0.0], [3.0, 2.0], [1.1, 0.1]]), np.array([True, False, False])
    assert first_on_path(Changes(np.zeros(3), points, new), AHEAD) is None
    assert not Changes(np.zeros(3), points, new).any
    new[2] = True
    assert first_on_path(Changes(np.zeros(3), points, new), AHEAD) is not None
