"""Adapters: messages of ours from LCM types of other packages, and back."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from graphnav.codec import add_type
from graphnav.errors import DeclarationError, one_line
from graphnav.messages import Message


class Adapter:
    """Turns an LCM type that another package defines into a message of ours, and back.

    A plugin's hook ``graphnav_adapters`` returns adapters; a graph finds them by ``type_name`` before it looks for a
    type that is installed. One direction is enough::

        class BasePose(Adapter):
            type_name = "base.pose_t"
            lcm_class = base.pose_t
            message = Odometry

            def from_lcm(self, fields: Mapping[str, Any]) -> Odometry:
                return Odometry(x_m=fields["pos"][0], ...)
    """

    type_name: ClassVar[str]
    """``package.type_t``, as graphs name it."""
    lcm_class: ClassVar[type]
    """What lcm-gen made of it; it need not be importable under ``type_name``."""
    message: ClassVar[type[Message]]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Make the type known to what decodes any channel, as ``graphnav spy`` and ``graphnav echo`` do."""
        super().__init_subclass__(**kwargs)
        if isinstance(getattr(cls, "type_name", None), str) and hasattr(
            getattr(cls, "lcm_class", None), "__typenames__"
        ):
            add_type(cls.type_name, cls.lcm_class)

    def from_lcm(self, fields: Mapping[str, Any]) -> Message:
        """Return the message that the LCM fields hold; arrays are numpy arrays, received read-only.

        Raises
        ------
        ValueError
            The fields hold nothing that this adapter can read; the message is counted and not used.
        """
        raise NotImplementedError

    def to_lcm(self, message: Any, utime: int) -> Mapping[str, Any]:
        """Return the LCM fields for a message stamped ``utime`` (microseconds); sizes of arrays may be left out."""
        raise NotImplementedError

    def utime(self, fields: Mapping[str, Any]) -> int | None:
        """Return the sender's stamp in microseconds, None if the type has none; by default the field ``utime``."""
        value = fields.get("utime")
        return value if isinstance(value, int) else None

    @classmethod
    def reads(cls) -> bool:
        """Whether it turns their type into ours."""
        return cls.from_lcm is not Adapter.from_lcm

    @classmethod
    def writes(cls) -> bool:
        """Whether it turns ours into theirs."""
        return cls.to_lcm is not Adapter.to_lcm


@dataclass(frozen=True)
class Adapters:
    """The adapters of the loaded plugins, by ``type_name``: one for each direction of a type."""

    readers: Mapping[str, Adapter]
    """Those that turn their type into ours."""
    writers: Mapping[str, Adapter]
    """Those that turn ours into theirs."""


def collect_adapters(found: Iterable[tuple[str, Any]]) -> Adapters:
    """Return adapters by type; ``found``: pairs of the package or file and what its hook gave, instances or classes.

    Raises
    ------
    DeclarationError
        One is not an adapter, is declared wrongly, or two turn the same type in the same direction.
    """
    readers: dict[str, Adapter] = {}
    writers: dict[str, Adapter] = {}
    origins: dict[tuple[str, str], str] = {}
    for origin, given in found:
        adapter = _made(origin, given)
        name = adapter.type_name
        for verb, does, known in (("read", adapter.reads(), readers), ("written", adapter.writes(), writers)):
            if not does:
                continue
            if name in known:
                raise DeclarationError(f"'{name}' is {verb} by adapters of {origins[verb, name]} and of {origin}")
            known[name], origins[verb, name] = adapter, origin
    return Adapters(readers, writers)


def _made(origin: str, given: Any) -> Adapter:
    """Return the instance of an adapter whose declaration is complete."""
    adapter = given
    if isinstance(given, type) and issubclass(given, Adapter):
        try:
            adapter = given()
        except Exception as error:
            raise DeclarationError(f"{origin}: {given.__name__}() raises {one_line(error)}") from error
    if not isinstance(adapter, Adapter):
        raise DeclarationError(f"{origin}: graphnav_adapters() returns {given!r}, which is not an Adapter")
    who = f"{origin}: adapter {type(adapter).__name__}"
    if not isinstance(getattr(adapter, "type_name", None), str):
        raise DeclarationError(f"{who} does not name its type: write type_name = 'package.type_t'")
    if not hasattr(getattr(adapter, "lcm_class", None), "__typenames__"):
        raise DeclarationError(f"{who} has no lcm_class that lcm-gen made")
    message = getattr(adapter, "message", None)
    if not (isinstance(message, type) and issubclass(message, Message)):
        raise DeclarationError(f"{who} does not name its message: write message = Image, or another Message")
    if not (adapter.reads() or adapter.writes()):
        raise DeclarationError(f"{who} has neither from_lcm nor to_lcm")
    return adapter
