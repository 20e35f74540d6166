"""``graphnav lcm-spy``: start LCM's own spy with the types of graphnav, of plugins and of ``--types``."""

from __future__ import annotations

import os
import sys

from graphnav.core.cli import CommandArguments, Options
from graphnav.core.parameters import Parameter, command


@command(Parameter("url", nargs="?", metavar="URL", help="udpm://... (default: where runs are tapped)"), *Options.TYPES)
def main(args: CommandArguments) -> int:
    """Run the command: build the jar of all types unless it is cached, then replace this process by lcm-spy."""
    from graphnav import UserError
    from graphnav.core.lcm_url import lcm_url
    from graphnav.core.typeinfo import file_of_lcm
    from graphnav.develop.java import require_jdk, types_jar

    url = lcm_url(("URL", args.url))
    require_jdk()
    known = args.known_types()
    if not os.environ.get("DISPLAY"):
        what = "lcm-spy opens a window, but there is no display: DISPLAY is not set"
        raise UserError.of(what, "run it in a graphical session, or watch in this terminal: graphnav spy")
    types = known.every()
    jar = types_jar(types.values())
    print(f"lcm-spy on {url}: {len(types)} types in {jar}", file=sys.stderr, flush=True)
    classpath = os.pathsep.join(filter(None, (str(jar), os.environ.get("CLASSPATH"))))
    lcm_spy = str(file_of_lcm("lcm-spy"))
    os.execve(lcm_spy, [lcm_spy, "--lcm-url", url], {**os.environ, "CLASSPATH": classpath})  # noqa: S606, of the wheel
