import base64
import re

import cv2

from tests.viz.pictures import decoded, plain
from tutorial_lib.viz.figures.panels import (
    TITLE,
)
from tutorial_lib.viz.notebook.display import play


def test_a_film_is_one_of_its_own_kind_and_leaves_a_strip(tmp_path):
    frames = [plain(31, 45, shade) for shade in range(0, 200, 20)]  # odd sizes too
    film = play(frames, 5)
    page = film._repr_html_()
    assert all(word in page for word in ("<video", "controls", "loop", "muted"))
    assert re.findall(r"(?:https?:)?//[a-z]", page.split("base64")[0]) == []
    data = base64.b64decode(re.search(r"base64,([^\"]*)", page)[1])
    (tmp_path / "film.webm").write_bytes(data)
    capture = cv2.VideoCapture(str(tmp_path / "film.webm"))
    count = 0
    while capture.read()[0]:
        count += 1
    assert count == 10
    assert decoded(film._repr_png_()).shape[0] == 31 + 1 + TITLE


def test_a_film_shows_as_html_and_as_a_picture(monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.publish_display_data", shown.append)
    play([plain(32, 32)] * 3, 5)._ipython_display_()
    assert [next(iter(data)) for data in shown] == ["text/html", "image/png"]
