import cv2
import numpy as np
import pytest

from tests.viz.pictures import decoded, plain
from tutorial_lib.errors import InputError
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.figures.film import exact_png, png, write_film


def frames(count, height=48, width=64):
    """Pictures of one colour each, getting redder."""
    shades = np.linspace(20, 220, count).astype(np.uint8)
    pictures = np.zeros((count, height, width, 3), np.uint8)
    pictures[..., 0] = shades[:, None, None]
    pictures[..., 2] = 40
    return list(pictures)


def read_film(path):
    film = cv2.VideoCapture(str(path))
    rate, pictures = film.get(cv2.CAP_PROP_FPS), []
    while True:
        more, picture = film.read()
        if not more:
            return rate, pictures
        pictures.append(picture[..., ::-1])


def test_a_film_has_all_frames_in_order_at_its_size_and_rate(tmp_path):
    given = frames(12)
    write_film(tmp_path / "film.webm", given, 10)
    rate, pictures = read_film(tmp_path / "film.webm")
    assert rate == pytest.approx(10)
    assert [p.shape for p in pictures] == [(48, 64, 3)] * 12
    assert np.abs(np.array(pictures).astype(int) - given).mean() < 8
    assert [f.name for f in tmp_path.iterdir()] == ["film.webm"]
    assert (tmp_path / "film.webm").read_bytes()[:4] == b"\x1aE\xdf\xa3"  # EBML, so WebM


@pytest.mark.parametrize(
    ("name", "pictures", "words"),
    [
        ("a.webm", [], "no frames"),
        ("a.webm", [*frames(3), frames(1, 20)[0]], "size"),
        ("a.webm", [*frames(3), frames(1)[0] / 255], "uint8"),
        ("a.webm", frames(3, 47, 63), "even"),
        ("a.xyz", frames(3), "webm"),
    ],
    ids=["no frames", "two sizes", "no bytes", "odd size", "other suffix"],
)
@pytest.mark.filterwarnings("ignore")
def test_a_film_that_cannot_be_written_leaves_what_was_there(name, pictures, words, tmp_path):
    (tmp_path / name).write_text("an older film")
    with pytest.raises(InputError, match=words):
        write_film(tmp_path / name, pictures, 10)
    assert {f.name: f.read_text() for f in tmp_path.iterdir()} == {name: "an older film"}


def test_a_film_interrupted_midway_leaves_what_was_there(tmp_path):
    class Frames(list):
        def __iter__(self):
            yield from self[:3]
            raise KeyboardInterrupt

    (tmp_path / "a.webm").write_text("an older film")
    with pytest.raises(KeyboardInterrupt):
        write_film(tmp_path / "a.webm", Frames(frames(5)), 10)
    assert {f.name: f.read_text() for f in tmp_path.iterdir()} == {"a.webm": "an older film"}


def end_after(count, fail, monkeypatch):
    """Have OpenCV write `count` frames of a film, and call `fail` in the place of each other."""

    class Ending:
        fourcc = cv2.VideoWriter.fourcc

        def __init__(self, *given):
            self.writer, self.left = cv2_writer(*given), count

        def isOpened(self):  # noqa: N802 - as OpenCV calls it
            return self.writer.isOpened()

        def write(self, frame):
            self.left -= 1
            if self.left >= 0:
                self.writer.write(frame)
            else:
                fail()

        def release(self):
            self.writer.release()

    cv2_writer = cv2.VideoWriter
    monkeypatch.setattr(cv2, "VideoWriter", Ending)


def test_a_film_of_which_frames_are_lost_leaves_what_was_there(tmp_path, monkeypatch):
    (tmp_path / "a.webm").write_text("an older film")
    end_after(7, lambda: None, monkeypatch)  # as on a full disk, of which OpenCV says nothing
    with pytest.raises(InputError, match=r"a\.webm: .*7 of 12 frames could be read.* MB free"):
        write_film(tmp_path / "a.webm", frames(12), 10)
    assert {f.name: f.read_text() for f in tmp_path.iterdir()} == {"a.webm": "an older film"}


@pytest.mark.parametrize("count", [3, 100])  # of which 30 may wait
def test_an_error_while_frames_are_encoded_ends_the_film(count, tmp_path, monkeypatch):
    def fail():
        raise cv2.error("no memory")

    (tmp_path / "a.webm").write_text("an older film")
    end_after(2, fail, monkeypatch)
    with pytest.raises(cv2.error, match="no memory"):
        write_film(tmp_path / "a.webm", frames(count), 10)
    assert {f.name: f.read_text() for f in tmp_path.iterdir()} == {"a.webm": "an older film"}


def test_an_exact_png_comes_back_as_it_was(tmp_path):
    picture = np.random.default_rng(0).integers(0, 256, (13, 17, 3), np.uint8)
    (tmp_path / "view.png").write_bytes(exact_png(picture))
    assert (cv2.imread(str(tmp_path / "view.png"))[..., ::-1] == picture).all()


def test_a_png_keeps_few_colours_and_nearly_keeps_many():
    few = plain(20, 30)
    few[5:9, 3:20] = colours.LASER
    assert (decoded(png(few)) == few).all()
    slope = np.stack([np.tile(np.arange(256), (40, 1))] * 3, axis=-1).astype(np.uint8)
    slope[..., 2] = np.arange(40)[:, None] * 6
    assert np.abs(decoded(png(slope)).astype(int) - slope).mean() < 8
    for k, colour in enumerate(colours.THINGS):  # which keep their colours beside many others
        slope[2 * k, :20] = colour
    back = decoded(png(slope))
    assert all((back[2 * k, :20] == colour).all() for k, colour in enumerate(colours.THINGS))
    with pytest.raises(InputError, match="uint8"):
        png(slope / 255)
    assert decoded(png(few)).shape == few.shape


def test_short_lines_keep_their_colours_among_many_others():
    pale = np.random.default_rng(0).integers(200, 256, (300, 400, 3)).astype(np.uint8)
    shades = [(224, 160, 12), (208, 98, 8), (10, 152, 118)]  # of a path, laser and goal, scaled
    for row, shade in enumerate(shades):
        pale[100 * row, :30] = shade
    back = decoded(png(pale)).astype(int)
    assert all(np.abs(back[100 * row, 0] - shade).max() < 16 for row, shade in enumerate(shades))
