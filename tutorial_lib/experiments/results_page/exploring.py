"""Exploring a place never seen: Neural Topological SLAM and what it is compared with."""

from __future__ import annotations

from itertools import product

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.nts.scores import PAIRS
from tutorial_lib.experiments.nts.table1 import PAPER as TABLE1
from tutorial_lib.experiments.nts.table2 import CONDITIONS, PAPER, PAPER_STANDARD
from tutorial_lib.experiments.protocols.exploration import AT_STEPS
from tutorial_lib.experiments.results_page.markdown import (
    Row,
    interval,
    number,
    percent,
    points,
    table,
    with_best_bold,
)
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, matching, one
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.learning.exploration_training import WITHIN
from tutorial_lib.learning.weights import load_card
from tutorial_lib.world.generators import SIGNS

AGENTS = {
    "nts": "NTS",
    "nts_no_graph": "NTS without a graph",
    "nts_no_score": "NTS, random scores",
    "nts_blind": "NTS, scores blind to the goal",
    "fbe": "nearest frontier",
    "ans_like": "learned choice of frontier",
    "il": "imitation",
    "random": "random walk",
    "oracle": "oracle",
}
"""How agents are called on the page."""
RL = {"target_rl": "target-driven RL", "map_rl": "metric map and RL"}
"""The paper's baselines that learn by reinforcement."""
LATER = "Part of the course's last notebook"
"""In place of what those reach here."""
SENSORS = {"rgbd": "with depth", "rgb": "without depth"}


def gap_of(row: Row, key: str) -> str:
    """A paired difference of shares and its interval.

    >>> gap_of({"gain": 0.1, "gain_low": 0.05, "gain_high": 0.2}, "gain")
    '+10.0 points (+5.0 to +20.0)'
    """
    low, high = (100 * row[f"{key}_{end}"] for end in ("low", "high"))
    return f"{points(row[key])} ({low:+.1f} to {high:+.1f})"


def choices(rows: Rows) -> str:
    """How often each score chooses the right direction, with depth; and F_S without."""
    lines = []
    for pairs, signs, difficulty in product(PAIRS, SIGNS, DIFFICULTIES):
        key = {"pairs": pairs, "signs": signs, "difficulty": difficulty}
        found = {row["score"]: row for row in matching(rows, sensor="rgbd", **key)}
        rgb = one(rows, sensor="rgb", score="semantic", **key)
        lines.append(
            [
                *(pairs, signs, difficulty, f"{rgb['decisions']:,}"),
                interval(found["semantic"], "top1"),
                *(percent(found[s]["top1"]) for s in ("masked", "blind", "histogram", "random")),
                *(gap_of(found[score], "gain") for score in ("masked", "blind", "histogram")),
                percent(rgb["top1"]),
            ]
        )
    head = ["pairs", "worlds", "goals", "decisions", "F_S", "masked", "blind", "colours", "random"]
    head += ["F_S - masked", "F_S - blind", "F_S - colours", "F_S without depth"]
    return table(head, lines)


def _score_section(results: Results) -> list[str]:
    rows = results.rows("nts_scores")
    mine = matching(rows, sensor="rgbd", signs="plain", score="semantic")
    decisions = {
        pairs: sum(row["decisions"] for row in matching(mine, pairs=pairs)) for pairs in PAIRS
    }

    asked = f"{decisions['unconnected']:,}"

    def gain(signs: str, level: str, pairs: str = "unconnected") -> str:
        key = {"signs": signs, "difficulty": level, "pairs": pairs}
        return points(one(rows, sensor="rgbd", score="blind", **key)["gain"])

    return [
        f"F_S scores the directions of a panorama by how near they lead to the goal of another. Is "
        f"its first choice right: is the path to the goal from that direction's end at most "
        f"{WITHIN:g} m longer than from the best one's? {decisions['all']:,} decisions in "
        f"{results.worlds('nts_scores')} test worlds, the same with and without signs. F_S is "
        f"asked only where the goal is in another node (Sec. 4.2): those {asked} "
        f"*unconnected* pairs come first. *Masked* is a network of the same recipe whose scores "
        f"learnt from unconnected pairs only, as the paper's do (appendix B); ours learn from all. "
        f"*Blind* is a network whose scores were trained without the goal; *colours* compares "
        f"histograms.",
        choices(rows),
        f"Between unconnected places, to see the goal is worth {gain('plain', 'medium')} on medium "
        f"decisions and {gain('plain', 'hard')} on hard ones in plain worlds, and "
        f"{gain('wayfinding', 'medium')} and {gain('wayfinding', 'hard')} where signs lead to it. "
        f"Over all pairs it is worth {gain('plain', 'easy', 'all')} on easy decisions: almost all "
        f"of those goals are in sight, where the robot asks F_R and not F_S.",
    ]


