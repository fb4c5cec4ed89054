from importlib import metadata

from tutorial_lib.checks.nb00 import environment


def test_here_nothing_is_missing(capsys):
    assert environment.check_environment()
    assert "ready to go" in capsys.readouterr().out


def test_what_is_missing_or_old_is_named_with_its_fix(monkeypatch, capsys):
    real = metadata.version

    def version(name):
        if name == "numba":
            raise metadata.PackageNotFoundError(name)
        return "1.0" if name == "numpy" else real(name)

    monkeypatch.setattr(environment.metadata, "version", version)
    assert not environment.check_environment()
    said = capsys.readouterr().out
    assert "numba is missing" in said
    assert "numpy 1.0 does not fit >=1.26" in said
    assert said.count("fix: in the course's folder: python3 start.py setup") == 2


def test_packages_that_only_the_tests_need_are_not_required(monkeypatch):
    required = []
    real = metadata.version
    monkeypatch.setattr(environment.metadata, "version", lambda n: required.append(n) or real(n))
    assert environment.find_faults() == []
    assert "numpy" in required
    assert "pytest" not in required


def test_a_course_that_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr(environment, "PROJECT", "no-such-course")
    assert environment.find_faults() == ["the course itself is not installed in this Python"]
