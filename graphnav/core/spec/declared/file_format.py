"""Kinds of files, each by its declared root: how it is read, checked and described; those of installed plugins."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from graphnav.core.errors import CatalogError, Place, Problem, shown_path
from graphnav.core.spec.declared.json_schema import Schema, record_schema
from graphnav.core.spec.declared.read_record import read_record
from graphnav.core.spec.declared.record import Record
from graphnav.core.spec.declared.reference_page import reference_page
from graphnav.core.spec.yaml import parse_yaml, read_bytes

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog


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


def plugin_formats(catalog: Catalog) -> dict[str, FileFormat[Any]]:
    """Return the formats of all installed plugins, which are imported, by name.

    Raises
    ------
    CatalogError
        A plugin cannot be imported, does not return formats, or returns one of a name that another one has.
    """
    for family in catalog.families():
        catalog.load(family)
    found: dict[str, FileFormat[Any]] = {}
    for hook in catalog.hook.graphnav_file_formats.get_hookimpls():
        origin = hook.plugin_name.partition(": ")[2]
        given = catalog.called(origin, "graphnav_file_formats()", hook.function)
        if not isinstance(given, list | tuple) or not all(isinstance(one, FileFormat) for one in given):
            what = f"{origin}: graphnav_file_formats() does not return a list of FileFormat"
            raise CatalogError(what, "return [FileFormat(...)]")
        for one in given:
            if one.name in found:
                raise CatalogError(f"{origin}: there is another file format '{one.name}'", "give it another name")
            found[one.name] = one
    return found
