"""The run's side of the process that sends motor channels."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from graphnav.core.errors import BusError
from graphnav.live.motors.sender import MotorChannel, MotorSender

from .listening import Listener, go, is_gone, motor, wait_until

Make = Callable[..., MotorSender]


@pytest.fixture
def make(group: str) -> Iterator[Make]:
    """Return what makes senders on the group that end with the test."""
    made: list[MotorSender] = []

    def sender_of(*channels: MotorChannel) -> MotorSender:
        made.append(MotorSender(group, channels))
        return made[-1]

    yield sender_of
    for sender in made:
        if sender.alive:
            os.kill(sender.pid, signal.SIGKILL)
        sender.close()


def n_descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def children() -> set[int]:
    """Return this process's children, those included that ended and were not collected."""
    found = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parent = stat.read_text().rpartition(")")[2].split()[1]
            if int(parent) == os.getpid():
                found.add(int(stat.parent.name))
    return found


def test_commands_are_forwarded_as_they_are(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 10.0))
    for seq in range(50):
        assert sender.send(name, go(seq))
        listener.wait_for_count(seq + 1)
    assert [heard.seq for heard in listener.heard] == list(range(50))
    wait_until(lambda: sender.counts.forwarded == 50)
    assert sender.counts == (50, 0, 0, 0, 0)
    assert sender.refused == 0


def test_nothing_is_sent_before_the_first_command(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 0.01), motor(f"{name}_B", 0.2))
    assert sender.send(f"{name}_B", go())
    listener.wait_for_stops(f"{name}_B")
    assert {heard.channel for heard in listener.heard} == {f"{name}_B"}


def test_each_channel_has_its_own_limit(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 60.0), motor(f"{name}_B", 0.1))
    sender.send(name, go())
    sender.send(f"{name}_B", go())
    listener.wait_for_stops()
    assert {heard.channel for heard in listener.stops()} == {f"{name}_B"}


def test_silence_is_answered_and_a_later_command_ends_the_stops(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 0.5))
    sender.send(name, go())
    listener.wait_for_stops(count=5)
    n_before = len(listener.stops())
    sent_s = time.monotonic()
    assert sender.send(name, go(1))
    listener.wait_for(lambda _: len(listener.commands()) == 2)
    listener.wait_for(lambda heard: heard[-1].is_stop)
    after = [heard for heard in listener.stops()[n_before:] if heard.at_s > listener.commands()[1].at_s]
    assert after[0].at_s - sent_s > 0.45


def test_an_ordered_stop_lasts_a_second_and_the_process_goes_on(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 60.0), motor(f"{name}_B", 60.0))
    sender.send(name, go())
    listener.wait_for_count(1)
    sender.stop()
    wait_until(lambda: sender.stops >= 2)
    for channel in (name, f"{name}_B"):
        listener.wait_for_stops(channel)
    listener.wait_for(lambda _: listener.stops()[-1].at_s - listener.stops()[0].at_s > 0.9)
    assert sender.alive
    assert sender.send(name, go(1))
    listener.wait_for(lambda _: len(listener.commands()) == 2)


def test_a_command_behind_an_ordered_stop_ends_it_on_its_channel(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 60.0), motor(f"{name}_B", 60.0))
    sender.stop()
    sender.send(name, go())
    listener.wait_for_stops(f"{name}_B")
    ours = [heard for heard in listener.heard if heard.channel == name]
    assert [heard.is_stop for heard in ours] == sorted((heard.is_stop for heard in ours), reverse=True)
    assert ours[0].is_stop
    assert not ours[-1].is_stop


def test_closing_stops_every_channel_and_leaves_nothing_behind(make: Make, listener: Listener, name: str) -> None:
    n_before, children_before = n_descriptors(), children()
    sender = make(motor(name, 60.0), motor(f"{name}_B", 60.0))
    sender.send(name, go())
    listener.wait_for(lambda heard: heard)
    sender.close()
    wait_until(lambda: not sender.alive)
    for channel in (name, f"{name}_B"):
        listener.wait_for_stops(channel)
    assert is_gone(sender.pid)
    assert children() == children_before
    assert n_descriptors() == n_before
    assert sender.counts.forwarded == 1
    assert sender.counts.stops == len(listener.stops())
    sender.close()
    sender.stop()
    assert not sender.send(name, go())
    assert sender.refused == 1


