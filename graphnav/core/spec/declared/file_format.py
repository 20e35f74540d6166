"""A kind of file, by its declared root: how it is read, checked and described."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from graphnav.core.errors import Place, Problem, shown_path
from graphnav.core.spec.declared.json_schema import Schema, record_schema
from graphnav.core.spec.declared.read_record import read_record
from graphnav.core.spec.declared.record import Record
from graphnav.core.spec.declared.reference_page import reference_page
from graphnav.core.spec.yaml import parse_yaml, read_bytes

R = TypeVar("R", bound=Record)


@dataclass(frozen=True)
class FileFormat(Generic[R]):
    """A kind of YAML file that a plugin reads, named as in ``graphnav schema --of NAME``."""

    name: str
    record: type[R]
    title: str
    """Of the reference page."""
    doc: str
    """Introduction of the reference page, in Markdown: units, frames, a complete example."""

    def read(self, path: Path) -> tuple[R | None, list[Problem]]:
        """Return what a file says, and everything that is wrong with single values, each with its place.

        None: something required is wrong or missing. What else is wrong has its default, so that more can be checked.

        Raises
        ------
        UserError
            It cannot be read or is not YAML.
        """
        return self.parse(self.content(path), shown_path(path))

    def content(self, path: Path) -> bytes:
        """Return the bytes of a file, for `parse`.

        Raises
        ------
        UserError
            It cannot be read.
        """
        return read_bytes(path, Place(shown_path(path)))

    def parse(self, data: bytes, source: str) -> tuple[R | None, list[Problem]]:
        """Return what the bytes of a file say, as `read` does; messages call it ``source``.

        Raises
        ------
        UserError
            They are not YAML.
        """
        value, problems = parse_yaml(data, source)
        return (None, problems) if problems else read_record(self.record, value)

    def schema(self) -> Schema:
        """Return the JSON Schema of such files."""
        return record_schema(self.record, f"{self.record.noun} of graphnav".capitalize())

    def reference(self) -> str:
        """Return the reference page, in Markdown."""
        return reference_page(self.record, self.title, self.doc)
