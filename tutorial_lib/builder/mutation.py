"""Small changes to a solution, each of which should make it wrong.

The operators are those of mutation testing (A. J. Offutt et al., 1996): another comparison or
boolean operator, another constant, one more or one less, another arithmetic operator, a related
function, exchanged or dropped arguments, a dropped bound, branch or statement.
"""

import ast
from collections.abc import Callable, Iterator
from typing import Any

_COMPARE: dict[type, tuple[type, ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_ARITHMETIC: dict[type, type] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Div,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
_SWAPS = (
    *(("sin", "cos"), ("tan", "sin"), ("min", "max"), ("minimum", "maximum"), ("any", "all")),
    *(("argmin", "argmax"), ("zeros", "ones"), ("floor", "ceil"), ("log", "exp"), ("sum", "mean")),
    *(("fmin", "fmax"), ("hypot", "arctan2"), ("append", "extend")),
)
_SYMMETRIC = {"min", "max", "minimum", "maximum", "fmin", "fmax", "hypot", "add", "multiply"}
_TINY = 1e-6
"""Constants up to here only guard against rounding."""
_RELATED = {**dict(_SWAPS), **{second: first for first, second in _SWAPS}}


def changes(code: str, within: range) -> Iterator[tuple[str, str]]:
    """Every changed code, and what was changed: ``old line -> new line``.

    Args:
        code: that defines functions.
        within: the numbers of the lines that may change, from 1.
    """
    tree = ast.parse(code)
    seen, names = {ast.unparse(tree)}, {}
    for statement, old, swap in _all_swaps(tree, within):
        restore = swap()
        try:
            changed, new = ast.unparse(ast.fix_missing_locations(tree)), _line(statement())
        finally:
            restore()
        if changed in seen:
            continue
        seen.add(changed)
        name = f"{old} -> {new}"
        names[name] = names.get(name, 0) + 1
        yield changed, name if names[name] == 1 else f"{name} ({names[name]})"


_Swap = Callable[[], Callable[[], None]]
"""Makes a change, and returns what undoes it."""
_Holder = ast.AST | list[Any]
"""Where an expression stands: in a field of a node, by its name, or in a list, by its number."""


def _all_swaps(
    tree: ast.Module, within: range
) -> Iterator[tuple[Callable[[], ast.stmt], str, _Swap]]:
    """For each change: the statement in which it lies as it then is, as it was, and the change."""
    for parent in ast.walk(tree):
        for field in ("body", "orelse"):
            statements = getattr(parent, field, None)
            if not isinstance(statements, list):
                continue
            for i, statement in enumerate(statements):
                if statement.lineno not in within or isinstance(statement, ast.FunctionDef):
                    continue
                for new in (*_statements(statement), *_deleted(statement)):
                    yield (
                        lambda statements=statements, i=i: statements[i],
                        _line(statement),
                        _exchange(statements, i, new),
                    )
                for holder, key, node in _slots(statement):
                    for other in _expressions(node):
                        swap = _exchange(holder, key, other)
                        yield (lambda statement=statement: statement), _line(statement), swap


def _exchange(holder: _Holder, key: Any, new: object) -> _Swap:  # noqa: ANN401 - see `_Holder`
    def put(value: object) -> None:
        if isinstance(holder, list):
            holder[key] = value
        else:
            setattr(holder, key, value)

    def swap() -> Callable[[], None]:
        old = holder[key] if isinstance(holder, list) else getattr(holder, key)
        put(new)
        return lambda: put(old)

    return swap


def _slots(node: ast.AST) -> Iterator[tuple[_Holder, str | int, ast.AST]]:
    """Where the expressions of one statement stand, without those of statements within it."""
    for field, value in ast.iter_fields(node):
        if isinstance(value, list):
            for i, item in enumerate(value):
                if isinstance(item, ast.AST) and not isinstance(item, ast.stmt):
                    yield value, i, item
                    yield from _slots(item)
        elif isinstance(value, ast.AST) and not isinstance(value, ast.stmt):
            yield node, field, value
            yield from _slots(value)


def _line(statement: ast.stmt) -> str:
    """The first line of a statement."""
    return ast.unparse(statement).splitlines()[0]


def _deleted(statement: ast.stmt) -> list[ast.stmt]:
    if isinstance(statement, ast.Return | ast.Pass | ast.Import | ast.ImportFrom):
        return []
    return [ast.copy_location(ast.Pass(), statement)]


def _statements(statement: ast.stmt) -> list[ast.stmt]:
    """Other statements in place of one."""
    new: list[ast.stmt] = []
    if isinstance(statement, ast.If):
        body, orelse = statement.body, statement.orelse
        new += [ast.If(ast.Constant(known), body, orelse) for known in (True, False)]
    if isinstance(statement, ast.AugAssign):
        target = ast.Name(statement.target.id) if isinstance(statement.target, ast.Name) else None
        new += [ast.Assign([target or statement.target], statement.value, lineno=statement.lineno)]
        other = _ARITHMETIC.get(type(statement.op))
        new += [ast.AugAssign(statement.target, other(), statement.value)] if other else []
    if isinstance(statement, ast.Break):
        new.append(ast.Continue())
    if isinstance(statement, ast.Continue):
        new.append(ast.Break())
    return [ast.copy_location(item, statement) for item in new]


def _expressions(node: ast.AST) -> list[ast.AST]:
    """Other expressions in place of one."""
    if isinstance(node, ast.Compare):
        return _comparisons(node)
    if isinstance(node, ast.BoolOp):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        return [ast.BoolOp(other, node.values), *node.values]
    if isinstance(node, ast.UnaryOp):
        return [node.operand]
    if isinstance(node, ast.BinOp):
        return _arithmetic(node)
    if isinstance(node, ast.Constant):
        return [ast.Constant(value) for value in _constants(node.value)]
    if isinstance(node, ast.Call):
        return _calls(node)
    if isinstance(node, ast.Slice):
        parts = (node.lower, node.upper, node.step)
        return [ast.Slice(*(None if p is part else p for p in parts)) for part in parts if part]
    if isinstance(node, ast.IfExp):
        return [node.body, node.orelse]
    if isinstance(node, ast.comprehension) and node.ifs:
        return [ast.comprehension(node.target, node.iter, [], node.is_async)]
    return []


def _comparisons(node: ast.Compare) -> list[ast.AST]:
    return [
        ast.Compare(node.left, [*node.ops[:i], other(), *node.ops[i + 1 :]], node.comparators)
        for i, operator in enumerate(node.ops)
        for other in _COMPARE[type(operator)]
    ]


def _arithmetic(node: ast.BinOp) -> list[ast.AST]:
    new: list[ast.AST] = [node.left, node.right]
    other = _ARITHMETIC.get(type(node.op))
    if other:
        new.append(ast.BinOp(node.left, other(), node.right))
    if isinstance(node.op, ast.MatMult | ast.Sub | ast.Div):
        new.append(ast.BinOp(node.right, node.op, node.left))
    return new


def _constants(value: object) -> list[float]:
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1, value - 1]
    if isinstance(value, float) and not 0 < abs(value) <= _TINY:
        return [2 * value + (value == 0), value / 2 - (value == 0)]
    return []


def _calls(node: ast.Call) -> list[ast.AST]:
    new: list[ast.AST] = []
    name = getattr(node.func, "id", getattr(node.func, "attr", ""))
    if name in _RELATED:
        value, other = getattr(node.func, "value", None), _RELATED[name]
        renamed = ast.Attribute(value, other) if value is not None else ast.Name(other)
        new.append(ast.Call(renamed, node.args, node.keywords))
    for i in range(0 if name in _SYMMETRIC else len(node.args) - 1):
        swapped = [*node.args[:i], node.args[i + 1], node.args[i], *node.args[i + 2 :]]
        new.append(ast.Call(node.func, swapped, node.keywords))
    for i in range(len(node.keywords)):
        rest = [*node.keywords[:i], *node.keywords[i + 1 :]]
        new.append(ast.Call(node.func, node.args, rest))
    if node.args and not isinstance(node.args[0], ast.Starred | ast.GeneratorExp):
        new.append(node.args[0])
    return new
