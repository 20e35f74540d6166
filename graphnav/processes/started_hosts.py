"""The commands that `graphnav up` starts on the hosts of a run, over ssh, and ends with it."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import Awaitable, Callable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, TypeVar

from graphnav import GraphnavError, UserError
from graphnav.core.api import Shared
from graphnav.processes import ssh
from graphnav.processes.host_key import new_key
from graphnav.processes.host_orders import ALIVE, FROM_STDIN, PERIOD_S, is_waiting, orders
from graphnav.processes.hosts import Host, HostKeys
from graphnav.processes.output_lines import named_line

if TYPE_CHECKING:
    from asyncssh import SSHClientProcess, SSHReader, SSHWriter

_END_S = 10.0
"""How long a command may take to end its processes."""
_LINES_S = 1.0
"""How long the last lines of a command may take."""
_T = TypeVar("_T")


def words_for_hosts(graph: str, overrides: Sequence[str], plugins: Sequence[Path]) -> list[str]:
    """Return the graph and the options that commands on hosts need as well; the rest they are told by the run."""
    words = [graph]
    for one in overrides:
        words += [Shared.SET.flag, one]
    for path in plugins:
        words += [Shared.PLUGINS.flag, str(path)]
    return words


class _RunEndsError(Exception):
    """The run has ended first."""


class StartedHosts:
    """A context in which ``graphnav run --host`` runs on each host, with a key of its own for this run alone.

    ``words``: of that command, before those for one host. ``notice`` gets what they print, the host's name before each
    line. When one ends before the run does, or its connection breaks, the run is ended as by Ctrl-C.

    Raises
    ------
    GraphnavError
        On entering: a host cannot be reached, or its command ends before it waits for the run.
    """

    def __init__(self, hosts: Mapping[str, HostKeys], words: Sequence[str], notice: Callable[[str], None]) -> None:
        self.failure = ""
        """Why the run was ended from here."""
        self._declared, self._words, self._notice = hosts, words, notice
        self._hosts = {name: Host(name, host.address, host.port, new_key()) for name, host in hosts.items()}
        self._starting = set(hosts)
        """Those that do not wait for the run yet."""
        self._are_waiting: Future[None] = Future()
        self._end = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = threading.Thread(target=self._serve, name="graphnav ssh", daemon=True)

    def __enter__(self) -> Mapping[str, Host]:
        ssh.import_asyncssh()
        self._thread.start()
        try:
            self._are_waiting.result()
        except BaseException:
            self._close()
            raise
        return self._hosts

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._close()

    def _close(self) -> None:
        """End the commands."""
        with suppress(RuntimeError):  # all have ended, and the loop with them
            if self._loop is not None:
                self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(_END_S + _LINES_S)

    def _serve(self) -> None:
        asyncio.run(self._share_all())

    async def _share_all(self) -> None:
        self._loop = asyncio.get_running_loop()
        await asyncio.gather(*map(self._share_or_fail, self._declared))

    async def _share_or_fail(self, name: str) -> None:
        """Have a host serve until the run ends; end the run if the host fails."""
        try:
            await self._share(name, self._declared[name])
        except _RunEndsError:
            pass
        except (ssh.import_asyncssh().Error, OSError) as error:
            hint = "try there by hand what 'graphnav up --help' says it runs"
            self._fail(UserError.of(f"host {name}: ssh fails: {error}", hint, self._declared[name].place()))
        except BaseException as error:
            self._fail(error)
            if not isinstance(error, GraphnavError):
                raise

    def _fail(self, error: BaseException) -> None:
        """Hand an error to the run, the first one that comes."""
        if self._end.is_set():
            return
        self._end.set()
        if not self._are_waiting.done():
            self._are_waiting.set_exception(error)
            return
        self.failure = str(error)
        self._notice(f"{self.failure}\n  the run ends")
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    async def _share(self, name: str, host: HostKeys) -> None:
        async with await self._unless_ending(ssh.connected(name, host)) as connection:
            line = ssh.shell_line(host, [*self._words, "--host", name, "--key", str(FROM_STDIN)])
            process = await self._unless_ending(connection.create_process(line, encoding=None))
            printed = asyncio.gather(self._show(name, process.stderr), self._hear(name, process.stdout))
            alive = asyncio.create_task(self._send_orders(name, process.stdin))
            try:
                await self._unless_ending(process.wait_closed())
                await asyncio.wait([printed], timeout=_LINES_S)
                raise self._ended(name, host, process)
            finally:
                alive.cancel()
                if not process.is_closing():
                    process.stdin.write_eof()
                with suppress(TimeoutError):
                    async with asyncio.timeout(_END_S):
                        await process.wait_closed()
                        await printed

    async def _unless_ending(self, wanted: Awaitable[_T]) -> _T:
        """Return what is awaited; give it up and raise if the run ends first."""
        task, end = asyncio.ensure_future(wanted), asyncio.ensure_future(self._end.wait())
        await asyncio.wait([task, end], return_when=asyncio.FIRST_COMPLETED)
        end.cancel()
        if task.done():
            return task.result()
        task.cancel()
        raise _RunEndsError

    async def _send_orders(self, name: str, stdin: SSHWriter[bytes]) -> None:
        with suppress(OSError):  # it has ended
            stdin.write(orders(self._hosts[name].port, self._hosts[name].key))
            while True:
                await asyncio.sleep(PERIOD_S)
                stdin.write(ALIVE)

    async def _show(self, name: str, stream: SSHReader[bytes]) -> None:
        with suppress(ssh.import_asyncssh().Error):  # the connection is lost
            while line := await stream.readline():
                self._notice(named_line(name, line))

    async def _hear(self, name: str, stream: SSHReader[bytes]) -> None:
        """Note when a host waits for the run; show what else the shell there prints."""
        with suppress(ssh.import_asyncssh().Error):  # the connection is lost
            while line := await stream.readline():
                if not is_waiting(line):
                    self._notice(named_line(name, line))
                    continue
                self._starting.discard(name)
                if not self._starting and not self._are_waiting.done():
                    self._are_waiting.set_result(None)

    def _ended(self, name: str, host: HostKeys, process: SSHClientProcess[bytes]) -> GraphnavError:
        """Return the error of a command that has ended before the run."""
        if process.exit_status == ssh.NOT_FOUND:
            return ssh.not_found(name, host)
        if process.exit_status is None and process.exit_signal is None:
            return GraphnavError(f"host {name}: the connection of ssh is lost")
        how = f"status {process.exit_status}" if process.exit_signal is None else f"signal {process.exit_signal[0]}"
        what = f"host {name}: its command has ended, by {how}"
        if name in self._starting:
            hint = f"see its lines above, which begin with [{name}]"
            return UserError.of(f"{what}, before it waited for the run", hint, host.place())
        return GraphnavError(what)