def test_closing_need_not_wait(make: Make, listener: Listener, name: str) -> None:
    children_before = children()
    sender = make(motor(name))
    sender.close(wait=False)
    assert not sender.send(name, go())
    listener.wait_for_stops()
    wait_until(lambda: children() == children_before)
    assert not listener.commands()


def test_many_starts_and_ends_leak_nothing(group: str, name: str) -> None:
    n_before, children_before = n_descriptors(), children()
    senders = []
    for _ in range(15):
        senders.append(MotorSender(group, [motor(name)]))
        senders[-1].send(name, go())
        senders[-1].close(wait=False)
    wait_until(lambda: children() == children_before)
    wait_until(lambda: n_descriptors() == n_before)
    assert not any(sender.alive for sender in senders)
    assert all(sender.stops >= 20 for sender in senders)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT])
def test_a_signal_to_the_process_itself(number: signal.Signals, make: Make, listener: Listener, name: str) -> None:
    old = signal.pthread_sigmask(signal.SIG_BLOCK, {number})  # a process inherits what its parent blocks
    try:
        sender = make(motor(name, 60.0))
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, old)
    sender.send(name, go())
    listener.wait_for(lambda heard: heard)
    os.kill(sender.pid, number)
    listener.wait_for_stops()
    sender.send(name, go(1))
    wait_until(lambda: not sender.alive)
    assert len(listener.commands()) == 1
    assert not sender.send(name, go(2))


def test_a_process_that_is_killed_is_noticed(make: Make, name: str) -> None:
    sender = make(motor(name))
    assert sender.alive
    os.kill(sender.pid, signal.SIGKILL)
    wait_until(lambda: not sender.alive)
    assert not sender.send(name, go())
    sender.stop()
    assert sender.refused == 1


def test_a_process_that_is_suspended_delays_no_process_and_forwards_no_old_commands(
    make: Make, listener: Listener, name: str
) -> None:
    sender = make(motor(name, 0.3))
    assert sender.send(name, go())
    listener.wait_for(lambda heard: heard)
    os.kill(sender.pid, signal.SIGSTOP)
    for seq in range(1, 3000):
        sender.send(name, go(seq))
    assert sender.refused > 500
    old_s = time.monotonic() + 0.3
    wait_until(lambda: time.monotonic() > old_s)
    os.kill(sender.pid, signal.SIGCONT)
    wait_until(lambda: sender.counts.late > 0)
    listener.wait_for_stops()
    assert len(listener.commands()) == 1
    assert sender.counts.forwarded == 1


def test_closing_while_the_process_is_suspended_ends_in_stops(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 60.0))
    os.kill(sender.pid, signal.SIGSTOP)
    for seq in range(2000):
        sender.send(name, go(seq))
    sender.close(wait=False)
    os.kill(sender.pid, signal.SIGCONT)
    listener.wait_for_stops()
    wait_until(lambda: not sender.alive)
    assert len(listener.commands()) <= 1
    assert listener.heard[-1].is_stop


def test_after_a_suspension_the_newest_command_is_forwarded(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 60.0))
    assert sender.send(name, go())
    listener.wait_for(lambda heard: heard)
    os.kill(sender.pid, signal.SIGSTOP)
    for seq in range(1, 100):
        sender.send(name, go(seq))
    os.kill(sender.pid, signal.SIGCONT)
    listener.wait_for(lambda heard: len(heard) == 2)
    assert listener.heard[-1].seq == 99
    wait_until(lambda: sender.counts.overtaken == 98)
    assert sender.send(name, go(100))


def test_a_suspended_process_is_noticed_within_a_moment(make: Make, name: str) -> None:
    sender = make(motor(name, 60.0))
    os.kill(sender.pid, signal.SIGSTOP)
    wait_until(lambda: not sender.send(name, go()))
    assert sender.counts.forwarded == 0
    os.kill(sender.pid, signal.SIGCONT)
    wait_until(lambda: sender.send(name, go()))


