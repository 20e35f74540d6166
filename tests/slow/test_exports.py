"""Every format that a log is exported to, read back by its own library: a drive of 60 s."""

from __future__ import annotations

import csv
import json
import math
import os
import shutil
import subprocess
import sysconfig
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import jsonschema
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from testbed.drives import GRAPHNAV, drive

from graphnav import Recording
from graphnav.core.messages import About
from graphnav.core.run_folder import RunFolder
from graphnav.watch.export.entries.topics import Topics
from graphnav.watch.export.foxglove import TOPICS
from graphnav.watch.export.scalar_fields import Scalar, leaves_of
from tests.targets import Targets

from .display import display

_UNTIL_S = 60
_SLOW = "control.max_speed_mps=0.2"
"""The drive of the shipped graph finishes before 60 s."""
_VIEWER_PX = (1400, 900)
_SCRIPTS = Path(sysconfig.get_path("scripts"))


@pytest.fixture(scope="module")
def run(seeds: range, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a drive of 60 s with everything recorded."""
    folder = tmp_path_factory.mktemp("exports") / "run"
    drive("corridor_ccw", seeds[0], (_SLOW, f"run.until_s={_UNTIL_S}", "run.record=all"), folder)
    return folder


@pytest.mark.parametrize("kind", ["mcap", "rrd", "mp4", "csv", "parquet"])
def test_exports(targets: Targets, run: Path, kind: str) -> None:
    """Export the drive, read that back, print how much of the recording it contains."""
    target = run.parent / f"run.{kind}"
    command = [str(GRAPHNAV), "export", str(run), "--to", kind, "-o", str(target)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    with Recording(run / RunFolder.LOG) as recording:
        n_messages = sum(map(recording.count, recording.channels))
        lasted_s = recording.timeline.duration_us * 1e-6
        targets.say(f"a drive of {lasted_s:.1f} s, {n_messages} messages on {len(recording.channels)} channels")
        good, numbers = _CHECKS[kind](recording, target)
    targets.check(f"{done.stdout.strip().removeprefix(f'{run.parent}/')}: {numbers}", good=good)
    if kind == "rrd" and _opened_by_rerun(target, shown := run.parent / "rerun.png"):
        targets.say(f"Rerun's viewer opens it: look at {shown}")


def _mcap(recording: Recording, target: Path) -> tuple[bool, str]:
    """Decode every message by the schema that the file holds."""
    counts: Counter[str] = Counter()
    schemas: dict[str, str] = {}
    with target.open("rb") as file:
        factory = DecoderFactory()
        reader = make_reader(file, decoder_factories=[factory], validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if channel.message_encoding == "json":
                jsonschema.validate(json.loads(message.data), json.loads(schema.data))
            else:
                decode = factory.decoder_for(channel.message_encoding, schema)
                assert decode is not None
                decode(message.data)
            counts[channel.topic] += 1
            schemas[channel.topic] = schema.name
        summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    topics = Topics(TOPICS)
    named = {channel: topics.of(channel) for channel in _exported(recording)}
    different = [channel for channel, topic in named.items() if counts[topic] != recording.count(channel)]
    shown = Counter(name for topic, name in schemas.items() if name.startswith("foxglove."))
    good = (
        summary.statistics.message_count == counts.total()
        and not different
        and {"foxglove.CompressedImage", "foxglove.SceneUpdate", "foxglove.PoseInFrame", "foxglove.Log"} <= set(shown)
    )
    listed = ", ".join(f"{count} {name}" for name, count in sorted(shown.items()))
    return good, (
        f"all {counts.total()} messages of {len(counts)} topics are decoded by their schemas; as many as in the log on "
        f"{len(named) - len(different)} of {len(named)} channels; topics of Foxglove's own schemas: {listed}"
    )


def _rrd(_recording: Recording, target: Path) -> tuple[bool, str]:
    """Let Rerun verify its file."""
    environment = {**os.environ, "CI": "true", "NO_COLOR": "1"}
    command = [str(_SCRIPTS / "rerun"), "rrd", "verify", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    said = (done.stdout + done.stderr).strip().splitlines()
    return done.returncode == 0, f"rerun rrd verify: {said[-1] if said else 'nothing said'}"


def _opened_by_rerun(recording: Path, target: Path) -> bool:
    """Let Rerun's viewer draw what it shows of a recording; return whether it did."""
    if shutil.which("Xvfb") is None:
        return False
    with display(_VIEWER_PX) as screen:
        environment = {**os.environ, "CI": "true", "DISPLAY": screen, "HOME": str(target.parent)}
        size = "x".join(map(str, _VIEWER_PX))
        command = [str(_SCRIPTS / "rerun"), str(recording), "--window-size", size, "--screenshot-to", str(target)]
        subprocess.run(command, env=environment, capture_output=True, check=False, timeout=180)
    return target.exists()


def _mp4(recording: Recording, target: Path) -> tuple[bool, str]:
    """Decode every frame."""
    capture = cv2.VideoCapture(str(target))
    n_frames = 0
    while capture.read()[0]:
        n_frames += 1
    n_images = recording.count("robot.image")
    return n_frames == n_images, f"{n_frames} frames decoded, {n_images} images recorded"


def _csv(recording: Recording, target: Path) -> tuple[bool, str]:
    def rows(channel: str) -> Iterator[dict[str, Any]]:
        with (target / f"{channel}.csv").open(encoding="utf-8", newline="") as file:
            yield from csv.DictReader(file)

    return _same_scalars(recording, rows)


def _parquet(recording: Recording, target: Path) -> tuple[bool, str]:
    return _same_scalars(recording, lambda channel: pq.read_table(target / f"{channel}.parquet").to_pylist())


def _same_scalars(recording: Recording, read: Callable[[str], Any]) -> tuple[bool, str]:
    """Compare every scalar of a table with that of the log."""
    n_scalars = n_numbers = n_different = 0
    largest = 0.0
    for channel, lcm_class in _exported(recording).items():
        leaves = leaves_of(lcm_class)
        rows = [*read(channel)]
        n_different += abs(len(rows) - recording.count(channel))
        for index, row in enumerate(rows):
            fields = recording.fields(channel, index)
            for leaf in leaves:
                wanted = leaf.of(fields)
                found = _as_type(row[leaf.name], wanted)
                n_scalars += 1
                if isinstance(wanted, int | float) and isinstance(found, int | float):
                    n_numbers += 1
                    if not (math.isnan(wanted) and math.isnan(found)) and found != wanted:
                        largest = max(largest, abs(found - wanted))
                        n_different += 1
                elif found != wanted:
                    n_different += 1
    return not n_different, (
        f"{n_scalars} scalars read back, {n_numbers} of them numbers: {n_different} differ, "
        f"largest difference {largest:g}"
    )


def _exported(recording: Recording) -> dict[str, type]:
    """Return the channels that an export holds, with their types: what describes the log is not one."""
    return {name: lcm_class for name, lcm_class in recording.channels.items() if name != About.CHANNEL and lcm_class}


def _as_type(cell: Any, like: Scalar) -> Any:
    """Return a cell as the type of ``like``: a CSV has strings only."""
    if not isinstance(cell, str) or isinstance(like, str):
        return cell
    return cell == "True" if isinstance(like, bool) else type(like)(cell)


_CHECKS: dict[str, Callable[[Recording, Path], tuple[bool, str]]] = {
    "mcap": _mcap,
    "rrd": _rrd,
    "mp4": _mp4,
    "csv": _csv,
    "parquet": _parquet,
}
