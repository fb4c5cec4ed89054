"""Imported maps: where the walls land, what the rays see, and the message for each mistake."""

import json
import re
import unicodedata

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fuzz.corpus import png
from tutorial_lib.errors import InputError, Notice
from tutorial_lib.geometry import distance_to_segments, to_local, to_world
from tutorial_lib.world.importers import (
    contours,
    import_houseexpo,
    import_map,
    import_ros_map,
    parse_region,
    surfaces,
)
from tutorial_lib.world.importers.contours import free_loops, signed_area, trace_loops
from tutorial_lib.world.importers.surfaces import SPAN, dress_loops
from tutorial_lib.world.materials import PERIOD
from tutorial_lib.world.occupancy import check_closed, clearance_grid
from tutorial_lib.world.plan_json import plan_from_json, plan_to_json, save_plan

FREE, UNKNOWN, OCCUPIED = 254, 205, 0
KEYS = {
    "image": "map.pgm",
    "resolution": 0.1,
    "origin": [0.0, 0.0, 0.0],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


def write_yaml(folder, drop=(), **changes):
    keys = {k: v for k, v in {**KEYS, **changes}.items() if k not in drop}
    (folder / "map.yaml").write_text("".join(f"{k}: {v}\n" for k, v in keys.items()))
    return folder / "map.yaml"


def p5(pixels, comment=b"# CREATOR: a test\n"):
    height, width = pixels.shape
    return b"P5\n%s%d %d\n255\n" % (comment, width, height) + pixels.astype(np.uint8).tobytes()


def write_map(folder, pixels, **changes):
    """A map from its pixels, row 0 on top; the path of its YAML file."""
    (folder / "map.pgm").write_bytes(p5(pixels))
    return write_yaml(folder, **changes)


def box(height=30, width=40, value=OCCUPIED):
    """A free room with a frame of two cells."""
    pixels = np.full((height, width), value, np.uint8)
    pixels[2:-2, 2:-2] = FREE
    return pixels


def blobs(seed, shape=(120, 160), level=0.55):
    """A map of smooth random blobs with salt and pepper, and a closed border."""
    rng = np.random.default_rng(seed)
    noise = cv2.GaussianBlur(rng.random(shape), (0, 0), 5)
    pixels = np.where(noise < np.quantile(noise, level), FREE, UNKNOWN)
    pixels[rng.random(shape) < 0.005] = OCCUPIED
    pixels[rng.random(shape) < 0.002] = FREE
    pixels[0] = OCCUPIED
    return pixels.astype(np.uint8)


def corners(plan):
    return {tuple(p) for p in plan.walls.reshape(-1, 2).round(9).tolist()}


def sides(loop):
    return np.concatenate([loop, np.roll(loop, -1, axis=0)], axis=1).astype(float)


# --- ROS: where things land ---------------------------------------------------------------------


def test_walls_lie_on_the_edges_of_the_cells(tmp_path):
    plan = import_ros_map(write_map(tmp_path, box(), origin=[-1.0, 2.0, 0.0]))
    assert corners(plan) == {(-0.8, 2.2), (2.8, 2.2), (2.8, 4.8), (-0.8, 4.8)}
    assert len(plan.walls) == 4
    assert (plan.family, plan.seed, plan.furniture, plan.doors) == ("ros", 0, (), ())
    assert [room.kind for room in plan.rooms] == ["open"]
    assert plan.area == pytest.approx(3.6 * 2.6)


def test_row_zero_of_the_picture_is_the_top(tmp_path):
    pixels = box()
    pixels[2:12, 15:] = OCCUPIED  # an L: the upper right is missing
    plan = import_ros_map(write_map(tmp_path, pixels))
    assert corners(plan) == {(0.2, 0.2), (3.8, 0.2), (3.8, 1.8), (1.5, 1.8), (1.5, 2.8), (0.2, 2.8)}


@pytest.mark.parametrize("yaw", [0.5 * np.pi, -2.0, 0.3])
def test_yaw_turns_the_map_about_its_lower_left_corner(tmp_path, yaw):
    pixels = box()
    pixels[2:12, 15:] = OCCUPIED
    straight = import_ros_map(write_map(tmp_path, pixels))
    pose = [3.0, -1.0, yaw]
    turned = import_ros_map(write_map(tmp_path, pixels, origin=pose))
    expected = to_world(pose, straight.walls.reshape(-1, 2))
    np.testing.assert_allclose(turned.walls.reshape(-1, 2), expected, atol=1e-9)
    check_closed(turned)


def test_obstacles_inside_and_map_edges_get_walls(tmp_path):
    pixels = np.full((30, 40), FREE, np.uint8)
    pixels[10:13, 20:25] = OCCUPIED
    pixels[20, 5] = UNKNOWN
    plan = import_ros_map(write_map(tmp_path, pixels))
    assert {(2.0, 1.7), (2.5, 1.7), (2.5, 2.0), (2.0, 2.0), (0.5, 0.9), (0.6, 1.0)} < corners(plan)
    assert {(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)} < corners(plan)
    assert len(plan.walls) == 12
    assert len(plan.rooms) == 1


def test_regions_too_small_for_the_car_are_left_out(tmp_path):
    pixels = np.full((40, 60), OCCUPIED, np.uint8)
    pixels[5:35, 5:25] = FREE  # 2 x 3 m
    pixels[5:14, 30:38] = FREE  # 0.72 m2
    pixels[20:22, 28:58] = FREE  # long, but 0.2 m wide
    pixels[26:37, 30:58] = FREE  # 1.1 x 2.8 m
    plan = import_ros_map(write_map(tmp_path, pixels))
    assert len(plan.rooms) == 2
    assert plan.area == pytest.approx(6.0 + 3.08)


# --- ROS: what a pixel means --------------------------------------------------------------------


def write_png(folder, picture):
    assert cv2.imwrite(str(folder / "map.png"), picture)


def test_p2_p5_png_and_colour_say_the_same(tmp_path):
    pixels = box(value=UNKNOWN)
    pixels[10:14, 10:18] = OCCUPIED
    expected = import_ros_map(write_map(tmp_path, pixels)).walls
    text = "\n".join(" ".join(map(str, row)) for row in pixels.tolist())
    (tmp_path / "map.pgm").write_text(f"P2 # text\n40 30\n255\n# rows\n{text}\n")
    np.testing.assert_array_equal(import_ros_map(write_yaml(tmp_path)).walls, expected)
    for picture in (
        pixels,
        np.repeat(pixels[..., None], 3, axis=2),
        pixels.astype(np.uint16) * 257,
    ):
        write_png(tmp_path, picture)
        np.testing.assert_array_equal(
            import_ros_map(write_yaml(tmp_path, image="map.png")).walls, expected
        )


def test_pgm_with_another_largest_value(tmp_path):
    pixels = (box() > 0).astype(np.uint8)
    expected = import_ros_map(write_map(tmp_path, box())).walls
    (tmp_path / "map.pgm").write_bytes(b"P5 40 30 1\n" + pixels.tobytes())
    np.testing.assert_array_equal(import_ros_map(write_yaml(tmp_path)).walls, expected)
    wide = (pixels.astype(">u2") * 1000).tobytes()
    (tmp_path / "map.pgm").write_bytes(b"P5 40 30 1000\n" + wide)
    np.testing.assert_array_equal(import_ros_map(write_yaml(tmp_path)).walls, expected)


@pytest.mark.parametrize("negate", [1, "true"])
def test_negate_swaps_black_and_white(tmp_path, negate):
    pixels = box()
    expected = import_ros_map(write_map(tmp_path, pixels)).walls
    plan = import_ros_map(write_map(tmp_path, 255 - pixels, negate=negate))
    np.testing.assert_array_equal(plan.walls, expected)


def test_thresholds_are_those_of_map_server(tmp_path):
    pixels = box()
    pixels[10:14, 10:18] = 204  # occupancy 0.2
    assert len(import_ros_map(write_map(tmp_path, pixels, free_thresh=0.1999)).walls) == 8
    assert len(import_ros_map(write_map(tmp_path, pixels, free_thresh=0.2001)).walls) == 4
    pixels[pixels == FREE] = 255  # occupancy 0, which is not below 0
    expect_error(import_ros_map, write_map(tmp_path, pixels, free_thresh=0), ["free region"])
    # With nav2's default of 0.25 the grey of a trinary map counts as free.
    pixels[10:14, 10:18] = UNKNOWN
    assert len(import_ros_map(write_map(tmp_path, pixels, free_thresh=0.25)).walls) == 4


def test_scale_keeps_graded_and_transparent_cells_out(tmp_path):
    pixels = box()
    pixels[10:14, 10:18] = 128
    assert len(import_ros_map(write_map(tmp_path, pixels, mode="scale")).walls) == 8
    picture = np.repeat(box()[..., None], 4, axis=2)
    picture[..., 3] = 255
    picture[10:14, 10:18, 3] = 0
    write_png(tmp_path, picture)
    yaml_path = write_yaml(tmp_path, image="map.png", mode="scale")
    assert len(import_ros_map(yaml_path).walls) == 8


MODES = ["trinary", "scale", "raw"]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("colours", [1, 3])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_opaque_pixels_count_as_their_grey_and_all_others_are_unknown(
    tmp_path, mode, colours, kind
):
    pixels = box(value=UNKNOWN)
    pixels[20:24, 20:28] = OCCUPIED
    if mode == "raw":
        pixels = np.choose(pixels == FREE, [np.where(pixels == OCCUPIED, 100, 255), 3])
    top = np.iinfo(kind).max
    levels = (pixels / 255 * top).round().astype(kind)
    plain = import_ros_map(write_picture(tmp_path, levels, "map.tiff", mode=mode))
    assert len(plain.walls) == 8
    clear = np.full_like(levels, top)
    clear[10:14, 10:18] = top - 1  # as good as opaque, and yet not
    for opacity, walls in ((np.full_like(levels, top), 8), (clear, 12)):
        picture = np.dstack([levels] * colours + [opacity])
        plan = import_ros_map(write_picture(tmp_path, picture, "map.png", mode=mode))
        assert len(plan.walls) == walls
    assert {(1.0, 1.6), (1.8, 2.0)} < corners(plan)


def write_picture(folder, values, name, **changes):
    """A map with a picture by its numbers (H, W, C); the path of its YAML file."""
    data = grey_alpha_png(values) if values.shape[2:] == (2,) else None
    if data is None:
        assert cv2.imwrite(str(folder / name), values)
    else:
        (folder / name).write_bytes(data)
    return write_yaml(folder, image=name, **changes)


def grey_alpha_png(values):
    """A PNG of grey and opacity, which OpenCV cannot write."""
    height, width, _ = values.shape
    rows = values.astype(values.dtype.newbyteorder(">")).reshape(height, -1)
    body = b"".join(b"\0" + row.tobytes() for row in rows)
    return png(width, height, body, kind=4, depth=8 * values.itemsize)


@pytest.mark.parametrize("mode", MODES)
def test_a_grey_that_a_png_names_as_transparent_is_unknown(tmp_path, mode):
    grey = {"trinary": 254, "scale": 254, "raw": 0}[mode]
    pixels = np.full((30, 40), grey, np.uint8)
    pixels[10:14, 10:18] = grey + 1
    body = b"".join(b"\0" + row.tobytes() for row in pixels)
    for named, walls in ((b"", 4), (b"\0" + bytes([grey + 1]), 8), (b"\0\7", 4)):
        (tmp_path / "map.png").write_bytes(png(40, 30, body, named=named))
        plan = import_ros_map(write_yaml(tmp_path, image="map.png", mode=mode))
        assert len(plan.walls) == walls
    for depth, named in ((1, b"\0\1"), (4, b"\0\x0f")):  # white; fewer bits are spread
        body = b"".join(b"\0" + bytes([255] * (40 * depth // 8)) for _ in range(30))
        (tmp_path / "map.png").write_bytes(png(40, 30, body, named=named, depth=depth))
        with pytest.raises(InputError, match="no free region"):
            import_ros_map(write_yaml(tmp_path, image="map.png", mode=mode))


def test_a_colour_that_a_png_names_as_transparent_is_unknown(tmp_path):
    pixels = np.full((30, 40, 3), 254, np.uint8)
    pixels[10:14, 10:18] = (250, 251, 252)
    body = b"".join(b"\0" + row.tobytes() for row in pixels)
    for named, walls in (((250, 251, 252), 8), ((252, 251, 250), 4)):
        named = np.array(named, ">u2").tobytes()
        (tmp_path / "map.png").write_bytes(png(40, 30, body, kind=2, named=named))
        assert len(import_ros_map(write_yaml(tmp_path, image="map.png")).walls) == walls


@pytest.mark.parametrize(
    ("value", "walls"), [(0, 4), (19, 4), (20, 8), (66, 8), (100, 8), (101, 8), (254, 8)]
)
def test_a_raw_pixel_is_the_occupancy_in_per_cent(tmp_path, value, walls):
    pixels = np.full((30, 40), 5, np.uint8)
    pixels[10:14, 10:18] = value
    for negate in (0, 1):  # which says nothing of raw maps
        path = write_map(tmp_path, pixels, mode="raw", negate=negate)
        assert len(import_ros_map(path).walls) == walls
    colour = np.repeat(pixels[..., None], 3, axis=2)
    path = write_picture(tmp_path, colour, "map.png", mode="raw")
    assert len(import_ros_map(path).walls) == walls


@pytest.mark.parametrize("suffix", [".jpg", ".tif", ".ppm", ".bmp", ".png"])
def test_every_kind_of_picture_says_the_same(tmp_path, suffix):
    pixels = np.full((48, 64), UNKNOWN, np.uint8)
    pixels[8:-8, 8:-8] = FREE
    pixels[16:24, 24:32] = OCCUPIED  # squares of 8 x 8 pixels, as JPEG has them
    expected = import_ros_map(write_map(tmp_path, pixels)).walls
    colour = np.repeat(pixels[..., None], 3, axis=2)
    assert cv2.imwrite(str(tmp_path / f"map{suffix}"), colour, [cv2.IMWRITE_JPEG_QUALITY, 100])
    found = import_ros_map(write_yaml(tmp_path, image=f"map{suffix}"))
    np.testing.assert_array_equal(found.walls, expected)


def test_equal_thresholds_leave_nothing_unknown(tmp_path):
    pixels = box()
    pixels[10:14, 10:18] = UNKNOWN  # occupancy 0.196
    path = write_map(tmp_path, pixels, free_thresh=0.5, occupied_thresh=0.5)
    assert len(import_ros_map(path).walls) == 4
    pixels[10:14, 10:18] = 127
    path = write_map(tmp_path, pixels, free_thresh=0.5, occupied_thresh=0.5)
    assert len(import_ros_map(path).walls) == 8


@pytest.mark.parametrize(
    ("said", "negated"),
    [
        *(('"0"', False), ("'1'", True), ("no", False), ("Yes", True), ("off", False)),
        *(("on", True), ("n", False), ("0x0", False), ("FALSE", False), ("2", True)),
    ],
)
def test_negate_is_read_as_yaml_cpp_does(tmp_path, said, negated):
    pixels = 255 - box() if negated else box()
    assert len(import_ros_map(write_map(tmp_path, pixels, negate=said)).walls) == 4


@pytest.mark.parametrize(
    ("said", "metres"),
    [('"0.1"', 0.1), ("1e-1", 0.1), (".1", 0.1), ("+1.e-1", 0.1), ("01", 1.0), ("0o1", 1.0)],
)
def test_numbers_are_those_of_yaml_1_2(tmp_path, said, metres):
    plan = import_ros_map(write_map(tmp_path, box(), resolution=said))
    assert plan.bounds == pytest.approx(np.multiply((2, 2, 38, 28), metres))


@pytest.mark.parametrize("said", ["0_1", "1e-1_0", "0b1", "1:30", "1,0", "0.1m", "''", "true", "~"])
def test_what_is_no_number_of_yaml_1_2_is_refused(tmp_path, said):
    for key, value in (("resolution", said), ("origin", f"[{said.replace(',', '_')}, 0, 0]")):
        expect_error(
            import_ros_map, write_map(tmp_path, box(), **{key: value}), [f"map.yaml: {key}"]
        )


def test_a_key_that_is_given_twice_is_named(tmp_path):
    path = write_map(tmp_path, box())
    path.write_text(path.read_text() + "resolution: 0.2\n")
    expect_error(import_ros_map, path, ["map.yaml", "line 7", "'resolution' is given twice"])


# --- ROS: where the picture is ------------------------------------------------------------------

ELSEWHERE = [
    "/opt/robot/maps/map.pgm",
    r"C:\robot\map.pgm",
    r"..\maps\map.pgm",
    "maps/map.pgm",
    "~/map.pgm",
    "~nobody/map.pgm",
    "file:///maps/map.pgm",
    "package://maps/map.pgm",
    "MAP.PGM",
]


@pytest.mark.parametrize("named", ELSEWHERE)
def test_a_picture_beside_its_file_is_taken_whatever_its_path_was_and_that_is_said(
    tmp_path, named, monkeypatch
):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    expected = import_ros_map(write_map(tmp_path, box())).walls
    for other in ("other.pgm", "map.png"):
        (tmp_path / other).write_bytes(b"")
    path = write_yaml(tmp_path, image=f"'{named}'")
    with pytest.warns(Notice) as said:
        plan = import_ros_map(path)
    np.testing.assert_array_equal(plan.walls, expected)
    assert [str(word.message) for word in said] == [
        f"map.yaml: image: {named!r} is not there; took 'map.pgm' beside it"
    ]


def test_a_picture_that_is_where_it_is_said_to_be_is_taken_without_a_word(
    tmp_path, monkeypatch, recwarn
):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    write_map(tmp_path, np.zeros((30, 40)))  # beside it
    for folder in (tmp_path / "home", tmp_path):
        (folder / "room.pgm").write_bytes(p5(box()))
    (tmp_path / "room.pgm").rename(tmp_path / r"a\map.pgm")
    for named in ("~/room.pgm", str(tmp_path / "home" / "room.pgm"), "home/room.pgm", r"a\map.pgm"):
        assert len(import_ros_map(write_yaml(tmp_path, image=f"'{named}'")).walls) == 4
    assert not recwarn


def test_windows_separators_lead_into_folders(tmp_path):
    (tmp_path / "sub dir").mkdir()
    (tmp_path / "sub dir" / "rôom 1.pgm").write_bytes(p5(box()))
    write_map(tmp_path, np.zeros((30, 40)))
    with pytest.warns(Notice, match="took 'rôom 1.pgm'"):
        plan = import_ros_map(write_yaml(tmp_path, image=r"'sub dir\rôom 1.pgm'"))
    assert len(plan.walls) == 4


def test_accents_may_be_stored_apart(tmp_path):
    (tmp_path / unicodedata.normalize("NFD", "rôom.pgm")).write_bytes(p5(box()))
    path = write_yaml(tmp_path, image=unicodedata.normalize("NFC", "rôom.pgm"))
    with pytest.warns(Notice):
        assert len(import_ros_map(path).walls) == 4


def test_of_another_machine_s_path_the_only_picture_of_its_kind_is_meant(tmp_path):
    (tmp_path / "renamed.pgm").write_bytes(p5(box()))
    foreign = write_yaml(tmp_path, image="/opt/robot/map.pgm")
    with pytest.warns(Notice, match=r"took 'renamed\.pgm'"):
        assert len(import_ros_map(foreign).walls) == 4
    own = ["map.pgm", "maps/map.pgm", "/opt/robot/map.png", "/opt/robot/"]
    for named in own:  # nobody knows which is meant, or it may be mistyped
        expect_error(import_ros_map, write_yaml(tmp_path, image=named), ["map.yaml: image"])
    (tmp_path / "second.pgm").write_bytes(p5(box()))
    foreign = write_yaml(tmp_path, image="/opt/robot/map.pgm")
    expect_error(import_ros_map, foreign, ["map.yaml: image", "beside the YAML file"])


# --- ROS: size, and regions ---------------------------------------------------------------------


def test_a_long_building_is_read(tmp_path):
    pixels = np.full((60, 3020), OCCUPIED, np.uint8)
    pixels[5:-5, 10:-10] = FREE
    pixels[20:24, 20:60:8] = OCCUPIED  # most walls at one end
    plan = import_ros_map(write_map(tmp_path, pixels))
    assert plan.bounds == pytest.approx((1.0, 0.5, 301.0, 5.5))


@pytest.mark.parametrize("yaw", [0.0, 0.7])
@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ((44, 2020), ["2,016 x 40 pixels at 1 m", "more than 1,000 m;"]),
        ((254, 254), ["250 x 250 pixels at 1 m", "m² and more than the 41,943 m² that fit"]),
    ],
)
def test_a_map_that_is_too_large_is_named_with_its_pixels(tmp_path, shape, words, yaw):
    path = write_map(tmp_path, box(*shape), resolution=1.0, origin=[0, 0, yaw])
    expect_error(import_ros_map, path, ["map.yaml: image", "resolution", "region", *words])


def test_what_is_not_free_does_not_count(tmp_path):
    pixels = np.full((400, 400), UNKNOWN, np.uint8)
    pixels[100:140, 300:330] = FREE
    plan = import_ros_map(write_map(tmp_path, pixels, resolution=1.0))
    assert plan.bounds == pytest.approx((300, 260, 330, 300))


def test_a_map_at_the_end_of_the_world_is_named(tmp_path):
    path = write_map(tmp_path, box(), origin="[1e15, 0, 0]")
    expect_error(import_ros_map, path, ["map.yaml: image", "1e+15 m from the origin", "correct"])


def three_parts(folder, **changes):
    """Rooms of 2 x 3, 1.5 x 1.5 and 3 x 3 m, side by side; the path of the YAML file."""
    pixels = np.full((40, 90), OCCUPIED, np.uint8)
    pixels[5:35, 5:25] = FREE
    pixels[20:35, 30:45] = FREE
    pixels[5:35, 50:80] = FREE
    return write_map(folder, pixels, **changes)


@pytest.mark.parametrize(
    ("region", "areas"),
    [
        (None, [6.0, 2.25, 9.0]),
        ((1.0, 2.0), [6.0]),
        ((3.5, 1.0), [2.25]),
        ([6.0, 3.0], [9.0]),
        ((0.0, 0.0, 4.6, 4.0), [6.0, 2.25]),
        ((4.6, 4.0, 0.0, 0.0), [6.0, 2.25]),
        ((1.0, 1.0, 7.0, 2.5), [1.5 * 1.5, 1.5, 2.0 * 1.5]),
        ((-100, -100, 100, 100), [6.0, 2.25, 9.0]),
        ((1.04, 0.0, 2.06, 4.0), [1.1 * 3.0]),  # a cell belongs to it by its middle
    ],
)
@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (500_000.0, -30.0, 0.0)])
def test_a_region_can_be_chosen(tmp_path, region, areas, pose):
    path = three_parts(tmp_path, origin=list(pose))
    if region is not None:
        region = np.add(region, np.tile(pose[:2], len(region) // 2))
    plan = import_map(path, region=region)
    assert [room.area for room in plan.rooms] == pytest.approx(areas)
    check_closed(plan)


def test_a_region_is_in_the_frame_of_the_map_which_may_be_turned(tmp_path):
    pose = [2.0, -1.0, 0.6]
    path = three_parts(tmp_path, origin=pose)
    plan = import_ros_map(path, region=to_world(pose, [3.5, 1.0]))
    assert [room.area for room in plan.rooms] == pytest.approx([2.25])
    x0, y0, x1, y1 = plan.bounds
    part = import_ros_map(path, region=(x0, y0, x1, (y0 + y1) / 2))
    assert 0.4 * 2.25 < part.area < 0.6 * 2.25
    assert part.bounds[3] <= (y0 + y1) / 2 + 0.1


@pytest.mark.parametrize(
    ("region", "words"),
    [
        ((2.7, 1.0), ["map.yaml: region: 2.7,1 is in no free part", "m²", "6.45,1.95 (9.0 m²) or"]),
        ((100.0, 1.0), ["100,1 is in no free part"]),
        ((10.0, 0.0, 20.0, 9.0), ["map.yaml: image: no free region", "and the region"]),
        ((1.0, 2.0, 3.0), ["region: [1.0, 2.0, 3.0]; give x0, y0, x1, y1 of a box, or x, y"]),
        ((1.0, 2.0, 1.0, 3.0), ["region: [1.0, 2.0, 1.0, 3.0]"]),
        ((), ["region: "]),
        ((float("nan"), 0.0), ["region: nan"]),
        (((1.0, 2.0),), ["region: shape (1, 2)"]),
        ("1,2", ["region: '1,2'"]),
    ],
)
def test_a_region_that_is_none_is_named(tmp_path, region, words):
    expect_error(import_map, three_parts(tmp_path), words, region=region)


def test_a_point_that_is_named_for_a_part_is_in_it(tmp_path):
    path = three_parts(tmp_path)
    with pytest.raises(InputError) as caught:
        import_ros_map(path, region=(100.0, 0.0))
    named = re.findall(r"([\d.]+,[\d.]+) \(([\d.]+) m²\)", str(caught.value))
    assert [float(area) for _, area in named] == [9.0, 6.0, pytest.approx(2.25, abs=0.06)]
    for point, area in named:
        plan = import_ros_map(path, region=parse_region(point))
        assert plan.area == pytest.approx(float(area), abs=0.06)


def test_other_kinds_of_maps_have_no_regions(tmp_path):
    expect_error(
        import_map, write_house(tmp_path), ["region: house.json is no ROS map"], region=(1, 1)
    )


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "a,b", "1,2,3,4,5", "1,nan", "1 2", "1,,2"])
def test_a_region_s_text_is_read_or_refused(text):
    with pytest.raises(InputError, match=r"region: .*give x0,y0,x1,y1 or x,y in metres"):
        parse_region(text)
    assert parse_region("-1, 2.5") == (-1.0, 2.5)