def success_and_spl(rows: Rows, signs: str) -> str:
    """Table 1 for one kind of worlds: success and SPL of every agent, the paper's beside them."""
    lines = []
    for sensor, words in SENSORS.items():
        mine = matching(rows, signs=signs, sensor=sensor)
        agents = [name for name in AGENTS if matching(mine, agent=name)]
        columns = []
        for difficulty in DIFFICULTIES:
            found = [one(mine, agent=name, difficulty=difficulty) for name in agents]
            values = [
                None if r["agent"] in ("oracle", "random") or len(found) == 1 else r["spl"]
                for r in found
            ]
            cells = [f"{percent(row['success'])} / {number(row['spl'])}" for row in found]
            columns.append(with_best_bold(cells, values))
        for number_of, name in enumerate(agents):
            paper = [
                f"{number(row['paper_success'], 2)} / {number(row['paper_spl'], 2)}"
                for row in (one(mine, agent=name, difficulty=level) for level in DIFFICULTIES)
                if row["paper_success"] is not None
            ]
            cells = [column[number_of] for column in columns]
            lines.append([AGENTS[name], words, *cells, ", ".join(paper)])
        for name, called in RL.items():
            if (name, sensor) in TABLE1:
                paper = [f"{success:.2f} / {spl:.2f}" for success, spl in TABLE1[name, sensor]]
                lines.append([called, words, LATER, "", "", ", ".join(paper)])
    return table(["agent", "sensor", *DIFFICULTIES, "paper"], lines)


def in_time(rows: Rows, signs: str) -> str:
    """Success within fewer steps."""
    lines = []
    for name in ("nts", "fbe", "ans_like"):
        found = [
            one(rows, agent=name, sensor="rgbd", signs=signs, difficulty=level)
            for level in DIFFICULTIES
        ]
        keys = (*(f"success_{steps}" for steps in AT_STEPS), "success")
        cells = [" / ".join(percent(row[key]) for key in keys) for row in found]
        lines.append([AGENTS[name], *cells])
    return table(["agent", *DIFFICULTIES], lines)


def spl_gap(
    results: Results, agent: str, signs: str, difficulty: str, report: str = "nts_table1"
) -> str:
    """The paired difference in SPL of NTS to another agent with depth, as its report says it."""
    what = f"SPL, nts (rgbd) - {agent} (rgbd), {signs}, {difficulty}: "
    return results.note(report, what)


def _table1_section(results: Results) -> list[str]:
    rows = results.rows("nts_table1")
    episodes = rows[0]["episodes"]
    worlds = results.worlds("nts_table1")
    easy = one(rows, agent="fbe", sensor="rgbd", signs="plain", difficulty="easy")
    differences = table(
        ["NTS - other, SPL", "worlds", *DIFFICULTIES],
        [
            [
                AGENTS[agent],
                signs,
                *(spl_gap(results, agent, signs, level) for level in DIFFICULTIES),
            ]
            for agent in ("fbe", "ans_like", "nts_no_score", "nts_blind")
            for signs in SIGNS
        ],
    )
    return [
        f"Image-goal navigation (Table 1 of Chaplot et al. 2020, *Neural Topological SLAM*): a "
        f"robot with a panorama in a place that it has never seen, the picture of a goal, 500 "
        f"actions with measured noise of motion and odometry; success is to stop within 1 m. "
        f"{episodes} episodes of each difficulty and kind of worlds in {worlds} test worlds, the "
        f"same for every agent. Cells are success / SPL. All agents but *imitation* and the "
        f"oracle have NTS's recognition of the goal and its local policy, as in the paper.",
        "Worlds with signs, whose accents follow the distance along the corridors:",
        success_and_spl(rows, "wayfinding"),
        "Plain worlds:",
        success_and_spl(rows, "plain"),
        f"In two dimensions a panorama shows much more of a place than a camera does in three: the "
        f"nearest frontier, which does not know the goal, finds {percent(easy['success'])} of the "
        f"easy ones. Paired differences on the same episodes, intervals over worlds:",
        differences,
        f"Success within {AT_STEPS[0]} / {AT_STEPS[1]} / 500 actions, with signs:",
        in_time(rows, "wayfinding"),
        "*Learned choice of frontier* stands for Active Neural SLAM, whose global policy is "
        "trained by reinforcement; ours is supervised with the true distances. *Imitation* is "
        "behaviour cloning with a recurrent network. Without depth NTS's learned one stands in; "
        "the nearest frontier has a row with measured depth only, as in the paper.",
    ]


