"""Stages of `policy.onnx` around small networks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from graphnav_policy.onnx_policy import Onnx
from onnx import ModelProto

MakePolicy = Callable[..., Any]


@pytest.fixture
def make_policy(tmp_path: Path) -> MakePolicy:
    """Return what makes a stage of a network and parameters, checked and reset."""

    def make(model: ModelProto, **params: Any) -> Any:
        file = tmp_path / "network.onnx"
        file.write_bytes(model.SerializeToString())
        words = {"latest": (), **params}
        cls = Onnx.with_ports(**{name: words[name] for name in Onnx.ports_from})
        stage = cls(file=file, **words)
        stage.check()
        stage.reset(seed=1)
        return stage

    return make
