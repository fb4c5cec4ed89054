"""Papers and course: every table and figure of the papers, and what is ours."""

from __future__ import annotations

from tutorial_lib.experiments.results_page import compared_ltvn, compared_meng, compared_nts
from tutorial_lib.experiments.results_page.departures import departures
from tutorial_lib.experiments.results_page.departures_ltvn import LTVN
from tutorial_lib.experiments.results_page.departures_meng import MENG
from tutorial_lib.experiments.results_page.departures_nts import NTS
from tutorial_lib.experiments.results_page.markdown import table
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results

TITLE = "Papers and course"
"""Of the chapter."""
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


def _ltvn_section(results: Results) -> list[str]:
    return [
        "R. R. Wiyatno, A. Xu and L. Paull, *Lifelong Topological Visual Navigation* (2022): the "
        "method as its authors describe it on their page, which has neither the thresholds nor "
        "the tables of results.",
        table(HEAD, compared_ltvn.lines(results)),
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


def _ours_in_ltvn_section(_: Results) -> list[str]:
    return ["The same for *Lifelong Topological Visual Navigation*.", departures(LTVN)]


SECTIONS = (
    Section("Meng 2020 beside the course", (), _meng_section, reads=compared_meng.READS),
    Section("What is ours in Meng's system", (), _ours_in_meng_section),
    Section("Chaplot et al. 2020 beside the course", (), _nts_section, reads=compared_nts.READS),
    Section("What is ours in NTS", (), _ours_in_nts_section),
    Section(
        "Lifelong Topological Visual Navigation beside the course",
        (),
        _ltvn_section,
        reads=compared_ltvn.READS,
    ),
    Section("What is ours in LTVN", (), _ours_in_ltvn_section),
)
