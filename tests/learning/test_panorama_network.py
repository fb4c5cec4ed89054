"""The multi-task network: shapes, symmetries, sizes, and what it refuses."""

import pytest
import torch

from tutorial_lib.errors import InputError
from tutorial_lib.learning.panorama_encoder import FEATURES, CircularConvolution, Encoded
from tutorial_lib.learning.panorama_network import (
    KINDS,
    PanoramaArchitecture,
    PanoramaNetwork,
)
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of

CASES = [("rgb", False), ("rgbd", False), ("rgbd", True)]
TURN = 16  # columns of 30 degrees


@pytest.fixture(scope="module")
def panoramas():
    """Images and depth from places of an office, as tensors."""
    scene = scene_of("office/1/standard")
    x = torch.linspace(0, 1, 8).numpy()
    low, high = scene.plan.walls.reshape(-1, 2).min(0), scene.plan.walls.reshape(-1, 2).max(0)
    places = low + (high - low) * torch.rand(6, 2, generator=torch.manual_seed(3)).numpy()
    poses = torch.cat([torch.from_numpy(places), torch.from_numpy(x[:6, None]) * 6], dim=1).numpy()
    images, depth = PanoramicCamera().look(scene, poses)
    return torch.from_numpy(images), torch.from_numpy(depth).float().clamp(max=20.0)


def make(sensor="rgbd", blind=False):
    torch.manual_seed(0)
    network = PanoramaNetwork(PanoramaArchitecture(sensor, blind)).eval()
    for value in network.parameters():  # biases of zero and one-sided layers hide mistakes
        value.data.add_(0.02 * torch.randn_like(value))
    return network


def turned(images, depth, bins):
    """The same places, with headings `bins` times 30 degrees farther counter-clockwise."""
    return images.roll(TURN * bins, 2), depth.roll(TURN * bins, 1)


@torch.inference_mode()
def compared(network, sources, goals):
    return network.compare(network.encode(*sources), network.encode(*goals))


@pytest.mark.parametrize(("sensor", "blind"), CASES)
def test_shapes_and_ranges(panoramas, sensor, blind):
    network, (images, depth) = make(sensor, blind), panoramas
    with torch.inference_mode():
        encoded = network.encode(images, depth)
        seen = network.seen(encoded)
        found = network.compare(encoded, encoded)
    assert seen.explorable.shape == (6, 12)
    assert seen.kinds.shape == (6, 12, KINDS)
    assert found.connection.shape == found.nearness.shape == (6,)
    for name in ("direction", "offset", "scores", "sharp", "same_room"):
        assert getattr(found, name).shape == (6, 12), name
    assert ((found.scores >= 0) & (found.scores <= 1)).all()
    assert ((found.nearness >= 0) & (found.nearness <= 1)).all()
    assert (found.offset.abs() <= 1).all()
    assert encoded.flat().shape == (6, FEATURES)


