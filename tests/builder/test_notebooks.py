import ast
import re

import nbformat
import pytest

from tutorial_lib.builder import STUB, build, compact_imports, for_students, read, stubbed, to_text
from tutorial_lib.errors import InputError

WIDGET = "application/vnd.jupyter.widget-view+json"

GOOD = """# %% [markdown]
# # Doubling

# %% exercise="double"
def double(x):
    \"\"\"Twice as much.\"\"\"
    ### BEGIN SOLUTION
    half = x
    return half + x
    ### END SOLUTION

# %%
double = check_double.use(double)

# %% [markdown]
# **30 minutes.** See [a paper](https://arxiv.org/abs/1).
#
# ### Exercise 1 · `double` (large, 30 minutes)
#
# <details><summary>Hint 1: concept</summary>Twice.</details>
# <details><summary>Hint 2: approach</summary>Add.</details>
# <details><summary>Hint 3: one line</summary>What is half + half?</details>
"""
WRONG = "".join(f"def double__wrong_{i}(x):\n    return {i}\n\n\n" for i in range(3))
RUNNABLE = GOOD.replace(
    "# # Doubling\n",
    """# # Doubling

# %%
from tutorial_lib.checks.framework.check import WrongAnswer, check


@check(lambda x: 2 * x, (1.0,))
def check_double(student):
    if student(3.0) != 6.0:
        raise WrongAnswer("double: return twice the number")
""",
)


@pytest.fixture
def project(tmp_path):
    for folder in ("notebooks", "solutions", "tests/wrong_answers"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "tests/wrong_answers/09_double.py").write_text(WRONG)
    (tmp_path / "solutions/09_double.py").write_text(GOOD)
    return tmp_path


def read_source(project, text):
    source = project / "solutions/09_double.py"
    source.write_text(text)
    return read(source, project / "tests/wrong_answers/09_double.py")


def test_students_get_a_stub_with_the_docstring_and_no_solution(project):
    notebook = for_students(read_source(project, GOOD))
    code = notebook.cells[1].source
    assert code == f'def double(x):\n    """Twice as much."""\n    {STUB}'
    assert "half = x" not in to_text(notebook)
    assert all(not cell.get("outputs") for cell in notebook.cells)
    nbformat.validate(notebook)


def test_ids_are_stable_and_unique(project):
    first = read_source(project, GOOD)
    again = read_source(project, GOOD)
    longer = read_source(project, GOOD + "\n# %%\n1\n\n# %%\n1\n")
    ids = [cell.id for cell in first.cells]
    assert ids == [cell.id for cell in again.cells] == [c.id for c in longer.cells][: len(ids)]
    assert len({cell.id for cell in longer.cells}) == len(longer.cells)


def test_nested_solutions_keep_their_indentation():
    solution = "        ### BEGIN SOLUTION\n        y = 1\n        ### END SOLUTION\n"
    code = f"def f(x):\n    if x:\n{solution}    return y"
    assert stubbed(code) == f"def f(x):\n    if x:\n        {STUB}\n    return y"


SOLUTION = GOOD[GOOD.index("    ### BEGIN") : GOOD.index("\n# %%\ndouble")]
HEAD = GOOD[GOOD.index("def double") : GOOD.index("    half")]
SECOND = GOOD[GOOD.index("# %% exercise") : GOOD.index("# %%\ndouble")]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("    ### END SOLUTION\n", "", r":7: .* never closed"),
        ("    half = x\n", "    ### BEGIN SOLUTION\n", r":8: .* again"),
        ("    ### BEGIN SOLUTION\n", "", r":9: .* without"),
        (SOLUTION, "", r":4: .* mark its solution"),
        ("double = check_double.use(double)\n", "", r":4: .*no check_double.use"),
        ('# %% exercise="double"', "# %%", r":7: .* name it"),
        ('exercise="double"', 'exercise="twice"', r":4: .*'twice' defines no function"),
        (HEAD, "### BEGIN SOLUTION\ndef double(x):\n", r":4: .*differ in double\(x\)"),
        ("    half = x\n", "    half = = x\n", r":4: invalid syntax"),
        ("# %% [markdown]\n", "", r":1: .*first '# %%'"),
        ("# %%\ndouble = check", SECOND + "# %%\ndouble = check", r":12: a second exercise"),
    ],
)
def test_broken_sources_are_refused_with_their_line(project, old, new, words):
    assert old in GOOD
    with pytest.raises(InputError, match="09_double.py" + words):
        read_source(project, GOOD.replace(old, new, 1))


def test_a_check_without_wrong_answers_is_refused(project):
    (project / "tests/wrong_answers/09_double.py").write_text(
        "def double__wrong(x):\n    return 0\n\n\ndef double__right_too(x):\n    return 2 * x\n"
    )
    with pytest.raises(InputError, match="has 1 wrong answers for 'double'"):
        read_source(project, GOOD)


def test_nothing_is_written_from_a_broken_source(project):
    source = project / "solutions/09_double.py"
    source.write_text(GOOD.replace("    ### END SOLUTION\n", ""))
    with pytest.raises(InputError):
        build(source, project)
    assert not list(project.glob("*/*.ipynb"))


def test_a_build_executes_once_and_a_rebuild_changes_nothing(project):
    source = project / "solutions/09_double.py"
    source.write_text(RUNNABLE)
    assert len(build(source, project)) == 2
    files = [project / "notebooks/09_double.ipynb", project / "solutions/09_double.ipynb"]
    before = [file.read_bytes() for file in files]
    solved = nbformat.read(files[1], as_version=4)
    assert any("passed" in str(cell.get("outputs")) for cell in solved.cells)
    assert "### BEGIN" not in before[1].decode()
    assert len(build(source, project)) == 1
    assert [file.read_bytes() for file in files] == before


