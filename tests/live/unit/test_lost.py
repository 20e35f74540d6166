"""Messages that never arrived are counted by their numbers."""

from __future__ import annotations

from graphnav.live.inputs.sender_monitor import SenderMonitor

from .camera import Camera


def test_skipped_numbers_are_counted() -> None:
    camera = Camera(SenderMonitor())
    camera.send(5)
    assert camera.monitor.missing == 0
    camera.seq += 3
    camera.frame += 3
    camera.send(5)
    assert camera.monitor.missing == 3


def test_a_restarted_sender_has_lost_nothing() -> None:
    camera = Camera(SenderMonitor(), seq=500)
    camera.send(10)
    camera.pause(10)
    camera.seq = 0
    camera.send(10)
    assert camera.verdicts[-1].accepted
    assert camera.monitor.missing == 0


def test_a_type_without_numbers_loses_none() -> None:
    camera = Camera(SenderMonitor(), is_counting=False)
    camera.send(3)
    camera.pause(1)
    camera.send(3)
    assert camera.monitor.missing == 0


def test_messages_whose_number_could_not_be_read_did_arrive() -> None:
    camera = Camera(SenderMonitor())
    camera.send(5)
    camera.monitor.unread += 3
    camera.seq += 4
    camera.frame += 4
    camera.send(5)
    assert camera.monitor.missing == 1
    camera.seq += 2
    camera.frame += 2
    camera.send(5)
    assert camera.monitor.missing == 3
