"""Forecasts of the time that a map takes."""

from types import SimpleNamespace

import numpy as np
import pytest

from tutorial_lib.experiments.demos import navigation_demo
from tutorial_lib.experiments.demos.forecast import DrivesForecast, Forecast

SURE, UNSURE = np.full(40, 0.999), np.full(40, 0.9)


def test_longer_drives_and_those_of_which_re_is_unsure_take_longer():
    short, long = DrivesForecast([10.0], [SURE]), DrivesForecast([20.0], [np.tile(SURE, 2)])
    assert long.left == pytest.approx(2 * short.left)
    assert DrivesForecast([20.0], [UNSURE]).left > 5 * DrivesForecast([20.0], [SURE]).left


def test_the_first_drives_correct_it():
    forecast = DrivesForecast([20.0] * 3, [SURE, SURE, UNSURE])
    whole = forecast.left
    assert forecast.words() == f"60 m, about {max(whole, 1):.0f} s"
    alone = DrivesForecast([20.0], [SURE]).left
    assert forecast.done(5 * alone)  # five times slower than usual
    assert forecast.left == pytest.approx(5 * (whole - alone))
    assert forecast.words().startswith("2 drives left, 40 m, about ")


def test_a_busy_machine_is_known_from_how_long_it_took_to_ask():
    idle, busy = (DrivesForecast([20.0], [SURE], asked) for asked in (0.06, 0.30))
    assert busy.left == pytest.approx(5 * idle.left)
    busy.done(1.0)
    assert busy.left == 0.0


def test_what_is_left_is_said_after_the_first_drive_and_from_time_to_time():
    forecast = DrivesForecast([20.0] * 6, [SURE] * 6)
    said = [forecast.done(seconds) for seconds in (1.0, 2.0, 5.5, 6.0, 12.0, 20.0)]
    assert said == [True, False, True, False, True, False]  # after the last nothing is left
    assert forecast.left == 0.0


def test_parts_of_known_cost_are_forecast_at_the_pace_of_those_that_are_done():
    forecast = Forecast(np.array([10.0, 30.0]))
    assert forecast.words() == "about 40 s"
    assert forecast.done(20.0)  # twice as slow as usual
    assert forecast.words() == "about 60 s"


def test_scans_are_matched_once_before_any_drive_is_timed(monkeypatch):
    """What numba compiles for that took seconds, and counted as the pace of the first drive."""
    happened = []

    def match(first, second, starts):
        assert first.dtype == second.dtype == np.float64  # what is compiled is for that
        happened.append("match")

    clock = SimpleNamespace(monotonic=lambda: happened.append("clock") or 0.0)
    agent = SimpleNamespace(learn=lambda _: happened.append("learn"), topomap=[])
    seen = SimpleNamespace(laser=np.ones((2, 96), np.float32))
    drives = [SimpleNamespace(arc_length=[20.0])] * 2
    recorded = SimpleNamespace(trajectories=drives, observe=lambda frames: seen)
    monkeypatch.setattr(navigation_demo, "match_scans", match)
    monkeypatch.setattr(navigation_demo, "time", clock)
    monkeypatch.setattr(navigation_demo, "load_learned", lambda *_: None)
    monkeypatch.setattr(navigation_demo, "sureness", lambda *_: [SURE, SURE])
    monkeypatch.setattr(navigation_demo, "experiences", lambda _: drives)
    navigation_demo.learn_map(agent, SimpleNamespace(recorded=recorded))
    assert happened[:2] == ["match", "clock"]
    assert happened.count("learn") == 2