# --- ROS: rays ----------------------------------------------------------------------------------


def march(free, origins, directions):
    """Cells travelled through a grid until the first cell that is not free; row 0 lowest."""
    grid = np.pad(free, 1)
    cell = np.floor(origins).astype(int)
    inverse = 1 / np.abs(directions)
    following = np.where(directions > 0, cell + 1 - origins, origins - cell) * inverse
    travelled, live = np.zeros(len(origins)), np.arange(len(origins))
    while live.size:
        axis = following[live].argmin(axis=1)
        travelled[live] = following[live, axis]
        cell[live, axis] += np.sign(directions[live, axis]).astype(int)
        following[live, axis] += inverse[live, axis]
        live = live[grid[cell[live, 1] + 1, cell[live, 0] + 1]]
    return travelled


def cast(walls, origins, directions):
    """Distance along each ray to the first wall, by trying every wall."""
    start, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    ranges = np.empty(len(origins))
    for i, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        gap = start - origin
        with np.errstate(divide="ignore", invalid="ignore"):
            across = direction[0] * along[:, 1] - direction[1] * along[:, 0]
            far = (gap[:, 0] * along[:, 1] - gap[:, 1] * along[:, 0]) / across
            share = (gap[:, 0] * direction[1] - gap[:, 1] * direction[0]) / across
        hit = (far >= 0) & (share >= -1e-9) & (share <= 1 + 1e-9)
        ranges[i] = far[hit].min(initial=np.inf)
    return ranges


