"""Fingerprints of the library's code, by which a stored result tells whether it still fits.

Comments, docstrings and blank lines do not count: they change no number.
"""

import ast
import re
from collections import defaultdict
from functools import cache
from hashlib import sha256
from pathlib import Path

LIBRARY = Path(__file__).resolve().parents[2]
_STRING_OR_COMMENT = re.compile(
    r'''("""(?:\\.|[^\\])*?"""|'{3}(?:\\.|[^\\])*?'{3}'''
    r"""|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')|#[^\n]*""",
    re.DOTALL,
)
_DIGITS = 12  # of a fingerprint: as many as tell one version from another


def code_of(module: str, library: Path = LIBRARY) -> dict[str, str]:
    """Fingerprints of the code that a module runs, by part of the library; its version is none.

    Args:
        module: whole name of a module of the library; what it imports, at its top or within, runs
            with it.
        library: folder of the package.
    """
    parts: dict[str, list[str]] = defaultdict(list)
    for name, code in sorted(imported(module, library).items()):
        if name != library.name:
            parts[name.split(".")[1]].append(f"{name}\n{code}")
    return {part: _fingerprint("\n".join(codes)) for part, codes in sorted(parts.items())}


def imported(module: str, library: Path = LIBRARY) -> dict[str, str]:
    """The plain code of all modules that run where a module is imported, by their whole names."""
    found, left = dict[str, str](), [module]
    while left:
        name = left.pop()
        read = None if name in found else _read(name, library)
        if read is not None:
            found[name], imports = read
            left += [name.rpartition(".")[0], *imports]
    return found


def plain_code(source: str, tree: ast.AST) -> str:
    """A module's code without comments, blank lines, and what docstrings say.

    >>> plain_code(two := "two = 1 + 1  # or 2", ast.parse(two))
    'two = 1 + 1'
    """
    lines = _STRING_OR_COMMENT.sub(lambda found: found[1] or "", source).splitlines()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(getattr(node.value, "value", None), str):
            first, last = node.lineno - 1, node.end_lineno or node.lineno
            lines[first:last] = ["" for _ in lines[first:last]]
            lines[first] = node.col_offset * " " + "..."
    return "\n".join(line.rstrip() for line in lines if line.strip())


@cache
def _read(name: str, library: Path) -> tuple[str, tuple[str, ...]] | None:
    """A module's plain code and the names that it imports; None where there is no such module.

    Of ``from a import b`` both a and a.b are named, which may be a module.
    """
    path = library.parent.joinpath(*name.split("."))
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    if name.split(".")[0] != library.name or not file.is_file():
        return None
    source, found = file.read_text(encoding="utf-8"), list[str]()
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return plain_code(source, tree), tuple(found)


def _fingerprint(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:_DIGITS]
