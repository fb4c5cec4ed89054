"""Agents of one's own: whatever their code does, what is wrong is said in one line."""

import numpy as np
import pytest

from tests.fuzz.sources import agent_sources
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.agents import custom
from tutorial_lib.experiments.common.own import guarded
from tutorial_lib.world.simulation import checked_actions

GOOD, *BAD = agent_sources()


def act(path):
    """Make the agent of a file, and let it act."""
    where = f"{path}:Agent"
    component = custom(where)
    return guarded(where, lambda: checked_actions(component.learn([]), 3))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "mine.py"


def test_a_good_one_acts(path):
    path.write_text(GOOD)
    assert act(path).tolist() == np.full((3, 2), 0.5).tolist()


@pytest.mark.full
def test_whatever_a_bad_one_does_is_said_in_one_line(path):
    for source in BAD:
        path.write_text(source, encoding="utf-8", errors="surrogatepass")
        with pytest.raises(InputError, match=r"^--agent .*mine\.py:Agent: ") as caught:
            act(path)
        message = str(caught.value)
        assert message.isprintable()
        assert len(message) < 600


def test_control_c_is_no_fault_of_an_agent(path):
    path.write_text("raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        act(path)


@pytest.mark.parametrize("size", [None, 10**10])
def test_what_is_no_file_of_code_is_refused(path, size):
    if size is None:
        path.mkdir()
    else:
        path.touch()
        with path.open("r+b") as file:
            file.truncate(size)
    with pytest.raises(InputError, match=r"cannot be read .*; give a file of Python code"):
        act(path)
