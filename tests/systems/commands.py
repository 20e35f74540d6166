"""``python commands.py``: run in an empty folder what works on every system; end with the first command that does not.

It is what CI runs on macOS and Windows, with graphnav alone installed, and `test_systems.py` on simulated ones.
"""

from __future__ import annotations

import contextlib
import io
import sys
from pathlib import Path

from graphnav.core import cli
from graphnav.core.machine import is_linux

STUDY = "ablate corridor_ccw --vary plane=plane.homography,plane.affine --seeds 0:1 --set run.until_s=1 -j 2 -o study"
ANYWHERE = (
    ("", "commands:"),
    ("--version", "graphnav"),
    ("check corridor_ccw navigate", "corridor_ccw"),
    ("draw corridor_ccw", "robot"),
    ("stages plane", "plane.ica"),
    ("types twist_t", "twist_t"),
    ("schema", "$schema"),
    ("run corridor_ccw --until 1 -o out", "run.lcmlog"),
    ("info out", "robot.image"),
    ("spy out --once", "robot.image"),
    ("echo control.twist out -n 1", "control.twist"),
    ("replay out", "metrics as recorded"),
    ("figure out --at 0.5", "out"),
    ("export out --to csv -o out.csv --channel control.twist", ""),
    (STUDY, "report.html"),
    (STUDY, "report.html"),
)
"""Commands, and what each prints; the second time a study goes on where it stopped."""
LINUX = (
    ("spy", "channels between programs work"),
    ("hz robot.image", "channels between programs work"),
    ("play out", "channels between programs work"),
    ("spy robot.local: --once", "the feed of another computer works"),
    ("run navigate_live", "live runs work"),
    ("run corridor_ccw --live", "live runs work"),
    ("run corridor_ccw --processes", "runs in several processes work"),
    ("run corridor_ccw -d", "--detach works"),
    ("teleop", "'graphnav teleop' works"),
    ("ps", "'graphnav ps' works"),
    ("lcm-spy", "'graphnav lcm-spy' works"),
)
"""Commands that other systems refuse, and the subject of the refusal."""
FILES = ("out/run.lcmlog", "out/summary.json", "study/report.html", "study/plan.json")


def run(words: str) -> tuple[int, str, str]:
    """Run a command of graphnav; return its status and what it printed on both streams."""
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="cp1252") for _ in range(2)]
    sys.argv = ["graphnav", *words.split()]
    with contextlib.redirect_stdout(streams[0]), contextlib.redirect_stderr(streams[1]):
        try:
            status = cli.main()
        except SystemExit as end:
            status = int(end.code or 0)
    texts = []
    for stream in streams:
        stream.flush()
        texts.append(stream.buffer.getvalue().decode("cp1252"))
    return status, texts[0], texts[1]


def check(words: str, wanted_status: int, wanted: str) -> None:
    """End the program unless a command ends with a status and prints some text, on standard error if it fails."""
    status, out, err = run(words)
    print(f"graphnav {words}: {status}", flush=True)
    printed = err if wanted_status else out
    if status != wanted_status or wanted not in printed or "Traceback" in err:
        sys.exit(f"wanted {wanted_status} and {wanted!r}\n--- stdout\n{out}--- stderr\n{err}")


def main() -> None:
    """Run all."""
    for words, wanted in ANYWHERE:
        check(words, 0, wanted)
    if missing := [name for name in FILES if not Path(name).is_file()]:
        sys.exit(f"not written: {missing}")
    if left := [str(path) for path in Path().rglob(".*") if path.name != ".lock"]:
        sys.exit(f"left behind: {left}")
    if not is_linux():
        for words, what in LINUX:
            check(words, 2, f"{what} on Linux only, and this is ")


if __name__ == "__main__":
    main()
