"""Trajectory following: Figs. 5, 6 and 7 of Meng 2020, and disturbances."""

from __future__ import annotations

import math

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.local_control import NOISE
from tutorial_lib.experiments.protocols.moves import ASIDE, TURNED
from tutorial_lib.experiments.results_page import paper
from tutorial_lib.experiments.results_page.markdown import (
    counted,
    interval,
    listed,
    number,
    percent,
    span,
    table,
)
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, matching, one
from tutorial_lib.experiments.robustness import disturbances
from tutorial_lib.experiments.robustness.disturbances import SOON
from tutorial_lib.topology.following.transitions import FollowerSettings

CONTEXTS = {"k0": "k = 0", "k2": "k = 2", "k5": "k = 5", "laser": "laser, k = 2"}
DISTURBANCES = {
    "none": "none",
    "pushed": f"pushed {ASIDE:g} m aside",
    "turned": f"turned by {math.degrees(TURNED):.0f}°",
    "person": "a person walks across",
    "carried": "kidnapped out of sight",
}


def anchors_by(row: dict[str, object]) -> str:
    """How the anchors of a row were chosen.

    >>> anchors_by({"method": "sptm", "threshold": 20})
    'SPTM: every 20th frame'
    """
    if row["method"] == "sptm":
        return f"SPTM: every {row['threshold']}th frame"
    return f"RE above {row['threshold']:g}"


def cover_rates(rows: Rows) -> str:
    """Cover rate and sparsity for every choice of anchors, with actuation noise where driven."""
    lines = []
    for row in matching(rows, condition="clean"):
        same = {key: row[key] for key in ("method", "context", "threshold")}
        noisy = matching(rows, condition="noise", **same)
        lines.append(
            [
                CONTEXTS[row["context"]],
                anchors_by(row),
                number(row["sparsity"]),
                number(row["stored"]),
                interval(row, "cover_rate"),
                interval(noisy[0], "cover_rate") if noisy else "",
            ]
        )
    head = ["context", "anchors by", "sparsity", "stored", "cover rate", "with noise"]
    return table(head, lines)


def placement(rows: Rows) -> str:
    """How densely anchors are kept, and where."""
    lines = [
        [
            CONTEXTS[row["context"]],
            f"{row['anchors']:,}",
            number(row["sparsity"]),
            f"{number(row['metres'], 2)} m",
            _correlation(row, "with_clearance"),
            _correlation(row, "with_turn"),
        ]
        for row in rows
    ]
    head = ["context", "anchors", "sparsity", "apart", "ρ with clearance", "ρ with turning"]
    return table(head, lines)


def one_rollout(rows: Rows) -> str:
    """The numbered places of one rollout."""
    lines = [
        [
            str(row["place"]),
            f"{number(row['seconds'], 1)} s",
            row["state"].replace("_", " "),
            f"{row['active']} of {row['anchors']}",
            number(row["probability"]),
        ]
        for row in rows
    ]
    return table(["place", "time", "state", "active anchor", "RE"], lines)


def recoveries(rows: Rows) -> str:
    """How rollouts go on after a disturbance."""
    lines = []
    for name, label in DISTURBANCES.items():
        row = one(rows, disturbance=name)
        kidnapped = name == "carried"
        lines.append(
            [
                label,
                str(row["trajectories"]),
                "" if kidnapped else interval(row, "finished", "finished_low", "finished_high"),
                interval(row, "soon", "soon_low", "soon_high"),
                counted(row["lost"], row["trajectories"]),
            ]
        )
    head = ["disturbance", "rollouts", "finished", f"lost within {SOON:g} s", "lost in the end"]
    return table(head, lines)


def patience(rows: Rows) -> str:
    """Which robots give up and which arrive, by the follower's thresholds."""
    lines = []
    for row in rows:
        kinds = ("none", "pushed", "turned", "person")
        finished = [percent(row[f"finished_{kind}"]) for kind in kinds]
        fall = f"{row['fall']:g}" if row["fall"] < 1 else "no doubts"
        rules = [fall, f"{row['timeout']:g} s", f"{row['p_lose']:g}", f"{row['calm']:g} s"]
        lines.append([*rules, interval(row, "soon", "soon_low", "soon_high"), *finished])
    head = ["fall", "timeout", "p_lose", "calm", f"kidnapped: lost within {SOON:g} s"]
    return table([*head, "undisturbed: finished", "pushed", "turned", "a person"], lines)


def _correlation(row: dict[str, float], key: str) -> str:
    low, high = row[f"{key}_low"], row[f"{key}_high"]
    return f"{row[key]:+.2f} ({low:+.2f} to {high:+.2f})"


