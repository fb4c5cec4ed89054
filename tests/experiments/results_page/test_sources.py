import json
import shutil

import pytest

from tutorial_lib.cli import parse
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.results import FOLDER
from tutorial_lib.experiments.results_page.page import page_of, write_results
from tutorial_lib.experiments.results_page.sources import (
    COMMANDS,
    RETIRED,
    command_of,
    load_results,
    matching,
    one,
)


@pytest.fixture
def folder(tmp_path):
    """A copy of the stored results."""
    for file in FOLDER.glob("*.json"):
        shutil.copy(file, tmp_path)
    return tmp_path


def test_every_stored_result_has_its_command_and_the_other_way_round():
    assert {*COMMANDS, *RETIRED} == {file.stem for file in FOLDER.glob("*.json")}


@pytest.mark.parametrize("name", COMMANDS)
def test_the_command_makes_the_report_of_that_name(name):
    *_, arguments = command_of(name).partition(" tutorial_lib ")
    options = parse(arguments.split())
    assert options.json.name == f"{name}.json"
    entry = options.table[options.name]
    ablation = getattr(options, "ablation", "")
    report = json.loads((FOLDER / f"{name}.json").read_text())
    assert report["name"] == (entry.ablations[ablation] if ablation else entry).name
    file = getattr(options, "map", None)
    assert report.get("map", "") == (file.name if file else "")


def test_a_missing_file_is_named_with_its_command(folder):
    (folder / "faults.json").unlink()
    with pytest.raises(InputError, match=r"faults\.json: there is no such file.*experiment faults"):
        load_results(folder)


@pytest.mark.parametrize("text", ["{", "[1]", '{"name": "map"}'])
def test_a_damaged_file_is_named_with_its_command(folder, text):
    (folder / "map.json").write_text(text)
    with pytest.raises(InputError, match=r"map\.json.*tutorial_lib bench map"):
        load_results(folder)


def spoil(folder, name, change):
    path = folder / f"{name}.json"
    report = json.loads(path.read_text())
    change(report)
    path.write_text(json.dumps(report))


@pytest.mark.parametrize(
    "change",
    [
        lambda report: report["rows"].clear(),
        lambda report: report["rows"].pop(),
        lambda report: report["rows"][0].pop("area"),
        lambda report: report["rows"][1].update(success=None),
        lambda report: report.update(rows=[1]),
    ],
)
def test_rows_that_are_missing_or_damaged_are_named_with_the_command(folder, change):
    spoil(folder, "meng_table2", change)
    with pytest.raises(
        InputError, match=r"meng_table2\.json: (damaged|not a result).*meng_table2 "
    ):
        page_of(load_results(folder))


@pytest.mark.parametrize(("name", "what"), [("meng_fig6", "notes"), ("meng_fig9", "findings")])
def test_a_note_or_finding_that_is_missing_is_named_with_the_command(folder, name, what):
    spoil(folder, name, lambda report: report[what].clear())
    with pytest.raises(InputError, match=rf"{name}\.json: damaged.*experiment {name} "):
        page_of(load_results(folder))


def test_a_quick_run_is_not_shown(folder):
    spoil(folder, "plans", lambda report: report.update(quick=True))
    with pytest.raises(InputError, match="plans: a quick run"):
        page_of(load_results(folder))


def test_nothing_is_written_when_something_is_missing(folder):
    (folder / "fleet.json").unlink()
    with pytest.raises(InputError, match="fleet"):
        write_results(folder / "none.md", folder / "page.md", folder)
    assert not (folder / "README.md").exists()


def test_rows_are_found_by_their_values():
    rows = [{"a": 1, "b": 1}, {"a": 1, "b": 2}]
    assert matching(rows, a=1) == rows
    assert one(rows, a=1, b=2) == rows[1]
    for values in ({"a": 1}, {"a": 3}):
        with pytest.raises(LookupError):
            one(rows, **values)
