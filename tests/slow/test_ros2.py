"""ROS 2 topics beside a robot in C on another version of Cyclone DDS, and a drive through topics."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="there is no wheel of Cyclone DDS for this machine")

import bench_ros2


@pytest.mark.slow
def test_a_robot_in_c_is_heard_and_hears(tmp_path: Path) -> None:
    peer = bench_ros2.built(tmp_path)
    if peer is None:
        pytest.skip("apt install cyclonedds-dev cyclonedds-tools gcc")
    found = bench_ros2.beside_c(peer, tmp_path, 60.0, 10.0, (640, 480))
    print(found)
    for topic, one in found["topics"].items():
        assert one["accepted"] >= 0.95 * one["sent"], topic
        assert one["stamps_kept"], topic
        assert not one["rejected"], topic
    assert found["heard"]["/cmd_vel"] > 300
    assert found["heard"]["/local_map"] > 30


@pytest.mark.slow
def test_the_simulated_robot_arrives_through_topics(tmp_path: Path) -> None:
    found = bench_ros2.drive(tmp_path, 135.0, by_ros=True)
    print(found)
    assert found["scores"]["drive"]["success"] == 1.0
