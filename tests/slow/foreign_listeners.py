"""Programs in C and Java that decode what is played, and what the log holds, to compare with."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, Self

import lcm
from testbed.drives import GRAPHNAV

from graphnav import Recording
from graphnav.core.codec import lcm_name
from graphnav.core.typeinfo import file_of_lcm
from graphnav.develop.java import find_jdk

_SOURCES = Path(__file__).with_name("foreign")
_ROOT = Path(__file__).resolve().parents[2]
_TOOLS = Path(lcm.LCM_BIN_DIR)


class Sums(NamedTuple):
    """Of each channel its type, and its number of messages with the sums of their ``utime`` and ``seq``."""

    types: Mapping[str, str]
    sums: Mapping[str, tuple[int, int, int]]

    @classmethod
    def of_log(cls, path: Path) -> Self:
        """Return what a log holds."""
        with Recording(path) as recording:
            types = {name: lcm_name(lcm_class) for name, lcm_class in recording.channels.items() if lcm_class}
            heads = [head for head in recording.heads() if head.channel in types]
        sums = dict.fromkeys(types, (0, 0, 0))
        for head in heads:
            count, utime, seq = sums[head.channel]
            sums[head.channel] = count + 1, utime + head.utime, seq + head.seq
        return cls(types, sums)


def c_listener(folder: Path, types: Mapping[str, str], url: str) -> list[str]:
    """Build a C program of all our types and LCM's library from its wheel; return the command that listens."""
    folder.mkdir()
    definitions = sorted((_ROOT / "lcmtypes").glob("*.lcm"))
    subprocess.run([_TOOLS / "lcm-gen", "-c", *definitions], cwd=folder, check=True, capture_output=True)
    names = {channel: type_name.replace(".", "_") for channel, type_name in types.items()}
    lines = [f'#include "{name}.h"' for name in dict.fromkeys(names.values())]
    rows = (f'X({number}, {name}, "{channel}")' for number, (channel, name) in enumerate(names.items()))
    (folder / "channels.h").write_text("\n".join([*lines, "#define CHANNELS \\", " \\\n".join(rows)]) + "\n")
    root, generated = _TOOLS.parent, sorted(folder.glob("*.c"))
    flags = ["-std=gnu11", "-Wall", f"-I{root}/include", f"-I{folder}", f"-L{root}/lib", f"-Wl,-rpath,{root}/lib"]
    program = folder / "listener"
    subprocess.run(["gcc", *flags, "-o", program, _SOURCES / "listener.c", *generated, "-llcm"], check=True)
    return [str(program), url]


def java_listener(folder: Path, types: Mapping[str, str], url: str) -> list[str] | None:
    """Build the jar of our types and a Java program; return the command that listens, None without a JDK."""
    if find_jdk().missing:
        return None
    subprocess.run([GRAPHNAV, "types", "--java", folder], check=True, capture_output=True)
    jar = next(folder.rglob("*.jar"))
    path = os.pathsep.join(map(str, (jar, file_of_lcm("lcm.jar"), folder)))
    subprocess.run(["javac", "-cp", path, "-d", folder, _SOURCES / "Listener.java"], check=True)
    words = [f"{channel}={type_name}" for channel, type_name in types.items()]
    return ["java", "-Djava.net.preferIPv4Stack=true", "-cp", path, "Listener", url, *words]


def played(listener: Sequence[str], log: Path, url: str) -> dict[str, tuple[int, int, int]]:
    """Let lcm-logplayer play a log to a listener; return the sums that it prints."""
    with subprocess.Popen(listener, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stdin is not None
        assert program.stdout.readline() == "ready\n"
        subprocess.run([_TOOLS / "lcm-logplayer", "--lcm-url", url, log], check=True, capture_output=True)
        program.stdin.close()
        lines = [line.split() for line in program.stdout.read().splitlines()]
    return {name: (int(count), int(utime), int(seq)) for name, count, utime, seq in lines}
