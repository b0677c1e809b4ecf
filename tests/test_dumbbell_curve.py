"""The reference of the collapsing dumbbell."""

import numpy as np
import pytest

from levelset.solids import Dumbbell
from pmesh.cases import dumbbell_curve
from pmesh.cases.dumbbell import DumbbellCase
from pmesh.cases.dumbbell_curve import followed, outline


def test_the_outline_is_on_the_shape():
    shape = Dumbbell(0.3, separation=1.0, bar=0.1, fillet=0.05)
    line = outline(shape, 300)
    assert line[0] == pytest.approx([0.0, 0.1])
    assert line[-1] == pytest.approx([0.8, 0.0])
    points = np.stack([line[:, 0], line[:, 1], 0 * line[:, 0]])
    np.testing.assert_allclose(shape.distance(points), 0, atol=2e-5)


def test_the_curve_is_converged_to_better_than_the_metrics_ask(monkeypatch):
    shape = DumbbellCase(fillet=0.03).shape
    fine = followed(shape)
    monkeypatch.setattr(dumbbell_curve, "POINTS", 250)
    followed.cache_clear()
    coarse = followed(shape)
    followed.cache_clear()
    assert coarse.pinch == pytest.approx(fine.pinch, rel=1e-3)
    assert coarse.end == pytest.approx(fine.end, rel=1e-3)
