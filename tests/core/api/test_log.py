"""Logs read by channel and time; damaged ones as far as they are complete."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import graphnav
from graphnav import Flow, Recording, Steering, Twist, UserError, open_log
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter

RunToy = Callable[..., graphnav.Run]


@pytest.fixture(scope="module")
def log_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the log of a run of eleven ticks of 0.1 s."""
    folder = tmp_path_factory.mktemp("log")
    graph = folder / "toy.yaml"
    shutil.copy(Path(__file__).with_name("door_stages.py"), folder)
    graph.write_text(
        "plugins: [door_stages.py]\nrun: {until_s: 1}\nstages:\n  sensor: {use: door.sensor}\n"
        "  steer: {use: door.steerer, in: {flow: sensor.flow}}\n"
    )
    return graphnav.run(graph, pictures=False, record="all", folder=folder / "run").folder / "run.lcmlog"


def test_channels_tell_type_count_and_times(log_file: Path) -> None:
    with open_log(log_file) as log:
        assert list(log.channels) == ["graphnav.about", "sensor.flow", "sensor.twist", "steer.steering"]
        flow = log.channels["sensor.flow"]
        assert (flow.message, flow.type_name, flow.n_messages) == (Flow, "graphnav_lcm.flow_t", 11)
        assert (flow.first_s, flow.last_s, flow.rate_hz) == (0.0, 1.0, 10.0)
        assert (log.duration_s, log.damage, log.path) == (1.0, (), log_file)
        assert list(log.graph["stages"]) == ["sensor", "steer"]
    assert open_log(str(log_file.parent)).path == log_file


def test_messages_are_those_of_the_recording(log_file: Path) -> None:
    with open_log(log_file) as log, Recording(log_file) as recording:
        for channel in ("sensor.twist", "sensor.flow"):
            for sample, (utime, _, message) in zip(log.messages(channel), recording.messages(channel), strict=True):
                assert sample.time_s == utime / 1e6
                assert vars(sample.message).keys() == vars(message).keys()
                assert all(np.array_equal(vars(sample.message)[name], value) for name, value in vars(message).items())


@given(start_us=st.integers(-200_000, 1_200_000), span_us=st.integers(-100_000, 1_200_000))
@settings(max_examples=40)
def test_a_window_begins_with_its_start_and_ends_before_its_end(log_file: Path, start_us: int, span_us: int) -> None:
    start_s, end_s = start_us / 1e6, (start_us + span_us) / 1e6
    wanted = [k / 10 for k in range(11) if start_us <= k * 100_000 < start_us + span_us]
    with open_log(log_file) as log:
        times_s, values = log.stack("sensor.twist", "v_mps", start_s=start_s, end_s=end_s)
        assert times_s.tolist() == wanted
        assert [sample.time_s for sample in log.messages("sensor.twist", start_s=start_s, end_s=end_s)] == wanted
        assert values.tolist() == [10 * time_s + 1 for time_s in wanted] or len(wanted) == 0


