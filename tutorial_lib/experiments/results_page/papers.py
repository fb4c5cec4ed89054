"""What the chapter on papers and course says: numbers beside the papers', and where things are."""

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.nts.table1 import PAPER as TABLE1
from tutorial_lib.experiments.nts.table2 import PAPER as TABLE2
from tutorial_lib.experiments.nts.table2 import PAPER_STANDARD
from tutorial_lib.experiments.results_page import exploring
from tutorial_lib.experiments.results_page.markdown import Row, link, listed, percents, points
from tutorial_lib.experiments.results_page.sources import Results
from tutorial_lib.experiments.results_page.tables import Text, asked, matching, pivot
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.world.generators import SIGNS

NOTEBOOKS = {
    "02": "02_local_control",
    "03": "03_reachability",
    "04": "04_sparsification",
    "05": "05_map_building",
    "06": "06_probabilistic_planning",
    "07": "07_aliasing",
    "08": "08_lifelong_maps",
    "09": "09_ghost_nodes",
    "10": "10_ten_visits",
}


def where(*places: str, measured: str = "") -> str:
    """Links to files of the library or numbers of notebooks, and to a section of the page.

    >>> where("topology/planner.py", measured="Fig. 8: whole maps")
    '[planner.py](../topology/planner.py); [Fig. 8: whole maps](#fig-8-whole-maps)'
    """
    links = listed([_place(place) for place in places])
    return f"{links}; {link(measured)}" if measured else links


def counts(values: list[int]) -> str:
    """From the least to the greatest of some counts.

    >>> counts([1_297, 900])
    '900 to 1,297'
    """
    return f"{min(values):,} to {max(values):,}"


def reported(agent: str, sensor: str) -> str:
    """Success by difficulty in the paper's Table 1."""
    return ", ".join(percents([success for success, _ in TABLE1[agent, sensor]], 0))


def reached(results: Results, agent: str, sensor: str) -> str:
    """Success by difficulty in ours, in plain worlds / with signs."""
    rows = matching(exploring.all_agents(results), agent=agent, sensor=sensor)
    cells = pivot(rows, asked(signs=SIGNS), asked(difficulty=DIFFICULTIES), "{success:.0%}")
    return " / ".join(", ".join(line) for line in cells)


def reported_gain(agent: str, condition: str) -> str:
    """What an agent gains in the paper's Table 2."""
    return points(TABLE2[agent, condition][-1] - PAPER_STANDARD[agent])


def gains(results: Results, agent: str, condition: str) -> str:
    """What it gains in ours, in plain worlds / with signs."""
    return " / ".join(exploring.gain_without(results, agent, signs, condition) for signs in SIGNS)


def from_one_to_ten(rows: Rows, text: Text) -> str:
    """What is said of one goal and of ten one after another, in plain worlds / with signs."""
    cells = pivot(rows, asked(signs=SIGNS), asked(goals=(1, 10)), text)
    return " / ".join(" to ".join(line) for line in cells)


def success_gap(row: Row) -> str:
    """By what share of the goals NTS finds more."""
    return points(row["success_gap"])


def _place(where: str) -> str:
    """A link to a notebook or a file, seen from the page.

    >>> _place("09"), _place("topology/planner.py")
    ('[09](../../notebooks/09_ghost_nodes.ipynb)', '[planner.py](../topology/planner.py)')
    """
    if where in NOTEBOOKS:
        return f"[{where}](../../notebooks/{NOTEBOOKS[where]}.ipynb)"
    return f"[{where.rpartition('/')[2]}](../{where})"
