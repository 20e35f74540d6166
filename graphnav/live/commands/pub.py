"""``graphnav pub``: publish a message, once or at a rate."""

from __future__ import annotations

from graphnav.core.cli import CommandArguments, Exit, Options, channel_name, positive
from graphnav.core.parameters import Parameter, command

_EXAMPLES = """\
examples:
  graphnav pub TELEOP Twist 'v_mps: 0.2, omega_radps: 0' --rate 10
  graphnav pub STOP stop_t 'engaged: true, reason: by hand'
  graphnav pub BASE_CMD some_robot.command_t '{wheels: [{speed: 1.5}, {speed: 1.5}]}' --rate 20 --for 3

FIELDS is YAML; omitted fields are zero or empty. utime is the current time and seq counts, unless given.
"""


@command(
    Options.CHANNEL.but(type=channel_name, help="the LCM channel"),
    Parameter(
        "type",
        metavar="TYPE",
        help="Twist, twist_t, or package.type_t of an installed package or of --types",
        offers="types",
    ),
    Parameter("fields", metavar="FIELDS", nargs="?", default="", help="the fields (default: all zero)"),
    Parameter("rate", "--rate", type=positive, metavar="HZ", help="publish repeatedly (default: once)"),
    Options.MAX_MESSAGES.but(help="end after N messages; needs --rate"),
    Options.FOR_S.but(help="end after S seconds (default: Ctrl-C); needs --rate"),
    Options.URL,
    *Options.TYPES,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav import Place, UserError
    from graphnav.core.bus import Bus
    from graphnav.core.codec import codec_of, lcm_name
    from graphnav.core.field_summary import described, summarised
    from graphnav.live.publish import Publisher, parse_fields, repeat

    if args.rate is None and (args.count or args.for_s):
        option = "-n" if args.count else "--for"
        raise UserError.of("without --rate only one message is published", "give --rate HZ", Place(option))
    url = args.lcm_url()
    lcm_class = args.known_types().called(args.type)
    fields = parse_fields(args.fields, lcm_class)
    bus = Bus(url)
    publisher = Publisher(bus, args.channel, lcm_class, fields)
    rhythm = f"at {args.rate:g} Hz" if args.rate else "once"
    print(f"publishing {lcm_name(lcm_class)} on '{args.channel}' {rhythm}, {url}")
    values = codec_of(lcm_class).decode(codec_of(lcm_class).encode(fields.values))
    given = {name: value for name, value in values.items() if name in fields.given}
    print("\n".join(described(summarised(given)) or ["    all fields zero"]), flush=True)
    try:
        if args.rate is None:
            publisher.publish()
        else:
            repeat(publisher.publish, args.rate, args.count, args.for_s)
    finally:
        bus.close()
        if args.rate is not None:
            print(f"{publisher.count} messages published")
    return Exit.OK
