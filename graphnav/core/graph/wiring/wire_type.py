"""Find the LCM or ROS 2 type that a graph names, and what turns it into a message of ours or back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graphnav.core.adapter import Adapter, Adapters, Ros2Adapter
from graphnav.core.catalog import Catalog
from graphnav.core.codec import Codec, codec_of, lcm_name, message_class_of, message_types, type_named
from graphnav.core.errors import CatalogError, did_you_mean, one_line
from graphnav.core.interrupts import CtrlC, third_party_code
from graphnav.core.messages import Message
from graphnav.core.ros2 import RosType, ros_name


@dataclass(frozen=True)
class WireType:
    """A type on the wire, and the message that graphs know it as."""

    name: str
    """``package.type_t``; of a topic ``package/Type``"""
    lcm_class: type
    message: type[Message]
    adapter: Adapter | None
    """None where the message class wraps the type itself."""
    ros_type: RosType | None = None
    """The type of a ROS 2 topic; ``lcm_class`` is then that of the message."""

    @property
    def codec(self) -> Codec | RosType:
        """Encodes and decodes its messages."""
        return self.ros_type or codec_of(self.lcm_class)


def type_read(name: str, catalog: Catalog) -> WireType:
    """Return the type that an input names: that of an adapter first, then any that is installed.

    Raises
    ------
    CatalogError
        There is none, its package cannot be imported, or nothing makes a message of it.
    """
    adapters = catalog.adapters()
    if name in adapters.readers:
        _check_truth(name, adapters.readers[name])
        return _adapted(name, adapters.readers[name])
    if name in adapters.writers and name not in message_types():
        raise CatalogError(f"the adapter of '{name}' only writes it", "give it from_lcm")
    lcm_class = _installed(name, adapters)
    message = message_class_of(lcm_class)
    if message is None:
        short = lcm_class.__name__.removesuffix("_t").title().replace("_", "")
        raise CatalogError(
            f"'{name}' is installed, but no message wraps it and no adapter reads it",
            f"write class {short}(Message, lcm={name}), or an Adapter whose type_name is '{name}'",
        )
    return WireType(name, lcm_class, message, None)


def type_written(name: str | None, message: type[Message], catalog: Catalog) -> WireType:
    """Return the type in which a message leaves; ``name``: None for the message's own.

    Raises
    ------
    CatalogError
        There is none, its package cannot be imported, or the message does not turn into it.
    """
    own = lcm_name(message.lcm_class)
    if name is None:
        return WireType(own, message.lcm_class, message, None)
    adapters = catalog.adapters()
    writers = adapters.writers
    if name in writers and issubclass(message, writers[name].message):
        return _adapted(name, writers[name])
    if name == own:
        return WireType(own, message.lcm_class, message, None)
    if name in adapters.readers and name not in (*writers, *message_types()):
        raise CatalogError(f"the adapter of '{name}' only reads it", "give it to_lcm")
    if name not in writers and _installed(name, adapters) is message.lcm_class:
        return WireType(name, message.lcm_class, message, None)
    fitting = [own, *(other for other, adapter in writers.items() if issubclass(message, adapter.message))]
    carried = writers[name].message if name in writers else message_types().get(name)
    what = f", which carries a {carried.__name__}" if carried else ""
    raise CatalogError(
        f"a {message.__name__} cannot leave as '{name}'{what}",
        f"write type: {' or '.join(fitting)}, or an Adapter from {message.__name__} to '{name}'",
    )


def ros_type_read(name: str, catalog: Catalog) -> WireType:
    """Return the ROS 2 type that an input names.

    Raises
    ------
    CatalogError
        No adapter reads it.
    """
    adapters, kind = catalog.adapters(), ros_name(name)
    if kind in adapters.ros_readers:
        return _ros(adapters.ros_readers[kind])
    if kind in adapters.ros_writers:
        raise CatalogError(f"the adapter of '{name}' only writes it", "give it from_ros")
    raise _unknown_ros(name, adapters.ros_readers)


def ros_type_written(name: str | None, message: type[Message], catalog: Catalog) -> WireType:
    """Return the ROS 2 type in which a message leaves; ``name``: None for the only one that carries it.

    Raises
    ------
    CatalogError
        There is none, or the message does not turn into it.
    """
    writers = catalog.adapters().ros_writers
    fitting = [kind for kind, adapter in writers.items() if issubclass(message, adapter.message)]
    if name is None and len(fitting) == 1:
        return _ros(writers[fitting[0]])
    if name is not None and ros_name(name) in fitting:
        return _ros(writers[ros_name(name)])
    if name is not None and ros_name(name) not in {**writers, **catalog.adapters().ros_readers}:
        raise _unknown_ros(name, writers)
    hint = (
        f"write type: {' or '.join(fitting)}" if fitting else f"write a Ros2Adapter with message = {message.__name__}"
    )
    if name is None:
        several = f"{len(fitting)} ROS 2 types carry" if fitting else "no ROS 2 type carries"
        raise CatalogError(f"{several} a {message.__name__}", hint)
    raise CatalogError(f"a {message.__name__} cannot leave as '{name}'", hint)


def _ros(adapter: Ros2Adapter) -> WireType:
    kind = adapter.ros_type
    return WireType(kind.name, adapter.message.lcm_class, adapter.message, adapter, kind)


def _unknown_ros(name: str, known: Mapping[str, Ros2Adapter]) -> CatalogError:
    hint = did_you_mean(ros_name(name), known) or f"types are {', '.join(sorted(known))}; a Ros2Adapter adds another"
    return CatalogError(f"no adapter knows the ROS 2 type '{name}'", hint)


def _check_truth(name: str, adapter: Adapter) -> None:
    """Raise CatalogError for an adapter that would turn true data into what every stage may read."""
    own = message_class_of(adapter.lcm_class)
    if own is not None and own.is_truth and not adapter.message.is_truth:
        raise CatalogError(
            f"the adapter of '{name}' makes {adapter.message.__name__}, which every stage may read, of true data",
            f"give it a message whose is_truth is True, as {own.__name__} has",
        )


def _adapted(name: str, adapter: Adapter) -> WireType:
    _compile(name, adapter.lcm_class)
    return WireType(name, adapter.lcm_class, adapter.message, adapter)


def _installed(name: str, adapters: Adapters) -> type:
    """Return an LCM type that is installed; importing a third party's package may raise anything."""
    try:
        with third_party_code():
            lcm_class = type_named(name)
    except CtrlC:
        raise
    except BaseException as error:
        raise CatalogError(
            f"the package of '{name}' cannot be imported: {one_line(error)}", "fix the package"
        ) from error
    known = {*message_types(), *adapters.readers, *adapters.writers}
    if lcm_class is None:
        short = [other for other in sorted(known) if other.rpartition(".")[2] in (name, f"{name}_t")]
        hint = f"did you mean {' or '.join(map(repr, short))}?" if short else did_you_mean(name, known)
        hint = hint or "install the package that lcm-gen made of it, or name a type of an adapter"
        raise CatalogError(f"there is no LCM type '{name}'", hint)
    _compile(name, lcm_class)
    return lcm_class


def _compile(name: str, lcm_class: type) -> None:
    try:
        codec_of(lcm_class)
    except CtrlC:
        raise
    except BaseException as error:
        raise CatalogError(f"'{name}' is not what lcm-gen makes: {one_line(error)}", "run lcm-gen again") from error
