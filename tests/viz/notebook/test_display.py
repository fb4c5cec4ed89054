import base64
import re
from types import SimpleNamespace

import cv2
import pytest

from tests.viz.pictures import decoded, plain
from tutorial_lib.errors import InputError
from tutorial_lib.viz.figures.panels import (
    TITLE,
)
from tutorial_lib.viz.notebook.display import SHORTEST, STATIC, play, show


def test_a_film_is_one_of_its_own_kind_and_leaves_a_strip(tmp_path):
    frames = [plain(31, 45, shade) for shade in range(0, 200, 20)]  # odd sizes too
    film = play(frames, 5)
    page = film._repr_html_()
    assert all(word in page for word in ("<video", "controls", "loop", "muted"))
    assert re.findall(r"(?:https?:)?//[a-z]", page.split("base64")[0]) == []
    data = base64.b64decode(re.search(r"base64,([^\"]*)", page)[1])
    (tmp_path / "film.webm").write_bytes(data)
    capture = cv2.VideoCapture(str(tmp_path / "film.webm"))
    assert capture.get(cv2.CAP_PROP_FPS) * SHORTEST == pytest.approx(10, rel=0.01)  # slowed down
    pictures = []
    while (read := capture.read())[0]:
        pictures.append(read[1])
    assert len(pictures) == 10
    assert pictures[0].shape[0] >= TITLE + 31 + 56  # the time above, the player's controls below
    assert pictures[0][:TITLE].min() < 150
    assert pictures[0][-50:].min() > 230
    assert decoded(film._repr_png_()).shape[0] == 31 + TITLE


def test_a_strip_may_show_other_pictures_of_the_same_moments():
    frames, maps = ([plain(32, wide, shade) for shade in (0, 60, 120)] for wide in (64, 20))
    film = play(frames, 5, count=2, strip=maps)
    assert film.still.shape == (32 + TITLE, 2 * 20 + 8, 3)
    assert 'width="640"' in film._repr_html_()
    assert play(frames, 5, count=2).still.shape == (32 + TITLE, 2 * 64 + 8, 3)
    with pytest.raises(InputError, match="strip"):
        play(frames, 5, strip=maps[:2])


def test_a_picture_says_what_it_shows(monkeypatch):
    picture = plain(32, 48)
    live, _ = show(picture, 'a "quoted" robot')._repr_mimebundle_()
    assert 'alt="a &quot;quoted&quot; robot"' in live["text/html"]
    assert "image/png" not in live
    monkeypatch.setenv(STATIC, "1")
    stored, metadata = show(picture, "a robot")._repr_mimebundle_()
    assert "text/html" not in stored
    assert metadata == {"image/png": {"alt": "a robot"}}
    assert decoded(base64.b64decode(stored["image/png"])).shape == picture.shape


def test_without_words_a_picture_has_the_title_of_its_cell(monkeypatch):
    shell = SimpleNamespace(user_ns={"In": ["", "# Draw the robot\nshow(picture)"]})
    monkeypatch.setattr("IPython.get_ipython", lambda: shell)
    assert show(plain(8, 8)).alt == "Draw the robot"
    shell.user_ns["In"].append("x = 1")
    assert show(plain(8, 8)).alt == ""


def test_a_film_shows_as_html_and_as_a_picture(monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.publish_display_data", shown.append)
    play([plain(32, 32)] * 3, 5)._ipython_display_()
    assert [next(iter(data)) for data in shown] == ["text/html", "image/png"]
