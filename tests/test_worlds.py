import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.world.generators import generate
from tutorial_lib.world.plan_json import plan_to_json
from tutorial_lib.world.worlds import local_world, scene_of, training_world, world_name


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
    assert [training_world(seed) for seed in (0, 1, 2, 9999)] == [
        "apartment/0/standard",
        "office/1/standard",
        "maze/2/standard",
        "apartment/9999/standard",
    ]
    assert training_world(4, "shifted") == "office/4/shifted"
    assert local_world(np.int64(3)) == "loop_corridor/3/standard"


def test_no_training_world_is_a_loop_corridor():
    assert {training_world(seed).split("/")[0] for seed in range(100)} == {
        "apartment",
        "office",
        "maze",
    }


@pytest.mark.parametrize("seed", [10_000, 20_000, -1])
def test_what_is_kept_for_tests_is_not_trained_on(seed):
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
        ("maze/²/standard", "seed"),
        ("maze/17/sepia", "palette 'sepia'"),
    ],
)
def test_a_wrong_name_says_what_is_wrong(name, words):
    with pytest.raises(InputError, match=words):
        scene_of(name)


@pytest.mark.parametrize("parts", [("castle", 1), ("maze", True), ("maze", 1.0), ("maze/2", 1)])
def test_a_name_is_made_of_what_exists(parts):
    with pytest.raises(InputError, match="world"):
        world_name(*parts)
