import json
import re
from pathlib import Path

import pytest

from tutorial_lib.builder.guides import MADE, students_page, teachers_page, write_guides
from tutorial_lib.builder.page import read_glossary, title_of
from tutorial_lib.builder.standard import minutes_of
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.planner import DijkstraPlanner

PROJECT = Path(__file__).resolve().parents[2]
SOURCE = """# %% [markdown]
# # 01 · Doubling
#
# **40 minutes.** You need nothing.
#
# After this notebook you can
#
# - double;
# - halve
#   what was doubled.
#
# There is one exercise about [[RE]].
#
# ### Exercise 1 · `double` (easy, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>Twice.</details>
#
# **Predict:** what is twice two?
#
# <details><summary>What did you find?</summary>
# It is
# four.
# </details>
#
# <details><summary>Why?</summary>It adds.</details>
"""
WRONG = """
def double__halves(x):
    '''multiply | do not divide'''


def double__right(x):
    pass
"""


@pytest.fixture
def project(tmp_path):
    for folder in ("notebooks", "solutions", "tests/wrong_answers"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "solutions/01_double.py").write_text(SOURCE)
    (tmp_path / "tests/wrong_answers/01_double.py").write_text(WRONG)
    entry = {"meaning": "Reachability.", "symbol": "p", "unit": "none"}
    (tmp_path / "solutions/glossary.json").write_text(json.dumps({"RE": entry}))
    for name in ("notebooks/README.md", "solutions/REFERENCE.md"):
        (tmp_path / name).write_text(f"# By hand\n\n{MADE}\n\nold\n")
    return tmp_path


def test_students_get_a_map_of_the_course_and_the_glossary(project):
    page = students_page([project / "solutions/01_double.py"], "# Top\n")
    assert page.startswith("# Top\n\n## The notebooks")
    assert "| [01 · Doubling](01_double.ipynb) | `double` (10) | 40 |" in page
    assert '| <a id="re"></a>RE | $p$ | none | Reachability. | 01 |' in page


def test_teachers_get_goals_answers_and_mistakes(project):
    sources = [project / "solutions/01_double.py"]
    page = teachers_page(sources, project / "tests/wrong_answers", "# Top")
    assert "40 minutes." in page
    assert "- double;\n- halve\n  what was doubled." in page
    assert "| `double` | easy | 10 |" in page
    assert "- **Predict:** what is twice two?\n  *Answer:* It is four." in page
    assert "- **Why?**\n  *Answer:* It adds." in page  # no prediction since the last answer
    assert "Hint" not in page
    assert "| `double` | halves | multiply &#124; do not divide |" in page
    assert "right" not in page


def test_teachers_get_the_mistakes_that_checks_know(project):
    source = project / "solutions/01_compose.py"
    source.write_text(SOURCE.replace("`double`", "`compose`"))
    page = teachers_page([source], project / "tests/wrong_answers", "# Top")
    assert "- `compose`\n  - the second pose is seen from the first" in page
    assert "\n  - the headings are subtracted; they add up\n" in page


def test_teachers_get_the_predictions_that_students_commit_to(project):
    source = project / "solutions/01_double.py"
    code = """
# %%
what = Prediction(
    "01", "what", f"How much is {x} and {x}?", {"A": "three", "B": "four"}, right="B",
    robot="it counts.", tempting="A", because="one is "
    "forgotten.", before=picture,
)
"""
    source.write_text(SOURCE + code)
    page = teachers_page([source], project / "tests/wrong_answers", "# Top")
    asked = "- How much is … and …? A: three; B: four\n  *Answer:* B. A tempts: one is forgotten."
    assert asked in page


def test_what_is_written_by_hand_stays(project):
    first = [file.read_text() for file in write_guides(project)]
    assert all(text.startswith(f"# By hand\n\n{MADE}\n") for text in first)
    assert all("old" not in text for text in first)
    assert [file.read_text() for file in write_guides(project)] == first
    (project / "notebooks/README.md").write_text("# By hand\n")
    with pytest.raises(InputError, match="made by the build"):
        write_guides(project)


def test_the_pages_of_the_course_are_those_of_its_sources():
    sources = sorted((PROJECT / "solutions").glob("[0-9][0-9]_*.py"))
    wrong_answers = PROJECT / "tests/wrong_answers"
    for name, page in (
        ("notebooks/README.md", lambda top: students_page(sources, top)),
        ("solutions/REFERENCE.md", lambda top: teachers_page(sources, wrong_answers, top)),
    ):
        text = (PROJECT / name).read_text(encoding="utf-8")
        assert text == page(text[: text.index(MADE) + len(MADE)]), "python -m tutorial_lib build"


def test_a_teacher_finds_a_plan_for_each_notebook_with_its_minutes_and_sections():
    text = (PROJECT / "solutions/README.md").read_text(encoding="utf-8")
    heading = r"^### (\d\d · [^\n]+? \(\d+(?: \+ \d+)? minutes\))\n(.+?)(?=^##)"
    plans = dict(re.findall(heading, text, re.M | re.S))
    for source in sorted((PROJECT / "solutions").glob("[0-9][0-9]_*.py")):
        heading = f"{title_of(source)} ({minutes_of(source)} minutes)"
        plan = plans.pop(heading)
        for part in ("**Vote**", "**Misconceptions.**", "**Discuss**"):
            assert part in plan, heading
        known = set(re.findall(r"^# ## (\d+) · ", source.read_text(encoding="utf-8"), re.M))
        named = set(re.findall(r"(?:^|· )(\d+)(?=[–\d]* )", plan.split("- **Vote**")[0]))
        assert named <= known or not known, heading
    assert not plans


def test_the_thresholds_of_the_glossary_are_those_of_the_library():
    glossary = read_glossary(PROJECT / "solutions")
    settings = (FollowerSettings(), MapSettings(), DijkstraPlanner(), agents.meng())
    names = [name for name in glossary if name.startswith("p_")]
    assert len(names) >= 10
    for name in names:
        (value,) = {getattr(one, name) for one in settings if hasattr(one, name)}
        assert glossary[name].meaning.startswith(f"Threshold {value:g}"), name
