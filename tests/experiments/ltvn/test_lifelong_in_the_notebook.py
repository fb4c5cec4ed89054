"""What notebook 08 says of lives in eight buildings is what was measured."""

from pathlib import Path

import numpy as np

from tutorial_lib.experiments import load_result

PROJECT = Path(__file__).resolve().parents[3]
TEXT = (PROJECT / "solutions" / "08_lifelong_maps.py").read_text(encoding="utf-8")


def test_what_is_said_of_eight_buildings_was_measured():
    rows = {
        (row["agent"], row["family"], row["block"]): row
        for row in load_result("ltvn_lifelong").rows
        if row["perception"] == "network"
    }

    def gain(family, blocks):
        return 100 * np.mean(
            [
                rows["ltvn", family, block]["success"] - rows["frozen", family, block]["success"]
                for block in blocks
            ]
        )

    late, families = (2, 3), {"others": 250 / 400, "loop_corridor": 150 / 400}
    assert "is ahead by three or four trips in a hundred" in TEXT
    assert 2.5 < sum(share * gain(name, late) for name, share in families.items()) < 4.5
    assert abs(sum(share * gain(name, (0, 1)) for name, share in families.items())) < 2
    assert "in the five ordinary buildings the two stay level" in TEXT
    assert abs(gain("others", late)) < 2 < 5 < gain("loop_corridor", late)
    assert "the map nearly doubles" in TEXT
    for name in families:
        grown = rows["ltvn", name, 9]["vertices"] / rows["frozen", name, 0]["vertices"]
        assert 1.6 < grown < 2
