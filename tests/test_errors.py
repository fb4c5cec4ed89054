"""Messages are one line that any terminal can print, whatever they quote."""

import pickle

import pytest

from tutorial_lib.errors import MAX_MESSAGE, MAX_QUOTE, InputError, one_line, words_of


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("as it is: 5 m², x̂ = “a”; θ", "as it is: 5 m², x̂ = “a”; θ"),
        ("one\ntwo\r\n  three\tfour\u2028five\u00a0six", "one two three four five six"),
        ("\x1b[2J\x00\ud800!", "\ufffd[2J\ufffd\ufffd!"),
        ("", ""),
    ],
)
def test_a_message_is_one_line(text, line):
    assert str(InputError(text)) == one_line(text) == line
    line.encode()


@pytest.mark.parametrize("length", [MAX_MESSAGE + 1, 5_000, 200_000])
def test_a_long_message_keeps_its_beginning_and_its_end(length):
    message = str(InputError("file.json: " + "x" * length + "; restore it"))
    assert len(message) == MAX_MESSAGE
    assert message.startswith("file.json: xxx")
    assert message.endswith("xxx; restore it")
    assert " … " in message


def test_a_message_that_just_fits_is_left_alone():
    text = "y" * MAX_MESSAGE
    assert str(InputError(text)) == text


def test_it_comes_back_from_another_process():
    error = pickle.loads(pickle.dumps(InputError("a\nb")))
    assert type(error) is InputError
    assert str(error) == "a b"


class Mute(BaseException):
    def __str__(self):
        raise Mute


def test_the_words_of_any_error_can_be_had():
    assert words_of(KeyError("a")) == "KeyError: 'a'"
    assert words_of(Mute()) == "Mute: no message, since its __str__ raised Mute"
    assert words_of(ValueError("one\ntwo")) == "ValueError: one two"
    assert len(words_of(ValueError("long " * 50_000))) == MAX_QUOTE
