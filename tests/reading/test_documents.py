"""JSON and YAML: whatever is more than plain data of a sane depth is refused."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fuzz.corpus import _aliases, _merges, nested
from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import parse_json, read_json, read_yaml
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
        with pytest.raises(InputError, match=r"here: damaged.* 32 lists and mappings within"):
            parse_json(text, "here")
        with pytest.raises(InputError, match="32 lists and mappings within"):
            parse_json(text.replace("[", '{"a":').replace("]", "}"), "here")


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
        (b"a: 2001-99-99", "month"),
        (b"a: [", "line"),
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
