"""Complete ``--set`` and ``--vary``: stages, parameters, values, stage classes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphnav.develop.completion.index import Index

_TIMES = ("every_ms", "deadline_ms")


def override_candidates(text: str, uses: Mapping[str, str], index: Index, *, many: bool = False) -> Iterator[str]:
    """Yield completions of an override of a graph whose stages are of the classes ``uses``.

    ``many``: values are separated by commas, as in ``--vary``; the last one is completed.
    """
    target, equals, value = text.partition("=")
    if equals:
        done = value.rpartition(",")[0] + "," if many and "," in value else ""
        yield from (f"{target}={done}{one}" for one in _values(target.rstrip("+"), uses, index))
        return
    stage, dot, _ = text.partition(".")
    if not dot:
        yield from (f"{name}{sign}" for name in uses for sign in "=.")
        yield "run."
    elif stage == "run":
        yield from (f"run.{name}=" for name in index.run_options)
    elif stage in uses:
        use = uses[stage]
        yield from (f"{stage}.{name}=" for name in (*index.params.get(use, ()), *_TIMES))
        yield from (f"{stage}.in.{port}=" for port in index.ports.get(use, ()))


def _values(target: str, uses: Mapping[str, str], index: Index) -> Sequence[str]:
    stage, dot, param = target.partition(".")
    if not dot:
        family = uses.get(stage, "").partition(".")[0]
        return [use for use in index.params if use.partition(".")[0] == family or stage not in uses]
    if stage == "run":
        return index.run_options.get(param, [])
    if param.startswith("in."):
        return index.channels
    return index.params.get(uses.get(stage, ""), {}).get(param, [])