@given(at_us=st.integers(0, 2_000_000))
@settings(max_examples=40)
def test_at_a_time_is_the_newest_message(log_file: Path, at_us: int) -> None:
    with open_log(log_file) as log:
        twist: Twist = log.at("sensor.twist", at_us / 1e6)
    assert twist.v_mps == min(at_us // 100_000, 10) + 1


def test_a_sum_of_tenths_finds_its_tick(log_file: Path) -> None:
    assert open_log(log_file).at("sensor.twist", 0.1 + 0.2).v_mps == 4


def test_a_stack_is_one_array(log_file: Path) -> None:
    with open_log(log_file) as log:
        times_s, uv_px = log.stack("sensor.flow", "uv_px")
        assert (times_s.shape, uv_px.shape, str(uv_px.dtype)) == ((11,), (11, 4, 6, 2), "float32")
        assert np.array_equal(uv_px, np.array([sample.message.uv_px for sample in log.messages("sensor.flow")]))
        assert uv_px.flags.writeable
        assert np.array_equal(log.times_s("sensor.flow"), times_s)
        assert log.stack("sensor.flow", "interval_us").values.tolist() == [100_000] * 11
        empty = log.stack("sensor.flow", "uv_px", start_s=5)
        assert (empty.times_s.size, empty.values.size) == (0, 0)


def test_a_table_has_a_column_a_scalar_and_an_element_of_small_arrays(log_file: Path) -> None:
    with open_log(log_file) as log:
        twist = log.to_pandas("sensor.twist")
        assert (twist.index.name, list(twist.columns)) == ("time_s", ["v_mps", "omega_radps"])
        assert twist.loc[0.3, "v_mps"] == 4.0
        assert np.array_equal(twist.index, log.times_s("sensor.twist"))
        steering = log.to_pandas("steer.steering", start_s=0.5)
        pairs = [f"{name}[{i}]" for name in ("repulsive", "guiding", "control") for i in range(2)]
        assert list(steering.columns) == [*pairs, "theta_rad", "eigenvalues[0]", "eigenvalues[1]"]
        first: Steering = log.at("steer.steering", 0.5)
        assert steering.iloc[0]["repulsive[1]"] == first.repulsive[1]
        assert list(log.to_pandas("sensor.flow").columns) == ["interval_us", "step_px"]
        assert log.to_pandas("sensor.flow", start_s=9).shape[0] == 0


def test_an_array_that_changes_its_shape_is_told(tmp_path: Path, run_toy: RunToy) -> None:
    log = run_toy(set={"sensor.grief": "grow"}).log
    with pytest.raises(UserError) as error:
        log.stack("sensor.flow", "uv_px")
    assert str(error.value) == (
        "'uv_px' of 'sensor.flow' has shape (4, 6, 2) first, and (5, 6, 2) at 0.4 s\n"
        "  choose start_s and end_s so that all shapes are equal, or read messages one by one"
    )
    assert log.stack("sensor.flow", "uv_px", end_s=0.4).values.shape == (4, 4, 6, 2)
    assert list(log.to_pandas("sensor.flow").columns) == ["interval_us", "step_px"]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda log: log.messages("sensor.flw"),
            "{path} has no channel 'sensor.flw'\n  did you mean 'sensor.flow'?",
        ),
        (
            lambda log: log.messages("xyz"),
            "{path} has no channel 'xyz'\n  it has graphnav.about, sensor.flow, sensor.twist, steer.steering",
        ),
        (lambda log: log.messages(3), 'channel must be a string, not 3 (int)\n  write channel="control.twist"'),
        (
            lambda log: log.messages(["sensor.flow"]),
            "channel must be a string, not ['sensor.flow'] (list)\n  write channel=\"control.twist\"",
        ),
        (
            lambda log: log.messages("sensor.flow", start_s="1"),
            "start_s must be a number of seconds, not '1' (str)\n  write start_s=1.5",
        ),
        (
            lambda log: log.messages("sensor.flow", end_s=float("nan")),
            "end_s is nan, but must be a number of seconds\n  write end_s=1.5",
        ),
        (lambda log: log.at("sensor.flow", -1), "'sensor.flow' has no message at -1 s\n  its first one is at 0 s"),
        (
            lambda log: log.at("sensor.flow", None),
            "time_s must be a number of seconds, not None\n  write time_s=1.5",
        ),
        (
            lambda log: log.stack("sensor.flow", "uv"),
            "'sensor.flow' has no field 'uv'\n  it has uv_px, valid, interval_us, step_px",
        ),
        (
            lambda log: log.stack("sensor.flow", "uv_pix"),
            "'sensor.flow' has no field 'uv_pix'\n  did you mean 'uv_px'?",
        ),
        (
            lambda log: log.stack("graphnav.about", "channels"),
            "'channels' of 'graphnav.about' is not numeric\n  read the messages one by one",
        ),
    ],
)
def test_what_a_log_does_not_hold_is_told(log_file: Path, call: Callable[[graphnav.Log], Any], said: str) -> None:
    with open_log(log_file) as log, pytest.raises(UserError) as error:
        call(log)
    assert str(error.value) == said.format(path=log_file)


def test_files_that_are_no_logs_are_refused(tmp_path: Path) -> None:
    (tmp_path / "text.lcmlog").write_text("hello, this is not a log at all")
    with pytest.raises(graphnav.GraphnavError, match=r"text\.lcmlog is not an LCM log$"):
        open_log(tmp_path / "text.lcmlog")
    with pytest.raises(UserError, match=r"^there is no .*missing\n  name a run folder or a log$"):
        open_log(tmp_path / "missing")
    with pytest.raises(UserError, match=r"holds no run.lcmlog\n"):
        open_log(tmp_path)
    with pytest.raises(UserError, match="File name too long"):
        open_log("x" * 5000)
    with pytest.raises(UserError, match=r'^path must be a path, not 3 \(int\)\n  write path="runs/1"$'):
        open_log(3)  # type: ignore[arg-type]


def test_a_closed_log_says_so(log_file: Path) -> None:
    log = open_log(log_file)
    samples = log.messages("sensor.twist")
    log.close()
    log.close()
    with pytest.raises(UserError, match=r"is closed\n  open it again with graphnav.open_log"):
        log.messages("sensor.twist")
    with pytest.raises(graphnav.GraphnavError):
        next(samples)


