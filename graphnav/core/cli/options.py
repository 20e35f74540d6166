"""Arguments shared by several commands."""

from __future__ import annotations

import argparse
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from graphnav.core.errors import GraphnavError, Place, Problem, UserError
from graphnav.core.interrupts import ended_by_interrupt
from graphnav.core.notices import print_notice

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog
    from graphnav.core.graph import Graph, Override
    from graphnav.core.record import ChannelFilter

MAX_S = 1e9
"""The longest duration that an option takes."""
MAX_FACTOR = 1e6
"""The maximum of rates, speeds and factors that options take; the inverse is the minimum."""
MAX_SEED = 2**32 - 1
_MAX_DIGITS = 12


def add_graph_options(
    parser: argparse.ArgumentParser, nargs: Literal["?", "+"] | None = None, *, runs: bool = False
) -> None:
    """Declare GRAPH, of which there are as many as ``nargs`` says, ``--set`` and ``--plugin``, for `load`.

    ``runs``: whether the command runs the graph because the user says so, and with it the plugins that the graph names;
    others get ``--trust``.
    """
    parser.add_argument("graph", nargs=nargs, metavar="GRAPH", help="a YAML file, or the name of a graph that ships")
    add_set_option(parser)
    add_plugin_option(parser)
    if runs:
        parser.set_defaults(trust=True)
    else:
        add_trust_option(parser)


def add_trust_option(parser: argparse.ArgumentParser) -> None:
    """Declare ``--trust``, for `catalog_of`."""
    parser.add_argument(
        "--trust",
        action="store_true",
        help="run the plugin files that the graph or the run folder names, without asking (default: only those that "
        "graphnav wrote or whose folder is trusted; at a terminal, ask)",
    )


def add_set_option(parser: argparse.ArgumentParser) -> None:
    """Declare ``--set``, for `overrides_of`."""
    parser.add_argument(
        "--set",
        dest="sets",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="swap a stage (plane=plane.affine), a parameter (plane.rule=otsu), a time (guard.every_ms=20) or a wire "
        "(plane.in.flow=flow.flow), or add a stage (twin+=plane.affine)",
    )


