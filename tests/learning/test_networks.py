import numpy as np
import pytest
import torch
from torch.nn import functional

from tutorial_lib.errors import InputError
from tutorial_lib.learning.encoders import COLUMNS, FEATURES, MatchingEncoder, PairEncoder
from tutorial_lib.learning.networks import ENCODERS, OUTPUTS, Architecture, LocalNetwork
from tutorial_lib.learning.views import VIEWS, CameraView, LaserView
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation
from tutorial_lib.world.worlds import scene_of

torch.set_num_threads(1)  # so small are they here that two threads are slower
CLOSE = {"rtol": 1e-5, "atol": 1e-5}
POSES = np.array([[2.0, 2.0, 0.3], [5.0, 9.3, 0.0], [8.5, 3.0, -2.0], [1.0, 6.0, 1.4]])


def build(encoder="matching", k=2, view="camera16", outputs="waypoint"):
    """An untrained network, with weights large enough that it tells pairs apart."""
    torch.manual_seed(0)
    network = LocalNetwork(Architecture(k, encoder, view, outputs)).eval()
    for layer in network.modules():
        if isinstance(layer, torch.nn.Linear | torch.nn.Conv1d | torch.nn.Conv2d):
            layer.weight.data.mul_(1.6)
    return network


def pictures_for(network, *shape, seed=1):
    """Random columns in place of pictures."""
    generator = torch.Generator().manual_seed(seed)
    channels, rows, columns = network.architecture.looks_at.size
    numbers = torch.randn(*shape, channels, 1, columns, generator=generator)
    return numbers.repeat_interleave(rows, dim=-2)


def pairs_for(network, count=5):
    contexts = pictures_for(network, count, network.architecture.images, seed=2)
    return pictures_for(network, count), contexts


def one_by_one(network, current, contexts):
    """Outputs (N, O), each pair and each of its pictures for itself."""
    rows = []
    for own, context in zip(current, contexts, strict=True):
        encoder, x = network.encoder, network.context.bias
        for place, picture in enumerate(context):
            kept = encoder.current(own[None]), encoder.target(picture[None])[:, None]
            x = x + network.context.weight[:, :, place] @ encoder.compare(*kept)[0, 0]
        rows.append(network.heads(functional.relu(network.hidden(functional.relu(x)))))
    return torch.stack(rows)


every_encoder = pytest.mark.parametrize("encoder", ENCODERS)
every_view = pytest.mark.parametrize("view", VIEWS)


# The network.


@every_view
@every_encoder
@torch.inference_mode()
def test_what_is_kept_and_compared_is_what_plain_evaluation_gives(encoder, view):
    network = build(encoder, view=view)
    current, contexts = pairs_for(network)
    kept = network.encode_targets(contexts)
    outputs, poses = network.compare(network.encode_current(current), kept)
    assert outputs.shape == (5, 6)
    assert poses.shape == (5, kept.shape[1], 4)
    assert kept.shape[:2] == (5, 5)
    torch.testing.assert_close(outputs, network(current, contexts), **CLOSE)
    torch.testing.assert_close(outputs, one_by_one(network, current, contexts), **CLOSE)
    assert outputs.std(dim=0).min() > 100 * CLOSE["atol"]  # pairs differ at all


@every_encoder
@torch.inference_mode()
def test_outputs_do_not_depend_on_the_rest_of_the_batch(encoder):
    network = build(encoder).train()  # also while it learns
    current, contexts = pairs_for(network, 6)
    together = network(current, contexts)
    order = torch.tensor([3, 0, 5, 1])
    torch.testing.assert_close(network(current[order], contexts[order]), together[order], **CLOSE)
    for n in range(6):
        alone = network(current[n : n + 1], contexts[n : n + 1])
        torch.testing.assert_close(alone, together[n : n + 1], **CLOSE)


@every_encoder
@torch.inference_mode()
def test_every_picture_counts_and_so_does_its_place(encoder):
    network = build(encoder, k=1)
    current, contexts = pairs_for(network)
    plain = network(current, contexts)
    other = pictures_for(network, 5, seed=3)
    for place in range(3):
        changed = contexts.clone()
        changed[:, place] = other
        assert (network(current, changed) - plain).abs().amax(dim=1).min() > 1e-3
    assert (network(other, contexts) - plain).abs().amax(dim=1).min() > 1e-3
    assert (network(current, contexts.flip(1)) - plain).abs().amax(dim=1).min() > 1e-3


