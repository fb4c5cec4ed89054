from dataclasses import replace

import numpy as np
import pytest

from tests.world.test_generators import signature
from tests.world.test_sensors import free_poses, light
from tutorial_lib.geometry import to_world
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.materials import TEXEL, TEXELS
from tutorial_lib.world.scene import SHADE, Scene
from tutorial_lib.world.sensors import Camera, PanoramicCamera


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(2)
def test_sixteen_rows_are_the_means_of_sixty_four(family):
    scene = Scene(generate(family, 71))
    poses = free_poses(scene, 50)
    for few, many in ((Camera(16), Camera(64)), (PanoramicCamera(16), PanoramicCamera(64))):
        (coarse, depth), (fine, same_depth) = few.look(scene, poses), many.look(scene, poses)
        means = fine.reshape(50, 16, 4, few.columns, 3).mean(axis=2)
        assert np.abs(coarse - means).max() <= 1.0
        assert (depth == same_depth).all()


def test_a_wall_has_the_mean_colour_of_the_stretch_that_a_column_covers():
    rng = np.random.default_rng(3)
    plan = generate("apartment", 72)  # its strips change at every texel when there is grain
    noisy = replace(plan, look=replace(plan.look, noise=60.0))
    scene, camera = Scene(noisy), Camera(64)
    poses = free_poses(scene, 40, clearance=0.3)
    hits = scene.caster.cast(poses, camera.fan)
    image, _ = camera.look(scene, poses)
    borders = np.arctan(np.tan(camera.field_of_view / 2) * np.linspace(-1, 1, 65))
    spread = np.diff(borders)  # radians that each ray's column covers
    fine = np.linspace(0, 1, 20_001)[:-1] + 0.5 / 20_000
    for pose, ray in rng.integers((0, 0), (40, 64), (400, 2)):
        wall, distance = hits.wall[pose, ray], hits.distance[pose, ray]
        segment = noisy.segments[wall]
        run, angle = segment[2:] - segment[:2], poses[pose, 2] + camera.fan.angles[ray]
        length = np.hypot(*run)
        facing = abs(np.cos(angle) * run[1] - np.sin(angle) * run[0]) / length
        reach = distance * spread[ray] / facing / 2
        if not 0.05 < reach < 1.9:
            continue
        low, high = np.clip(hits.along[pose, ray] + np.array([-reach, reach]), 0, length)
        stretch = noisy.segment_offsets[wall] + low + (high - low) * fine
        texels = noisy.atlas[noisy.segment_materials[wall], (stretch / TEXEL).astype(int) % TEXELS]
        shade = 1 - SHADE * abs(run[0]) / length
        expected = texels.mean(axis=0) * shade * light(distance)
        # The row above the horizon shows nothing but wall.
        assert np.abs(image[pose, 31, 63 - ray] - expected).max() <= 1.5


@pytest.mark.parametrize("palette", ["standard", pytest.param("shifted", marks=pytest.mark.full)])
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(2)
def test_the_same_seed_gives_the_same_bytes_and_a_palette_only_other_colours(family, palette):
    scene, again = (Scene(generate(family, 73, palette)) for _ in range(2))
    poses = free_poses(scene, 20)
    image, depth = Camera().look(scene, poses)
    same, _ = Camera().look(again, poses)
    assert image.tobytes() == same.tobytes()
    singles = [Camera().look(scene, pose[None])[0][0] for pose in poses]
    assert (image == singles).all()
    other = "shifted" if palette == "standard" else "standard"
    changed, other_depth = Camera().look(Scene(generate(family, 73, other)), poses)
    assert (depth == other_depth).all()
    assert np.abs(image.astype(int) - changed).mean() > 10
    another, _ = Camera().look(Scene(generate(family, 74, palette)), poses)
    assert (image != another).any()


def test_twin_rooms_of_a_symmetric_office_cannot_be_told_apart():
    plan = generate("symmetric_office", 40)
    twins = {}
    for room in plan.rooms:
        twins.setdefault(signature(plan, room), []).append(np.asarray(room.outline))
    rooms = max((group for group in twins.values() if len(group[0]) == 4), key=len)
    assert len(rooms) >= 2
    size = np.abs(np.diff(rooms[0][:3], axis=0)).max(axis=1)
    rng = np.random.default_rng(0)
    local = np.column_stack([rng.uniform(0.2, 0.8, (60, 2)) * size, rng.uniform(-3, 3, 60)])
    views = []
    for outline in rooms:
        ahead = outline[1] - outline[0]
        frame = np.array([*outline[0], np.arctan2(ahead[1], ahead[0])])
        poses = np.column_stack([to_world(frame, local[:, :2]), local[:, 2] + frame[2]])
        views.append(Camera().look(Scene(plan), poses))
    (image, depth), (twin, twin_depth) = views[:2]
    # Through the door one may see that the rooms stand in different places.
    inside = np.isclose(depth, twin_depth, atol=1e-6)
    assert inside.mean() > 0.85
    difference = np.abs(image.astype(int) - twin).max(axis=(1, 3))[inside]
    assert np.mean(difference <= 1) > 0.995
