"""The case of diffusion along a surface."""

import numpy as np
import pytest

from pmesh.cases.runner import run_case
from pmesh.cases.surface_diffusion import SurfaceDiffusionCase
from remesh.errors import InputError


@pytest.mark.parametrize("options", [{}, {"surface": "torus", "cells": 14, "until": 0.05}])
def test_a_short_run_decays_as_it_should_and_keeps_its_integral(options, tmp_path):
    case = SurfaceDiffusionCase.make(options, quick=True)
    report = run_case("surface-diffusion", case, tmp_path)
    assert all(metric.passed for metric in report.metrics)
    series = report.outcome.series
    assert (np.diff(series["mode3"]) < 0).all()
    assert (np.diff(series["highest"]) < 0).all()
    assert (tmp_path / "figure.png").stat().st_size > 20000


def test_the_order_is_taken_from_half_the_cells(tmp_path):
    case = SurfaceDiffusionCase(cells=16, until=0.03, stretch=20.0, every=0.03)
    metrics = run_case("surface-diffusion", case, tmp_path).metrics
    (order,) = (metric for metric in metrics if "order" in metric.name)
    assert order.passed


def test_meshes_that_do_not_see_the_waves_are_refused():
    for wrong in ({"cells": 6}, {"surface": "torus", "cells": 10}, {"cells": 8}, {"stretch": 0.0}):
        with pytest.raises(InputError):
            SurfaceDiffusionCase(**wrong)
    with pytest.raises(InputError, match="one of sphere, torus"):
        SurfaceDiffusionCase(surface="cube")