@pytest.mark.parametrize("seed", [0, 1])
def test_rays_agree_with_the_grid(tmp_path, seed):
    pixels, pose, resolution = blobs(seed), [2.0, -3.0, 0.7], 0.05
    plan = import_ros_map(write_map(tmp_path, pixels, origin=pose, resolution=resolution))
    rng = np.random.default_rng(seed)
    free = pixels[::-1] == FREE
    clearance = cv2.distanceTransform(np.pad(free, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    cells = np.argwhere(clearance * resolution > 0.25)
    inside = clearance_grid(plan).at(to_world(pose, (cells[:, ::-1] + 0.5) * resolution)) > 0
    cells = cells[inside]  # not in the regions left out
    starts = cells[rng.integers(len(cells), size=10_000)][:, ::-1] + 0.5
    angles = rng.uniform(0, 2 * np.pi, len(starts))
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    expected = march(free, starts, rays) * resolution
    local = to_local(pose, plan.walls.reshape(-1, 2)).reshape(-1, 4)
    ranges = cast(local, starts * resolution, rays)
    assert np.isfinite(ranges).all()  # no ray escapes
    assert (np.abs(ranges - expected) <= resolution).mean() >= 0.99


@pytest.mark.parametrize("seed", [0, 1])
def test_clearance_agrees_with_the_grid(tmp_path, seed):
    pixels, resolution = blobs(seed), 0.05
    plan = import_ros_map(write_map(tmp_path, pixels, resolution=resolution))
    check_closed(plan)
    free = pixels[::-1] == FREE
    rows, columns = np.nonzero(free)
    centres = (np.stack([columns, rows], axis=1) + 0.5) * resolution
    clearance = cv2.distanceTransform(np.pad(free, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    found, expected = clearance_grid(plan).at(centres), clearance[free] * resolution
    reached = found > 0
    assert (expected > 0.2)[reached].any()
    assert np.abs(found - expected)[reached].max() < 3 * resolution


def test_a_large_island_does_not_pass_for_the_room(tmp_path):
    pixels = box(100, 140)
    pixels[20:-20, 20:-20] = UNKNOWN
    grid = clearance_grid(import_ros_map(write_map(tmp_path, pixels)))
    assert grid.at([1.0, 1.0]) > 0.5
    assert grid.at([7.0, 5.0]) == 0


# --- Outlines -----------------------------------------------------------------------------------


def crossings(walls):
    """Pairs of walls that properly cross."""
    a, b = walls[:, None, :2], walls[:, None, 2:]
    c, d = walls[None, :, :2], walls[None, :, 2:]

    def side(p, q, r):
        u, v = q - p, r - p
        cross = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
        return np.where(np.abs(cross) < 1e-9, 0.0, cross)

    return ((side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)).sum()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 24), st.integers(2, 24), st.sampled_from([0, 0.8, 2]))
def test_outlines_are_simple_and_within_half_a_cell(seed, height, width, blur):
    noise = np.random.default_rng(seed).random((height, width))
    noise = cv2.GaussianBlur(noise, (0, 0), blur) if blur else noise
    free = noise < np.median(noise)
    exact = [loop for loop, _ in trace_loops(free)]
    loops = free_loops(free)
    assert sum(map(signed_area, exact)) == free.sum()
    count, _ = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    assert sum(signed_area(loop) > 0 for loop in loops) == count - 1
    for true, loop in zip(exact, loops, strict=True):
        assert len(np.unique(loop, axis=0)) == len(loop) >= 3
        assert np.sign(signed_area(loop)) == np.sign(signed_area(true))
        samples = np.linspace(sides(loop)[:, :2], sides(loop)[:, 2:], 9).reshape(-1, 2)
        assert distance_to_segments(true, sides(loop)).min(axis=1).max() <= 0.5
        assert distance_to_segments(samples, sides(true)).min(axis=1).max() <= 0.5
    assert crossings(np.concatenate([sides(loop) for loop in loops])) == 0


def test_simplifying_saves_corners():
    rows, columns = np.mgrid[:80, :80]
    disc = np.hypot(columns - 40.2, rows - 39.7) < 35.4
    assert len(free_loops(disc)[0]) < 0.9 * len(trace_loops(disc)[0][0])


def test_loops_are_closed_and_materials_change(tmp_path):
    pixels = box(200, 600)
    pixels[50:60, 100:400] = OCCUPIED
    pixels[100, 300] = pixels[120, 310] = OCCUPIED
    plan = import_ros_map(write_map(tmp_path, pixels))
    starts, ends = plan.walls[:, :2], plan.walls[:, 2:]
    assert sorted(map(tuple, starts)) == sorted(map(tuple, ends))  # exactly, not nearly
    lengths = np.hypot(*(ends - starts).T)
    assert len(plan.materials) >= lengths.sum() / SPAN
    assert (plan.wall_offsets + lengths <= PERIOD).all()  # so no strip repeats
    joined = (ends[:-1] == starts[1:]).all(axis=1)
    same = np.array(plan.wall_materials[1:]) == np.array(plan.wall_materials[:-1])
    gaps = (plan.wall_offsets[:-1] + lengths[:-1] - plan.wall_offsets[1:])[joined & same]
    assert np.abs(gaps).max() < 1e-5  # offsets run on along the outline
    features = sum(len(material.stripes) for material in plan.materials)
    assert features / (PERIOD * len(plan.materials)) > 1 / 0.8


@pytest.mark.parametrize("gap", [-0.02, -0.005, 0.0, 0.005, 0.02])
def test_a_corner_beside_a_change_of_material(gap):
    loop = np.array(
        [[0, 0], [24.5 + gap, 0], [24.5 + gap, 1], [47, 1], [47, 2], [0, 2]]
    )  # 98 m around
    walls, names, offsets, materials = dress_loops([loop], np.random.default_rng(0), "standard")
    lengths = np.hypot(*(walls[:, 2:] - walls[:, :2]).T)
    assert (offsets + lengths <= SPAN + 0.02).all()
    assert lengths.min() >= 0.01
    assert set(names) == {material.name for material in materials}
    assert lengths.sum() == pytest.approx(98)
    assert len(materials) == 4


# --- Colours ------------------------------------------------------------------------------------


def test_same_seed_same_bytes(tmp_path):
    path = write_map(tmp_path, blobs(3), resolution=0.05)
    first = plan_to_json(import_ros_map(path, 5))
    assert first == plan_to_json(import_ros_map(path, 5))
    assert first == plan_to_json(plan_from_json(first))
    other = import_ros_map(path, 6)
    assert plan_to_json(other) != first
    np.testing.assert_array_equal(other.walls, import_ros_map(path, 5).walls)


def test_shifted_looks_different(tmp_path):
    path = write_map(tmp_path, box())
    for seed in range(5):
        standard = import_ros_map(path, seed).look
        shifted = import_ros_map(path, seed, "shifted").look
        assert (standard.palette, standard.gamma, standard.noise) == ("standard", 1.0, 0.0)
        assert shifted.palette == "shifted"
        assert 0.7 <= shifted.gamma <= 0.8 or 1.3 <= shifted.gamma <= 1.5
        assert 6 <= shifted.noise <= 12


# --- ROS: mistakes ------------------------------------------------------------------------------

NAN, INF = ".nan", ".inf"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"drop": ["image"]}, ["map.yaml", "image"]),
        ({"drop": ["resolution"]}, ["map.yaml", "resolution"]),
        ({"drop": ["origin"]}, ["origin"]),
        ({"drop": ["negate"]}, ["negate"]),
        ({"drop": ["free_thresh"]}, ["free_thresh"]),
        ({"drop": ["occupied_thresh"]}, ["occupied_thresh"]),
        ({"image": "none.pgm"}, ["map.yaml: image", "none.pgm"]),
        ({"image": "[1]"}, ["map.yaml: image"]),
        ({"resolution": 0}, ["map.yaml: resolution", "above 0"]),
        ({"resolution": -0.1}, ["resolution"]),
        ({"resolution": NAN}, ["resolution", "finite"]),
        ({"resolution": "wide"}, ["resolution"]),
        ({"resolution": 50}, ["resolution", "spans 1,800 m x 1,300 m"]),
        ({"resolution": 0.001}, ["free region"]),
        ({"origin": [0, 0]}, ["origin", "yaw"]),
        ({"origin": f"[0, {INF}, 0]"}, ["origin[1]"]),
        ({"negate": "maybe"}, ["negate"]),
        ({"mode": "raw"}, ["free region", "mode"]),
        ({"mode": "binary"}, ["mode", "trinary"]),
        ({"free_thresh": 0.66}, ["free_thresh", "at most occupied_thresh, 0.65"]),
        ({"free_thresh": -0.1}, ["free_thresh"]),
        ({"occupied_thresh": 1.1}, ["occupied_thresh"]),
        ({"negate": 1}, ["free region", "negate"]),
    ],
)
def test_a_wrong_yaml_is_named(tmp_path, changes, words):
    (tmp_path / "map.pgm").write_bytes(p5(box()))
    expect_error(import_ros_map, write_yaml(tmp_path, **changes), words)


