"""The full-screen spy on live channels."""

from __future__ import annotations

from pathlib import Path

from textual.pilot import Pilot
from textual.widgets import Static

from graphnav.core.bus import Bus
from graphnav.core.record import Recording
from graphnav.watch.spy.screen.keys_screen import KeysScreen

from .spy_app import drive, line_of, opened, publishing, screen_text, until


def test_it_starts_before_the_publishers_and_outlives_them(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: "no publisher" in screen_text(pilot))
        with publishing(group, "robot.image", "control.twist"):
            await until(pilot, lambda: "Hz" in line_of(pilot, "control.twist"))
            assert "no publisher" not in screen_text(pilot)
            screen = await opened(pilot, "robot.image")
            await until(pilot, lambda: screen.picture is not None)
        await until(pilot, lambda: "stale for" in screen_text(pilot))
        assert screen.picture is not None
        with publishing(group, "robot.image", run_id="run-b"):
            await until(pilot, lambda: "run run-b" in screen_text(pilot))
            await until(pilot, lambda: "stale for" not in screen_text(pilot))

    drive(group, act)


def test_all_runs_on_the_group_are_named(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist", run_id="run-a"):
            await until(pilot, lambda: " run run-a" in screen_text(pilot))
            with publishing(group, "flow.flow", run_id="run-b"):
                await until(pilot, lambda: "2 runs: run-a, run-b" in screen_text(pilot))
            await until(pilot, lambda: " run run-a" in screen_text(pilot))
            with publishing(group, run_id="c"), publishing(group, run_id="d"), publishing(group, run_id="e"):
                await until(pilot, lambda: "and 1 more" in screen_text(pilot))

    drive(group, act)


def test_what_was_announced_and_does_not_come_says_so(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist"):
            await opened(pilot, "flow.flow")
            await until(pilot, lambda: "announced, but not received" in screen_text(pilot))

    drive(group, act)


def test_an_unknown_type_says_its_fingerprint(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        bus = Bus(group)

        def published() -> bool:
            bus.publish("strange", b"\x01\x23\x45\x67\x89\xab\xcd\xefmore")
            return bool(line_of(pilot, "strange"))

        await until(pilot, published)
        await opened(pilot, "strange")
        await until(pilot, lambda: "unknown fingerprint 0123456789abcdef" in screen_text(pilot))
        bus.close()

    drive(group, act)


def test_the_view_goes_on_while_its_keys_are_listed(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist"):
            await until(pilot, lambda: "Hz" in line_of(pilot, "control.twist"))
            for channel in (None, "control.twist"):
                if channel is not None:
                    await opened(pilot, channel)
                await pilot.press("question_mark")
                await until(pilot, lambda: isinstance(pilot.app.screen, KeysScreen))
                below = pilot.app.screen_stack[-2]
                heading = str(below.query_one("#heading", Static).render())
                await until(pilot, lambda: str(below.query_one("#heading", Static).render()) != heading)  # noqa: B023
                await pilot.press("question_mark")
                await until(pilot, lambda: pilot.app.screen is below)  # noqa: B023

    drive(group, act)


def test_frozen_the_view_stands_still_and_nothing_is_missed(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist"):
            await opened(pilot, "control.twist")
            await until(pilot, lambda: "v_mps" in screen_text(pilot))
            await pilot.press("space")
            await until(pilot, lambda: "FROZEN" in screen_text(pilot))
            watch = pilot.app._session.watch  # type: ignore[attr-defined]
            channel, seen = watch.channel("control.twist"), body_of(pilot)
            count = channel.count
            await until(pilot, lambda: channel.count > count + 10)
            assert body_of(pilot) == seen
            await pilot.press("space")
            await until(pilot, lambda: body_of(pilot) != seen)
            assert channel.lost == 0

    drive(group, act)


def body_of(pilot: Pilot[None]) -> str:
    """Return the screen below its heading."""
    return "\n".join(screen_text(pilot).splitlines()[1:])


def test_what_is_heard_is_recorded(group: str, tmp_path: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist", "robot.image"):
            await until(pilot, lambda: "Hz" in line_of(pilot, "control.twist"))
            await pilot.press("r")
            await until(pilot, lambda: "recording spy-" in screen_text(pilot))
            path = next(tmp_path.glob("spy-*.lcmlog"))
            channel = pilot.app._session.watch.channel("control.twist")  # type: ignore[attr-defined]
            count = channel.count
            await until(pilot, lambda: channel.count > count + 10)
            await pilot.press("r")
            await until(pilot, lambda: "recording spy-" not in screen_text(pilot))
        with Recording(path) as recording:
            assert recording.about is not None
            assert recording.about.run_id == "run-a"
            assert recording.count("control.twist") >= 10
            assert recording.count("robot.image") >= 10

    drive(group, act, folder=tmp_path)


def test_heading_says_where_it_listens(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        address = group.partition("?")[0]
        await until(pilot, lambda: address in str(pilot.app.screen.query_one("#heading", Static).render()))

    drive(group, act)
