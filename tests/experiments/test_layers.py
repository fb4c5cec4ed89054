"""Experiments share what they have in common through common and protocols, not with each other."""

from tests.project.test_layers import imports, read_library

BELOW = {
    "common": set(),
    "protocols": {"common"},
    "meng2020": {"common", "protocols"},
    "robustness": {"common", "protocols"},
    "benchmarks": {"common", "protocols"},
    "demos": {"common", "protocols"},
    "registry": {"common", "meng2020", "robustness", "benchmarks"},
}
PREFIX = "tutorial_lib.experiments."


def test_experiments_import_only_what_is_below_them():
    sources = {n: text for n, text in read_library().items() if n.startswith(PREFIX)}
    found = []
    for name, source in sources.items():
        part = name.removeprefix(PREFIX).split(".")[0]
        for other in imports(name, source, sources):
            theirs = other.removeprefix(PREFIX).split(".")[0]
            if other.startswith(PREFIX) and theirs not in BELOW[part] | {part}:
                found.append(f"{name} imports {other}")
    assert {name.removeprefix(PREFIX).split(".")[0] for name in sources} == set(BELOW)
    assert found == []
