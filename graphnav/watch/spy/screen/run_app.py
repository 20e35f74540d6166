"""Run the full-screen spy until the user quits or a signal ends it."""

from __future__ import annotations

import asyncio
import signal

from graphnav.core.interrupts import plain_ctrl_c
from graphnav.watch.spy.screen.app import SpyApp


def run_app(app: SpyApp) -> int:
    """Run the app; return the exit status: 0, or 128 + N after signal N.

    After SIGTERM and SIGHUP the terminal is restored. A second signal ends the program immediately.
    """
    with plain_ctrl_c():
        asyncio.run(_run(app))
    return app.return_code or 0


async def _run(app: SpyApp) -> None:
    loop = asyncio.get_running_loop()

    def leave(number: signal.Signals) -> None:
        loop.remove_signal_handler(number)
        app.leave(128 + number)

    for number in (signal.SIGTERM, signal.SIGHUP):
        loop.add_signal_handler(number, leave, number)
    await app.run_async()
