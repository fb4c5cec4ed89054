"""The page taken apart: sections, and the cells of tables in Markdown."""

from tutorial_lib.experiments.results_page.templates import render_chapter


def section(chapter, title, results):
    """One section of a chapter, which may lack the reports of all others."""
    _, (found,) = render_chapter(results, chapter, title)
    return found


def cells(text):
    """The cells of each line, head first; what rules the head off is left out."""
    head, rule, *lines = [line.strip("|").split("|") for line in text.splitlines()]
    assert rule == ["---"] * len(head)
    assert all(len(line) == len(head) for line in lines)
    return [[cell.strip() for cell in line] for line in (head, *lines)]
