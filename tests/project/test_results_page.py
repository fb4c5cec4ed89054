"""The results page and the README's blocks are what the command makes."""

import re
from functools import cache, partial
from pathlib import Path

import pytest

from tutorial_lib.cli import main
from tutorial_lib.commands import results
from tutorial_lib.commands.experiment import ABLATIONS
from tutorial_lib.commands.results import measuring_block
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.registry import BENCHMARKS, EXPERIMENTS
from tutorial_lib.experiments.results_page.markdown import interval, percent
from tutorial_lib.experiments.results_page.page import (
    BEGIN,
    CHAPTERS,
    END,
    block_of,
    page_of,
    with_block,
    write_results,
)
from tutorial_lib.experiments.results_page.sources import (
    COMMANDS,
    RETIRED,
    command_of,
    load_results,
)
from tutorial_lib.experiments.results_page.templates import render_chapter

HERE = Path(__file__).parents[2]
PAGE = HERE / "tutorial_lib" / "results" / "README.md"
README = HERE / "README.md"
RESULTS = load_results()


@cache
def sections():
    """All of the page."""
    return [found for chapter in CHAPTERS for found in render_chapter(RESULTS, chapter)[1]]


def test_the_page_is_what_the_command_makes():
    assert PAGE.read_bytes() == page_of(RESULTS).encode()


@pytest.mark.parametrize(
    "block", [partial(block_of, RESULTS), measuring_block], ids=["results", "help"]
)
def test_a_block_of_the_readme_is_what_the_command_makes(block):
    text = README.read_text(encoding="utf-8")
    assert with_block(text, block()).encode() == README.read_bytes()


def test_the_readme_tells_what_each_experiment_measures_and_takes():
    lines = measuring_block().splitlines()
    for name, entry in {**EXPERIMENTS, **BENCHMARKS}.items():
        (line,) = [line for line in lines if line.startswith(f"| `{name}` | ")]
        _, _, measures, takes, _ = (cell.strip() for cell in line.split("|"))
        assert len(measures) > 30
        assert takes.strip("`") == " ".join(entry.options())
    for option in ("--json FILE", "--map FILE", "--quick", "--body {round,car}"):
        (line,) = [line for line in lines if line.startswith(f"| `{option}` | ")]
        assert len(line.split("|")[2]) > 10


def test_every_ablation_has_its_words():
    assert set(ABLATIONS) == {name for entry in EXPERIMENTS.values() for name in entry.ablations}


def test_the_readme_has_a_short_table():
    table = [line for line in block_of(RESULTS).splitlines() if line.startswith("|")]
    assert 5 <= len(table) - 2 <= 11


def test_each_result_is_shown_once_below_its_command():
    shown = [name for section in sections() for name in section.sources]
    assert sorted(name for name in shown if name not in RETIRED) == sorted(COMMANDS)
    assert len(set(shown)) == len(shown)
    page = PAGE.read_text(encoding="utf-8")
    assert [page.count(f"{command_of(name)}   #") for name in COMMANDS] == [1] * len(COMMANDS)


def test_every_link_of_the_contents_leads_to_a_heading():
    page = PAGE.read_text(encoding="utf-8")
    headings = re.findall(r"^##+ (.*)$", page, re.MULTILINE)
    links = re.findall(r"^ *- \[(.*)\]\(#(.*)\)$", page, re.MULTILINE)
    assert [title for title, _ in links] == headings
    anchors = [anchor for _, anchor in links]
    assert len(set(anchors)) == len(anchors)


def test_figures_that_must_not_be_left_out_are_on_the_page():
    page = PAGE.read_text(encoding="utf-8")
    recall = RESULTS.rows("map")[0]["recall"]
    assert f"{recall:.2%}" in page
    assert "p_reuse = 0.94, where the paper has 0.99" in page
    for name in ("depot", "tb3_sandbox", "warehouse"):
        rows = {row["method"]: row for row in RESULTS.rows(f"meng_table2_{name}")}
        line = next(x for x in page.splitlines() if x.startswith(f"| {name}, "))
        assert f"{rows['random']['success']:.1%}" in line


BOOTSTRAPPED = [
    ("meng_fig10", "success", "low", "high"),
    ("meng_table2_thresholds", "success", "low", "high"),
    ("faults", "reached", "reached_low", "reached_high"),
]


@pytest.mark.parametrize(("name", "key", "low", "high"), BOOTSTRAPPED)
def test_a_bootstrapped_interval_over_few_worlds_is_not_shown(name, key, low, high):
    assert 1 < len(RESULTS.reports[name].worlds) < 6
    rows = [row for row in RESULTS.rows(name) if row[key] is not None and row[low] < row[high]]
    assert rows
    text = section_with(name)
    for row in rows:
        assert percent(row[key]) in text
        assert interval(row, key, low, high) not in text


@pytest.mark.parametrize("name", ["meng_table2", "meng_table2_shifted"])
def test_a_difference_over_few_worlds_has_no_interval(name):
    assert 1 < len(RESULTS.reports[name].worlds) < 6
    found = " ".join(map(str, RESULTS.reports[name].findings))
    spans = re.findall(r"points (\(.*?\))", found)
    assert len(spans) == 3
    assert not [span for span in spans if span in section_with(name)]


def section_with(name):
    """The text of the section that shows a report."""
    (section,) = [section for section in sections() if name in section.sources]
    return section.text


def test_the_command_writes_both_and_says_so(tmp_path, monkeypatch, capsys):
    readme = tmp_path / "README.md"
    readme.write_text(f"# Mine\n\n{BEGIN}\nold\n{END}\n\nThe rest.\n", encoding="utf-8")
    made = tmp_path / "made.md"
    monkeypatch.setattr(results, "course_folder", lambda: tmp_path)
    monkeypatch.setattr(results, "write_results", lambda path, page, blocks: [path, made])
    assert main(["results"]) == 0
    assert capsys.readouterr().out == "wrote README.md\nwrote made.md\n"


def test_without_a_readme_the_page_alone_is_written(tmp_path):
    for name in (*COMMANDS, *RETIRED):
        (tmp_path / f"{name}.json").write_bytes((PAGE.parent / f"{name}.json").read_bytes())
    page = tmp_path / "new" / "README.md"
    assert write_results(tmp_path / "other.md", page, tmp_path) == [page]
    assert page.read_bytes() == PAGE.read_bytes()


def test_only_what_is_between_the_markers_is_replaced():
    found = with_block(f"a\n{BEGIN}\nold\n{END}\nb\n", f"{BEGIN}\nnew\n{END}")
    assert found == f"a\n{BEGIN}\nnew\n{END}\nb\n"


@pytest.mark.parametrize(
    "text", ["none", BEGIN, END, f"{END}{BEGIN}", f"{BEGIN}{BEGIN}{END}", f"{BEGIN}{END}{END}"]
)
def test_markers_that_are_missing_or_doubled_are_named(text):
    with pytest.raises(InputError, match=r"README\.md: write <!-- results: begin"):
        with_block(text, f"{BEGIN}\nnew\n{END}")


def test_a_readme_has_all_blocks(tmp_path):
    readme, more = tmp_path / "README.md", "<!-- more: begin -->\nnew\n<!-- more: end -->"
    readme.write_text(f"{BEGIN}\n{END}\n{more.replace('new', 'old')}\n", encoding="utf-8")
    write_results(readme, tmp_path / "page.md", blocks=[more])
    assert readme.read_text(encoding="utf-8") == f"{block_of(RESULTS)}\n{more}\n"


def test_the_help_lists_the_command(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "write the results page" in capsys.readouterr().out
