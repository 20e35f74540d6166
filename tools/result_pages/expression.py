"""Evaluate an expression over the results of a study: comparisons of numbers and of a few functions, nothing else."""

from __future__ import annotations

import ast
import inspect
import operator
from collections.abc import Callable, Iterator, Mapping
from functools import partial

from graphnav.core.errors import UserError
from result_pages.functions import FUNCTIONS
from result_pages.shipped_results import NotMeasuredError, ShippedResults

_ARITHMETIC: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_COMPARISONS: Mapping[type[ast.cmpop], Callable[[object, object], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: lambda a, b: _number(a) < _number(b),
    ast.LtE: lambda a, b: _number(a) <= _number(b),
    ast.Gt: lambda a, b: _number(a) > _number(b),
    ast.GtE: lambda a, b: _number(a) >= _number(b),
}


_DIGITS = "digits"
"""The parameter of a function that says how a value is printed, not what it is."""


class MissingError(ValueError):
    """The case of an expression was not run, or none of its runs has the metric."""


def evaluate(expression: str, results: ShippedResults) -> object:
    """Return the value of an expression.

    Raises
    ------
    MissingError
        It can be read, but there is no such run, or no run that has the metric.
    ValueError
        It cannot be read, or names what the results do not have.
    """
    try:
        return _value(ast.parse(expression, mode="eval").body, results)
    except (SyntaxError, TypeError, ZeroDivisionError) as error:
        raise ValueError(f"cannot be read: {error}") from None
    except NotMeasuredError as error:
        raise MissingError(str(error)) from None
    except UserError as error:
        raise ValueError(str(error)) from None


def left_side(expression: str) -> str:
    """Return what stands before the first comparison of an expression that can be read; all of it without one."""
    compared = [node for node in ast.walk(ast.parse(expression, mode="eval")) if isinstance(node, ast.Compare)]
    first = min(compared, key=lambda node: node.col_offset, default=None)
    return expression if first is None else str(ast.get_source_segment(expression, first.left))


def without_digits(expression: str) -> str:
    """Return an expression without the numbers of digits that it rounds to; unchanged if it cannot be read."""
    text = expression.encode()
    try:
        nodes = list(ast.walk(ast.parse(expression, mode="eval")))
    except SyntaxError:
        return expression
    for digits in (node for call in nodes if isinstance(call, ast.Call) for node in _digits_of(call)):
        begin, end = digits.col_offset, digits.end_col_offset or digits.col_offset
        text = text[:begin] + b" " * (end - begin) + text[end:]
    return text.decode()


def _digits_of(call: ast.Call) -> Iterator[ast.expr]:
    function = FUNCTIONS.get(call.func.id) if isinstance(call.func, ast.Name) else None
    if function is None or _DIGITS not in (names := list(inspect.signature(function).parameters)):
        return
    yield from call.args[names.index(_DIGITS) - 1 :][:1]
    yield from (one.value for one in call.keywords if one.arg == _DIGITS)


def _value(node: ast.expr, results: ShippedResults) -> object:
    of = partial(_value, results=results)
    match node:
        case ast.Constant(value=int() | float() | str() | bool() as value):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_number(of(operand))
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return not of(operand)
        case ast.BinOp(left=left, op=kind, right=right) if type(kind) in _ARITHMETIC:
            return _ARITHMETIC[type(kind)](_number(of(left)), _number(of(right)))
        case ast.BoolOp(op=kind, values=values):
            return (all if isinstance(kind, ast.And) else any)(of(value) is True for value in values)
        case ast.Compare(left=left, ops=kinds, comparators=rest) if all(type(kind) in _COMPARISONS for kind in kinds):
            found = [of(left), *map(of, rest)]
            return all(_COMPARISONS[type(kind)](a, b) for kind, a, b in zip(kinds, found, found[1:], strict=False))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=keywords) if name in FUNCTIONS:
            return FUNCTIONS[name](results, *map(of, args), **{str(one.arg): of(one.value) for one in keywords})
    raise ValueError(f"'{ast.unparse(node)}' is not allowed; functions: {', '.join(FUNCTIONS)}")


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r} is not a number")
    return value
