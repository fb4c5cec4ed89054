"""What is run for the project: GitHub's workflow, and the hooks before a commit."""

import re
from pathlib import Path

import yaml

PROJECT = Path(__file__).resolve().parents[2]
WORKFLOW = yaml.safe_load((PROJECT / ".github" / "workflows" / "tests.yml").read_text())
HOOKS = yaml.safe_load((PROJECT / ".pre-commit-config.yaml").read_text())


def test_the_tests_run_on_every_system_and_python_that_is_named():
    named = re.findall(r"Python :: (3\.\d+)", (PROJECT / "pyproject.toml").read_text())
    strategy = WORKFLOW["jobs"]["tests"]["strategy"]
    assert strategy["matrix"]["python"] == named
    assert [system.split("-")[0] for system in strategy["matrix"]["os"]] == [
        "ubuntu",
        "macos",
        "windows",
    ]
    assert strategy["fail-fast"] is False


def test_what_is_slow_runs_nightly():
    assert WORKFLOW[True]["schedule"]  # YAML 1.1 reads the key "on" so
    (step,) = [step["run"] for step in WORKFLOW["jobs"]["full"]["steps"] if "run" in step]
    assert step == "python start.py test --full"


def test_the_hooks_keep_style_size_and_notebooks():
    hooks = [hook for repository in HOOKS["repos"] for hook in repository["hooks"]]
    names = ("check-added-large-files", "end-of-file-fixer", "trailing-whitespace")
    assert [hook["id"] for hook in hooks] == [
        *names,
        "ruff-check",
        "ruff-format",
        "pyrefly",
        "notebooks",
    ]
    assert all(re.compile(hook.get("files", "")) for hook in hooks)
