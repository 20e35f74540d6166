"""A mailbox keeps the newest messages, and those of other writers apart from those that count."""

from __future__ import annotations

from graphnav.live.inputs.receiver import MAX_OF_OTHERS, Mailbox

MARK = b"fingerpr"


def test_what_begins_with_another_fingerprint_is_counted_and_not_kept() -> None:
    mailbox = Mailbox(MARK, 4)
    assert not mailbox.put(b"another type", 0.0)
    assert not mailbox.put(b"", 0.0)
    assert mailbox.take() == []
    assert mailbox.wrong_type == 2


def test_the_newest_are_kept() -> None:
    mailbox = Mailbox(MARK, 4)
    for k in range(10):
        assert mailbox.put(MARK + bytes([k]), float(k))
    assert [arrival.data[-1] for arrival in mailbox.take()] == [6, 7, 8, 9]
    assert mailbox.overflowed == 6
    assert mailbox.take() == []


def test_however_many_others_send_nothing_of_the_own_writer_is_lost() -> None:
    mailbox = Mailbox(MARK, 4, lambda data, _: data.endswith(b"own"))
    mailbox.put(MARK + b"own", 0.0)
    for k in range(1000):
        assert not mailbox.put(MARK + b"other", 1.0 + k)
    mailbox.put(MARK + b"own", 2000.0)
    taken = mailbox.take()
    assert [arrival.data[8:] for arrival in taken] == [b"own", *[b"other"] * MAX_OF_OTHERS, b"own"]
    assert [arrival.at_s for arrival in taken] == sorted(arrival.at_s for arrival in taken)
    assert mailbox.flooded == 1000 - MAX_OF_OTHERS
    assert mailbox.overflowed == 0
