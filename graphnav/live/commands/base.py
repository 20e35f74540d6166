"""``graphnav base``: pass commands on to a base on a serial line."""

from __future__ import annotations

from graphnav.core.cli import CommandArguments, Exit, Options, channel_name, positive
from graphnav.core.parameters import COUNT, Parameter, command, seconds

_EXAMPLES = """\
examples:
  graphnav base /dev/ttyUSB0                                     0.200,0.500 for 0.2 m/s and 0.5 rad/s to the left
  graphnav base /dev/ttyACM0 --baud 57600 --format 'V {v_mps:.3f} {omega_radps:.3f}\\r\\n'
  graphnav base /dev/ttyUSB0 --format 'M {left_radps:.2f} {right_radps:.2f}' --track-m 0.3 --radius-m 0.05
  graphnav base /dev/ttyUSB0 --odometry 'O {x_m} {y_m} {yaw_rad} {v_mps} {omega_radps}'

Fields of --format: v_mps, omega_radps; left_mps and right_mps (with --track-m); left_radps and right_radps (with
--radius-m too). Without commands for --timeout the base gets stops. The base needs a timeout of its own all the same:
nothing is written when this program is killed, or the cable is pulled.
"""


@command(
    Parameter("port", metavar="DEVICE", help="the serial line, such as /dev/ttyUSB0"),
    Parameter("baud", "--baud", type=COUNT, default=115200, metavar="N", help="bits per second (default: %(default)s)"),
    Parameter(
        "channel",
        "--channel",
        type=channel_name,
        default="BASE_CMD",
        help="channel of the commands, graphnav_lcm.twist_t (default: %(default)s)",
    ),
    Parameter(
        "format",
        "--format",
        default="{v_mps:.3f},{omega_radps:.3f}",
        metavar="LINE",
        help="what a command is written as (default: %(default)s)",
    ),
    Parameter("track_m", "--track-m", type=positive, metavar="M", help="distance between the wheels, m"),
    Parameter("radius_m", "--radius-m", type=positive, metavar="M", help="radius of the wheels, m"),
    Parameter(
        "timeout",
        "--timeout",
        type=seconds,
        default=0.5,
        metavar="S",
        help="stop the base when no command came for S seconds (default: %(default)s)",
    ),
    Parameter("odometry", "--odometry", metavar="LINE", help="read odometry in lines of this form from the base"),
    Parameter(
        "odometry_channel",
        "--odometry-channel",
        type=channel_name,
        default="ODOMETRY",
        help="channel of the odometry (default: %(default)s)",
    ),
    Options.URL,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import Place, UserError
    from graphnav.core.bus import Bus
    from graphnav.live.base_bridge import BaseBridge
    from graphnav.live.base_lines import CommandLine, OdometryLines
    from graphnav.live.serial_line import RATES

    if args.baud not in RATES:
        near = min((rate for rate in RATES if rate), key=lambda rate: abs(rate - args.baud))
        raise UserError.of(f"a serial line cannot run at {args.baud} baud", f"did you mean {near}?", Place("--baud"))
    line = CommandLine(args.format, args.track_m, args.radius_m)
    odometry = None if args.odometry is None else (args.odometry_channel, OdometryLines(args.odometry))
    url = args.lcm_url()
    bus = Bus(url)
    print(f"listening for graphnav_lcm.twist_t on '{args.channel}', {url}", flush=True)
    bridge = BaseBridge(bus, args.channel, args.port, args.baud, line, args.timeout, odometry, _show)
    try:
        bridge.run()
    finally:
        bus.close()
    return Exit.OK


def _show(line: str) -> None:
    print(line, flush=True)
