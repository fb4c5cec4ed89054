"""environment.md gives a reason and a tested version for every dependency, and for no other."""

import re
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
COURSE = "topological-visual-navigation"  # one of its extras holds another
NAME = r"[A-Za-z0-9][A-Za-z0-9._-]*"


def declared():
    """Dependency names by table: the course itself, then each extra that adds some."""
    text = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
    try:
        import tomllib
    except ModuleNotFoundError:  # Python 3.10
        found = declared_by_pattern(text)
    else:
        project = tomllib.loads(text)["project"]
        found = {"dependencies": project["dependencies"], **project["optional-dependencies"]}
    names = {table: {re.match(NAME, item)[0].lower() for item in found[table]} for table in found}
    return {table: found - {COURSE} for table, found in names.items() if found}


def declared_by_pattern(text):
    """The same without a TOML parser, for files laid out as ours is."""
    lists = rf"^(dependencies|{NAME}) = \[(.*?)\]$"
    optional = text.split("[project.optional-dependencies]")[1].split("\n[")[0]
    found = re.findall(lists, text.split("[project.optional-dependencies]")[0], re.M | re.S)
    found = [(table, items) for table, items in found if table == "dependencies"]
    found += re.findall(lists, optional, re.M | re.S)
    return {table: re.findall(r'"([^"]+)"', re.sub(r"#.*", "", items)) for table, items in found}


def rows():
    """(package, version, reason) of each row, table by table."""
    section = (PROJECT / "environment.md").read_text(encoding="utf-8")
    section = section.split("## The packages")[1].split("\n## ")[0]
    tables = section.split("| package | tested | what for |")[1:]
    return [
        re.findall(rf"^\| `({NAME})` \| ([^|]*?) \| ([^|]*?) \|$", table, re.M) for table in tables
    ]


def test_every_dependency_has_a_row_in_its_table_and_every_row_a_dependency():
    listed = [[name for name, _, _ in table] for table in rows()]
    assert all(len(set(table)) == len(table) for table in listed)
    assert [set(table) for table in listed] == list(declared().values())


def test_every_row_has_a_version_and_a_reason():
    for table in rows():
        for name, version, reason in table:
            assert re.fullmatch(r"\d+(\.\d+)+", version), name
            assert len(reason) > 10, name


def test_tested_versions_are_accepted_ones():
    packaging = pytest.importorskip("packaging.requirements")
    text = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
    versions = {name: version for table in rows() for name, version, _ in table}
    items = [item for table in declared_by_pattern(text).values() for item in table]
    items = [item for item in items if not item.startswith(COURSE)]
    assert len(items) == len(versions)
    for item in items:
        requirement = packaging.Requirement(item)
        assert requirement.specifier.contains(versions[requirement.name.lower()]), item


def test_the_pattern_finds_what_the_parser_finds():
    tomllib = pytest.importorskip("tomllib")
    text = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
    project = tomllib.loads(text)["project"]
    expected = {"dependencies": project["dependencies"], **project["optional-dependencies"]}
    assert declared_by_pattern(text) == expected
