"""A network in an ONNX file, run by onnxruntime on one thread of the processor."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav import ParamError, import_extra, read_regular
from graphnav_policy.onnx_file import OnnxHeader, read_header

Array = npt.NDArray[Any]
Shape = Sequence[int | None]
_EXPORT = "export the network as one ONNX file"
_TYPES = {
    "tensor(float)": np.float32,
    "tensor(double)": np.float64,
    "tensor(float16)": np.float16,
    "tensor(uint8)": np.uint8,
    "tensor(int8)": np.int8,
    "tensor(uint16)": np.uint16,
    "tensor(int16)": np.int16,
    "tensor(uint32)": np.uint32,
    "tensor(int32)": np.int32,
    "tensor(uint64)": np.uint64,
    "tensor(int64)": np.int64,
    "tensor(bool)": np.bool_,
}


class Tensor(NamedTuple):
    """An input or output of a network; None for an axis of any length."""

    name: str
    dtype: np.dtype[Any]
    shape: tuple[int | None, ...]

    def takes(self, shape: Shape) -> bool:
        """Return whether an array may have this shape, as far as both are known."""
        return len(shape) == len(self.shape) and all(
            mine is None or given is None or mine == given for mine, given in zip(self.shape, shape, strict=True)
        )


def shape_text(shape: Shape) -> str:
    """Return a shape as errors show it, ``(1, ?, 80)``."""
    lengths = ["?" if length is None else str(length) for length in shape]
    return f"({', '.join(lengths)}{',' if len(lengths) == 1 else ''})"


class Network:
    """A network that is ready to run.

    It runs on one thread, one operator after the other, and on the processor alone; no library of operators is loaded,
    and no other file is read. The same inputs give the same bytes on one kind of processor.

    Raises
    ------
    ParamError
        The file cannot be read, is larger than ``max_bytes``, is not ONNX, keeps its weights in other files, or is
        nothing that the installed onnxruntime can run; names the parameter ``file``.
    UserError
        onnxruntime is not installed.
    """

    def __init__(self, path: Path, max_bytes: int) -> None:
        runtime = import_extra("onnxruntime", "onnx", "policy.onnx")
        data, header = _read(path, max_bytes)
        runtime.disable_telemetry_events()
        options = runtime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.execution_mode = runtime.ExecutionMode.ORT_SEQUENTIAL
        options.use_deterministic_compute = True
        options.log_severity_level = 4
        options.add_session_config_entry("session.load_model_format", "ONNX")
        try:
            self._session = runtime.InferenceSession(
                data,
                options,
                providers=["CPUExecutionProvider"],
                enable_fallback=0,  # else it prints what it retries
            )
        except Exception as error:
            what = (
                f"onnxruntime {runtime.__version__} cannot load {path} "
                f"(opset {header.opset}, IR version {header.ir_version}): {_line(error)}"
            )
            hint = "export it with an older opset and IR version, or install a newer onnxruntime"
            raise ParamError("file", what, hint) from error
        self.inputs = {one.name: one for one in map(self._tensor, self._session.get_inputs())}
        self.outputs = {one.name: one for one in map(self._tensor, self._session.get_outputs())}

    def run(self, names: Sequence[str], arrays: Mapping[str, Array]) -> list[Array]:
        """Return the outputs called ``names`` for inputs by name.

        Raises
        ------
        ValueError
            The network cannot take these arrays, or one of its operators fails.
        """
        try:
            found: list[Array] = self._session.run([*names], {**arrays})
        except Exception as error:
            raise ValueError(f"the network failed: {_line(error)}") from error
        return found

    @staticmethod
    def _tensor(one: Any) -> Tensor:
        if one.type not in _TYPES:
            what = f"'{one.name}' of the network is {one.type}, which no message holds"
            raise ParamError("file", what, "export a network whose inputs and outputs are tensors of numbers")
        shape = tuple(length if isinstance(length, int) else None for length in one.shape)
        return Tensor(one.name, np.dtype(_TYPES[one.type]), shape)


def _read(path: Path, max_bytes: int) -> tuple[bytes, OnnxHeader]:
    try:
        data = read_regular(path, max_bytes)
    except OSError as error:
        raise ParamError("file", f"cannot read {path}: {error.strerror or error}", _EXPORT) from error
    try:
        header = read_header(data)
    except ValueError as error:
        raise ParamError("file", f"{path} is not an ONNX file", _EXPORT) from error
    if not header.ir_version or not header.opset:
        raise ParamError("file", f"{path} is not an ONNX file", _EXPORT)
    if header.has_external_data:
        what = f"{path} keeps weights in other files, which are not read"
        raise ParamError("file", what, "save it as one file: onnx.save(onnx.load(FILE), 'one.onnx')")
    return data, header


def _line(error: Exception) -> str:
    """Return what onnxruntime says in one line of at most 300 characters."""
    return textwrap.shorten(str(error), 300, placeholder="...")
