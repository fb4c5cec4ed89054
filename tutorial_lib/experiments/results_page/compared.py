"""Papers and course: every table and figure of the papers, and what is ours."""

from __future__ import annotations

from tutorial_lib.experiments.results_page import compared_meng, compared_nts
from tutorial_lib.experiments.results_page.departures import departures
from tutorial_lib.experiments.results_page.departures_meng import MENG
from tutorial_lib.experiments.results_page.departures_nts import NTS
from tutorial_lib.experiments.results_page.markdown import table
from tutorial_lib.experiments.results_page.section import Section
from tutorial_lib.experiments.results_page.sources import Results

TITLE = "Papers and course"
"""Of the chapter."""
LTVN = "Part of the course's notebook 08, which is not there yet."
"""In place of what is measured for that paper."""
HEAD = ("table or figure", "the paper", "here", "trend")


def _meng_section(results: Results) -> list[str]:
    return [
        "Every table and figure of Meng 2020, and what it reports in its text alone. *Trend* says "
        "whether what is measured here goes the same way; the numbers are of another world.",
        table(HEAD, compared_meng.lines(results)),
    ]


def _nts_section(results: Results) -> list[str]:
    return [
        "Every table and figure of Chaplot et al. 2020, in the same way: success on easy, medium "
        "and hard goals (Table 1), what an agent gains over all of them (Table 2), success of all "
        "goals until then (Fig. 8). What is measured here stands for plain worlds / for worlds "
        "with signs.",
        table(HEAD, compared_nts.lines(results)),
    ]


def _ltvn_section(_: Results) -> list[str]:
    names = ("Figs. 1 to 5, Algorithm 1, tables and figures of its results",)
    return [
        "R. R. Wiyatno, A. Xu and L. Paull, *Lifelong Topological Visual Navigation* (2022).",
        table(HEAD, [[name, "", LTVN, ""] for name in names]),
    ]


def _ours_in_meng_section(_: Results) -> list[str]:
    return [
        "What the course has and Meng 2020 has not, or has otherwise, by the paper's section; *its "
        "authors' code* is what they published beside it. Where nothing is said of a measurement, "
        "nobody has measured what it changes.",
        departures(MENG),
    ]


def _ours_in_nts_section(_: Results) -> list[str]:
    return [
        "The same for Chaplot et al. 2020, who published no code.",
        departures(NTS),
    ]


SECTIONS = (
    Section("Meng 2020 beside the course", (), _meng_section, reads=compared_meng.READS),
    Section("What is ours in Meng's system", (), _ours_in_meng_section),
    Section("Chaplot et al. 2020 beside the course", (), _nts_section, reads=compared_nts.READS),
    Section("What is ours in NTS", (), _ours_in_nts_section),
    Section("Lifelong Topological Visual Navigation", (), _ltvn_section),
)