def test_threads_may_send_and_stop_at_once(make: Make, listener: Listener, name: str) -> None:
    sender = make(motor(name, 60.0), motor(f"{name}_B", 60.0))
    done = threading.Event()

    def hurry(channel: str) -> None:
        while not done.is_set():
            sender.send(channel, go())
            sender.stop()
            time.sleep(0)  # the process of the motors has to come to it, too

    threads = [threading.Thread(target=hurry, args=(channel,)) for channel in (name, f"{name}_B")]
    for thread in threads:
        thread.start()
    wait_until(lambda: sender.counts.forwarded > 500)
    done.set()
    for thread in threads:
        thread.join()
    assert sender.alive
    sender.close()
    wait_until(lambda: not sender.alive)


def test_a_command_of_many_packets_is_forwarded_and_one_without_bound_is_not(make: Make, name: str) -> None:
    sender = make(motor(name, 60.0))
    sender.send(name, bytes(300_000))
    wait_until(lambda: sender.send(name, go()) and sender.counts.forwarded >= 1)
    refused = sender.refused
    assert not sender.send(name, bytes(2_000_000))
    assert sender.refused == refused + 1


def test_what_is_no_motor_channel_is_a_mistake(make: Make, name: str) -> None:
    with pytest.raises(KeyError):
        make(motor(name)).send("other", b"")
    with pytest.raises(ValueError, match="two motor channels have the same name"):
        make(motor(name), motor(name))


@pytest.mark.parametrize(
    ("url", "what"),
    [
        ("udpm://10.0.0.1:7667?ttl=0", "'10.0.0.1' is not a multicast address"),
        ("nothing://", "LCM does not open nothing://"),
    ],
)
def test_a_network_that_cannot_be_used_is_told(url: str, what: str, name: str) -> None:
    n_before, children_before = n_descriptors(), children()
    with pytest.raises(BusError, match=what):
        MotorSender(url, [motor(name)])
    assert children() == children_before
    assert n_descriptors() == n_before


def test_a_stop_that_is_too_long_is_refused(group: str, name: str) -> None:
    children_before = children()
    with pytest.raises(BusError, match="the stop messages are too long"):
        MotorSender(group, [MotorChannel(name, bytes(50_000), None, None, 0.5)])
    assert children() == children_before


def test_it_starts_from_any_folder_and_without_much(group: str, name: str, tmp_path: Path) -> None:
    """A file of the user's named like a module must not come first, and numpy would cost a tenth of a second."""
    for module in ("socket", "json", "graphnav"):
        (tmp_path / f"{module}.py").write_text("raise SystemExit(9)\n")
    program = (
        "import sys; from graphnav.live.motors.sender import MotorSender\n"
        f"sender = MotorSender({group!r}, [])\n"
        "maps = open(f'/proc/{sender.pid}/maps').read()\n"
        "assert 'numpy' not in maps and '_lcm' in maps, maps\n"
        "sender.close()\n"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr


@pytest.fixture
def unshare() -> str:
    """Return the program that gives another one a network of its own."""
    found = shutil.which("unshare")
    if found is None or subprocess.run([found, "-rn", "true"], capture_output=True, check=False).returncode:
        pytest.skip("this machine gives no network namespace to try it in")
    return found


def test_without_a_multicast_route_it_says_the_command(unshare: str) -> None:
    program = "from graphnav.live.motors.sender import MotorSender; MotorSender('udpm://239.255.76.67:7667', [])"
    command = [unshare, "-rn", sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "BusError: no multicast route to 239.255.76.67" in done.stderr
    assert "ip route add 224.0.0.0/4 dev lo" in done.stderr


def test_while_the_network_is_down_it_keeps_trying(unshare: str) -> None:
    if shutil.which("ip") is None:
        pytest.skip("this machine has no program that takes a network down")
    program = Path(__file__).with_name("network_down.py")
    done = subprocess.run([unshare, "-rn", sys.executable, program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
