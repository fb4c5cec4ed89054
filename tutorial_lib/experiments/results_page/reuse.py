"""Fig. 13 of Meng 2020 by the rule of reuse."""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.markdown import counted, number, percent, table
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, goal_words, one
from tutorial_lib.topology.mapping.edge_rules import MapSettings


def rules_of_reuse(rows: Rows) -> str:
    """Growth, size and success by the rule of reuse."""
    lines = [
        [
            f"{row['p_reuse']:g}",
            "never" if row["p_between"] == 1 else f"{row['p_between']:g}",
            number(row["vertices"], 0),
            number(row["edges"], 0),
            percent(row["growth"]),
            counted(row["success"], row["trials"]),
        ]
        for row in rows
    ]
    return table(["p_reuse", "p_between", "vertices", "edges", "growth", "success"], lines)


def _reuse_section(results: Results) -> list[str]:
    rows, usual = results.rows("meng_fig13_reuse"), MapSettings()
    used = one(rows, p_reuse=usual.p_reuse, p_between=usual.p_between)
    alone = one(rows, p_reuse=usual.p_reuse, p_between=1.0)
    return [
        f"Fig. 13 by the rule of reuse, {results.worlds('meng_fig13_reuse')} validation worlds: a "
        f"vertex replaces an anchor above p_reuse; where none does, an edge may on which the "
        f"anchor lies, with RE above p_between from its source and to its target (not in the "
        f"paper). *Growth* is that of the vertices over the second half of the frames, success "
        f"that of the same trials on each map at its end. {goal_words(rows)}",
        rules_of_reuse(rows),
        f"With p_reuse = {usual.p_reuse:g} and p_between = {usual.p_between:g}, as maps are built "
        f"now, they grow by {percent(used['growth'])} instead of {percent(alone['growth'])}, and "
        f"{percent(used['success'])} of the trials succeed instead of "
        f"{percent(alone['success'])}.",
    ]


SECTIONS = (Section("Fig. 13: rules of reuse", ("meng_fig13_reuse",), _reuse_section),)
