"""Principal components are found although vectors are missing, beside fields whose factors are given."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_planar.principal_components import principal_components
from graphnav_planar.teach import KeptFrames

from graphnav.arrays import Bools, Doubles

FRAMES, CELLS = 300, 120


def drive(rng: np.random.Generator, count: int, missing: float) -> tuple[Doubles, Doubles, Doubles, Bools]:
    """Return given factors (frames, 2), exact fields (2 + count, cells, 2), flows, and which of their vectors count."""
    given, factors = rng.normal(size=(FRAMES, 2)), rng.normal(size=(FRAMES, count))
    fields = rng.normal(size=(2 + count, CELLS, 2))
    return given, fields, np.tensordot(np.hstack([given, factors]), fields, 1), rng.random((FRAMES, CELLS)) >= missing


def outside(fields: Doubles, span: Doubles) -> float:
    """Return the share of ``fields`` (k, n, 2) that does not lie in the span of ``span``."""
    basis = np.linalg.qr(span.reshape(len(span), -1).T)[0]
    rows = fields.reshape(len(fields), -1)
    return float(np.linalg.norm(rows - rows @ basis @ basis.T) / np.linalg.norm(rows))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("missing", [0.0, 0.1])
def test_the_fields_are_recovered(seed: int, missing: float) -> None:
    given, exact, flows, valid = drive(np.random.default_rng(seed), 3, missing)
    found = principal_components(given, flows.astype(np.float32), valid, 3)
    assert found is not None
    # six alternations reduce an error of the order of the missing share by that share each; float32 sets the floor
    assert outside(found.fields, exact[2:]) < 1e-3
    assert outside(found.given, exact) < 1e-3
    assert found.residual.max() < 0.01


def test_what_is_missing_does_not_count() -> None:
    given, _, flows, valid = drive(np.random.default_rng(0), 2, 0.1)
    spoiled = np.where(valid[..., None], flows, 1000.0)
    one, other = (principal_components(given, uv.astype(np.float32), valid, 2) for uv in (flows, spoiled))
    assert one is not None
    assert other is not None
    assert np.array_equal(one.fields, other.fields)


def test_too_few_frames_determine_nothing() -> None:
    given, _, flows, valid = drive(np.random.default_rng(0), 3, 0.0)
    assert principal_components(given[:14], flows[:14].astype(np.float32), valid[:14], 3) is None
    assert principal_components(given[:15], flows[:15].astype(np.float32), valid[:15], 3) is not None


def test_kept_frames_are_spread_evenly_over_the_drive() -> None:
    kept = KeptFrames()
    for frame in range(3000):
        kept.add(np.array([float(frame)]), np.zeros((2, 3, 2), np.float32), np.ones((2, 3), np.bool_))
    frames = kept.arrays()[0][:, 0]
    assert len(frames) <= 512
    assert set(np.diff(frames)) == {8.0}
    assert frames[0] == 0
    assert frames[-1] >= 3000 - 8
    assert (kept.count == len(frames)).all()