def expect_error(function, path, words, **choice):
    with pytest.raises(InputError) as caught:
        function(path, **choice)
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    "content", [b"image: [", b"\xff\xfe", b"just words", b"a: b: c", b"- 1", b"x: \x00", b""]
)
def test_a_file_that_is_not_yaml_is_named(tmp_path, content):
    (tmp_path / "map.yaml").write_bytes(content)
    expect_error(import_ros_map, tmp_path / "map.yaml", ["map.yaml"])


@pytest.mark.parametrize(
    "content",
    [
        p5(box())[:-1],
        b"P5\n40 30\n255\n",
        b"P5\n40 30",
        b"P5\n40 0\n255\n",
        b"P5 -1 3 255\n" + bytes(99),
        b"P5 100000000 100000000 255\n" + bytes(9),
        b"P2 3 3 255\n1 2 3 4",
        b"P2 2 1 255\n1 x",
        b"GIF89a",
        b"",
    ],
)
def test_a_broken_picture_is_named(tmp_path, content):
    (tmp_path / "map.pgm").write_bytes(content)
    expect_error(import_ros_map, write_yaml(tmp_path), ["map.yaml: image", "map.pgm"])


def test_a_cut_png_is_named(tmp_path):
    write_png(tmp_path, blobs(0))
    data = (tmp_path / "map.png").read_bytes()
    for size in (20, len(data) // 2, len(data) - 13):
        (tmp_path / "map.png").write_bytes(data[:size])
        expect_error(import_ros_map, write_yaml(tmp_path, image="map.png"), ["image", "cut off"])


def test_a_missing_file_a_negative_seed_and_an_unknown_palette_are_named(tmp_path):
    path = write_map(tmp_path, box())
    for function in (import_ros_map, import_houseexpo, import_map):
        expect_error(function, tmp_path / "none.json", ["none.json"])
        expect_error(function, path, ["seed", "-1"], seed=-1)
        expect_error(function, path, ["palette", "pink"], palette="pink")


def test_a_map_without_free_space_is_named(tmp_path):
    path = write_map(tmp_path, np.full((30, 40), UNKNOWN))
    expect_error(import_ros_map, path, ["map.yaml", "free region"])


# --- HouseExpo ----------------------------------------------------------------------------------

L_SHAPE = [[0, 0], [8, 0], [8, 4], [3, 4], [3, 7], [0, 7]]


def write_house(folder, **changes):
    house = {
        "id": "a1",
        "room_num": 3,
        "bbox": {"min": [0, 0], "max": [8, 7]},
        "verts": L_SHAPE,
        "room_category": {
            "Living_Room": [[3.2, 0.1, 7.9, 3.9]],
            "Bedroom": [[0.1, 4.2, 2.9, 6.9]],
            "Toilet": [[0, 0, 3, 4]],
        },
    }
    house = {k: v for k, v in {**house, **changes}.items() if v is not None}
    (folder / "house.json").write_text(json.dumps(house))
    return folder / "house.json"


def test_house_walls_and_kinds(tmp_path):
    plan = import_houseexpo(write_house(tmp_path), 4)
    assert corners(plan) == {tuple(map(float, p)) for p in [*L_SHAPE, (5, 4)]}  # cut: 30 m around
    assert [room.kind for room in plan.rooms] == ["living", "bedroom", "bathroom"]
    assert (plan.family, plan.seed) == ("houseexpo", 4)
    check_closed(plan)
    grid = clearance_grid(plan)
    assert grid.at([1.5, 5.5]) == pytest.approx(1.5, abs=0.06)
    assert grid.at([6.0, 6.0]) == 0


@pytest.mark.parametrize(
    ("category", "kind"),
    [
        ("Kitchen", "kitchen"),
        ("Dining_Room", "living"),
        ("Child_Room", "bedroom"),
        ("guest room", "bedroom"),
        ("Hallway", "hallway"),
        ("Hall", "hallway"),
        ("Entryway", "hallway"),
        ("Bathroom", "bathroom"),
        ("Office", "office"),
        ("Garage", "storage"),
        ("Wardrobe", "storage"),
        ("Gym", "open"),
        ("Balcony", "open"),
        ("Zzz", "open"),
    ],
)
def test_categories(tmp_path, category, kind):
    path = write_house(tmp_path, room_category={category: [[1, 1, 3, 3]]})
    assert [room.kind for room in import_houseexpo(path).rooms] == [kind]


def test_a_box_that_pokes_out_is_cut_to_the_outline(tmp_path):
    rooms = {"Office": [[-2, -2, 20, 20]], "Kitchen": [[4, 3, 9, 9]], "Hall": [[5, 5, 8, 8]]}
    plan = import_houseexpo(write_house(tmp_path, room_category=rooms))
    assert [room.kind for room in plan.rooms] == ["office", "kitchen"]
    assert plan.rooms[0].area == pytest.approx(41.0)
    assert plan.rooms[1].area == pytest.approx(4.0)
    check_closed(plan)


def test_a_box_across_a_notch(tmp_path):
    comb = [[0, 0], [9, 0], [9, 5], [6, 5], [6, 1], [5.9, 1], [5.9, 5], [3, 5], [3, 1], [2, 1]]
    path = write_house(
        tmp_path, verts=[*comb, [2, 5], [0, 5]], room_category={"Hall": [1, 2, 8, 4]}
    )
    plan = import_houseexpo(path)
    assert plan.rooms[0].area == pytest.approx(1 * 2 + 2.9 * 2 + 2 * 2)
    check_closed(plan)


@pytest.mark.parametrize("rooms", [None, {}, {"Hall": [[50, 50, 60, 60]]}])
def test_without_rooms_there_is_one_open_room(tmp_path, rooms):
    plan = import_houseexpo(write_house(tmp_path, room_category=rooms))
    assert [room.kind for room in plan.rooms] == ["open"]
    assert plan.area == pytest.approx(41.0)


def test_order_and_repeated_corners_do_not_matter(tmp_path):
    expected = {tuple(map(float, p)) for p in L_SHAPE}
    repeated = [p for p in L_SHAPE for _ in range(2)] + [L_SHAPE[0]]
    for verts in (repeated, L_SHAPE[::-1]):
        plan = import_houseexpo(write_house(tmp_path, verts=verts, room_category=None))
        assert set(plan.rooms[0].outline) == expected <= corners(plan)


def test_a_mark_before_the_text_is_no_part_of_it(tmp_path):
    path = write_house(tmp_path)
    expected = plan_to_json(import_houseexpo(path))
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert plan_to_json(import_map(path)) == expected


def test_a_house_survives_json(tmp_path):
    for palette in ("standard", "shifted"):
        plan = import_houseexpo(write_house(tmp_path), 1, palette)
        text = plan_to_json(plan)
        assert plan_to_json(plan_from_json(text)) == text
        assert plan_to_json(import_houseexpo(write_house(tmp_path), 1, palette)) == text


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"verts": None}, ["house.json", "verts"]),
        ({"verts": []}, ["house.json: verts", "three"]),
        ({"verts": [[0, 0], [1, 1], [1, 1], [0, 0]]}, ["verts", "three"]),
        ({"verts": [[0, 0], [4, float("nan")], [4, 4]]}, ["verts[1][1]", "finite"]),
        ({"verts": [[0, 0], [4], [4, 4]]}, ["verts[1]"]),
        ({"verts": [[0, 0], [4, "a"], [4, 4]]}, ["verts[1][1]"]),
        ({"verts": 7}, ["verts"]),
        ({"verts": [[0, 0], [4, 4], [4, 0], [0, 4]]}, ["verts", "cross"]),
        ({"verts": [[0, 0], [4, 0], [8, 0]]}, ["verts", "enclose"]),
        ({"verts": [[0, 0], [9e5, 0], [9e5, 9e5]]}, ["verts", "metres"]),
        ({"room_category": [1]}, ["room_category"]),
        ({"room_category": {"Hall": [[1, 2, 3]]}}, ["room_category.Hall[0]", "4"]),
        ({"room_category": {"Hall": 3}}, ["room_category.Hall"]),
    ],
)
def test_a_wrong_house_is_named(tmp_path, changes, words):
    expect_error(import_houseexpo, write_house(tmp_path, **changes), words)


