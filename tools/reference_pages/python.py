"""The page of the public names of the package ``graphnav``."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import graphnav
import graphnav.core.hooks
from graphnav import Message
from reference_pages.markdown import bullets, docstring, page

_INTRO = """\
The public names of `graphnav`. [From Python](../howto/python.md) shows how they are used; everything is typed.
Names that are not on this page are not public."""
_GROUPS = {
    "Run, look, compare": (
        *("run", "ablate", "load", "check", "draw", "open_log"),
        *("Run", "Study", "Log", "Graph", "Drawing", "Recording"),
    ),
    "Learn to drive": (
        *("make_env", "make_vec_env", "numeric_fields", "message_from", "numeric_layout", "NumericField"),
        "messages_by_name",
    ),
    "Write a stage": (
        *("Stage", "Source", "Message", "param", "Latest", "Since", "Stamped", "Stamp", "Age", "Finished", "Role"),
        *("Metric", "MEASURED", "UNDEFINED"),
        *("hookimpl", "Continuity", "block_mean", "block_sum", "coarsen"),
    ),
    "Write an adapter or a drawing": ("Adapter", "PictureContext", "Scene", "SceneArea", "VideoFrames"),
    "Read a file of your own": ("FileFormat", "Record", "key", "Range", "Value"),
    "Errors": (
        *("GraphnavError", "UserError", "ParamError", "DeclarationError", "FieldError", "RunError"),
        *("Problem", "Place", "did_you_mean", "shown_path"),
    ),
}
_RETURNED = {"Run", "Study", "Log", "Drawing", "RunError"}
"""Classes whose objects functions return: how they are constructed is not public."""
_FURTHER = "Further names"
_HOOKS = (
    "What a plugin may implement, each marked with `hookimpl`. "
    "An implementation may leave out arguments that it does not use."
)
_OF_OTHERS = {
    "hookimpl": "Marks a function of a plugin as the implementation of a hook, as `graphnav_stages` (pluggy)."
}


def python_page() -> str:
    """Return the page; a public name that is in no group stands in a group of its own."""
    grouped = {name for names in _GROUPS.values() for name in names}
    messages = [name for name in dir(graphnav) if _is_message(name)]
    rest = [name for name in dir(graphnav) if name not in {*grouped, *messages, "__version__"}]
    groups = {**_GROUPS, **({_FURTHER: tuple(rest)} if rest else {})}
    parts = ["\n\n".join([f"## {title}", *map(_section, names)]) for title, names in groups.items()]
    hooks = (value for value in vars(graphnav.core.hooks).values() if hasattr(value, "graphnav_spec"))
    asked = "\n\n".join(["## Hooks", _HOOKS, *(_section_of(hook) for hook in hooks)])
    linked = bullets(f"[{name}](messages.md#{name.lower()})" for name in messages)
    return page("Python", _INTRO, *parts, asked, f"## Messages\n\n{linked}", _VERSION)


_VERSION = "## Version\n\n`graphnav.__version__`: the installed version, as a string."


def _is_message(name: str) -> bool:
    value = getattr(graphnav, name)
    return inspect.isclass(value) and issubclass(value, Message) and value is not Message


def _section(name: str) -> str:
    value = getattr(graphnav, name)
    if name in _OF_OTHERS:
        return f"### {name}\n\n{_OF_OTHERS[name]}"
    if inspect.isclass(value) or inspect.isfunction(value):
        return _section_of(value)
    return f"### {name}\n\n{_doc_of_constant(name)}"


def _section_of(value: Any) -> str:
    """Return the section of a class or function, from its source."""
    (node,) = ast.parse(textwrap.dedent(inspect.getsource(value))).body
    return _class(node) if isinstance(node, ast.ClassDef) else _function(node, inspect.getdoc(value) or "")


def _function(node: Any, doc: str) -> str:
    return f"### {node.name}\n\n```python\n{_signature(node)}\n```\n\n{docstring(doc)}"


def _class(node: ast.ClassDef) -> str:
    made = next((one for one in node.body if isinstance(one, ast.FunctionDef) and one.name == "__init__"), None)
    is_called = made and made.args.args[1:] and node.name not in _RETURNED
    call = f"```python\n{_signature(made, node.name)}\n```" if made and is_called else ""
    parts = (f"### {node.name}", call, docstring(ast.get_docstring(node) or ""), bullets(_members(node)))
    return "\n\n".join(part for part in parts if part)


def _members(node: ast.ClassDef) -> Iterator[str]:
    """Yield a line for each public field, property and method."""
    for one, after in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name) and not one.target.id.startswith("_"):
            said = _constant(after)
            yield f"`{one.target.id}: {ast.unparse(one.annotation)}`" + (f": {_first(said)}" if said else "")
        elif isinstance(one, ast.FunctionDef) and not one.name.startswith("_"):
            is_property = any("property" in ast.unparse(mark) for mark in one.decorator_list)
            called = one.name if is_property else f"{one.name}({_arguments(one)})"
            returned = f" -> {ast.unparse(one.returns)}" if one.returns and not is_property else ""
            yield f"`{called}{returned}`: {_first(ast.get_docstring(one) or '')}"


def _constant(node: ast.stmt | None) -> str:
    """Return the string that stands alone in a statement, empty if it is something else."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
        return inspect.cleandoc(node.value.value)
    return ""


