"""Does every loader name what is wrong with a file, and do nothing else?

    python -m tests.fuzz                            # 2,000 cases
    python -m tests.fuzz --cases 20000 --seed 7
    python -m tests.fuzz --only map                 # loaders whose name has this in it

Alters the files of each loader at random, or puts what once did harm in their place, and loads
them in a process that may compute for 10 s and grow by 1 GB for each. Prints a tally, and every
case that went wrong; ends with 1 if one did. The same seed gives the same cases.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterable

from tests.fuzz.outcome import BAD, GOOD, Outcome
from tests.fuzz.worker import outcomes


def tally(found: Iterable[Outcome]) -> str:
    """A table: for each loader what came of its cases, their longest time and largest size."""
    found = list(found)
    heads = "".join(f"{name:>9}" for name in (*GOOD, *BAD))
    lines = [f"{'loader':16}{heads}   max s  max MB"]
    names = list(dict.fromkeys(one.target for one in found))
    for name in [*names, "all"]:
        own = [one for one in found if name in (one.target, "all")]
        count = Counter(one.verdict for one in own)
        most = max(one.seconds for one in own), max(one.megabytes for one in own)
        cells = "".join(f"{count[verdict]:9,}" for verdict in (*GOOD, *BAD))
        lines.append(f"{name:16}{cells}{most[0]:8.2f}{most[1]:8.0f}")
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Run the cases and print what came of them."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--cases", type=int, default=2_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", metavar="NAME")
    options = parser.parse_args(arguments)
    print(f"seed {options.seed}", flush=True)
    found = []
    for number, outcome in enumerate(outcomes(options.seed, options.cases, options.only)):
        found.append(outcome)
        if outcome.verdict in BAD:
            print(f"case {number}: {outcome}", flush=True)
    print(tally(found))
    return int(any(one.verdict in BAD for one in found))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
