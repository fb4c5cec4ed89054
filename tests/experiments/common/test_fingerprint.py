"""Fingerprints change with the code that runs, and with nothing else."""

import ast

import pytest

from tutorial_lib.experiments.common.fingerprint import code_of, imported, plain_code

FILES = {
    "__init__.py": "",
    "world/__init__.py": "",
    "world/rays.py": 'FAR = 10.0  # metres\n\n\ndef cast():\n    """Cast."""\n    return FAR\n',
    "world/unused.py": "FAR = 5.0\n",
    "study/__init__.py": "",
    "study/table.py": "from house.world import rays\n\n\ndef run():\n    return rays.cast()\n",
}


def library(folder, **changed):
    """A package in files, some of them changed."""
    for name, text in FILES.items():
        path = folder / "house" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        key = "version" if name == "__init__.py" else path.stem
        path.write_text(changed.get(key, text))
    return folder / "house"


def prints(tmp_path, **changed):
    """Fingerprints of the study's code in a changed library."""
    folder = tmp_path / ("_".join(changed) or "as_it_is")
    return code_of("house.study.table", library(folder, **changed))


def test_what_a_module_imports_counts_with_its_packages(tmp_path):
    found = imported("house.study.table", library(tmp_path))
    wanted = ("house", "house.study", "house.study.table", "house.world", "house.world.rays")
    assert sorted(found) == sorted(wanted)


def test_a_changed_number_changes_the_fingerprint_of_its_part_alone(tmp_path):
    then = prints(tmp_path)
    now = prints(tmp_path, rays=FILES["world/rays.py"].replace("10.0", "11.0"))
    assert [part for part in then if then[part] != now[part]] == ["world"]


@pytest.mark.parametrize(
    "text",
    [
        FILES["world/rays.py"].replace("Cast.", "Cast one ray.\n\n    It ends at a wall.\n    "),
        FILES["world/rays.py"].replace("# metres", "# metres, as the laser's"),
        FILES["world/rays.py"].replace("\n\n\n", "\n\n# Rays.\n\n\n\n"),
    ],
)
def test_words_change_no_fingerprint(tmp_path, text):
    assert prints(tmp_path) == prints(tmp_path, rays=text)


def test_another_version_is_no_other_code(tmp_path):
    assert prints(tmp_path) == prints(tmp_path, version="__version__ = '2'\n")


def test_what_does_not_run_changes_no_fingerprint(tmp_path):
    assert prints(tmp_path) == prints(tmp_path, unused="FAR = 6.0\n")


def test_a_renamed_variable_is_another_code(tmp_path):
    renamed = FILES["world/rays.py"].replace("FAR", "REACH")
    assert prints(tmp_path) != prints(tmp_path, rays=renamed)


@pytest.mark.parametrize(
    ("source", "code"),
    [
        ("a = '#'  # b", "a = '#'"),
        ('a = "it\'s # one"', 'a = "it\'s # one"'),
        ('a = """\n# not a comment\n"""', 'a = """\n# not a comment\n"""'),
        ('def f():\n    """Nothing."""\n', "def f():\n    ..."),
        ('A = 1\n"""Of what is counted."""\nB = 2', "A = 1\n...\nB = 2"),
    ],
)
def test_plain_code(source, code):
    assert plain_code(source, ast.parse(source)) == code