@every_encoder
@torch.inference_mode()
def test_one_target_serves_many_robots(encoder):
    network = build(encoder)
    current, contexts = pictures_for(network, 6), pictures_for(network, 2, 5, seed=2)
    of = torch.tensor([0, 1, 1, 0, 1, 0])
    kept = network.encode_targets(contexts)[of]
    outputs, _ = network.compare(network.encode_current(current), kept)
    torch.testing.assert_close(outputs, network(current, contexts[of]), **CLOSE)


@every_view
@every_encoder
@torch.inference_mode()
def test_no_pairs_have_no_outputs(encoder, view):
    network = build(encoder, view=view)
    current, contexts = pairs_for(network, 0)
    kept = network.encode_targets(contexts)
    outputs, _ = network.compare(network.encode_current(current), kept)
    assert outputs.shape == network(current, contexts).shape == (0, 6)


@every_encoder
@pytest.mark.parametrize("k", [1, 3])
@torch.inference_mode()
def test_a_context_of_another_length_is_refused(encoder, k):
    network, current = build(encoder, k=2), pictures_for(build(), 4)
    contexts = pictures_for(network, 4, 2 * k + 1)
    kept = network.encode_targets(contexts)
    with pytest.raises(InputError, match=rf"contexts: shape \(4, {2 * k + 1}, "):
        network(current, contexts)
    with pytest.raises(InputError, match=f"{2 * k + 1} images; give 5"):
        network.compare(network.encode_current(current), kept)


@pytest.mark.parametrize(("outputs", "count"), OUTPUTS.items())
def test_there_are_as_many_outputs_as_are_named(outputs, count):
    network = build("pair", k=0, outputs=outputs)
    assert network(*pairs_for(network)).shape == (5, count)


@every_encoder
def test_all_weights_learn(encoder):
    network = build(encoder, k=1)
    current, contexts = pairs_for(network)
    outputs, poses = network.compare(
        network.encode_current(current), network.encode_targets(contexts)
    )
    (outputs.square().sum() + poses.square().sum()).backward()
    for name, value in network.named_parameters():
        assert value.grad is not None, name
        assert value.grad.abs().max() > 0, name


def test_the_same_seed_builds_the_same_network():
    one, two = build().state_dict(), build().state_dict()
    assert all(torch.equal(one[name], two[name]) for name in one)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({"k": -1}, "0 to 20"),
        ({"k": 21}, "0 to 20"),
        ({"k": 2.5}, "whole number"),
        ({"k": "2"}, "whole number"),
        ({"encoder": "siamese"}, "encoder 'siamese'; give one of matching, pair"),
        ({"view": "camera17"}, "view 'camera17'; give one of camera16, camera64, laser"),
        ({"outputs": "thoughts"}, "outputs 'thoughts'; give one of waypoint, action"),
    ],
)
def test_what_cannot_be_built_is_refused(fault, words):
    with pytest.raises(InputError, match=words):
        Architecture(**{"k": 2, **fault})


# The encoders.


@pytest.mark.parametrize("rows", [1, 16])
@torch.inference_mode()
def test_the_halves_of_the_pair_encoder_are_the_stacked_convolution(rows):
    torch.manual_seed(0)
    encoder = PairEncoder(3, rows)
    current, target = torch.rand(2, 7, 3, rows, 64)
    halves = encoder.current(current) + encoder.target(target)
    plain = encoder.stacked(torch.cat([current, target, current - target], dim=1))
    assert halves.shape == (7, 48, 1, COLUMNS)
    torch.testing.assert_close(halves, plain, **CLOSE)
    compared = encoder.compare(encoder.current(current), encoder.target(target)[:, None])
    assert compared.shape == (7, 1, FEATURES)


def correlation(encoder, current, target):
    """How alike each column of one picture is to each of another, (N, 32, 32) from -1 to 1."""
    volume = encoder.volume(encoder.current(current), encoder.target(target))
    return volume / encoder.sharpness.exp()


@torch.inference_mode()
def test_a_picture_matches_itself_along_the_diagonal():
    torch.manual_seed(0)
    encoder, pictures = MatchingEncoder(3, 16), torch.rand(6, 3, 16, 64)
    volume = correlation(encoder, pictures, pictures)
    diagonal = volume.diagonal(dim1=1, dim2=2)
    torch.testing.assert_close(diagonal, torch.ones(6, COLUMNS))
    assert volume.abs().max() <= 1 + 1e-5
    assert (volume.argmax(dim=2) == torch.arange(COLUMNS)).all()
    off = volume - 2 * torch.eye(COLUMNS)
    assert off.max() < 1 - 1e-4


