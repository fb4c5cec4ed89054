"""Templates: what a mistake in one, or in a report, is called."""

import pytest
from jinja2 import DictLoader

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Report
from tutorial_lib.experiments.results_page import templates, worlds
from tutorial_lib.experiments.results_page.page import CHAPTERS
from tutorial_lib.experiments.results_page.sources import Results
from tutorial_lib.experiments.results_page.templates import TEMPLATES, render_chapter

REPORT = Report("plans", 0, (1, 2), False, 1.0, [{"share": 0.5}], ("a note: yes",))


@pytest.fixture
def chapter(monkeypatch):
    """What becomes of a chapter with one section of a text."""

    def made(text, sources=""):
        page = f"## A\n\n{{% call section('B'{sources}) %}}\n{text}\n{{% endcall %}}\n"
        loader = DictLoader({"worlds.md.j2": page})
        monkeypatch.setattr(templates.ENVIRONMENT, "loader", loader)
        return render_chapter(Results({"plans": REPORT}), worlds)

    return made


def test_every_chapter_has_a_template_and_every_template_is_used():
    names = {chapter.__name__.rpartition(".")[2] for chapter in CHAPTERS}
    files = {file.name.removesuffix(".md.j2") for file in TEMPLATES.iterdir()}
    assert files == names | {"introduction", "in_short"}


def test_a_section_has_its_commands_below_its_first_paragraph(chapter):
    text, (section,) = chapter("{{ percent(row('plans').share) }}.\n\nMore.", ", 'plans'")
    assert section.sources == ("plans",)
    assert text == f"## A\n\n{section.text}"
    first, second, commands, last = section.text.split("\n\n")
    assert (first, second, last) == ("### B", "50.0%.", "More.")
    assert commands.startswith("```sh\n.venv/bin/python -m tutorial_lib experiment plans --json ")
    assert commands.endswith("   # 1 s\n```")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("one\n\n{{ precent(0.5) }}", r"worlds\.md\.j2, line 6: 'precent' is undefined"),
        ("{{ metrics.NOWHERE + 1 }}", r"worlds\.md\.j2, line 4: .*NOWHERE"),
        ("{{ percent( }}", r"worlds\.md\.j2, line 4: "),
        ("{{ rows('plains') }}", "plains: the page has no such report"),
    ],
)
def test_a_mistake_in_a_template_is_named_with_its_line(chapter, text, message):
    with pytest.raises(InputError, match=message) as found:
        chapter(text)
    assert "damaged" not in str(found.value)


@pytest.mark.parametrize(
    "text",
    [
        "{{ percent(row('plans').success) }}",
        "{{ rows('plans')[1].share }}",
        "{{ finding('plans', 'another') }}",
        "{{ percent(row('plans', share=0.4).share) }}",
        "{{ count(note('plans')) }}",
    ],
)
def test_what_a_report_lacks_is_named_with_the_command(chapter, text):
    with pytest.raises(InputError, match=r"^plans\.json: damaged .*make it with: .* plans --json"):
        chapter(text)
