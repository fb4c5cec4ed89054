import pytest

from tests.builder.test_notebooks import GOOD, WRONG
from tutorial_lib.builder import read
from tutorial_lib.builder.standard import MOST_GIVEN, minutes_of
from tutorial_lib.errors import InputError


def read_text(folder, text):
    source = folder / "09_double.py"
    source.write_text(text)
    (folder / "answers.py").write_text(WRONG)
    return read(source, folder / "answers.py")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("**30 minutes.**", "Half an hour.", r"\*\*N minutes"),
        ("https://arxiv.org/abs/1", "README.md", "no link to a paper"),
        ("`double` (large, 30 minutes)", "`double`", "no heading"),
        ("(large, 30 minutes)", "(easy, 30 minutes)", "no larger exercise"),
        ("(large, 30 minutes)", "(large, 20 minutes)", "no larger exercise"),
        ("Hint 2: approach", "Hint 2", "has no 'Hint 2: approach'"),
        ("What is half + half?", "<code>return half + x</code>", "gives a line away"),
        ("What is half + half?", "return (half+x)", "gives a line away"),
        ("Twice as much.", "Twice " + "as much " * 10, "is cut off: .*Twice"),
        ("\n# %%\ndouble =", "\n# %% hidden=true\nx = 1\n\n# %%\ndouble =", "begin with its title"),
        ("\n# %%\ndouble =", "\n# %%\n" + "x = 1\n" * 150 + "\n# %%\ndouble =", "stand open"),
    ],
)
def test_a_notebook_that_falls_behind_is_refused(tmp_path, old, new, words):
    assert GOOD.count(old) == 1
    with pytest.raises(InputError, match=words):
        read_text(tmp_path, GOOD.replace(old, new))


def test_what_is_folded_or_imported_may_be_long(tmp_path):
    folded = "\n# %% hidden=true\n# Long\n" + "x = 1\n" * (MOST_GIVEN + 1)
    assert read_text(tmp_path, GOOD + folded)


def test_the_minutes_are_those_at_the_top(tmp_path):
    source = tmp_path / "01_a.py"
    source.write_text("# # A\n#\n# **85 minutes.** More.\n")
    assert minutes_of(source) == "85"
    source.write_text("# # A\n#\n# **85 minutes, then 20.** More.\n")
    assert minutes_of(source) == "85 + 20"
    source.write_text("# # A\n")
    assert minutes_of(source) == ""