@pytest.mark.parametrize("shift", [3, -5])
@torch.inference_mode()
def test_shifted_columns_are_found_again(shift):
    torch.manual_seed(0)
    encoder, wide = MatchingEncoder(3, 16), torch.rand(6, 3, 16, 96)
    current, target = wide[..., 16:80], wide[..., 16 + 2 * shift : 80 + 2 * shift]
    found = correlation(encoder, current, target).argmax(dim=2)
    # Columns near an edge see beyond it.
    inside = torch.arange(9, COLUMNS - 9)
    assert (found[:, inside] == inside - shift).all()


# What a network looks at.


@pytest.mark.parametrize("rows", [16, 64])
def test_the_camera_s_view_is_its_picture(pillars, rows):
    view = CameraView(rows)
    assert VIEWS[view.name] == view
    flat = Camera(rows=rows).look(pillars, POSES)[0]
    assert (view.render(pillars, POSES) == flat).all()
    nested = view.render(pillars, POSES.reshape(2, 2, 3))
    assert nested.shape == (2, 2, rows, 64, 3)
    assert (nested.reshape(flat.shape) == flat).all()
    sensors = Sensors(camera=Camera(rows=rows))
    seen = Simulation(pillars, POSES, sensors=sensors).observe()
    assert (view.of(seen) == flat).all()


def test_the_laser_s_view_is_what_the_robots_scan(pillars):
    seen = Simulation(pillars, POSES).observe()
    shown = LaserView().render(pillars, POSES)
    assert shown.shape == (4, 1, 64, 1)
    assert (LaserView().of(seen) == shown).all()
    nested = LaserView().render(pillars, POSES.reshape(2, 2, 3))
    assert (nested.reshape(shown.shape) == shown).all()


def test_the_laser_s_columns_go_from_left_to_right(box):
    pose = np.array([[5.0, 9.3, 0.0]])  # a wall 0.7 m to the left
    scan = LaserView().render(box, pose)[0, 0, :, 0]
    angles = np.deg2rad(118.125 - 3.75 * np.arange(64))
    up, ahead = np.sin(angles), np.cos(angles)
    to_side = np.where(up > 0, 0.7, 9.3) / np.abs(up)
    wanted = np.minimum(np.minimum(to_side, 5.0 / np.abs(ahead)), 10.0)
    assert scan == pytest.approx(wanted, abs=1e-4)
    assert scan[:8].max() < 1.0 < 5.0 < scan[-8:].min()


def test_numbers_of_pictures_are_channels_rows_and_columns():
    pictures = np.random.default_rng(0).integers(0, 256, (2, 3, 16, 64, 3), dtype=np.uint8)
    numbers = CameraView().numbers(pictures)
    assert numbers.shape == (2, 3, *CameraView().size)
    assert numbers.dtype == torch.float32
    for where in ((0, 0, 3, 5, 1), (1, 2, 15, 63, 2)):
        picture, target, row, column, channel = where
        number = numbers[picture, target, channel, row, column]
        assert number.item() == pytest.approx(pictures[where] / 127.5 - 1, abs=1e-6)
    ends = CameraView().numbers(np.stack([pictures[0] * 0, pictures[0] * 0 + 255]))
    assert ends[0].unique().tolist() == [-1]
    assert ends[1].unique().tolist() == [1]


def test_numbers_of_a_scan_are_sound_from_touching_to_out_of_range():
    metres = np.linspace(0.0, 10.0, 64, dtype=np.float32).reshape(1, 1, 64, 1)
    numbers = LaserView().numbers(metres)
    assert numbers.shape == (1, *LaserView().size)
    assert numbers.abs().max() <= 2.0
    assert (numbers[0, 2, 0].diff() > 0).all()


def test_a_flipped_picture_is_a_picture():
    picture = np.random.default_rng(0).integers(0, 256, (1, 16, 64, 3), dtype=np.uint8)
    flipped = CameraView().numbers(picture[:, :, ::-1])
    assert torch.equal(flipped, CameraView().numbers(picture).flip(-1))
    scan = np.random.default_rng(0).uniform(0, 10, (1, 1, 64, 1)).astype(np.float32)
    assert torch.equal(LaserView().numbers(scan[:, :, ::-1]), LaserView().numbers(scan).flip(-1))


