"""The lines of text that a base understands, and those in which it tells its odometry."""

from __future__ import annotations

import math
import re
from string import Formatter

from graphnav import Odometry, Twist, UserError

WHEELS_MPS, WHEELS_RADPS = ("left_mps", "right_mps"), ("left_radps", "right_radps")
COMMANDS = ("v_mps", "omega_radps", *WHEELS_MPS, *WHEELS_RADPS)
ODOMETRY = ("x_m", "y_m", "yaw_rad", "v_mps", "omega_radps")
MAX_LINE_BYTES = 1024
_NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
_ESCAPES = {"\\n": "\n", "\\r": "\r", "\\t": "\t", "\\0": "\0"}


class CommandLine:
    """A command as a line of text, by a format with the fields `COMMANDS`, such as ``{v_mps:.3f},{omega_radps:.3f}``.

    Wheels are those of a differential drive: ``track_m`` between them, ``radius_m`` for turning rates. Line ends, tabs
    and null characters may be written with a backslash; a format without a line end gets a newline.

    Raises
    ------
    UserError
        The format has another field, or lacks a measure of the base.
    """

    def __init__(self, text: str, track_m: float | None, radius_m: float | None) -> None:
        for escape, character in _ESCAPES.items():
            text = text.replace(escape, character)
        self._text = text if text.endswith(("\n", "\r", "\0")) else text + "\n"
        self._track_m, self._radius_m = track_m, radius_m
        fields = _fields(self._text, "--format", COMMANDS)
        if not {*WHEELS_MPS, *WHEELS_RADPS}.isdisjoint(fields) and track_m is None:
            raise UserError.of(
                "--format has speeds of wheels, but the distance of the wheels is not known", "add --track-m"
            )
        if not set(WHEELS_RADPS).isdisjoint(fields) and radius_m is None:
            raise UserError.of("--format has turning rates of wheels, but their radius is not known", "add --radius-m")
        try:
            self.stop = self.of(Twist(v_mps=0.0, omega_radps=0.0))
        except (ValueError, LookupError) as error:
            raise UserError.of(f"--format: {error}", "write numbers as {v_mps:.3f} or {v_mps}") from error

    def of(self, twist: Twist) -> bytes:
        """Return the line of a command."""
        half_mps = 0.5 * (self._track_m or 0.0) * twist.omega_radps
        left_mps, right_mps = twist.v_mps - half_mps, twist.v_mps + half_mps
        radius_m = self._radius_m or math.inf
        values = twist.v_mps, twist.omega_radps, left_mps, right_mps, left_mps / radius_m, right_mps / radius_m
        # -0.0 would be written with its sign
        return self._text.format(**{name: value + 0.0 for name, value in zip(COMMANDS, values, strict=True)}).encode()


class OdometryLines:
    """Odometry from the lines of a base, by a format with the fields `ODOMETRY`, ``{x_m} {y_m} ...``.

    Other lines, and what is not finite, are counted in ``unread``.

    Raises
    ------
    UserError
        The format lacks a field, or has another one.
    """

    def __init__(self, text: str) -> None:
        fields = _fields(text, "--odometry", ODOMETRY)
        if missing := [name for name in ODOMETRY if name not in fields]:
            raise UserError.of(f"--odometry lacks {', '.join(missing)}", f"name {', '.join(ODOMETRY)}")
        parts = [(re.escape(literal), name) for literal, name, _, _ in Formatter().parse(text)]
        self._pattern = re.compile(
            "".join(literal.replace(r"\ ", r"\s+") + (_NUMBER if name else "") for literal, name in parts)
        )
        self._order = [name for _, name in parts if name]
        self.unread = 0
        self._begun = b""

    def feed(self, data: bytes) -> list[Odometry]:
        """Return what the lines say that ``data`` completes."""
        *lines, self._begun = (self._begun + data).replace(b"\r", b"\n").split(b"\n")
        self._begun = self._begun[-MAX_LINE_BYTES:]
        found = [self._read(line) for line in lines if line.strip()]
        return [one for one in found if one is not None]

    def _read(self, line: bytes) -> Odometry | None:
        match = self._pattern.fullmatch(line.decode("ascii", "replace").strip())
        values = [float(number) for number in match.groups()] if match else []
        if not values or not all(map(math.isfinite, values)):
            self.unread += 1
            return None
        return Odometry(**dict(zip(self._order, values, strict=True)))


def _fields(text: str, option: str, known: tuple[str, ...]) -> list[str]:
    """Return the fields of a format; raises UserError for another one than those that are known."""
    try:
        fields = [name for _, name, _, _ in Formatter().parse(text) if name is not None]
    except ValueError as error:
        raise UserError.of(f"{option}: {error}", "write braces that are part of the line twice: {{ and }}") from error
    for name in fields:
        if name not in known:
            raise UserError.of(f"{option} has no field '{name}'", f"fields are {', '.join(known)}")
    if not fields:
        raise UserError.of(f"{option} has no field", f"fields are {', '.join(known)}")
    return fields