@pytest.mark.parametrize("content", [b"", b"{", b"\xff", b"[" * 100_000, b"[1]", b"3"])
def test_a_file_that_is_not_a_house_is_named(tmp_path, content):
    path = tmp_path / "house.json"
    path.write_bytes(content)
    for function in (import_houseexpo, import_map):
        expect_error(function, path, ["house.json"])


# --- Any map ------------------------------------------------------------------------------------


def test_import_map_distinguishes_the_kinds(tmp_path):
    path = write_map(tmp_path, box())
    ros = import_map(path, 2, "shifted")
    assert plan_to_json(ros) == plan_to_json(import_ros_map(path, 2, "shifted"))
    (tmp_path / "map.YML").write_text(path.read_text())
    assert import_map(str(tmp_path / "map.YML")).family == "ros"
    assert import_map(write_house(tmp_path)).family == "houseexpo"
    save_plan(ros, tmp_path / "plan.json")
    assert plan_to_json(import_map(tmp_path / "plan.json")) == plan_to_json(ros)
    expect_error(import_map, tmp_path / "map.pgm", ["map.pgm", ".yaml"])
    (tmp_path / "other.json").write_text("{}")
    expect_error(import_map, tmp_path / "other.json", ["other.json", "verts", "schema"])


@pytest.mark.parametrize("verts", [L_SHAPE, L_SHAPE[::-1]], ids=["left", "right"])
def test_an_outline_runs_counter_clockwise_however_it_was_drawn(tmp_path, verts):
    plan = import_houseexpo(write_house(tmp_path, verts=verts))
    assert all(signed_area(np.array(room.outline)) > 0 for room in plan.rooms)
    x0, y0, x1, y1 = plan.walls.T
    assert (x0 * y1 - x1 * y0).sum() / 2 == pytest.approx(41.0)


