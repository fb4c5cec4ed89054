"""What may enter at a door, and the words for what may not."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tutorial_lib.errors import InputError
from tutorial_lib.validation import (
    alike,
    batch,
    flags,
    floats,
    images,
    instance,
    integers,
    number,
    one_of,
    whole,
)

HOSTILE = [None, "five", object(), 1j, [1, [2, 3]], {"a": 1}, [None], ["x"], np.array([1j])]


@pytest.mark.parametrize("value", HOSTILE)
@pytest.mark.parametrize("check", [floats, integers, flags, number, whole])
def test_what_is_no_number_is_refused_by_name(check, value):
    with pytest.raises(InputError, match=r"^speed: "):
        check("speed", value)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: floats("x", [1, math.nan]), "x: nan; give finite numbers"),
        (lambda: floats("x", [1, math.inf]), "x: inf; give finite numbers"),
        (lambda: floats("x", [math.nan], infinite=True), "x: nan; give numbers"),
        (lambda: floats("x", [1, -2], least=0), "x: -2.0; give finite numbers from 0 on"),
        (lambda: floats("x", math.nan, ()), "x: nan; give one real number"),
        (lambda: floats("x", [], empty=False), "x: empty; give real numbers, one at least"),
        (lambda: floats("x", 3, ("N", 3)), "x: shape (); give real numbers of shape (N, 3)"),
        (lambda: floats("x", [3], (..., 2)), "x: shape (1,); give real numbers of shape (..., 2)"),
        (lambda: integers("i", [0.0]), "i: array of float64; give whole numbers"),
        (lambda: integers("i", [True]), "i: array of bool; give whole numbers"),
        (lambda: integers("i", [-1], least=0), "i: -1; give whole numbers from 0 on"),
        (lambda: integers("i", 2**63, ()), "i: 9223372036854775808; give one whole number"),
        (lambda: flags("done", [2]), "done: 2; give True or False, or 1 and 0"),
        (lambda: images("image", [1.5], ("N",)), "image: array of float64; give uint8"),
        (lambda: images("image", np.zeros(1, np.uint16), ("N",)), "image: uint16; give uint8"),
        (lambda: number("v", math.inf), "v: inf; give one real number"),
        (lambda: number("v", 2, most=1), "v: 2.0; give one real number up to 1"),
        (lambda: whole("k", True), "k: True; give one whole number"),
        (lambda: whole("k", -1, least=0), "k: -1; give one whole number from 0 on"),
        (lambda: one_of("k", True, (1, 2)), "k: True; give 1 or 2"),
        (lambda: one_of("k", [1], ("a",)), "k: [1]; give a"),
    ],
)
def test_the_words_say_what_was_given_and_what_to_give(call, words):
    with pytest.raises(InputError, match=f"^{re.escape(words)}"):
        call()


@given(hnp.arrays(st.sampled_from(["f4", "f8", "i2", "u1", "?"]), hnp.array_shapes(min_dims=1)))
def test_real_arrays_pass_unchanged(array):
    array = np.clip(np.nan_to_num(array), -1e14, 1e14) if array.dtype.kind == "f" else array
    found = floats("x", array)
    assert found.dtype == np.float64
    assert np.array_equal(found, array)


def test_an_array_in_the_right_form_is_not_copied():
    array = np.zeros((2, 3))
    assert floats("poses", array, ("N", 3)) is array


def test_infinities_pass_where_they_mean_something():
    assert floats("geodesic", [1.0, math.inf], infinite=True, least=0)[1] == math.inf


@pytest.mark.parametrize("huge", [1e308, -1e200, np.float32(2e15), 10**18])
@pytest.mark.parametrize("others", [{}, {"least": -np.inf, "most": 1e300}, {"infinite": True}])
def test_numbers_whose_squares_or_cells_are_none_are_refused(huge, others):
    assert np.array_equal(floats("x", [1e15, -1e15], **others), [1e15, -1e15])
    for call in (lambda: floats("x", [[0.0, huge]], **others), lambda: number("x", huge, **others)):
        with pytest.raises(InputError, match=r"^x: .*; give .* from -1e\+15 to 1e\+15$"):
            call()
    with pytest.raises(InputError, match=r"^x: "):
        number("x", huge, above=0.0)


def test_empty_lists_have_the_kind_that_is_asked_for():
    assert integers("frames", []).dtype == np.intp
    assert floats("x", []).dtype == np.float64
    assert flags("done", []).dtype == np.bool_


def test_numbers_come_back_plain():
    assert type(whole("k", np.int32(2))) is int
    assert type(number("v", np.float32(0.5))) is float


def test_an_object_whose_repr_fails_is_named_by_its_class():
    class Sly:
        def __repr__(self):
            raise RuntimeError

    with pytest.raises(InputError, match="rng: a Sly; give a Generator"):
        instance("rng", Sly(), np.random.Generator)


def test_what_belongs_together_has_one_length():
    alike(starts=np.zeros(2), goals=np.zeros((2, 3)))
    with pytest.raises(InputError, match="starts: 2, goals: 3; give as many of each"):
        alike(starts=np.zeros(2), goals=np.zeros(3))


@pytest.mark.parametrize(
    "several", [[object()] * 2, np.ones((2, 3), bool), np.array([object(), None]), np.zeros(0)]
)
def test_a_batch_is_of_any_class_that_has_a_length_and_indices(several):
    assert batch("targets", several) is several


@pytest.mark.parametrize(
    "wrong",
    ["two", b"two", {1, 2}, 3, np.array(3), np.array(["x"]), np.array([b"x"]), 1j * np.ones(2)],
)
def test_text_and_complex_numbers_are_no_batch(wrong):
    with pytest.raises(InputError, match=r"^targets: "):
        batch("targets", wrong)