def test_other_text_is_written_without_executing_the_code_again(project):
    source, target = (project / "solutions" / f"09_double.{kind}" for kind in ("py", "ipynb"))
    source.write_text(RUNNABLE + "\n# %%\nimport uuid\n\nprint(uuid.uuid4())\n")
    build(source, project)
    before = nbformat.read(target, as_version=4)
    source.write_text(
        source.read_text().replace(
            "# %%\nimport uuid", "# %% [markdown]\n# Other words.\n\n# %%\nimport uuid"
        )
    )
    assert target in build(source, project)
    after = nbformat.read(target, as_version=4)
    assert "Other words." in str(after.cells)
    assert after.cells[-1].outputs == before.cells[-1].outputs


@pytest.mark.full
def test_a_page_has_no_progress_bars(project):
    source, target = (project / "solutions" / f"09_double.{kind}" for kind in ("py", "ipynb"))
    source.write_text(RUNNABLE + "\n# %%\nfrom tqdm.auto import tqdm\n\nlist(tqdm(range(3)))\n")
    build(source, project)
    assert "it/s" not in target.read_text()


def test_a_page_shows_the_pictures_of_widgets_in_place_of_them(project):
    """JupyterLab prefers a widget, which ended with its kernel."""
    source, target = (project / "solutions" / f"09_double.{kind}" for kind in ("py", "ipynb"))
    data = {"image/png": "AA==", "text/plain": "a strip", WIDGET: {"model_id": "1"}}
    source.write_text(f"{RUNNABLE}\n# %%\ndisplay({data}, raw=True)\n")
    build(source, project)
    page = nbformat.read(target, as_version=4)
    (output,) = page.cells[-1].outputs
    assert output.data == {"image/png": "AA==", "text/plain": "a strip"}
    before, output.data = target.read_text(), data
    bar = {"text/plain": "  0%|    | 0/3 [00:00<?, ?it/s]", WIDGET: {"model_id": "1"}}
    page.cells[-1].outputs.append(nbformat.v4.new_output("display_data", bar))
    page.metadata.processor = "of a page that was executed earlier"
    nbformat.write(page, target)
    assert target in build(source, project)  # and is not executed again
    after = nbformat.read(target, as_version=4)
    assert after.metadata.pop("processor") == page.metadata.processor
    assert after.cells == nbformat.reads(before, as_version=4).cells


def test_pages_have_the_metadata_that_jupyterlab_would_give_them(project):
    source, target = (project / "solutions" / f"09_double.{kind}" for kind in ("py", "ipynb"))
    source.write_text(RUNNABLE)
    build(source, project)
    old = target.read_text().replace("Python 3 (ipykernel)", "Python 3")
    target.write_text(old)
    assert target in build(source, project)
    for folder in ("notebooks", "solutions"):
        page = nbformat.read(project / folder / "09_double.ipynb", as_version=4)
        names = {"name": "python3", "display_name": "Python 3 (ipykernel)", "language": "python"}
        assert page.metadata.kernelspec == names


def test_links_of_both_notebooks_lead_to_the_map_of_the_course(project):
    source = project / "solutions/09_double.py"
    source.write_text(RUNNABLE)
    build(source, project)
    (project / "notebooks/README.md").write_text("# The map")
    for folder in ("notebooks", "solutions"):
        page = nbformat.read(project / folder / "09_double.ipynb", as_version=4)
        links = re.findall(r"\[map[^\]]*\]\(([^)]+)\)", str(page.cells))
        assert len(links) == 2
        for link in links:
            assert (project / folder / link).resolve() == (
                project / "notebooks/README.md"
            ).resolve()


def test_building_for_students_runs_nothing(project):
    source = project / "solutions/09_double.py"
    source.write_text(RUNNABLE + "\n# %%\nraise SystemExit\n")
    assert build(source, project, students_only=True) == [project / "notebooks/09_double.ipynb"]
    assert not (project / "solutions/09_double.ipynb").exists()


def test_a_notebook_that_is_too_large_is_refused(project):
    source = project / "solutions/09_double.py"
    source.write_text(RUNNABLE + "\n# %%\nprint('x' * 1_100_000)\n")
    with pytest.raises(InputError, match="smaller pictures"):
        build(source, project)
    assert not (project / "solutions/09_double.ipynb").exists()


def test_long_import_lists_fill_lines_and_nothing_else_changes():
    names = [f"name_{number:02}" for number in range(12)]
    listed = "from there import (\n" + "".join(f"    {name},\n" for name in names) + ")\n"
    code = f"import here\n{listed}call(\n    one,\n    two,\n)\n"
    compact = compact_imports(code)
    assert compact.count("\n") == 4 + code.count("\n") - listed.count("\n")
    assert max(map(len, compact.splitlines())) <= 100
    assert ast.dump(ast.parse(compact)) == ast.dump(ast.parse(code))
    assert "call(\n    one,\n    two,\n)" in compact


def test_an_exercise_is_checked_after_it_and_not_before(project):
    start, check = GOOD.split("\n# %%\n")
    title, exercise = start.split("\n# %% exercise")
    swapped = f"{title}\n# %%\n{check}\n# %% exercise{exercise}"
    with pytest.raises(InputError, match=r"has no check_double\.use\(double\) after it"):
        read_source(project, swapped)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_three_wrong_answers_are_needed(project, count):
    some = "".join(f"def double__wrong_{i}(x):\n    return {i}\n\n\n" for i in range(count))
    (project / "tests/wrong_answers/09_double.py").write_text(some)
    with pytest.raises(InputError, match=f"has {count} wrong answers for 'double'; write 3"):
        read_source(project, GOOD)