@pytest.mark.parametrize("bins", [1, 5, 11])
@pytest.mark.parametrize(("sensor", "blind"), CASES)
def test_turning_the_source_renumbers_its_directions(panoramas, sensor, blind, bins):
    network, goals = make(sensor, blind), (panoramas[0].flip(0), panoramas[1].flip(0))
    before = compared(network, panoramas, goals)
    after = compared(network, turned(*panoramas, bins), goals)
    for name in ("direction", "offset", "scores", "sharp", "same_room"):
        wanted = getattr(before, name).roll(-bins, 1)
        torch.testing.assert_close(getattr(after, name), wanted, rtol=1e-3, atol=2e-4, msg=name)
        assert wanted.std(1).min() > 1e-4, name  # directions differ
    for name in ("connection", "nearness"):
        torch.testing.assert_close(
            getattr(after, name), getattr(before, name), rtol=1e-3, atol=2e-4
        )
    with torch.inference_mode():
        one = network.seen(network.encode(*panoramas))
        two = network.seen(network.encode(*turned(*panoramas, bins)))
    torch.testing.assert_close(two.explorable, one.explorable.roll(-bins, 1), rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(two.kinds, one.kinds.roll(-bins, 1), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("bins", [1, 7])
@pytest.mark.parametrize(("sensor", "blind"), CASES)
def test_turning_the_goal_changes_nothing(panoramas, sensor, blind, bins):
    network, goals = make(sensor, blind), (panoramas[0].flip(0), panoramas[1].flip(0))
    before, after = (compared(network, panoramas, turned(*goals, turn)) for turn in (0, bins))
    for name, value in before._asdict().items():
        torch.testing.assert_close(getattr(after, name), value, rtol=1e-3, atol=2e-4, msg=name)


def test_the_goal_matters_for_scores_unless_they_are_blind(panoramas):
    goals = (panoramas[0].flip(0), panoramas[1].flip(0))
    for blind in (False, True):
        network = make(blind=blind)
        one, two = (compared(network, panoramas, goal) for goal in (panoramas, goals))
        assert torch.equal(one.scores, two.scores) == blind
        assert torch.equal(one.sharp, two.sharp) == blind
        assert not torch.equal(one.connection, two.connection)
        assert not torch.equal(one.direction, two.direction)


def test_rgb_does_not_look_at_depth(panoramas):
    network = make("rgb")
    with torch.inference_mode():
        with_depth, without = (
            network.encode(panoramas[0], depth).flat() for depth in (panoramas[1], None)
        )
    assert torch.equal(with_depth, without)


def test_the_matched_place_is_that_of_the_goal_for_perfect_matches():
    """Columns that show the same wall have the same features here: the motion is then exact."""
    network = make()
    network.sharpness.data[:] = torch.tensor([6.0, 3.0])
    angle = torch.atan2(network.bearing[:, 1], network.bearing[:, 0])
    encoded = network.encode(
        torch.zeros(2, 16, 192, 3, dtype=torch.uint8), torch.full((2, 192), 3.0)
    )
    marks = torch.randn(48, 16, generator=torch.manual_seed(1))
    marks = torch.nn.functional.normalize(marks, dim=1)
    place, turn = torch.tensor([0.8, -0.5]), 2 * torch.pi * 5 / 48
    points = 3.0 * network.bearing
    # The goal sees each point of the source from its own place, turned by five columns.
    local = points - place
    depth = local.norm(dim=1)
    bearing = torch.atan2(local[:, 1], local[:, 0]) - turn
    column = ((angle[0] - bearing) / (2 * torch.pi / 48)).round().long() % 48
    match, metres = torch.zeros(48, 16), torch.full((48,), 1.0)
    match[column], metres[column] = marks, depth
    goal = encoded._replace(match=match[None], depth=metres[None])
    source = encoded._replace(match=marks[None])
    with torch.no_grad():
        found = network._matched(source.rows(torch.tensor([0])), goal.rows(torch.tensor([0])))
    torch.testing.assert_close(found.position[0], place, atol=0.15, rtol=0.0)


def test_a_circular_convolution_is_one():
    layer = CircularConvolution(2, 3, 5)
    columns = torch.randn(1, 12, 2)
    weight = layer.linear.weight.view(3, 5, 2).transpose(1, 2)
    padded = torch.cat([columns[:, -2:], columns, columns[:, :2]], dim=1).transpose(1, 2)
    wanted = torch.nn.functional.conv1d(padded, weight, layer.linear.bias).transpose(1, 2)
    torch.testing.assert_close(layer(columns), wanted)


def test_patches_lie_about_their_directions(panoramas):
    """A bright column lights up the three tokens whose patches hold it, most in the middle."""
    network = make()
    tokens = network.encoder.tokens
    dark = torch.zeros(1, 48, 64)
    for direction in range(12):
        bright = dark.clone()
        bright[:, (23 - 4 * direction) % 48 : (23 - 4 * direction) % 48 + 1] = 1.0
        changed = (tokens(bright) - tokens(dark)).abs().amax(-1)[0] > 1e-6
        near = {(direction + step) % 12 for step in (-1, 0, 1)}
        assert set(changed.nonzero()[:, 0].tolist()) == near


def test_features_go_through_rows(panoramas):
    network = make()
    with torch.inference_mode():
        encoded = network.encode(*panoramas)
        for one, two in zip(encoded, Encoded.of(encoded.flat()), strict=True):
            assert torch.equal(one, two)
    with pytest.raises(InputError, match=r"features: shape \(6, 7\)"):
        Encoded.of(torch.zeros(6, 7))


@pytest.mark.parametrize("sensor", ["rgb", "rgbd"])
def test_the_network_is_small(sensor):
    assert 240_000 < sum(value.numel() for value in make(sensor).parameters()) < 300_000


@pytest.mark.parametrize(
    ("images", "depth", "words"),
    [
        (torch.zeros(2, 16, 64, 3, dtype=torch.uint8), torch.ones(2, 192), "panoramas: .*16, 64"),
        (torch.zeros(2, 16, 192, 3), torch.ones(2, 192), "uint8"),
        (torch.zeros(2, 16, 192, 3, dtype=torch.uint8), None, "depth camera"),
        (torch.zeros(2, 16, 192, 3, dtype=torch.uint8), torch.ones(2, 64), "depth camera"),
    ],
)
def test_what_does_not_fit_is_refused(images, depth, words):
    with pytest.raises(InputError, match=words):
        make().encode(images, depth)


@pytest.mark.parametrize(
    "wrong",
    [{"sensor": "lidar"}, {"sensor": "rgb", "kind": "local"}, {"sensor": "rgb", "goal_blind": 1}],
)
def test_an_architecture_that_is_none_is_refused(wrong):
    with pytest.raises(InputError, match="network: "):
        PanoramaArchitecture(**wrong)