def overrides_of(args: argparse.Namespace) -> tuple[Override, ...]:
    """Return the overrides of ``--set``.

    Raises
    ------
    UserError
        Every option that is not an override.
    """
    from graphnav.core.graph import parse_overrides

    problems: list[Problem] = []
    overrides = parse_overrides(args.sets, problems)
    if problems:
        raise UserError(problems)
    return overrides


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Declare ``--seed`` and ``--until``, for `load`."""
    parser.add_argument("--seed", type=int, help="seed of all randomness (default: the graph's)")
    parser.add_argument("--until", type=float, metavar="S", help="stop after S seconds: simulated, or live")


def add_verbose_option(
    parser: argparse.ArgumentParser, text: str = "show the cause of a failure with its traceback"
) -> None:
    """Declare ``-v``, for `FailureReport`; ``text`` is its help."""
    parser.add_argument("-v", "--verbose", action="store_true", help=text)


def notices_of(graph: Graph, *, verbose: bool) -> tuple[str, ...]:
    """Return the notices of a graph: with ``-v`` also the swaps that its own files make."""
    return (*graph.file_notices, *graph.notices) if verbose else graph.notices


class FailureReport:
    """Prints what failed; with ``-v`` the traceback of each failure as it is met, else that ``-v`` would show it."""

    def __init__(self, args: argparse.Namespace) -> None:
        self._verbose: bool = args.verbose
        self._has_more = False

    def __call__(self, error: BaseException) -> None:
        """Take a failure."""
        if self._verbose:
            traceback.print_exception(error)
        self._has_more |= error.__cause__ is not None or not isinstance(error, GraphnavError)

    def print(self, *failures: str) -> None:
        """Print the failures that a run ended with."""
        hints = ["  -v shows the traceback"] if self._has_more and not self._verbose else []
        for line in (*failures, *hints):
            print(line, file=sys.stderr)


def add_portable_option(parser: argparse.ArgumentParser) -> None:
    """Declare ``--portable`` and ``--no-portable``."""
    parser.add_argument(
        "--portable",
        action=argparse.BooleanOptionalAction,
        help="compute with AVX2 and FMA, so that logs are the same on every machine that has them, or refuse; with "
        "--no-portable numpy, OpenCV and BLAS choose by the CPU (default: portable where the CPU can)",
    )


def add_plugin_option(parser: argparse.ArgumentParser) -> None:
    """Declare ``--plugin``, for `catalog_of`."""
    parser.add_argument(
        "--plugin", dest="plugins", action="append", default=[], type=Path, metavar="FILE", help="a file with stages"
    )


def add_former_option(parser: argparse.ArgumentParser, former: str, now: str) -> None:
    """Refuse an option of an earlier version, and suggest what it is called now."""

    class Refuse(argparse.Action):
        def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
            parser.error(f"unknown option {former}: did you mean '{now}'?")

    parser.add_argument(former, action=Refuse, help=argparse.SUPPRESS)


def seconds(text: str) -> float:
    """Parse a duration above 0."""
    try:
        if 0 < (value := float(text)) <= MAX_S:
            return value
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a number of seconds above 0, at most {MAX_S:g}")


def positive(text: str) -> float:
    """Parse a rate or a factor: a number above 0, within `MAX_FACTOR` and its inverse."""
    try:
        if 1 / MAX_FACTOR <= (value := float(text)) <= MAX_FACTOR:
            return value
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a number above 0, from {1 / MAX_FACTOR:g} to {MAX_FACTOR:g}")


def seed(text: str) -> int:
    """Parse the seed of a random generator."""
    if text.isascii() and text.isdecimal() and len(text) <= _MAX_DIGITS and int(text) <= MAX_SEED:
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}' is not a seed: write an integer from 0 to {MAX_SEED}")


def channel_name(text: str) -> str:
    """Parse the name of a channel: accepted by LCM and not reserved."""
    from graphnav.core.graph.wiring.channels import MAX_NAME, RESERVED

    if not text or not text.isascii() or not text.isprintable() or " " in text:
        raise argparse.ArgumentTypeError(
            f"{text!r} cannot be the name of a channel: use ASCII characters without spaces"
        )
    if len(text) > MAX_NAME:
        raise argparse.ArgumentTypeError(f"'{text}' has {len(text)} characters, but LCM takes at most {MAX_NAME}")
    if text.startswith(RESERVED):
        raise argparse.ArgumentTypeError(f"channel names that begin with '{RESERVED}' are reserved: '{text}'")
    return text


def count(text: str) -> int:
    """Parse an integer above 0."""
    if text.isascii() and text.isdecimal() and len(text) <= _MAX_DIGITS and int(text):
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}' is not an integer above 0, of at most {_MAX_DIGITS} digits")


def add_feed_argument(parser: argparse.ArgumentParser) -> None:
    """Declare FEED: where to listen."""
    parser.add_argument(
        "feed",
        nargs="?",
        metavar="FEED",
        help="a udpm:// URL, a log or a run folder (default: where runs are tapped)",
    )


def add_channel_and_feed(parser: argparse.ArgumentParser) -> None:
    """Declare CHANNEL, which may be left out, and FEED, for `channel_and_feed`."""
    parser.add_argument("channel", nargs="?", metavar="CHANNEL", help="the channel's name (default: all channels)")
    add_feed_argument(parser)


def channel_and_feed(args: argparse.Namespace) -> tuple[str | None, str | None]:
    """Return the channel and the feed; a single word is the feed if it is a URL, a file or a folder."""
    if args.channel is not None and args.feed is None and _is_feed(args.channel):
        return None, args.channel
    return args.channel, args.feed


def _is_feed(word: str) -> bool:
    try:
        return word.startswith("udpm:") or (word != "" and Path(word).exists())
    except (OSError, ValueError):  # a name too long, or with a null character
        return False


def add_types_option(parser: argparse.ArgumentParser) -> None:
    """Declare ``--types`` and ``--plugin``, for `load_types_of`."""
    add_plugin_option(parser)
    parser.add_argument(
        "--types",
        action="append",
        default=[],
        metavar="PACKAGE_OR_DIR",
        help="decode LCM types of a package generated by lcm-gen, or of a folder of .lcm files; may be repeated",
    )


def load_types_of(args: argparse.Namespace, catalog: Catalog | None = None) -> dict[str, type]:
    """Register the types of ``--types``, of ``--plugin`` and of installed packages for decoding; return the first.

    ``catalog``: the command's own, with the ``--plugin`` files. The types are returned by LCM name.

    Raises
    ------
    UserError
        They do not exist, or cannot be used.
    """
    (catalog_of(args) if catalog is None else catalog).load_types()
    if not args.types:
        return {}
    from graphnav.core.typeinfo import load_types

    return load_types(args.types)


def add_url_option(parser: argparse.ArgumentParser) -> None:
    """Declare ``--url``, for `url_of`."""
    parser.add_argument(
        "--url",
        metavar="URL",
        help="where to publish, udpm://... (default: $LCM_DEFAULT_URL, else this machine's group)",
    )


def url_of(args: argparse.Namespace) -> str:
    """Return the LCM URL to publish on: ``--url``, ``LCM_DEFAULT_URL``, or this machine's group.

    Raises
    ------
    UserError
        The URL does not reach other programs.
    """
    from graphnav.core.lcm_url import lcm_url

    return lcm_url(("--url", args.url))


def add_channel_options(parser: argparse.ArgumentParser) -> None:
    """Declare ``--channel``, ``--regex`` and ``--invert``, for `channels_of`."""
    parser.add_argument(
        "-c",
        "--channel",
        dest="globs",
        action="append",
        default=[],
        metavar="GLOB",
        help="only channels that match, such as 'robot.*'; may be repeated (default: all)",
    )
    parser.add_argument(
        "--regex",
        dest="regexes",
        action="append",
        default=[],
        metavar="RE",
        help="only channels whose entire name matches a regular expression; may be repeated",
    )
    parser.add_argument("-v", "--invert", action="store_true", help="only channels that match none of them")


def channels_of(args: argparse.Namespace) -> ChannelFilter:
    """Return the channels selected by the options.

    Raises
    ------
    UserError
        ``--regex`` is not a regular expression, or ``--invert`` has nothing to invert.
    """
    from graphnav.core.record import ChannelFilter

    if args.invert and not args.globs and not args.regexes:
        raise UserError.of("there is no filter to invert", "add --channel GLOB or --regex RE", Place("--invert"))
    return ChannelFilter(args.globs, args.regexes, invert=args.invert)


def catalog_of(args: argparse.Namespace) -> Catalog:
    """Return the catalog with the ``--plugin`` files, and the trust that the command has in others."""
    from graphnav.core.api.load import add_plugins
    from graphnav.core.catalog import Catalog
    from graphnav.core.cli.trust import trust_of

    return add_plugins(Catalog(trust_of(args)), args.plugins)


def load(
    args: argparse.Namespace, name: str | None = None, *, partial: bool = False, makes_stages: bool = True
) -> tuple[Catalog, Graph]:
    """Return the catalog with the ``--plugin`` files and the checked graph with its swaps, seed and end.

    ``name``: the graph, by default GRAPH. ``partial``: the graph may lack plugins that are not trusted
    (`Graph.left_out`), which are told. ``makes_stages``: whether the stages will be made, so that what they miss is
    reported with the other errors.

    Raises
    ------
    UserError
        Everything that is wrong with the graph or the options.
    """
    with ended_by_interrupt(owns_process=args.owns_process):
        from graphnav.core.api.load import load_with, with_run_options
        from graphnav.core.graph import parse_overrides

        catalog = catalog_of(args)
        problems: list[Problem] = []
        overrides = parse_overrides(args.sets, problems)
        options = {"partial": partial, "makes_stages": makes_stages}
        graph = load_with(catalog, name or args.graph, overrides, args.plugins, problems, **options)
        for problem in graph.left_out:
            print_notice(str(problem))
        given = {
            "seed": getattr(args, "seed", None),
            "until_s": getattr(args, "until", None),
            "record": getattr(args, "record", None),
        }
        return catalog, with_run_options(graph, given, {"seed": "--seed", "until_s": "--until", "record": "--record"})
