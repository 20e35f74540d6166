"""Output formats of ``graphnav echo``: text, JSON lines, CSV."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from graphnav import GraphnavError
from graphnav.core.codec import lcm_name
from graphnav.core.errors import printable, shown_name
from graphnav.core.field_summary import described, summarised
from graphnav.core.notices import print_notice
from graphnav.watch.feed import Received
from graphnav.watch.fields.field_columns import Selection, all_columns, columns_of
from graphnav.watch.fields.field_path import MISSING, FieldPath
from graphnav.watch.fields.plain_values import nested, plain
from graphnav.watch.spy import size_of


class EchoedMessage(NamedTuple):
    """A message and its decoded fields; ``values`` is None if it cannot be decoded."""

    received: Received
    type_name: str | None
    lcm_class: type | None
    values: Mapping[str, Any] | None


class Lines:
    """Text: one line per message and one per field."""

    def __init__(self, selection: Selection, _epoch_s: float, *, full: bool) -> None:
        self._selection, self._full = selection, full

    def show(self, message: EchoedMessage) -> bool:
        """Print a message; return whether anything was printed."""
        size = size_of(len(message.received.data))
        head = f"{shown_name(message.received.channel)}  {shown_name(message.type_name or 'unknown type')}, {size}"
        print("\n".join([head, *self._contents(message)]), flush=True)
        return True

    def close(self) -> None:
        """Do nothing: every message was printed."""

    def _contents(self, message: EchoedMessage) -> list[str]:
        if message.lcm_class is None:
            return ["    its type is not known: --types PACKAGE_OR_DIR, or --plugin FILE"]
        if message.values is None:
            return ["    undecodable"]
        fields = self._selection.of(message.lcm_class, message.values)
        if fields is None:
            return ["    another type: it has no such fields"]
        return described(nested(fields) if self._full else summarised(fields))


class JsonLines:
    """One JSON object per message; ``at_s``: arrival or recording time, ``fields``: null if unknown."""

    def __init__(self, selection: Selection, epoch_s: float, *, full: bool) -> None:
        self._selection, self._epoch_s, self._full = selection, epoch_s, full

    def show(self, message: EchoedMessage) -> bool:
        """Print a message; return whether anything was printed."""
        fields = None
        if message.values is not None and message.lcm_class is not None:
            fields = self._selection.of(message.lcm_class, message.values)
        if fields is not None:
            fields = plain(fields if self._full else summarised(fields))
        told = {
            "at_s": round(self._epoch_s + message.received.at_s, 6),
            "type": message.type_name,
            "bytes": len(message.received.data),
            "fields": fields,
        }
        print(json.dumps(told), flush=True)
        return True

    def close(self) -> None:
        """Do nothing: every message was printed."""


class CsvRows:
    """One row per message: arrival or recording time, then fields; the first message determines the columns."""

    def __init__(self, paths: Sequence[FieldPath], epoch_s: float) -> None:
        self._paths, self._epoch_s = paths, epoch_s
        self._writer = csv.writer(sys.stdout, lineterminator="\n")
        self._columns: list[FieldPath] = []
        self._lcm_class: type | None = None
        self._n_skipped = 0
        self._skipped_type: type | None = None

    def show(self, message: EchoedMessage) -> bool:
        """Print a row and return True, unless the message cannot be decoded or has another type than the first."""
        if message.values is not None and self._lcm_class is None and message.lcm_class is not None:
            self._begin(message.lcm_class)
        if message.values is None or message.lcm_class is not self._lcm_class:
            self._n_skipped += 1
            self._skipped_type = message.lcm_class
            return False
        cells = [_cell(column.pick(message.values)) for column in self._columns]
        self._writer.writerow([f"{self._epoch_s + message.received.at_s:.6f}", *cells])
        sys.stdout.flush()
        return True

    def close(self) -> None:
        """Report the number of messages without a row; raise GraphnavError if no message has one."""
        if self._lcm_class is None:
            raise GraphnavError(self._undecodable())
        if self._n_skipped:
            print_notice(f"{self._n_skipped} messages skipped: undecodable, or not {lcm_name(self._lcm_class)}")

    def _undecodable(self) -> str:
        if self._skipped_type is None:
            hint = "name its package or its .lcm files: --types PACKAGE_OR_DIR, or its plugin: --plugin FILE"
            return f"none of {self._n_skipped} messages could be decoded\n  {hint}"
        hint = "check the program that sends them: they are truncated, or of another type"
        return f"none of {self._n_skipped} messages is a complete {lcm_name(self._skipped_type)}\n  {hint}"

    def _begin(self, lcm_class: type) -> None:
        if self._paths:
            self._columns = [column for path in self._paths for column in columns_of(path, lcm_class)]
        else:
            self._columns, left_out = all_columns(lcm_class)
            if left_out:
                print_notice(f"omitted: {', '.join(left_out)}; select elements of arrays with --field")
        self._lcm_class = lcm_class
        self._writer.writerow(["at_s", *(column.text for column in self._columns)])


def _cell(value: Any) -> Any:
    if value is MISSING:
        return ""
    return printable(value) if isinstance(value, str) else value