def test_without_pandas_the_extra_is_named(log_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with open_log(log_file) as log, pytest.raises(UserError) as error:
        log.to_pandas("sensor.twist")
    assert str(error.value) == "to_pandas needs pandas\n  pip install 'pandas>=2.1'"


def test_cut_anywhere_a_log_gives_what_is_complete(log_file: Path, tmp_path: Path) -> None:
    data = log_file.read_bytes()
    with Recording(log_file) as recording:
        n_events = recording.n_events
    counts = []
    for size in (*range(0, len(data), 67), len(data)):
        cut = tmp_path / "cut.lcmlog"
        cut.write_bytes(data[:size])
        with open_log(cut) as log:
            twists = [s.message.v_mps for s in log.messages("sensor.twist")] if "sensor.twist" in log.channels else []
            assert twists == [float(k + 1) for k in range(len(twists))]
            counts.append(sum(channel.n_messages for channel in log.channels.values()))
            assert len(log.damage) == (0 if size in {0, len(data)} or not log._recording.truncated else 1)
    assert counts == sorted(counts)
    assert counts[-1] <= n_events


def test_a_damaged_message_is_left_out_and_told(
    log_file: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    data = bytearray(log_file.read_bytes())
    with Recording(log_file) as recording:
        begin = data.index(recording.event("sensor.twist", 3).data)
    data[begin] ^= 0xFF  # the type's fingerprint
    damaged = tmp_path / "damaged.lcmlog"
    damaged.write_bytes(data)
    with open_log(damaged) as log:
        assert log.damage == ()
        times_s, v_mps = log.stack("sensor.twist", "v_mps")
        assert times_s.tolist() == [k / 10 for k in range(11) if k != 3]
        assert v_mps.shape == (10,)
        assert len(log.to_pandas("sensor.twist")) == 10
        assert log.at("sensor.twist", 0.35).v_mps == 3.0
        assert len(log.damage) == 1
        assert log.damage[0].startswith("1 of 11 messages of 'sensor.twist' cannot be decoded: ")
    assert len(caplog.messages) == 1
    assert caplog.messages[0].endswith("it is skipped and counted in Log.damage")


def test_a_log_whose_description_is_damaged_is_read_by_fingerprints(log_file: Path, tmp_path: Path) -> None:
    data = bytearray(log_file.read_bytes())
    with Recording(log_file) as recording:
        begin = data.index(recording.event("graphnav.about", 0).data)
    data[begin + 24 : begin + 28] = b"\xff\xff\xff\xff"  # the length of its first string
    (tmp_path / "damaged.lcmlog").write_bytes(data)
    with open_log(tmp_path / "damaged.lcmlog") as log:
        assert log.stack("sensor.flow", "uv_px").values.shape == (11, 4, 6, 2)
        assert log.times_s("sensor.flow")[-1] == 1.0


def test_bytes_that_are_not_events_are_skipped_and_told(log_file: Path, tmp_path: Path) -> None:
    data = bytearray(log_file.read_bytes())
    with Recording(log_file) as recording:
        begin = data.index(recording.event("sensor.twist", 3).data)
    data[begin - 40 : begin] = bytes(40)  # its header and channel
    (tmp_path / "damaged.lcmlog").write_bytes(data)
    with open_log(tmp_path / "damaged.lcmlog") as log:
        assert len(log.damage) == 1
        assert log.damage[0].endswith("are not an event")
        assert set(range(1, 12)) - {4, 5} <= {twist.v_mps for _, twist in log.messages("sensor.twist")}


def test_a_log_of_another_program_is_timed_by_its_events(tmp_path: Path) -> None:
    noon_us = 1_700_000_000_000_000
    with LogWriter(tmp_path / "heard.lcmlog") as writer:
        for k in range(5):
            twist = encode(Twist(v_mps=float(k), omega_radps=0.0), 1000 * k, k)
            writer.write("COMMAND", noon_us + 500_000 * k, twist)
            writer.write("\x1b[31mred<b>", noon_us + 500_000 * k, b"")
            writer.write("OTHER", noon_us + 500_000 * k, b"not one of our types")
    with open_log(tmp_path / "heard.lcmlog") as log:
        assert log.times_s("COMMAND").tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
        assert log.at("COMMAND", 1.2).v_mps == 2.0
        other = log.channels["OTHER"]
        assert (other.type_name, other.message, other.n_messages, other.rate_hz) == ("", None, 5, 2.0)
        assert ">\\x1b[31mred&lt;b&gt;</td>" in log._repr_html_()
        with pytest.raises(UserError, match=r"has no channel '\\x1b'\n  it has COMMAND, \\x1b\[31mred<b>, OTHER$"):
            log.at("\x1b", 1)
        with pytest.raises(UserError, match=r"^the type of channel 'OTHER' is not installed\n  install the package"):
            log.to_pandas("OTHER")
        with pytest.raises(UserError, match=r"^the type of channel 'OTHER'"):
            log.at("OTHER", 1.0)
        with pytest.raises(graphnav.GraphnavError, match="does not hold the graph that produced it"):
            _ = log.graph
