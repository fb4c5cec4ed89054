"""What a stored result was made from, and whether it would still come out the same.

A result carries fingerprints of the networks and of the code that its run used, and a canary: the
rows of a few episodes. Where the code has changed since, the canary tells whether the numbers have.
"""

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from math import isclose
from multiprocessing import get_context
from typing import Any

from joblib import parallel_config

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.fingerprint import code_of
from tutorial_lib.experiments.common.report import Options, Report, Rows, finite
from tutorial_lib.experiments.registry import EXPERIMENTS
from tutorial_lib.learning.threads import processor
from tutorial_lib.learning.weights import LOADED, fingerprint_of, load_card

MODULE, CODE, NETWORKS = "module", "code", "networks"
CANARY, PROCESSOR = "canary", "processor"
"""What a report's `made_from` holds."""
ROUNDING = 1e-6
"""Share of a number by which kinds of processors may differ."""
FITS, UNKNOWN, NETWORK, CHANGED = "fits", "unknown", "network", "code"
"""How a result stands to the library of today."""


@dataclass(frozen=True)
class Standing:
    """How a stored result stands to the library of today.

    Attributes:
        kind: `FITS`; `UNKNOWN` where the result does not say what it was made from; `NETWORK` where
            a network was trained anew; `CHANGED` where code has changed.
        words: which.
    """

    kind: str
    words: str = ""


def standing_of(report: Report) -> Standing:
    """Compare the fingerprints of a result with the library's."""
    then = report.made_from
    if not then:
        return Standing(UNKNOWN, "does not say what it was made from")
    trained = [name for name, known in then[NETWORKS].items() if _network(name) != known]
    if trained:
        return Standing(NETWORK, f"{', '.join(trained)} trained anew")
    now = _code(then[MODULE])
    changed = [part for part in sorted(now | then[CODE]) if now.get(part) != then[CODE].get(part)]
    return Standing(CHANGED, f"code changed in {', '.join(changed)}") if changed else Standing(FITS)


@cache
def _code(module: str) -> dict[str, str]:
    return code_of(module)


@cache
def _network(name: str) -> str:
    """The fingerprint of a network of the library; empty where there is none."""
    try:
        return fingerprint_of(load_card(name))
    except InputError:
        return ""


def made_from(name: str, options: Options) -> dict[str, Any]:
    """Fingerprints of what an experiment's run uses, and its canary.

    The canary runs in a process of its own, which uses no network but the experiment's.

    Args:
        name: of the experiment's command.
        options: of its run.
    """
    with ProcessPoolExecutor(1, get_context("spawn")) as process:
        found = process.submit(_made_from_here, name, options).result()
    # Where there is no canary, this process may have run the experiment itself.
    networks = found[NETWORKS] if found[CANARY] else LOADED
    return found | {NETWORKS: dict(sorted(networks.items()))}


def _made_from_here(name: str, options: Options) -> dict[str, Any]:
    LOADED.clear()
    with parallel_config(backend="sequential"):  # so that all runs here, where networks are counted
        rows = finite(EXPERIMENTS[name].canary_rows(options))
    run = EXPERIMENTS[name].named(options.ablation).run
    module = getattr(run, "func", run).__module__  # of a partial, too
    return {
        MODULE: module,
        PROCESSOR: processor(),
        NETWORKS: dict(LOADED),
        CODE: code_of(module),
        CANARY: json.loads(json.dumps(rows)),  # as they are read again
    }


def checked(report: Report, name: str, options: Options) -> tuple[Report, str]:
    """Run the canary of a result whose code has changed.

    Another kind of processor rounds otherwise, and the drives of a canary carry that on: of its
    numbers six digits are compared, which are more than any page shows. Rows that differ by more
    may differ by that alone, too.

    Args:
        report: the result.
        name: of the experiment's command.
        options: that it was measured with.

    Returns:
        The report, with the fingerprints of today if its numbers are the same, and what differs.
    """
    then, now = report.made_from, made_from(name, options)
    if not (then[CANARY] and now[CANARY]):
        return report, "it has no canary that could tell whether its numbers changed"
    elsewhere = then[PROCESSOR] != now[PROCESSOR]
    different = changed_rows(then[CANARY], now[CANARY], ROUNDING if elsewhere else 0.0)
    if different and elsewhere:
        different += f"; but its canary is of another kind of processor, {then[PROCESSOR]}"
    return (report if different else replace(report, made_from=now)), different


def changed_rows(then: Rows, now: Rows, rounding: float = 0.0) -> str:
    """What differs first between two canaries; empty where nothing does.

    Args:
        then: rows.
        now: rows.
        rounding: share of a number by which it may differ.
    """
    if len(then) != len(now):
        return f"{len(now)} rows, not {len(then)}"
    for number, (old, new) in enumerate(zip(then, now, strict=True)):
        for key in old | new:
            if not _alike(old.get(key), new.get(key), rounding):
                return f"row {number}: {key} {old.get(key)!r:.20} is {new.get(key)!r:.20}"
    return ""


def _alike(old: object, new: object, rounding: float) -> bool:
    if isinstance(old, float) and isinstance(new, float):
        return isclose(old, new, rel_tol=rounding)
    return old == new
