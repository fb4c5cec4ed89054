from collections import Counter

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.world.generators import generate
from tutorial_lib.world.plan_json import plan_to_json
from tutorial_lib.world.worlds import (
    local_world,
    map_world,
    parse_world,
    scene_of,
    training_world,
    validation_world,
    world_name,
)


def test_a_name_gives_the_world_it_names():
    scene = scene_of(world_name("maze", 12, "shifted"))
    assert plan_to_json(scene.plan) == plan_to_json(generate("maze", 12, "shifted"))
    assert plan_to_json(scene.plan) != plan_to_json(generate("maze", 12))


def test_the_seed_chooses_the_family():
    assert [local_world(seed) for seed in range(20_000, 20_005)] == [
        "apartment/20000/standard",
        "office/20001/standard",
        "maze/20002/standard",
        "loop_corridor/20003/standard",
        "apartment/20004/standard",
    ]
    assert [training_world(seed) for seed in (0, 1, 2, 3, 4, 9995)] == [
        "apartment/0/standard",
        "office/1/standard",
        "hall/2/standard",
        "scanned/3/standard",
        "maze/4/standard",
        "apartment/9995/standard/wayfinding",
    ]
    assert training_world(4, "shifted") == "maze/4/shifted"
    assert validation_world(10_001) == "loop_corridor/10001/standard"
    assert local_world(np.int64(3)) == "loop_corridor/3/standard"


def test_no_training_world_is_a_loop_corridor():
    families = Counter(training_world(seed).split("/")[0] for seed in range(100))
    assert families == dict.fromkeys(("apartment", "office", "hall", "scanned", "maze"), 20)


def test_every_fourth_training_world_of_each_family_has_signs():
    signs = Counter(parse_world(training_world(seed))[::4] for seed in range(100))
    families = ("apartment", "office", "hall", "scanned", "maze")
    assert signs == {(f, s): n for f in families for s, n in (("plain", 15), ("wayfinding", 5))}


def test_a_family_can_be_asked_for():
    assert local_world(20_001, family="hall") == "hall/20001/standard"
    assert {local_world(seed, family="all").split("/")[0] for seed in range(20_000, 20_006)} == {
        "apartment",
        "office",
        "hall",
        "scanned",
        "maze",
        "loop_corridor",
    }
    assert map_world(20_001, "shifted", "scanned") == "scanned/20001/shifted/large"
    with pytest.raises(InputError, match="family: 'castle'"):
        local_world(20_001, family="castle")


@pytest.mark.parametrize("seed", [10_000, 20_000, -1])
def test_seeds_kept_for_tests_are_not_for_training(seed):
    with pytest.raises(InputError, match="seed"):
        training_world(seed)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("apartment/17", "give family/seed/palette"),
        ("apartment/17/standard/more", "size .more. is unknown"),
        ("", "give family/seed/palette"),
        ("castle/17/standard", "family 'castle'"),
        ("maze/-1/standard", "seed '-1'"),
        ("maze/1.5/standard", "seed '1.5'"),
        ("maze/017/standard", "seed '017'"),  # or one world would have two files
        ("maze/1_7/standard", "seed '1_7'"),
        (f"maze/{'9' * 5000}/standard", "seed '999"),
        ("maze/²/standard", "seed"),
        ("maze/17/sepia", "palette 'sepia'"),
    ],
)
def test_a_wrong_name_says_what_is_wrong(name, words):
    with pytest.raises(InputError, match=words):
        scene_of(name)


@pytest.mark.parametrize("parts", [("castle", 1), ("maze", True), ("maze", 1.0), ("maze/2", 1)])
def test_a_name_is_made_of_what_exists(parts):
    with pytest.raises(InputError, match=r"(family|seed): "):
        world_name(*parts)


# Large worlds.


def test_maps_are_made_in_large_worlds_of_three_families():
    assert [map_world(seed) for seed in range(20_000, 20_004)] == [
        "loop_corridor/20000/standard/large",
        "apartment/20001/standard/large",
        "office/20002/standard/large",
        "loop_corridor/20003/standard/large",
    ]
    assert map_world(np.int64(3), "shifted") == "apartment/3/shifted/large"
    with pytest.raises(InputError, match="seed: -1"):
        map_world(-1)


def test_each_world_has_one_name():
    for size in ("any", "large"):
        for palette in ("standard", "shifted"):
            for signs in ("plain", "wayfinding"):
                name = world_name("office", 7, palette, size, signs)
                assert parse_world(name) == ("office", 7, palette, size, signs)
    assert world_name("office", 7) == "office/7/standard"
    assert world_name("office", 7, size="large") == "office/7/standard/large"
    assert world_name("maze", 7, signs="wayfinding") == "maze/7/standard/wayfinding"


def test_the_name_of_a_large_world_gives_the_large_one():
    scene = scene_of("office/12/standard/large")
    assert plan_to_json(scene.plan) == plan_to_json(generate("office", 12, size="large"))
    assert plan_to_json(scene.plan) != plan_to_json(generate("office", 12))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("office/12/standard/any", "give family/seed/palette"),  # or it would have two names
        ("office/12/standard/huge", "size 'huge' is unknown; use one of any, large"),
        ("office/12/standard/wayfinding/large", "give family"),
        ("office/12/standard/large/plain", "give family"),
        ("office/12/standard/large/arrows", "signs 'arrows' is unknown"),
        ("office/12/standard/large/", "give family/seed/palette.* and /large behind it"),
        ("office/12/large", "palette 'large'"),
    ],
)
def test_a_wrong_size_is_named(name, words):
    with pytest.raises(InputError, match=f"world.*: .*{words}"):
        parse_world(name)


def test_a_size_is_one_that_exists():
    with pytest.raises(InputError, match="size: 'huge'; give any or large"):
        world_name("office", 12, size="huge")
