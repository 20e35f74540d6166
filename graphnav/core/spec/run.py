"""Options under ``run:``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from graphnav.core.errors import ParamError
from graphnav.core.spec.declared import Record, key
from graphnav.core.stage import param, params_of

RecordOption = Literal["all", "small", "replayable"]
"""Selection of the messages that a log keeps."""


def option_in(written: object) -> RecordOption | None:
    """Return what a log keeps by ``record`` of a graph, which may be written as a mapping; None if it does not say."""
    word = written.get("keep") if isinstance(written, dict) else written
    return next((option for option in get_args(RecordOption) if option == word), None)


URL_SCHEMES = ("udpm://", "memq://")
"""Between processes, and inside one."""


def check_url(url: str) -> None:
    """Refuse a URL of the channels that leave and come in that is not of `URL_SCHEMES`.

    Raises
    ------
    ParamError
        It is of ``url``.
    """
    if not url.startswith(URL_SCHEMES):
        raise ParamError(
            "url", f"'url' must begin with udpm://, not be '{url}'", "write udpm://239.255.76.67:7667?ttl=0"
        )


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How a graph runs, unless the command line says otherwise."""

    until_s: float | None = param(None, gt=0.0, le=1e9, doc="when to stop; null runs until a source finishes")
    seed: int = param(0, ge=0, le=4_294_967_295, doc="all randomness of a run derives from it")
    record: Literal["all", "small", "replayable"] | None = param(
        None,
        doc="what the log keeps; small: messages below 4 kB, and the first of every channel; replayable: also what "
        "inputs and sources bring, from which commands that read the log make the rest again; null: replayable in "
        "lockstep, small live",
    )
    rotate_mb: float | None = param(
        None, gt=0.0, le=1e9, doc="begin a new file of the log before one exceeds so many megabytes"
    )
    rotate_s: float | None = param(None, gt=0.0, le=1e9, doc="begin a new file of the log after so many seconds")
    portable: bool = param(
        False,
        doc="refuse to run where the log would not be the same on every machine: numpy, OpenCV and BLAS must compute "
        "with AVX2 and FMA, which the command 'graphnav' chooses wherever the CPU has them",
    )
    url: str | None = param(
        None,
        doc="LCM URL of the channels that leave and come in, live; null: LCM_DEFAULT_URL, else this machine's group",
    )


def _same(option: str) -> Any:
    """Return the key that is an option of a run."""
    param = params_of(RunOptions)[option]
    return key(param.default, doc=param.doc, ge=param.ge, gt=param.gt, le=param.le, lt=param.lt)


class LogKeys(Record):
    """`record`, where the log is rotated too."""

    noun = "record"
    named = "record"
    example = "record: {keep: small, rotate_mb: 500}"

    keep: RecordOption | None = _same("record")
    rotate_mb: float | None = _same("rotate_mb")
    rotate_s: float | None = _same("rotate_s")


class RunKeys(Record):
    """How a graph runs, unless the command line says otherwise."""

    noun = "run"
    named = "run"
    example = "run: {until_s: 60, seed: 7}"

    until_s: float | None = _same("until_s")
    seed: int = _same("seed")
    record: RecordOption | LogKeys | None = _same("record")
    portable: bool = _same("portable")
    url: str | None = _same("url")

    @property
    def log(self) -> LogKeys:
        """The selection and rotation of the log."""
        return self.record if isinstance(self.record, LogKeys) else LogKeys(keep=self.record)

    @property
    def options(self) -> RunOptions:
        """The options that it gives."""
        log = self.log
        return RunOptions(
            until_s=self.until_s,
            seed=self.seed,
            record=log.keep,
            rotate_mb=log.rotate_mb,
            rotate_s=log.rotate_s,
            portable=self.portable,
            url=self.url,
        )