@pytest.mark.parametrize(
    ("view", "shape", "kind", "words"),
    [
        ("camera16", (2, 64, 64, 3), np.uint8, r"\(2, 64, 64, 3\).*uint8 \(..., 16, 64, 3\)"),
        ("camera64", (2, 16, 64, 3), np.uint8, r"\(2, 16, 64, 3\).*uint8 \(..., 64, 64, 3\)"),
        ("camera16", (2, 16, 192, 3), np.uint8, r"\(2, 16, 192, 3\).*16, 64, 3"),
        ("camera16", (2, 3, 16, 64), np.uint8, r"\(2, 3, 16, 64\).*16, 64, 3"),
        ("camera16", (16, 64), np.uint8, r"\(16, 64\).*16, 64, 3"),
        ("camera16", (2, 16, 64, 3), np.float32, r"float32 of shape.*takes uint8"),
        ("laser", (2, 1, 96, 1), np.float32, r"\(2, 1, 96, 1\).*float32 \(..., 1, 64, 1\)"),
        ("laser", (2, 64), np.float32, r"\(2, 64\).*float32 \(..., 1, 64, 1\)"),
        ("laser", (2, 1, 64, 1), np.float64, r"float64 of shape.*takes float32"),
    ],
)
def test_another_picture_is_refused_with_the_sizes(view, shape, kind, words):
    with pytest.raises(InputError, match=words):
        VIEWS[view].numbers(np.zeros(shape, kind))


def test_another_laser_is_refused_with_the_numbers_of_beams(box):
    seen = Simulation(box, POSES).observe()
    fewer = type(seen)(**{**vars(seen), "laser": seen.laser[:, ::2]})
    with pytest.raises(InputError, match="48 beams; give 96"):
        LaserView().of(fewer)


# Changed looks.


def many_colours(groups, seed=0):
    """Pictures (G, 2, 16, 64, 3) and contexts (G, 3, 16, 64, 3) of the same six colours."""
    rng = np.random.default_rng(seed)
    colours = np.array(
        [[0, 0, 0], [255, 255, 255], [220, 60, 30], [40, 180, 70], [50, 80, 200], [128, 128, 60]],
        np.uint8,
    )
    which = [rng.integers(6, size=(groups, n, 16, 64)) for n in (2, 3)]
    return colours, which, [colours[w] for w in which]


def test_a_group_s_pictures_change_their_looks_alike():
    colours, which, pictures = many_colours(12)
    before = [group.copy() for group in pictures]
    changed = CameraView().vary(pictures, np.random.default_rng(0))
    looks = []
    for g in range(12):
        table = np.stack(
            [np.unique(changed[0][g][which[0][g] == c], axis=0)[0] for c in range(len(colours))]
        )
        for part in range(2):  # one colour is one colour in the current and all other pictures
            assert (changed[part][g] == table[which[part][g]]).all()
        looks.append(table)
    assert len(np.unique(np.reshape(looks, (12, -1)), axis=0)) == 12
    for part in range(2):
        assert changed[part].dtype == np.uint8
        assert (pictures[part] == before[part]).all()


def test_looks_change_a_lot_but_colours_stay_apart():
    _, which, pictures = many_colours(200)
    changed = CameraView().vary(pictures, np.random.default_rng(0))[0]
    tables = np.stack(
        [changed[g][tuple(np.argwhere(which[0][g] == c)[0])] for g in range(200) for c in range(6)]
    ).reshape(200, 6, 3)
    brighter = tables[:, 1].astype(int) > tables[:, 0]  # white than black
    assert brighter.mean() == pytest.approx(0.5, abs=0.1)
    apart = [np.abs(tables[:, a].astype(int) - tables[:, b]).max(1) for a, b in ((2, 3), (3, 4))]
    assert np.mean(np.array(apart) > 30) > 0.9
    # The reddest of three colours is not always the reddest channel's.
    channel = np.abs(tables[:, 2].astype(int) - tables[:, 0]).argmax(axis=1)
    assert np.bincount(channel, minlength=3).min() > 40


def test_looks_are_drawn_by_the_seed():
    _, _, pictures = many_colours(3)
    one, two, other = (
        CameraView().vary(pictures, np.random.default_rng(seed))[1] for seed in (1, 1, 2)
    )
    assert (one == two).all()
    assert (one != other).any()


def test_distances_stay_what_they_are():
    scans = [np.ones((3, 2, 1, 64, 1), np.float32), np.zeros((3, 5, 1, 64, 1), np.float32)]
    changed = LaserView().vary(scans, np.random.default_rng(0))
    assert all((mine == theirs).all() for mine, theirs in zip(changed, scans, strict=True))


def test_other_colours_change_what_the_camera_sees_and_not_the_laser(recorded):
    shifted, poses = scene_of("office/1/shifted"), recorded.poses[::50]
    for view, alike in ((LaserView(), True), (CameraView(), False)):
        same = view.render(recorded.scene, poses) == view.render(shifted, poses)
        assert same.all() == alike