def test_obstacles_share_a_strip_only_while_it_lasts():
    square = 0.975 * np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    loops = [square + np.array([3.0 * number, 0.0]) for number in range(20)]
    walls, names, offsets, _ = dress_loops(loops, np.random.default_rng(0), "standard")
    ends = offsets + np.hypot(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1])
    assert len(set(names)) == 4  # six of 3.9 m to a strip of 25 m
    for name in set(names):
        mine = np.array(names) == name
        assert ends[mine].max() <= SPAN
        assert len(set(offsets[mine])) == mine.sum()  # each has a stretch of its own


# --- Sizes --------------------------------------------------------------------------------------


def test_an_outline_of_too_many_corners_is_refused(tmp_path, monkeypatch):
    path = write_map(tmp_path, blobs(0))
    corners = sum(len(loop) for loop, _ in trace_loops(blobs(0)[::-1] > 250))
    assert corners > 40
    monkeypatch.setattr(contours, "MAX_CORNERS", 40)
    expect_error(
        import_ros_map,
        path,
        ["map.yaml: image: the outline of its free space has", "more than the 40"],
    )


def test_an_outline_that_needs_too_many_materials_is_refused(tmp_path, monkeypatch):
    path = write_map(tmp_path, box())
    import_ros_map(path)
    monkeypatch.setattr(surfaces, "MAX_SURFACES", 0)
    expect_error(import_ros_map, path, ["need more than 0 materials"])


def test_a_house_of_too_many_corners_or_boxes_is_refused(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 1_001, endpoint=False)
    circle = np.stack([9 * np.cos(angle), 9 * np.sin(angle)], axis=1).tolist()
    path = tmp_path / "house.json"
    path.write_text(json.dumps({"verts": circle}))
    expect_error(import_houseexpo, path, ["verts: 1001 corners; give at most 1000"])
    boxes = {"Hall": [[0, 0, 1, 1]] * 100, "Kitchen": [[0, 0, 1, 1]] * 101}
    path.write_text(json.dumps({"verts": circle[::10], "room_category": boxes}))
    expect_error(import_houseexpo, path, ["room_category: give at most 200 boxes"])
    path.write_text(json.dumps({"verts": circle[:1_000]}))
    import_houseexpo(path)
