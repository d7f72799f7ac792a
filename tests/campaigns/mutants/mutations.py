"""The small changes of a module that a test should notice: one comparison, sign, number or statement at a time."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
"""What each comparison becomes: its limit moved, and the opposite."""

OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitOr: ast.BitAnd,
    ast.BitAnd: ast.BitOr,
}
"""What each operator becomes."""

FUNCTIONS = {"min": "max", "max": "min", "any": "all", "all": "any"}
"""What the call of a function becomes."""

BRANCHES = (ast.If, ast.IfExp, ast.While)

Change = Callable[[Any], None]
"""Changes one node in place."""


@dataclass(frozen=True)
class Mutation:
    """One change of a module."""

    number: int  # of the mutation among those of the module
    line: int  # in the file
    last_line: int  # in the file
    was: str  # the statement or expression, as source
    became: str  # what it was changed to, as source

    def __str__(self) -> str:
        return f"{self.line}: {self.was}  ->  {self.became}"


def mutations_of(source: str) -> list[Mutation]:
    """Return every mutation of a module by its `source`."""
    found = []
    for number, (node, change) in enumerate(_changes(ast.parse(source))):
        changed = copy.deepcopy(node)
        change(changed)
        place = node.test if isinstance(node, BRANCHES) else node
        lines = place.lineno, place.end_lineno or place.lineno
        found.append(Mutation(number, *lines, _brief(node), _brief(changed)))
    return found


def mutated(source: str, number: int) -> ast.Module:
    """Return the tree of a module by its `source`, with the mutation of a `number`."""
    tree = ast.parse(source)
    for place, (node, change) in enumerate(_changes(tree)):
        if place == number:
            change(node)
            return ast.fix_missing_locations(tree)
    raise IndexError(f"the module has no mutation {number}")


def _brief(node: ast.AST) -> str:
    line = " ".join(ast.unparse(node.test if isinstance(node, BRANCHES) else node).split())
    return line if len(line) <= 110 else f"{line[:107]}..."


def _changes(tree: ast.Module) -> Iterator[tuple[Any, Change]]:
    """Yield each node that can be changed, and the change; what is only for readers and type checkers is left alone."""
    for node, is_in_function in _code(tree, is_in_function=False):
        yield from ((node, change) for change in _changes_of_expression(node))
        if is_in_function:
            yield from _removals(node)


def _code(node: ast.AST, *, is_in_function: bool) -> Iterator[tuple[Any, bool]]:
    """Yield the nodes below a `node` that are run: no annotations, decorators, imports or docstrings."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, (ast.Import, ast.ImportFrom)) or _is_words(child):
                continue
            yield child, is_in_function
            inside = is_in_function or isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda))
            yield from _code(child, is_in_function=inside)


def _is_words(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _changes_of_expression(node: ast.AST) -> Iterator[Change]:
    if isinstance(node, ast.Compare):
        for place, operator in enumerate(node.ops):
            yield from (_set_entry("ops", place, other()) for other in COMPARISONS[type(operator)])
    elif isinstance(node, ast.BoolOp):
        yield _set("op", ast.Or() if isinstance(node.op, ast.And) else ast.And())
        yield from (_remove_entry("values", place) for place in range(len(node.values)) if len(node.values) > 2)
    elif isinstance(node, (ast.BinOp, ast.AugAssign)) and type(node.op) in OPERATORS:
        yield _set("op", OPERATORS[type(node.op)]())
    elif isinstance(node, ast.UnaryOp):
        yield _set("op", ast.UAdd()) if isinstance(node.op, ast.USub) else _negate_operand
    elif isinstance(node, BRANCHES):
        yield _negate_test
    elif isinstance(node, ast.Constant) and isinstance(node.value, (bool, int, float)):
        yield _set("value", _other_number(node.value))
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS:
        yield _set("func", ast.Name(FUNCTIONS[node.func.id], ast.Load()))


def _other_number(value: float) -> float:
    if isinstance(value, bool):
        return not value
    return value + 1 if isinstance(value, int) or value == 0.0 else 2.0 * value


def _removals(node: ast.AST) -> Iterator[tuple[Any, Change]]:
    """Yield the removal of each statement among those of a `node`."""
    if isinstance(node, (ast.Expr, ast.Assign, ast.AugAssign, ast.Raise, ast.Continue, ast.Break)):
        yield node, _become_pass
    elif isinstance(node, ast.Return) and node.value is not None and not _is_falsy(node.value):
        yield node, _set("value", ast.Constant(None))


def _is_falsy(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and not node.value


def _set(field: str, value: object) -> Change:
    return lambda node: setattr(node, field, value)


def _set_entry(field: str, place: int, value: object) -> Change:
    return lambda node: getattr(node, field).__setitem__(place, value)


def _remove_entry(field: str, place: int) -> Change:
    return lambda node: getattr(node, field).__delitem__(place)


def _negate_test(node: Any) -> None:
    node.test = ast.UnaryOp(ast.Not(), node.test)


def _negate_operand(node: Any) -> None:
    node.operand = ast.UnaryOp(ast.Not(), node.operand)


def _become_pass(node: Any) -> None:
    """Make a statement do nothing, in place: nothing but its class is changed."""
    node.__class__ = ast.Pass
    node._fields = ()
