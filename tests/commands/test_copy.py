"""Pages are copied once, kept where they were changed, and made new where they were not."""

import pytest

from tutorial_lib.cli import main
from tutorial_lib.commands import copy
from tutorial_lib.errors import InputError

NAMES = ("README.md", "notebooks/01_first.ipynb")


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """The folder of installed pages, and one to copy to."""
    source, folder = tmp_path / "share", tmp_path / "a course"
    (source / "notebooks").mkdir(parents=True)
    write(source, "first")
    monkeypatch.setattr(copy, "is_checkout", lambda: False)
    monkeypatch.setattr(copy, "_pages", lambda: {name: source / name for name in NAMES})
    return source, folder


def write(folder, text):
    for name in NAMES:
        (folder / name).write_text(f"{name} {text}")


def state(folder):
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {
        path.relative_to(folder).as_posix(): (path.read_text(), path.stat().st_mtime_ns)
        for path in files
    }


def test_a_second_copy_changes_nothing(installed):
    _, folder = installed
    assert copy.copy_pages(folder) == []
    before = state(folder)
    assert set(before) == {*NAMES, ".topological-navigation.json"}
    assert before["README.md"][0] == "README.md first"
    assert copy.copy_pages(folder) == []
    assert state(folder) == before


def test_what_was_deleted_comes_again(installed):
    _, folder = installed
    copy.copy_pages(folder)
    (folder / NAMES[1]).unlink()
    assert copy.copy_pages(folder) == []
    assert (folder / NAMES[1]).exists()


def test_a_newer_version_replaces_only_what_was_not_changed(installed):
    source, folder = installed
    copy.copy_pages(folder)
    (folder / NAMES[1]).write_text("my work")
    assert copy.copy_pages(folder) == []  # there is nothing newer
    write(source, "second")
    for _ in range(2):
        assert copy.copy_pages(folder) == [NAMES[1]]
        assert (folder / NAMES[0]).read_text() == "README.md second"
        assert (folder / NAMES[1]).read_text() == "my work"


def test_files_that_were_there_before_are_kept(installed, monkeypatch, capsys):
    _, folder = installed
    folder.mkdir()
    (folder / "README.md").write_text("of another project")
    assert main(["copy", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "kept your README.md" in said
    assert (folder / "README.md").read_text() == "of another project"
    assert (folder / NAMES[1]).exists()


@pytest.mark.parametrize("text", ["", "[]", "{", "\x00", '{"README.md": 3}'])
def test_damaged_notes_cost_no_work(installed, text):
    source, folder = installed
    copy.copy_pages(folder)
    (folder / ".topological-navigation.json").write_text(text)
    (folder / "README.md").write_text("my work")
    write(source, "second")
    assert "README.md" in copy.copy_pages(folder)
    assert (folder / "README.md").read_text() == "my work"


def test_in_a_checkout_nothing_is_copied(tmp_path):
    with pytest.raises(InputError, match="the checkout; open them there"):
        copy.copy_pages(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_installation_without_pages_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(copy, "is_checkout", lambda: False)
    monkeypatch.setattr(copy.metadata, "files", lambda name: None)
    with pytest.raises(InputError, match="pages are missing; install the course again"):
        copy.copy_pages(tmp_path)
