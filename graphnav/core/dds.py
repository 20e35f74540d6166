"""ROS 2 topics without ROS: a participant of Cyclone DDS that moves the bytes of messages, which `RosType` codes."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from graphnav.core.errors import BusError, UserError, did_you_mean, message_line
from graphnav.core.machine import import_extra
from graphnav.core.ros2 import LOOPBACK, MAX_BYTES, PRIMITIVES, STRING, Ros2Network, RosType, nested_types

Handler = Callable[[bytes, int], None]
"""Takes a message: its bytes, and a number that tells its publisher from others."""

_PYTHON_TYPES = {"bool": bool, STRING: str}
_MAX_TAKEN = 64
_MAX_LISTED = 256
"""Maximum number of publishers that are looked at: others decide how many there are."""
_DISCOVER_HERE = (
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    '<MaxAutoParticipantIndex>63</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery>'
)
"""Loopback often has no multicast: the participants of this machine are then found by their ports."""
_CONFIG = (
    '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="{interface}"/></Interfaces>{discovery}'
    "<Internal><MaxSampleSize>{max_bytes}B</MaxSampleSize></Internal><Tracing><Verbosity>none</Verbosity></Tracing>"
    "</Domain></CycloneDDS>"
)
_MAX_SAMPLE_BYTES = 4 * MAX_BYTES
"""Cyclone DDS drops a message that declares more, before memory is allocated; what is smaller is told of."""


class Endpoint(NamedTuple):
    """A publisher of a topic: the topic and the type as ROS names them, where they are ROS's."""

    topic: str
    type_name: str