def _cover_section(results: Results) -> list[str]:
    name, rules = "meng_fig7", FollowerSettings()
    rows = results.rows(name)
    clean = matching(rows, method="meng", condition="clean")
    covered = {k: [r["cover_rate"] for r in matching(clean, context=k)] for k in ("k0", "k2", "k5")}
    densest = max(matching(clean, context="k5"), key=lambda row: row["stored"])
    many, often = (
        max(matching(rows, method=m, context="k0", condition="clean"), key=lambda r: r["sparsity"])
        for m in ("meng", "sptm")
    )
    gaps = [
        f"{CONTEXTS[k]}: {results.note(name, f'area between meng and sptm, {k}: ')}"
        for k in covered
    ]
    noise = [
        f"{results.note(name, f'clean - noise, k2 at {p:g}: ')} at {p:g}"
        for p in (row["threshold"] for row in matching(rows, condition="noise"))
    ]
    return [
        f"Cover rate against sparsity (Fig. 7 of Meng 2020): the share of recorded trajectories "
        f"({results.note(name, 'mean length ')} on average) that is followed by anchors alone, "
        f"and the share of their frames that are anchors. {rows[0]['trajectories']} trajectories "
        f"in {results.worlds(name)} test worlds (the paper: {paper.TRAJECTORIES} in 5); p_search "
        f"= {rules.p_search:g}, p_follow = {rules.p_follow:g}. *Stored* is the share of frames "
        f"that are kept when each anchor's context is counted, too; *noise* multiplies both "
        f"controls by N(1, {NOISE:.2f}). SPTM's rows have the same controller and follower, with "
        f"the doubts that *Disturbances* describes. Nothing is bold: cover rate and sparsity are a "
        f"trade-off.",
        cover_rates(rows),
        f"The paper has over {percent(paper.COVERED[True], 0)} with context and at most "
        f"{percent(paper.COVERED[False], 0)} without; here it is {span(covered['k2'])} for k = 2, "
        f"{span(covered['k5'])} for k = 5 and {span(covered['k0'])} for k = 0, which keeps more "
        f"anchors. Over the sparsities that both have, RE covers more than every n-th frame "
        f"({'; '.join(gaps)}); an interval with 0 in it shows no difference. Where many anchors "
        f"are kept both are about as good: for k = 0 above {many['threshold']:g} it covers "
        f"{percent(many['cover_rate'])}, every {often['threshold']}th frame "
        f"{percent(often['cover_rate'])}, at sparsities {number(many['sparsity'])} and "
        f"{number(often['sparsity'])}. With context, a sparse path is not a small one: "
        f"{number(densest['sparsity'])} of the frames are anchors for k = 5 above "
        f"{densest['threshold']:g}, but {number(densest['stored'])} are stored. Without noise "
        f"over with it: {listed(noise)}; the paper finds no noticeable difference.",
    ]


def _placement_section(results: Results) -> list[str]:
    rows = results.rows("meng_fig5")
    k2, k5, laser = (one(rows, context=context) for context in ("k2", "k5", "laser"))
    return [
        f"Where anchors are kept (Fig. 5 of Meng 2020, p_sparsify = {k2['threshold']:g}): their "
        f"number on the same trajectories in {results.worlds('meng_fig5')} test worlds, the mean "
        f"distance to the next, and the rank correlation (Spearman) of that distance with the "
        f"least clearance and with the turning on the next metre.",
        placement(rows),
        f"As in the paper, k = 5 needs fewer anchors than k = 2 ({k5['anchors']:,} and "
        f"{k2['anchors']:,}), and anchors are denser in tight places and corners; the "
        f"correlations are weak to moderate. The laser's outcome differs: in the paper its anchors "
        f"are spread more uniformly (Sec. IV-A); here they follow clearance no less than the "
        f"camera's ({laser['with_clearance']:+.2f}, {k2['with_clearance']:+.2f} with k = 2), and "
        f"stand {k2['metres'] / laser['metres']:.1f} times as dense as with k = 2. Why is not "
        f"measured.",
    ]


def _one_rollout_section(results: Results) -> list[str]:
    note = results.note("meng_fig6")
    return [
        "One long trajectory, followed by its anchors (Fig. 6 of Meng 2020; an example, not a "
        "measurement), at places spread over the rollout.",
        one_rollout(results.rows("meng_fig6")),
        f"{note[0].upper()}{note[1:]}. Notebook 04 draws it.",
    ]


def _disturbance_section(results: Results) -> list[str]:
    rows = results.rows("disturbances")
    none, pushed, person, carried = (
        one(rows, disturbance=name) for name in ("none", "pushed", "person", "carried")
    )
    settings = disturbances.Settings()
    return [
        f"How the follower of Meng 2020, Sec. III-H, recovers (the paper has no such table): in "
        f"the middle of a recorded trajectory the car is pushed, turned, put down somewhere else "
        f"out of sight, or a person walks to and fro across its path. "
        f"{CONTEXTS[settings.context]}, p_sparsify = {settings.threshold:g}, "
        f"{results.worlds('disturbances')} test worlds; success is judged as in "
        f"navigation, and nobody is left out.",
        recoveries(rows),
        f"Undisturbed, {percent(none['finished'])} finish; pushed aside "
        f"{percent(pushed['finished'])} and with a person in the path "
        f"{percent(person['finished'])}, and the intervals overlap. Of the kidnapped "
        f"{percent(carried['soon'])} declare within {SOON:g} s that they are lost, "
        f"{percent(carried['lost'])} in the end.",
        f"Without doubts, a robot that gives up sooner when it is kidnapped also gives up sooner "
        f"behind a person, who hides as much of what it sees. But a person comes into sight little "
        f"by little, and one that was pushed or turned soon sees its anchors as before. So a robot "
        f"doubts (ours) where RE of its anchor falls by more than `fall` within a step, and is "
        f"lost unless RE of its anchor is above p_follow again within `timeout`. The table "
        f"compares thresholds on {results.worlds('disturbances_patience')} validation worlds; the "
        f"usual ones are in the first row.",
        patience(results.rows("disturbances_patience")),
    ]


SECTIONS = (
    Section("Fig. 7: cover rate and sparsity", ("meng_fig7",), _cover_section),
    Section("Fig. 5: placement of anchors", ("meng_fig5",), _placement_section),
    Section("Fig. 6: one rollout", ("meng_fig6",), _one_rollout_section),
    Section("Disturbances", ("disturbances", "disturbances_patience"), _disturbance_section),
)
