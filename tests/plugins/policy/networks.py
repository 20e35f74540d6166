"""Small networks, written with the onnx package."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from onnx import ModelProto, TensorProto, helper, numpy_helper, save_model

Shape = Sequence[int | str | None]
F32, U8, F64, I64 = TensorProto.FLOAT, TensorProto.UINT8, TensorProto.DOUBLE, TensorProto.INT64


def network(
    nodes: Sequence[tuple[str, str, str]] | Sequence[Any],
    inputs: Mapping[str, Shape],
    outputs: Mapping[str, Shape],
    weights: Mapping[str, npt.ArrayLike] | None = None,
    *,
    types: Mapping[str, int] | None = None,
    opset: int = 17,
    ir_version: int = 9,
) -> ModelProto:
    """Return a network of nodes ``(operator, inputs, outputs)``, names with spaces between, or made by `helper`."""
    kinds = dict(types or {})

    def told(shapes: Mapping[str, Shape]) -> list[Any]:
        return [helper.make_tensor_value_info(name, kinds.get(name, F32), shape) for name, shape in shapes.items()]

    made = [helper.make_node(n[0], n[1].split(), n[2].split()) if isinstance(n, tuple) else n for n in nodes]
    constants = [
        numpy_helper.from_array(np.asarray(value, np.float32), name) for name, value in (weights or {}).items()
    ]
    graph = helper.make_graph(made, "small", told(inputs), told(outputs), constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)])
    model.ir_version = ir_version
    return model


def linear(n: int, weights: npt.ArrayLike, bias: npt.ArrayLike, **shapes: Shape) -> ModelProto:
    """Return a network whose output ``y`` is linear in ``x`` (1, n), or in what ``x`` is flattened to."""
    weights, bias = np.asarray(weights, np.float32), np.asarray(bias, np.float32)
    nodes = [("Flatten", "x", "flat"), ("Gemm", "flat W b", "y")]
    given: Shape = shapes.get("x", (1, n))
    return network(nodes, {"x": given}, {"y": (1, len(bias))}, {"W": weights, "b": bias})


def recurrent() -> ModelProto:
    """Return a network that counts: ``y`` = (h, x) and ``h_out`` = h + 1."""
    nodes = [("Add", "h one", "h_out"), ("Concat", "h x", "y")]
    nodes[1] = helper.make_node("Concat", ["h", "x"], ["y"], axis=1)
    return network(nodes, {"x": (1, 1), "h": (1, 1)}, {"y": (1, 2), "h_out": (1, 1)}, {"one": [[1.0]]})


def means(steps: int, rows: int | None = None, cols: int | None = None) -> ModelProto:
    """Return a network that gives the means of the last ``steps`` pictures, ``y`` (1, steps)."""
    mean = helper.make_node("ReduceMean", ["f"], ["y"], axes=[2, 3], keepdims=0)
    cast = helper.make_node("Cast", ["x"], ["f"], to=F32)
    return network([cast, mean], {"x": (1, steps, rows, cols)}, {"y": (1, steps)}, types={"x": U8})


def external(path: Path, location: str) -> ModelProto:
    """Write a linear network that keeps its weights at ``location``."""
    model = linear(1, [[1.0], [0.0]], [0.0, 0.0])
    weights = model.graph.initializer[0]
    weights.ClearField("raw_data")
    weights.data_location = TensorProto.EXTERNAL
    for key, value in (("location", location), ("offset", "0"), ("length", "8")):
        entry = weights.external_data.add()
        entry.key, entry.value = key, value
    save_model(model, str(path))
    return model
