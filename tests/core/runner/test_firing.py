"""The firing rule: what fires when, at which stamp, and what is dropped."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from graphnav import Twist
from graphnav.core.graph import Graph, resolved_yaml
from graphnav.core.messages import About, Status
from graphnav.core.record import Recording
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import seed_of
from graphnav.core.runner.recording.kept_messages import kept
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.runner.recording.summary import Summary

Run = Callable[..., tuple[Summary, Recording]]


def speeds(recording: Recording, channel: str) -> list[tuple[int, float]]:
    """Return stamp and speed of every message of a channel."""
    found = []
    for utime, _, message in recording.messages(channel):
        assert isinstance(message, Twist)
        found.append((utime, message.v_mps))
    return found


def test_a_source_fires_at_rounded_multiples_of_its_period(run: Run) -> None:
    _, log = run("run: {until_s: 1}\nstages: {c: {use: probe.counter, with: {rate_hz: 3}}}")
    assert speeds(log, "c.twist") == [(0, 0), (333333, 1), (666667, 2), (1000000, 3)]


def test_what_follows_carries_the_stamp_and_the_sequence_counts(run: Run) -> None:
    _, log = run(
        """
        run: {until_s: 0.5}
        stages:
          c: {use: probe.counter}
          p: {use: probe.plus, in: {twist: c.twist}}
        """
    )
    assert speeds(log, "p.twist") == [(100000 * k, k + 1.0) for k in range(6)]
    assert [seq for _, seq, _ in log.messages("p.twist")] == list(range(6))


def test_the_order_in_the_file_does_not_matter_to_stages(run: Run) -> None:
    _, log = run(
        """
        run: {until_s: 0.2}
        stages:
          p: {use: probe.plus, in: {twist: q.twist}}
          q: {use: probe.plus, in: {twist: c.twist}}
          c: {use: probe.counter}
        """
    )
    assert speeds(log, "p.twist") == [(0, 2), (100000, 3), (200000, 4)]


def test_sources_of_different_rates_share_one_queue_and_join_where_they_meet(run: Run) -> None:
    summary, log = run(
        """
        run: {until_s: 1}
        stages:
          fast: {use: probe.counter, with: {rate_hz: 10}}
          slow: {use: probe.counter, with: {rate_hz: 4}}
          both: {use: probe.join, in: {a: fast.twist, b: slow.twist}}
        """
    )
    assert speeds(log, "both.twist") == [(0, 0), (500000, 7), (1000000, 14)]
    assert summary.stages["both"].dropped == 8 + 2
    assert summary.frames == 11 + 2


def test_a_port_that_stays_silent_fires_no_stage(run: Run) -> None:
    summary, log = run(
        """
        run: {until_s: 0.5}
        stages:
          c: {use: probe.counter}
          s: {use: probe.split, in: {twist: c.twist}}
          p: {use: probe.plus, in: {twist: s.odd}}
          j: {use: probe.join, in: {a: s.even, b: s.odd}}
        """
    )
    assert speeds(log, "p.twist") == [(100000, 2), (300000, 4), (500000, 6)]
    assert summary.stages["j"].steps == 3
    assert summary.stages["j"].dropped == 3
    assert summary.scores == {"j": {"fired": 3.0}}


def test_latest_is_sampled_never_triggers_and_knows_its_age(run: Run) -> None:
    _, log = run(
        """
        run: {until_s: 0.4}
        stages:
          world: {use: probe.sampler, in: {command: back.twist}}
          rare: {use: probe.counter, with: {rate_hz: 5}}
          back: {use: probe.plus, in: {twist: rare.twist}}
        """
    )
    ages = [m.omega_radps for _, _, m in log.messages("world.twist") if isinstance(m, Twist)]
    assert speeds(log, "world.twist") == [(0, -1), (100000, 1), (200000, 1), (300000, 2), (400000, 2)]
    assert ages == [0.0, 0.1, 0.2, 0.1, 0.2]


def test_a_loop_is_closed_by_latest(run: Run) -> None:
    _, log = run(
        """
        run: {until_s: 0.4}
        stages:
          world: {use: probe.sampler, in: {command: plus.twist}}
          plus: {use: probe.plus, in: {twist: world.twist}}
        """
    )
    assert [v for _, v in speeds(log, "world.twist")] == [-1, 0, 1, 2, 3]


def test_a_source_that_finishes_publishes_first_and_what_follows_still_fires(run: Run) -> None:
    summary, log = run(
        """
        stages:
          c: {use: probe.counter, with: {last: 4}}
          p: {use: probe.plus, in: {twist: c.twist}}
        """
    )
    assert summary.outcome == "goal"
    assert speeds(log, "p.twist")[-1] == (400000, 5)


def test_the_same_seed_gives_the_same_bytes_another_does_not(run: Run) -> None:
    text = """
        run: {until_s: 1, seed: %d}
        stages: {d: {use: probe.dice}, n: {use: probe.noise, with: {rate_hz: 30}}}
        """
    logs = [run(text % seed, name)[1].path.read_bytes() for seed, name in ((1, "a"), (1, "b"), (2, "c"))]
    assert logs[0] == logs[1] != logs[2]


def test_a_stage_keeps_its_randomness_whatever_stage_is_beside_it(run: Run) -> None:
    _, alone = run("run: {until_s: 1, seed: 5}\nstages: {d: {use: probe.dice}}", "alone")
    _, beside = run("run: {until_s: 1, seed: 5}\nstages: {e: {use: probe.dice}, d: {use: probe.dice}}", "beside")
    assert speeds(alone, "d.twist") == speeds(beside, "d.twist") != speeds(beside, "e.twist")
    assert seed_of(5, "d") != seed_of(5, "e") != seed_of(6, "e")


def test_the_log_describes_itself(run: Run, load: Callable[[str], Graph]) -> None:
    text = "run: {until_s: 1}\nchannels: {d.twist: COMMAND}\nstages: {d: {use: probe.dice, with: {rate_hz: 7}}}"
    _, log = run(text)
    assert log.about is not None
    assert next(log.events()).channel == About.CHANNEL
    assert log.about.channels == ("COMMAND",)
    assert log.about.types == ("graphnav_lcm.twist_t",)
    assert "struct twist_t" in log.about.lcm_text
    assert log.count("COMMAND") == 8
    again = load(log.about.graph_yaml)
    assert resolved_yaml(again) == log.about.graph_yaml


def test_small_logs_keep_small_messages_and_the_first_of_every_channel(run: Run) -> None:
    text = "run: {until_s: 1, record: small}\nstages: {d: {use: probe.dice}, n: {use: probe.noise}}"
    _, log = run(text)
    assert log.count("d.twist") == 11
    assert log.count("n.image") == 11
    _, log = run(text.replace("probe.noise", "probe.noise, with: {rows: 100}"), "large")
    assert (log.count("d.twist"), log.count("n.image")) == (11, 1)


def test_small_logs_keep_every_status_of_any_size(load: Callable[[str], Graph]) -> None:
    graph = load("run: {record: small}\nstages: {d: {use: probe.dice}}")
    written: list[str] = []

    class Log:
        def write(self, channel: str, _utime: int, _data: bytes) -> None:
            written.append(channel)

    sink = kept(graph, Log(), None, is_live=True)
    for _ in range(3):
        for channel in (Status.CHANNEL, "d.twist"):
            sink.write(channel, 0, bytes(Recording.SMALL_BYTES))
    assert written == [Status.CHANNEL, "d.twist", Status.CHANNEL, Status.CHANNEL]


def test_a_log_holds_only_the_channels_that_it_is_asked_to_keep(load: Callable[[str], Graph], tmp_path: Path) -> None:
    graph = load("run: {until_s: 1, record: small}\nstages: {d: {use: probe.dice}, n: {use: probe.noise}}")
    run_recorded(graph, graph.make_stages(), tmp_path, keep=["n.image"])
    with Recording(tmp_path / RunFolder.LOG) as log:
        assert list(log.channels) == [About.CHANNEL, "n.image"]
        assert log.count("n.image") == 11