def bodies(rows: Rows, cars: Rows) -> str:
    """Success and SPL of every agent with a car, and of the round robot beside it."""
    lines = []
    for signs in SIGNS:
        for name in dict.fromkeys(row["agent"] for row in cars):
            cells = []
            for level in DIFFICULTIES:
                key = {"agent": name, "sensor": "rgbd", "signs": signs, "difficulty": level}
                for row in (one(cars, **key), one(rows, **key)):
                    cells.append(f"{percent(row['success'])} / {number(row['spl'])}")
            lines.append([signs, AGENTS[name], *cells])
    head = [f"{level}, {body}" for level in DIFFICULTIES for body in ("car", "round")]
    return table(["worlds", "agent", *head], lines)


def _car_section(results: Results) -> list[str]:
    rows, cars = results.rows("nts_table1"), results.rows("nts_table1_car")
    key = {"agent": "nts", "sensor": "rgbd", "signs": "plain", "difficulty": "medium"}
    car, body = one(cars, **key), one(rows, **key)
    turned = results.note("nts_table1_car", "turned at their starts: ")
    return [
        f"The same agents in the course's car, which has the panorama and cannot turn in place: "
        f"instead of an action an agent gives a waypoint, and the motion policy drives to it in "
        f"pymunk, with three-point turns, for the half second in which the round robot drives one "
        f"action's 0.25 m; both have 0.5 m/s. {cars[0]['episodes']} episodes a cell, the same as "
        f"the round robot's; where the car did not fit into a start it was turned ({turned}).",
        bodies(rows, cars),
        f"On medium goals NTS in a car succeeds in {percent(car['success'])} and the round robot "
        f"in {percent(body['success'])}. Its paths are longer (SPL {number(car['spl'])} and "
        f"{number(body['spl'])}): SPL counts the metres of its turns, to and fro, and a robot "
        f"that turns in place has none.",
    ]


def stop_and_noise(results: Results) -> str:
    """Table 2: the paper's agents and ours, and what each gains in either."""
    rows, changed = results.rows("nts_table2"), list(CONDITIONS)[1:]
    lines = []
    for agent in ("nts", "ans_like", "fbe", *RL, "il"):
        usual, shares = PAPER_STANDARD[agent], [PAPER[agent, name][-1] for name in changed]
        cells = [percent(share, 0) for share in (usual, *shares)]
        called = (AGENTS | RL)[agent]
        lines.append([called, "the paper", *cells, *(points(share - usual) for share in shares)])
        if agent in RL:
            lines.append([called, LATER, *[""] * 5])
            continue
        for signs in SIGNS:
            overall = matching(rows, agent=agent, signs=signs, difficulty="overall")
            found = {row["condition"]: row for row in overall}
            note = f"{agent}, {signs}: {{}} - standard: "
            gains = [results.note("nts_table2", note.format(name)) for name in changed]
            cells = [percent(found[name]["success"]) for name in CONDITIONS]
            lines.append([called, signs, *cells, *gains])
    head = ["agent", "worlds", "standard", "without stop", "without noise"]
    return table([*head, "gain without stop", "gain without noise"], lines)


def _table2_section(results: Results) -> list[str]:
    rows, card = results.rows("nts_table2"), load_card("nts_rgbd").validation
    return [
        f"What stopping and what noise cost (Table 2 of Chaplot et al. 2020): success over all "
        f"difficulties where an episode ends near the goal by itself (a wrong stop still "
        f"ends it), and where motion and odometry are exact. {results.worlds('nts_table2')} test "
        f"worlds, {rows[0]['episodes']} episodes of each difficulty.",
        stop_and_noise(results),
        f"Both outcomes differ from the paper's. **Stopping** costs NTS 12 points there and none "
        f"here: no episode fails because a robot at its goal does not stop. On validation worlds "
        f"F_L has an AUC of {number(card['connection_auc'])} and F_R is wrong by "
        f"{number(card['distance_error'], 2)} m on average, where success needs 1 m. **Noise** "
        f"costs the nearest frontier 7 points there and Active Neural SLAM 10, by errors of pose "
        f"that accumulate (Sec. 6), and no agent much here; why, and why exact motion does worse "
        f"in places, is not known.",
    ]


SECTIONS = (
    Section("Scores of directions", ("nts_scores",), _score_section),
    Section("Table 1: image-goal navigation", ("nts_table1",), _table1_section),
    Section("Table 1 with a car", ("nts_table1_car",), _car_section),
    Section("Table 2: stopping and noise", ("nts_table2",), _table2_section),
)
