"""A ROS 2 bag as the events of a log: each message in the type of graphnav that says the same."""

from __future__ import annotations

import struct
import threading
from array import array
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from graphnav.core.codec import EncodeError, encode, fingerprint
from graphnav.core.errors import BagError, message_line
from graphnav.core.messages import Message
from graphnav.core.record.bags.bag_folder import METADATA, BagFolder
from graphnav.core.record.bags.from_ros import READ, stamp_us
from graphnav.core.record.bags.library import Cdr, RawMessage, expand_message
from graphnav.core.record.event import Entry

BAG_SUFFIXES = (".mcap", ".db3")
_HEAD = struct.Struct(">8sqq")
_NEAR_NS = 2_000_000_000
"""Messages that are so much later are reached by reading on, others by a search."""


def is_bag(path: Path) -> bool:
    """Whether a path is that of a ROS 2 bag: a folder with ``metadata.yaml``, or one file of it."""
    return path.suffix in BAG_SUFFIXES if path.is_file() else (path / METADATA).is_file()


class Bag:
    """A bag, read message by message: opening it reads it once, for the places of its messages.

    An event bears the time at which its message was recorded; the message has the stamp of its header. Its ``seq``
    counts the messages of its topic. Topics without a type in `READ` have the bytes of the bag (CDR) as data, and so
    has a message that cannot be converted, which no codec takes for its type; `fault` says why.

    ``types``: ROS types by topic, in the order of the bag, those without messages too. ``size``: of its files, bytes.

    Raises
    ------
    BagError
        It cannot be read, or contradicts itself.
    UserError
        The extra ``bags`` is not installed.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._cdr = Cdr()
        self._folder = BagFolder(path)
        self.size = self._folder.n_bytes
        self.types = self._folder.types
        self._starts, self._logged_ns, self._utimes, self._seqs = (array("q") for _ in range(4))
        self._topics: list[str] = []
        self._file_begins: list[int] = []
        self._cursor: Iterator[RawMessage] = iter(())
        self._place, self._next = -1, 0
        """The file that the cursor reads, and the number of the message that it yields next."""
        self._lock = threading.Lock()

    def entries(self) -> Iterator[Entry]:
        """Yield the position of each message, once; positions count the bytes of all messages as the bag has them."""
        begin = 0
        counts: Counter[str] = Counter()
        for file in self._folder.files:
            self._file_begins.append(len(self._starts))
            last_ns = 0
            for raw in file.messages():
                if raw.logged_ns < last_ns:
                    what = f"{file.path} contradicts itself: its messages are not in the order of its index"
                    raise BagError.of(what, "write its index again: mcap recover, or ros2 bag reindex")
                last_ns = raw.logged_ns
                self._starts.append(begin)
                self._logged_ns.append(raw.logged_ns)
                self._utimes.append(stamp_us(raw, self._data(raw)))
                self._seqs.append(counts[raw.topic])
                self._topics.append(raw.topic)
                counts[raw.topic] += 1
                n_bytes = max(len(raw.data), _HEAD.size + 1)  # more than a head: `read` tells the two apart
                yield Entry(raw.topic, raw.logged_ns // 1000, begin, begin + n_bytes)
                begin += n_bytes
        self._folder.check_counts(counts)

    def lcm_class(self, topic: str) -> type | None:
        """Return the LCM class in which messages of a topic are read, None if its ROS type has none."""
        found = READ.get(self.types[topic])
        return None if found is None else found.message.lcm_class

    def read(self, start: int, stop: int) -> bytes:
        """Return the data of the message at a position; of a part from its begin at most as many bytes.

        Raises BagError if the bag cannot be read.
        """
        number = bisect_right(self._starts, start) - 1
        lcm_class = self.lcm_class(self._topics[number])
        if lcm_class is not None and stop - start <= _HEAD.size:
            head = _HEAD.pack(fingerprint(lcm_class), self._utimes[number], self._seqs[number])
            return head[start - self._starts[number] : stop - self._starts[number]]
        with self._lock:
            raw = self._raw(number)
        try:
            return self._converted(number, raw)
        except (ValueError, EncodeError):
            return raw.data

    def fault(self, start: int) -> str:
        """Return why the message at a position has no data of its type, empty if it has."""
        number = bisect_right(self._starts, start) - 1
        with self._lock:
            raw = self._raw(number)
        try:
            self._converted(number, raw)
        except (ValueError, EncodeError) as error:
            return message_line(error)
        return ""

    def close(self) -> None:
        """Close the files; idempotent."""
        self._folder.close()

    def _converted(self, number: int, raw: RawMessage) -> bytes:
        found = READ.get(raw.ros_type)
        if found is None:
            return raw.data
        message: Message = found.convert(self._cdr.decode(self._data(raw), raw.ros_type))
        return encode(message, self._utimes[number], self._seqs[number])

    def _data(self, raw: RawMessage) -> bytes:
        return expand_message(raw.data) if self._folder.compresses_messages else raw.data

    def _raw(self, number: int) -> RawMessage:
        """Return a message: by reading on from the last one, or by a search for its time."""
        place = bisect_right(self._file_begins, number) - 1
        if not self._reads_on_to(number, place):
            wanted_ns, self._next, self._place = self._logged_ns[number], number, place
            while self._next > self._file_begins[place] and self._logged_ns[self._next - 1] == wanted_ns:
                self._next -= 1
            self._cursor = self._folder.files[place].messages(wanted_ns)
        raw = None
        while self._next <= number:
            raw = next(self._cursor, None)
            self._next += 1
        if raw is None or (raw.topic, raw.logged_ns) != (self._topics[number], self._logged_ns[number]):
            self._place = -1
            what = f"{self._folder.files[place].path} has changed since it was opened"
            raise BagError.of(what, "read it again when it is complete")
        return raw

    def _reads_on_to(self, number: int, place: int) -> bool:
        if place != self._place or self._next > number:
            return False
        return self._logged_ns[number] - self._logged_ns[self._next] <= _NEAR_NS
