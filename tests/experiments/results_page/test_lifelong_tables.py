"""Tables of maps that mend themselves."""

from tests.experiments.results_page.tables import cells
from tutorial_lib.experiments.common.report import Finding
from tutorial_lib.experiments.results_page.lifelong import differences, size


def test_maps_of_other_thresholds_have_a_line_for_each_d_m():
    rows = [
        {"family": family, "merge": merge, "connect": connect, "vertices": 100 * merge + connect}
        | {"success": merge / 2, "low": 0.1, "high": 0.9, "edges": 1_000 * connect}
        for family in ("others", "loop_corridor")
        for merge in (1.0, 0.4)
        for connect in (3.0, 2.0)
    ]
    found = cells(size(rows))
    assert found[0] == ["worlds", "D_m", "vertices", "D_c = 2.0 m", "D_c = 3.0 m"]
    assert found[1][:3] == ["apartments and offices", "0.4 m", "43"]
    assert found[1][3:] == [f"20.0% (10.0 to 90.0), {edges} edges" for edges in ("2,000", "3,000")]
    assert [line[:2] for line in found[3:]] == [["loop corridors", m] for m in ("0.4 m", "1.0 m")]


def test_differences_are_said_in_the_page_s_words_and_chosen_by_their_queries():
    found = [
        Finding(f"others, queries {some}, network: ltvn - no_trust", 0.1, 0.05, 0.2)
        for some in ("1 to 100", "51 to 100", "1 to 1000")
    ]
    line = ["apartments and offices", "1 to 100", "network", "LTVN", "no arrival is trusted"]
    assert cells(differences(found, "queries 1 to 100"))[1:] == [
        [*line, "+10.0 points (+5.0 to +20.0)"]
    ]
    assert len(cells(differences(found))) == 4