class Ros2Node:
    """A participant of Cyclone DDS: one thread calls `handle`, any thread may publish.

    ``who``: what needs it, in the error of a missing package. ``CYCLONEDDS_URI`` is not read: what a graph reaches
    follows from the graph.

    Raises UserError if Cyclone DDS is not installed or the interface does not exist, BusError if the domain cannot be
    joined.
    """

    def __init__(self, network: Ros2Network, who: str) -> None:
        import_extra("cyclonedds", "ros2", who)
        import cyclonedds

        self._dds: Any = cyclonedds
        self.network = network
        known = [name for _, name in socket.if_nameindex()]
        if network.interface not in known:
            hint = did_you_mean(network.interface, known) or f"interfaces are {', '.join(known)}"
            raise UserError.of(f"there is no network interface '{network.interface}'", hint)
        self._kinds: dict[str, Any] = {}
        self._readers: list[tuple[Any, Any, Handler]] = []
        self._writers: dict[str, tuple[Any, Any]] = {}
        config = _CONFIG.format(
            interface=network.interface,
            discovery=_DISCOVER_HERE if network.interface == LOOPBACK else "</General>",
            max_bytes=_MAX_SAMPLE_BYTES,
        )
        dds = self._dds
        try:
            self._domain = dds.domain.Domain(network.domain, config)
            self._participant = dds.domain.DomainParticipant(network.domain)
            self._waitset = dds.core.WaitSet(self._participant)
        except dds.core.DDSException as error:
            raise BusError(
                f"cannot join ROS 2 {network}: {message_line(error)}",
                "end other runs of this process, or choose another domain",
            ) from error

    def subscribe(self, topic: str, kind: RosType, handler: Handler, depth: int, *, reliable: bool = False) -> None:
        """Call ``handler`` for each message of a topic; the newest ``depth`` wait for it.

        One that is not ``reliable`` hears every publisher, but lost packets are not sent again; a reliable one hears
        only reliable publishers.
        """
        dds, policy = self._dds, self._dds.core.Policy
        qos = dds.core.Qos(
            policy.Reliability.Reliable(0) if reliable else policy.Reliability.BestEffort,
            policy.History.KeepLast(depth),
            policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=True),
        )
        reader = self._made(topic, lambda: dds.sub.DataReader(self._participant, self._topic(topic, kind), qos=qos))
        states = dds.core.SampleState.Any | dds.core.ViewState.Any | dds.core.InstanceState.Any
        condition = dds.core.ReadCondition(reader, states)
        self._waitset.attach(condition)
        self._readers.append((reader, condition, handler))

    def offer(self, topic: str, kind: RosType, *, latched: bool = False) -> None:
        """Prepare to publish on a topic; ``latched``: later subscribers get the last message, too."""
        dds, policy = self._dds, self._dds.core.Policy
        qos = dds.core.Qos(
            policy.Reliability.Reliable(0),  # a listener that does not answer must not hold up who publishes
            policy.History.KeepLast(1),
            policy.DataRepresentation(use_cdrv0_representation=True),
            policy.Durability.TransientLocal if latched else policy.Durability.Volatile,
        )
        writer = self._made(topic, lambda: dds.pub.DataWriter(self._participant, self._topic(topic, kind), qos=qos))
        sample = writer.data_type.__new__(writer.data_type)
        self._writers[topic] = writer, sample

    def publish(self, topic: str, data: bytes) -> None:
        """Send a message on a topic that is offered, without waiting; raises BusError if it is not taken."""
        writer, sample = self._writers[topic]
        sample.data = data
        try:
            writer.write(sample)
        except self._dds.core.DDSException as error:
            raise BusError(f"cannot publish {len(data)} bytes on '{topic}': {message_line(error)}") from error

    def handle(self, timeout_s: float) -> None:
        """Wait for messages and deliver them; raises BusError if DDS fails."""
        try:
            self._waitset.wait(round(timeout_s * 1e9))
            for reader, _, handler in self._readers:
                for sample in reader.take(_MAX_TAKEN):
                    if isinstance(sample, _Raw):
                        handler(sample.data, sample.sample_info.publication_handle)
        except self._dds.core.DDSException as error:
            raise BusError(f"cannot receive from ROS 2 {self.network}: {message_line(error)}") from error

    def listeners(self, topic: str) -> int:
        """Return how many subscribers of a topic that is offered have been found."""
        return len(self._writers[topic][0].get_matched_subscriptions())

    def publishers(self) -> Iterator[Endpoint]:
        """Yield the publishers of ROS topics that have been found."""
        dds = self._dds
        try:
            reader = dds.builtin.BuiltinDataReader(self._participant, dds.builtin.BuiltinTopicDcpsPublication)
            found = [(str(one.topic_name), str(one.type_name)) for one in reader.read(_MAX_LISTED)]
        except (dds.core.DDSException, ValueError, TypeError, LookupError):  # of what others announce
            return
        for topic, type_name in found:
            if topic.startswith("rt/"):
                yield Endpoint(topic[2:], type_name.removesuffix("_").replace("::msg::dds_::", "/"))

    def close(self) -> None:
        """Leave; others are told."""
        self._readers.clear()
        self._writers.clear()
        del self._waitset, self._participant, self._domain

    def _topic(self, topic: str, kind: RosType) -> Any:
        return self._dds.topic.Topic(self._participant, f"rt{topic}", self._kind(kind))

    def _made(self, topic: str, make: Callable[[], Any]) -> Any:
        try:
            return make()
        except self._dds.core.DDSException as error:
            raise BusError(f"cannot use the ROS topic '{topic}': {message_line(error)}") from error

    def _kind(self, kind: RosType) -> Any:
        """Return the class by which Cyclone DDS knows a type; it passes on bytes as they are.

        It is final, as all types of ROS are: those that may grow have other bytes.
        """
        if kind.name not in self._kinds:
            for nested in nested_types(kind):
                self._kinds.setdefault(nested.name, self._struct(nested))
            made = self._kinds[kind.name]
            made.deserialize = made.deserialize_key = classmethod(_received)
            made.serialize = made.serialize_key = _sent
        return self._kinds[kind.name]

    def _struct(self, kind: RosType) -> Any:
        idl = self._dds.idl
        fields = {}
        for one in kind.fields:
            element = self._kinds[one.kind.name] if isinstance(one.kind, RosType) else self._element(one.kind)
            if one.size is not None:
                element = idl.types.array[element, one.size] if one.size else idl.types.sequence[element]
            fields[one.name] = element
        made = idl.make_idl_struct(kind.dds_name.rpartition(":")[2], kind.dds_name, fields, dataclassify=False)
        return idl.annotations.final(made)

    def _element(self, kind: str) -> Any:
        if kind in _PYTHON_TYPES:
            return _PYTHON_TYPES[kind]
        is_octet = PRIMITIVES[kind].endswith("1")  # Cyclone DDS 0.10.2 crashes where it is told of an int8 or uint8
        return getattr(self._dds.idl.types, "byte" if is_octet else kind)


class _Raw:
    """The bytes of a received message; DDS adds ``sample_info``."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.sample_info: Any = None


def _received(_cls: type, data: bytes, has_header: bool = True, use_version_2: bool | None = None) -> _Raw:  # noqa: ARG001, FBT001, FBT002
    return _Raw(data)


def _sent(sample: Any, use_version_2: bool | None = None) -> bytes:  # noqa: ARG001, FBT001
    data: bytes = sample.data
    return data
