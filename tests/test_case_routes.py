"""Routes of drag and lift in a record: what was asked seldom, and how far they are apart."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.cases.routes import SEEN, Routes
from pmesh.run.statistics import periodic


def series(**factors: float) -> dict[str, np.ndarray]:
    """A street of lift 0.3 and drag 1.3 with period 5, by routes that differ by a factor."""
    dt = np.full(1200, 0.05)
    time = np.cumsum(dt) - dt[0]
    phase = 2 * math.pi * (time - 0.5 * dt) / 5
    columns = {"time": time, "dt": dt}
    for route, factor in {"body0": 1.0, **factors}.items():
        columns[f"{route}_force_x"] = 0.5 * factor * (1.3 + 0.01 * np.cos(2 * phase))
        columns[f"{route}_force_y"] = 0.5 * factor * 0.3 * np.sin(phase)
    for name in columns:
        if "force" in name:
            columns[name][0] = np.nan
    return columns


def test_a_route_that_was_asked_seldom_is_completed_by_the_main_one():
    columns = series(body0_flux=1.02)
    whole = Routes.of(columns, scale=2.0)
    for name in ("body0_flux_force_x", "body0_flux_force_y"):
        columns[name][np.arange(1200) % 5 != 0] = np.nan
    seldom = Routes.of(columns, scale=2.0)
    for component in ("drag", "lift"):
        np.testing.assert_allclose(
            seldom.curves["control volume", component][5:-5],
            whole.curves["control volume", component][5:-5],
            atol=3e-4,
        )


def test_a_route_that_was_not_asked_is_left_out():
    columns = series(impulse=1.0)
    columns["body0_surface_force_x"] = np.full(1200, np.nan)
    columns["body0_surface_force_y"] = np.full(1200, np.nan)
    assert set(Routes.of(columns, scale=2.0).others("lift")) == {"impulse"}


def test_means_and_amplitudes_are_those_of_the_record():
    routes = Routes.of(series(impulse=1.02), scale=2.0)
    cycle = periodic(routes.time_end, routes.of_main("lift"), routes.dt)
    assert routes.mean("drag", cycle) == pytest.approx(1.3, rel=1e-4)
    assert routes.amplitude("lift", cycle) == pytest.approx(0.3, rel=1e-3)
    assert routes.mean("drag", cycle, "impulse") == pytest.approx(1.02 * 1.3, rel=1e-4)
    mean, wide = routes.metrics(cycle, SEEN)
    assert mean.value == pytest.approx(0.02, rel=1e-3)
    assert not mean.passed, "1.5 % is allowed"
    assert wide.value == pytest.approx(0.02, rel=1e-3)
    assert wide.passed, "3 % is allowed"


def test_traction_is_judged_where_the_mesh_sees_the_layer():
    routes = Routes.of(series(body0_surface=1.05, impulse=1.05), scale=2.0)
    late = routes.time > 30
    for layer, judged in ((0.99 * SEEN, None), (SEEN, False)):
        found = {m.name: m for m in routes.apart("drag", late, layer)}
        assert found["drag, traction and momentum apart"].passed is judged
        assert found["drag, impulse and momentum apart"].passed is False
