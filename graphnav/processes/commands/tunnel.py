"""``graphnav tunnel``: channels of another host's LCM group on this one's, and back."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import Place, UserError
from graphnav.core.cli import CommandArguments, Exit, Options, StatusLine, counted, port_number
from graphnav.core.parameters import Parameter, command, flag, many
from graphnav.processes.tunnel import PORT
from graphnav.processes.tunnel.choice import Choice, Chosen, chosen

if TYPE_CHECKING:
    from graphnav.core.interrupts import Interrupt
    from graphnav.processes.host_link import HostCaller, HostListener, LinkError
    from graphnav.processes.tunnel.report import Report
    from graphnav.processes.tunnel.tunnel import Tunnel

_TURN_S = 0.05
_STATUS_S = 1.0
_LOSSES_S = 5.0
_EXAMPLES = f"""\
examples:
  graphnav tunnel --serve                                  on the robot; the first time it makes a key: copy it
  graphnav tunnel robot.local                              on the laptop: spy, top, view and lcm-spy see the robot
  graphnav tunnel robot.local --in 'graphnav.*' --in 'robot.image@2' --in 'guard.*'
  graphnav tunnel --serve --in TELEOP --in STOP            the robot takes these two from others,
  graphnav tunnel robot.local --out TELEOP --out STOP      and the laptop sends them: graphnav teleop there drives

