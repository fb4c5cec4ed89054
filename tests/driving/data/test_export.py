"""Recordings with their images, as other programs read them."""

import sys
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import make_box, trajectory_of
from tutorial_lib.driving.data import export
from tutorial_lib.driving.data.export import export_recording
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera

COLUMNS = ("poses", "odometry", "laser", "speed", "steering", "actions", "timestamps")


@pytest.fixture
def drives():
    """Three trajectories of 7, 4 and 5 frames in a box."""
    rng, found = np.random.default_rng(0), []
    for number, count in enumerate((7, 4, 5)):
        poses = np.column_stack([rng.uniform(2, 8, (count, 2)), rng.uniform(-3, 3, count)])
        drive = replace(
            trajectory_of(poses),
            world=f"büro {number}",
            seed=number + 3,
            odometry=rng.normal(size=(count, 3)),
            laser=rng.uniform(1, 9, (count, 96)).astype(np.float32),
            speed=rng.normal(size=count),
            steering=rng.normal(size=count),
            actions=rng.normal(size=(count, 2)),
        )
        found.append(drive)
    return RecordedWorld(Scene(make_box()), found)


def read(path):
    """All arrays of a file, as anybody would read them."""
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return dict(arrays)
    h5py = pytest.importorskip("h5py")
    with h5py.File(path) as file:
        found = {name: file[name][()] for name in file}
        return found | {"world": file["world"].asstr()[()]}


@pytest.mark.parametrize("camera", [None, Camera(rows=8, columns=20)])
@pytest.mark.parametrize("name", ["drives.npz", "drives.h5", "drives.HDF5"])
def test_all_frames_are_read_back(drives, tmp_path, monkeypatch, name, camera):
    if not name.endswith("npz"):
        pytest.importorskip("h5py")
    monkeypatch.setattr(export, "_AT_A_TIME", 3)  # three do not divide 16
    path = tmp_path / name
    export_recording(path, drives, camera)
    found = read(path)
    assert found.keys() == {*COLUMNS, "images", "trajectory", "world", "seed"}
    wanted = drives.observe(np.arange(16), camera).image
    assert found["images"].dtype == np.uint8
    assert (found["images"] == wanted).all()
    for column in COLUMNS:
        whole = np.concatenate([getattr(drive, column) for drive in drives.trajectories])
        assert found[column].dtype == whole.dtype
        assert (found[column] == whole).all()
    assert found["trajectory"].tolist() == [0] * 7 + [1] * 4 + [2] * 5
    assert found["world"].tolist() == ["büro 0", "büro 1", "büro 2"]
    assert found["seed"].tolist() == [3, 4, 5]
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["drives.npz", "drives.h5"])
def test_the_same_recording_gives_the_same_bytes(drives, tmp_path, name):
    if name.endswith("h5"):
        pytest.importorskip("h5py")
    written = []
    for folder in ("one", "other"):
        (tmp_path / folder).mkdir()
        export_recording(tmp_path / folder / name, drives)
        written.append((tmp_path / folder / name).read_bytes())
    assert written[0] == written[1]


def test_the_library_reads_it_too_and_nothing_is_compressed(drives, tmp_path):
    export_recording(tmp_path / "drives.npz", drives)
    arrays = load_arrays(tmp_path / "drives.npz", ["images", "poses"])
    assert arrays["images"].shape == (16, 16, 64, 3)
    with zipfile.ZipFile(tmp_path / "drives.npz") as archive:
        assert {one.compress_type for one in archive.infolist()} == {zipfile.ZIP_STORED}


@pytest.mark.parametrize("name", ["drives.npz", "drives.h5"])
def test_an_interrupted_export_leaves_what_was_there(drives, tmp_path, monkeypatch, name):
    if name.endswith("h5"):
        pytest.importorskip("h5py")
    path = tmp_path / name
    path.write_text("the old one")
    seen = []

    def look(frames, camera=None, observe=drives.observe):
        if len(seen) == 3:
            raise KeyboardInterrupt
        seen.append(frames)
        return observe(frames, camera)

    monkeypatch.setattr(export, "_AT_A_TIME", 3)
    monkeypatch.setattr(drives, "observe", look)
    with pytest.raises(KeyboardInterrupt):
        export_recording(path, drives)
    assert path.read_text() == "the old one"
    assert list(tmp_path.iterdir()) == [path]


def test_no_more_images_are_held_than_are_rendered_at_a_time(drives, tmp_path, monkeypatch):
    most = []

    def look(frames, camera=None, observe=drives.observe):
        most.append(len(frames))
        return observe(frames, camera)

    monkeypatch.setattr(export, "_AT_A_TIME", 5)
    monkeypatch.setattr(drives, "observe", look)
    export_recording(tmp_path / "drives.npz", drives)
    assert most == [0, 5, 5, 5, 1]


def test_what_cannot_be_exported_is_refused(drives, tmp_path, monkeypatch):
    for name in ("drives.csv", "drives"):
        with pytest.raises(InputError, match=r"give a name that ends in \.npz or \.h5"):
            export_recording(tmp_path / name, drives)
    with pytest.raises(InputError, match="cannot be written"):
        export_recording(tmp_path / "none" / "drives.npz", drives)
    few = replace(drives.trajectories[0], laser=drives.trajectories[0].laser[:, :64])
    with pytest.raises(InputError, match="different numbers of beams"):
        export_recording(
            tmp_path / "drives.npz", RecordedWorld(drives.scene, [few, drives.trajectories[1]])
        )
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"h5py is missing; install it .* or give a .npz"):
        export_recording(tmp_path / "drives.h5", drives)
    assert list(tmp_path.iterdir()) == []