def _first(doc: str) -> str:
    """Return the first paragraph of a docstring in one line."""
    return " ".join(docstring(doc.partition("\n\n")[0]).split())


def _signature(node: ast.FunctionDef, name: str = "") -> str:
    """Return how a function or a class is called, an argument a line where it does not fit into one."""
    returned = f" -> {ast.unparse(node.returns)}" if node.returns and not name else ""
    arguments = _arguments(node)
    line = f"{name or node.name}({arguments}){returned}"
    if len(line) <= 100:
        return line
    spread = "".join(f"    {one},\n" for one in _each_argument(node))
    return f"{name or node.name}(\n{spread}){returned}"


def _arguments(node: ast.FunctionDef) -> str:
    return ", ".join(_each_argument(node))


def _each_argument(node: ast.FunctionDef) -> list[str]:
    """Return the arguments as they are declared, without ``self``."""
    given = node.args
    plain = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(plain) - len(given.defaults)) + list(given.defaults)
    made = [_argument(one, default) for one, default in zip(plain, defaults, strict=True)]
    made = made[1:] if plain and plain[0].arg in {"self", "cls"} else made
    if given.vararg:
        made.append(f"*{_argument(given.vararg, None)}")
    elif given.kwonlyargs:
        made.append("*")
    made += [_argument(one, default) for one, default in zip(given.kwonlyargs, given.kw_defaults, strict=True)]
    return made + ([f"**{_argument(given.kwarg, None)}"] if given.kwarg else [])


def _argument(argument: ast.arg, default: ast.expr | None) -> str:
    kind = f": {ast.unparse(argument.annotation)}" if argument.annotation else ""
    return f"{argument.arg}{kind}" + (f" = {ast.unparse(default)}" if default is not None else "")


def _doc_of_constant(name: str) -> str:
    """Return what the string below an assignment says, in the modules of stages, ports and metrics."""
    for module in map(inspect.getmodule, (graphnav.Stage, graphnav.Latest, graphnav.Metric)):
        assert module is not None
        body = ast.parse(inspect.getsource(module)).body
        for one, after in pairwise(body):
            targets = (
                one.targets if isinstance(one, ast.Assign) else [one.target] if isinstance(one, ast.AnnAssign) else []
            )
            if [ast.unparse(target) for target in targets] == [name]:
                return f"```python\n{ast.unparse(one)}\n```\n\n{docstring(_constant(after))}"
    raise LookupError(name)