What passes is chosen by both ends, each by its --in and --out. A REGEX matches the entire name of a channel, the first
one that matches counts, and @HZ limits the rate of each of its channels. Twists, stops and what a run sends to motors
pass only where --in is the name of the channel; twists that a run merely taps pass like everything else.
What came through a tunnel goes through no other one. On a slow link the newest message of each channel is sent.
Who connects proves to have the key. The content is not encrypted: where that matters, connect by
'ssh -L {PORT}:localhost:{PORT} robot.local' and 'graphnav tunnel localhost'.
"""


@command(
    Parameter(
        "host", metavar="HOST", nargs="?", help="name or address of the host where 'graphnav tunnel --serve' runs"
    ),
    flag("serve", "--serve", "wait for other hosts, up to 8 at a time, in place of calling one"),
    many(
        "taken",
        "--in",
        type=chosen,
        metavar="REGEX[@HZ]",
        help="channels of the other host that appear here; may be repeated (default: all; with --serve: none)",
    ),
    many(
        "given",
        "--out",
        type=chosen,
        metavar="REGEX[@HZ]",
        help="channels of this host that may appear there; may be repeated (default: none; with --serve: all)",
    ),
    Parameter("port", "--port", type=port_number, default=PORT, metavar="N", help="TCP port (default: %(default)s)"),
    Parameter(
        "address", "--host", default="", metavar="ADDRESS", help="with --serve: address to listen on (default: all)"
    ),
    Parameter(
        "key",
        "--key",
        type=Path,
        metavar="FILE",
        help="the key, which both hosts have, in a file of mode 0600 (default: ~/.local/state/graphnav/hosts.key)",
    ),
    Options.URL.but(
        help="the LCM group of this host, udpm://... (default: $LCM_DEFAULT_URL, else this machine's group)"
    ),
    Options.FOR_S,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.interrupts import Interrupt
    from graphnav.core.notices import print_notice
    from graphnav.processes.host_link import LinkError
    from graphnav.processes.tunnel.end import Ways
    from graphnav.processes.tunnel.report import Report
    from graphnav.processes.tunnel.tunnel import Tunnel

    _check(args)
    url = args.lcm_url()
    everything = [Chosen(".*")]
    ways = Ways(
        Choice(args.taken or ([] if args.serve else everything)),
        Choice(args.given or (everything if args.serve else [])),
    )
    links: HostListener | HostCaller = _listener(args) if args.serve else _caller(args)
    try:
        tunnel = Tunnel(url, ways, links, _say, print_notice)
    except BaseException:
        links.close()
        raise
    print(_begun(args, url, links.port), flush=True)
    report = Report(tunnel)
    try:
        with Interrupt() as interrupt:
            try:
                _carry(tunnel, links, report, interrupt, args.for_s)
            finally:
                interrupt.settle()
                tunnel.close()
    except LinkError as error:
        raise _final(error, args) from error
    _print_end(report)
    return Exit.OK if tunnel.n_opened or args.serve else Exit.FAILED


def _check(args: CommandArguments) -> None:
    if args.serve and args.host is not None:
        raise UserError.of(
            "one end serves, the other one calls",
            f"remove --serve to call {args.host}, or remove HOST",
            Place("--serve"),
        )
    if not args.serve and args.host is None:
        raise UserError.of(
            "no host is named",
            "write graphnav tunnel HOST, or graphnav tunnel --serve on the other host",
            Place("HOST"),
        )
    if not args.serve and args.address:
        raise UserError.of("an end that calls listens nowhere", "remove it, or add --serve", Place("--host"))
    if not args.serve and not args.port:
        raise UserError.of("port 0 is not a port to call", "write that of the other end", Place("--port"))


def _listener(args: CommandArguments) -> HostListener:
    """Return what listens; raise UserError where the key or the port is refused."""
    from graphnav.processes.host_key import key_file, made_key
    from graphnav.processes.host_link import HostListener
    from graphnav.processes.tunnel.tunnel import MAX_LINKS, SERVICE

    path = key_file(args.key)
    key, is_new = made_key(path)
    if is_new:
        print(f"made a key: copy it to the hosts that call, with mode 0600: {path}", flush=True)
    try:
        return HostListener(args.address, args.port, key, SERVICE, MAX_LINKS)
    except (OSError, UnicodeError) as error:
        number = getattr(error, "errno", None) or 0
        why = os.strerror(number) if number > 0 else getattr(error, "strerror", None) or "not an address"
        what = f"cannot listen on {args.address or 'this host'}, port {args.port}: {why}"
        raise UserError.of(what, "choose another port with --port, 0 for a free one, or another --host") from error


def _caller(args: CommandArguments) -> HostCaller:
    """Return what calls; raise UserError where the key is missing."""
    from graphnav.processes.host_key import key_file, read_key
    from graphnav.processes.host_link import HostCaller
    from graphnav.processes.tunnel.tunnel import SERVICE

    return HostCaller(args.host, args.port, read_key(key_file(args.key)), SERVICE)


def _begun(args: CommandArguments, url: str, port: int) -> str:
    """Return the first lines."""
    group = url.partition("?")[0]
    if not args.serve:
        return f"joining {group} with that of {args.host}; Ctrl-C ends it"
    taken = ", ".join(one.pattern for one in args.taken) or "nothing: name channels by --in"
    return f"serving {group} on port {port}; Ctrl-C ends it\n  takes from others: {taken}"


def _carry(
    tunnel: Tunnel, links: HostListener | HostCaller, report: Report, interrupt: Interrupt, for_s: float | None
) -> None:
    """Carry until Ctrl-C, or for a time; tell what is lost."""
    begin_s = status_s = losses_s = time.monotonic()
    end_s = math.inf if for_s is None else begin_s + for_s
    failure = ""
    with StatusLine() as status:
        while not interrupt.asked and (now_s := time.monotonic()) < end_s:
            tunnel.turn(min(_TURN_S, end_s - now_s))
            if now_s - status_s < _STATUS_S:
                continue
            status_s = now_s
            lines = [report.refusals(), report.clocks()]
            if now_s - losses_s >= _LOSSES_S:
                losses_s = now_s
                lines.append(report.losses())
            if (now_failing := "" if tunnel.ends else links.failure) != failure:
                failure = now_failing
                lines.append(f"{failure}; trying again" if failure else "")
            for line in filter(None, lines):
                status.clear()
                _say(f"{now_s - begin_s:.0f} s  {line}")
            parts = [report.sums(), counted(len(tunnel.ends), "connection"), *report.clock_lines()]
            status.show(f"{now_s - begin_s:.0f} s  {'; '.join(parts)}")
    if losses := report.losses():
        _say(f"{time.monotonic() - begin_s:.0f} s  {losses}")


def _say(line: str) -> None:
    print(line, flush=True)


def _final(error: LinkError, args: CommandArguments) -> UserError:
    """Return what to do about a refusal that time does not change."""
    from graphnav.processes.host_key import key_file
    from graphnav.processes.host_link import Refusal
    from graphnav.processes.tunnel.tunnel import refusal

    hint = {
        Refusal.SERVICE: "name the port of 'graphnav tunnel --serve' of another host, or another group with --url",
    }.get(error.reason, f"name the port of 'graphnav tunnel --serve' with --port; this one is {args.port}")
    return refusal(error, args.host, key_file(args.key), hint)


def _print_end(report: Report) -> None:
    """Print what was carried and lost."""
    from graphnav.core.tables import print_folded

    table = report.table()
    if table.rows:
        print_folded(table)
    if n_more := report.n_further_rows():
        print(f"and {counted(n_more, 'more row')}")
    for line in report.clock_lines():
        print(line)
    print(report.sums())
