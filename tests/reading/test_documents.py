"""JSON and YAML: whatever is more than plain data of a sane depth is refused."""

import json
import math
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fuzz.corpus import _aliases, _merges, nested
from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import parse_json, read_json, read_yaml, scalar_of
from tutorial_lib.reading.limits import MAX_DEPTH, MAX_JSON, MAX_YAML


@given(st.recursive(st.none() | st.integers() | st.text(), st.lists, max_leaves=20))
def test_json_is_read_as_it_was_written(value):
    for ascii_only in (True, False):
        text = json.dumps({"[": value}, ensure_ascii=ascii_only)
        assert parse_json(text, "here") == {"[": value}


def test_brackets_in_text_are_no_depth():
    value = {"a": "[" * 500, 'b"{': '"[{\\' * 500, "c": ["]" * 500]}
    assert parse_json(json.dumps(value), "here") == value


def test_depth_has_a_limit():
    assert parse_json(json.dumps(nested(MAX_DEPTH - 1)), "here") == nested(MAX_DEPTH - 1)
    for depth in (MAX_DEPTH, 500, 100_000):
        text = "[" * (depth + 1) + "]" * (depth + 1)
        with pytest.raises(InputError, match=r"here: more than 32 lists and mappings within"):
            parse_json(text, "here")
        with pytest.raises(InputError, match="32 lists and mappings within"):
            parse_json(text.replace("[", '{"a":').replace("]", "}"), "here")


@pytest.mark.parametrize("text", ['{"a": 1, "a": 1}', '[{"b": {"a": 1, "c": 2, "a": 3}}]'])
def test_a_key_that_is_given_twice_is_named(text):
    with pytest.raises(InputError, match=r"^here: the key 'a' is given twice; keep one$"):
        parse_json(text, "here")


def test_of_many_keys_the_one_that_is_given_twice_is_found_at_once():
    keys = [*range(60_000), 59_999]  # comparing each with all others takes half a minute
    begun = time.process_time()
    with pytest.raises(InputError, match="the key '59999' is given twice"):
        parse_json("{" + ",".join(f'"{key}":1' for key in keys) + "}", "here")
    assert time.process_time() - begun < 3.0


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(("010", 10), ("-0", 0), ("+12", 12), ("0o17", 15), ("0x1F", 31), ("08", 8)),
        *((".5", 0.5), ("1.", 1.0), ("5e-2", 0.05), ("1E3", 1000.0), ("-.inf", -math.inf)),
        *((".INF", math.inf), ("true", True), ("FALSE", False), ("~", None), ("null", None)),
        *(("0_1", "0_1"), ("1e-1_0", "1e-1_0"), ("1:30", "1:30"), ("0b11", "0b11")),
        *(("-0x1", "-0x1"), ("0O7", "0O7"), ("yes", "yes"), ("off", "off"), ("tRUE", "tRUE")),
        *(("2001-12-14", "2001-12-14"), ("inf", "inf"), (".", "."), ("1e", "1e"), ("=", "=")),
    ],
)
def test_values_are_those_of_yaml_1_2(tmp_path, text, value):
    found = yaml_of(tmp_path, f"a: {text}\nb: [{text}]\n'{text}': c\nd: '{text}'".encode())
    assert found == {"a": value, "b": [value], text: "c", "d": text}
    assert type(found["a"]) is type(scalar_of(text)) is type(value)


def test_a_value_that_is_not_a_number_is_none(tmp_path):
    assert math.isnan(yaml_of(tmp_path, b"a: .NaN")["a"])
    assert yaml_of(tmp_path, b"a:\nb: ''") == {"a": None, "b": ""}


def test_a_mark_before_the_text_is_no_part_of_it(tmp_path):
    (tmp_path / "a.json").write_bytes(b'\xef\xbb\xbf{"a": "\xef\xbb\xbf"}')
    assert read_json(tmp_path / "a.json") == {"a": "\ufeff"}
    assert yaml_of(tmp_path, b"\xef\xbb\xbfa: 1") == {"a": 1}


@pytest.mark.parametrize("text", ["", "{", "[1,]", "9" * 5_000, '"' + '\\"' * 100_000, "\ud800"])
def test_what_is_no_json_is_named(text):
    with pytest.raises(InputError, match=r"^here: damaged, or not JSON \(.*\); do this$"):
        parse_json(text, "here", "do this")


def test_a_large_document_is_not_read(tmp_path):
    path = tmp_path / "a.json"
    path.write_bytes(b" " * MAX_JSON + b"1")
    with pytest.raises(InputError, match="more than the 16 MB"):
        read_json(path)


def yaml_of(tmp_path, content):
    path = tmp_path / "map.yaml"
    path.write_bytes(content)
    return read_yaml(path, "mend it")


def test_plain_yaml_is_read(tmp_path):
    text = b"image: map.pgm\norigin: [-1.0, 2, 0]\nnegate: 0\nmode: 'trinary'\n# end\n"
    assert yaml_of(tmp_path, text) == {
        "image": "map.pgm",
        "origin": [-1.0, 2, 0],
        "negate": 0,
        "mode": "trinary",
    }


def test_tabs_stand_between_words_as_spaces_do(tmp_path):
    text = (
        b"image:\tmap.pgm\t\nresolution: \t0.05\t# metres\norigin:\t[-1.0,\t2,\n\t0\t]\n"
        b"negate\t:\t'0'\nmode:\n-\ta\n- \t\"b\tc\"\t\n"
    )
    assert yaml_of(tmp_path, text) == {
        "image": "map.pgm",
        "resolution": 0.05,
        "origin": [-1.0, 2, 0],
        "negate": "0",
        "mode": ["a", "b\tc"],
    }


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a: &a [x]\nb: *a", "line 1 .anchors and aliases"),
        (b"a: 1\nb: *a", "line 2 .anchors and aliases"),
        (_aliases(), "anchors and aliases"),
        (_merges(), "anchors and aliases"),
        (b"a: 1\n<<: {b: 1}", "line 2 .merges"),
        (b"a: !!bool maybe", "tags"),
        (b"a: !!python/object/apply:os.system ['true']", "tags"),
        (b"!own {a: 1}", "tags"),
        (b"[" * 2_000, "32 lists"),
        (b"- " * 2_000 + b"a", "32 lists"),
        (b"{a: " * 40 + b"1" + b"}" * 40, "32 lists"),
        (b"a: 1\nb: 2\na: 1", "line 3 .the key 'a' is given twice"),
        (b"a: {b: 1, 'b': 2}", "line 1 .the key 'b' is given twice"),
        (b"1: a\n0x1: b", "line 2 .the key 1 is given twice"),
        (b"a: [", "line"),
        (b"a:\n\tb: 1", "line 2 .a tab indents it; use spaces"),
        (b"a: 1\n \tb: 1", "line 2 .a tab indents it; use spaces"),
        (b"a: " + b"9" * 5_000, "limit"),
        (b"? [a]\n: b", "unhashable"),
        (b"x: \x00", "special characters"),
        (b"a: 1\n--- \nb: 2", "another document"),
        (b"x" * (MAX_YAML + 1), "more than the 0.064 MB"),
    ],
)
def test_yaml_that_is_more_than_data_is_refused(tmp_path, content, words):
    with pytest.raises(InputError, match=rf"map\.yaml: .*{words}.*; mend it$"):
        yaml_of(tmp_path, content)
