"""Laws of diffusion along implicit surfaces."""

import numpy as np
import pytest
from scipy.special import ellipe, ellipeinc

from levelset import surface_diffusion
from levelset.shapes import Box, Disk, Ellipse, Sphere
from levelset.solids import Torus
from levelset.surface_band import SurfaceBand
from levelset.surface_diffusion import SurfaceDiffusion, implicit
from levelset.surface_operators import laplace_beltrami
from pmesh.run.loop import run
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid

SHIFT = 0.37  # of the mesh against the shape, in cells: nothing is aligned


def around(half, cells, ndim, boundary="unbounded"):
    n = round(half * cells) + 6
    return Grid((2 * n + 1,) * ndim, 1 / cells, (-(n + SHIFT) / cells,) * ndim, boundary)


def spread(shape, grid, law, until, **options):
    """The start, and the state at a time, D = 1."""
    flow = SurfaceDiffusion(grid=grid, diffusivity=1.0, **options)
    start = state = flow.start(shape, law)
    steps = int(np.ceil(until / flow.limit(state).dt))
    for _ in range(steps):
        state = flow.step(state, until / steps)
    return start, state


def sphere_points():
    """Points and weights of a product rule on the unit sphere, exact for polynomials to 20."""
    height, weight = np.polynomial.legendre.leggauss(12)
    angle = np.arange(24) * np.pi / 12
    z, turn = np.meshgrid(height, angle, indexing="ij")
    r = np.sqrt(1 - z * z)
    points = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=-1).reshape(-1, 3)
    return points, np.repeat(weight, 24) * np.pi / 12


MODES = {
    1: lambda p: p[0] - 0.5 * p[2],
    2: lambda p: p[0] * p[1] + p[2] ** 2 - p[0] ** 2,
    3: lambda p: p[0] * (5 * p[2] ** 2 - 1),  # on the unit sphere
}


def decay_rates(cells):
    """Relative errors of the decay rates of the sphere's modes l = 1, 2, 3."""
    points, weights = sphere_points()
    grid = around(1, cells, 3)
    start, state = spread(Sphere(1.0), grid, lambda p: sum(f(p) for f in MODES.values()), 0.04)
    errors = []
    for degree, mode in MODES.items():
        known = mode(points.T)
        before, after = (weights @ (known * s.surface.at(s.values, points)) for s in (start, state))
        errors.append(np.log(before / after) / (degree * (degree + 1) * 0.04) - 1)
    return np.array(errors)


def test_modes_of_the_sphere_decay_as_they_should_with_order_two():
    coarse, fine = decay_rates(8), decay_rates(16)
    assert np.abs(fine).max() < 2e-3
    assert np.log2(abs(coarse[0] / fine[0])) > 1.8


def arc_modes(cells, until=0.15, number=2):
    """Error of a wave along the arc of an ellipse with half axes 1 and 0.6."""
    square = 1 - 0.6**2
    length = 4 * ellipe(square)

    def wave(p):
        turn = np.arctan2(p[1] / 0.6, p[0])  # eccentric anomaly; arc length from the y axis
        arc = ellipe(square) - ellipeinc(np.pi / 2 - turn, square)
        return np.cos(2 * np.pi * number * arc / length)

    start, state = spread(Ellipse((1.0, 0.6)), around(1, cells, 2), wave, until)
    rate = (2 * np.pi * number / length) ** 2
    return np.abs(state.values - np.exp(-rate * until) * start.values).max()


def test_waves_along_the_arc_of_an_ellipse_decay_with_order_two():
    errors = [arc_modes(cells) for cells in (32, 64)]
    assert errors[1] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def test_a_circle_of_any_radius_spreads_by_its_own_radius():
    for radius in (0.5, 1.5):
        cells = 24 / radius
        start, state = spread(
            Disk(radius), around(radius, cells, 2), lambda p: p[0] * p[1], 0.1 * radius**2
        )
        expected = np.exp(-4 * 0.1) * start.values
        np.testing.assert_allclose(state.values, expected, atol=2e-3 * radius**2)


def test_a_torus_agrees_with_its_own_ordinary_equation():
    # c(turn of the tube): c_t = (w c')'/(r^2 w), w = 1 + (r/R) cos; Fourier series, to round-off
    tube, until, count = 0.5, 0.1, 64
    turn = np.arange(count) * 2 * np.pi / count
    wave = np.fft.fft(np.eye(count), axis=0)
    number = np.fft.fftfreq(count, 1 / count)
    slope = np.real(np.fft.ifft(1j * number[:, None] * wave, axis=0))
    width = 1 + tube * np.cos(turn)
    matrix = np.diag(1 / (tube**2 * width)) @ slope @ np.diag(width) @ slope
    values, vectors = np.linalg.eig(matrix)
    first = np.cos(turn) + np.sin(2 * turn)
    exact = np.real(vectors @ (np.exp(until * values) * np.linalg.solve(vectors, first)))

    def law(p):
        angle = np.arctan2(p[2], np.hypot(p[0], p[1]) - 1)
        return np.cos(angle) + np.sin(2 * angle)

    _, state = spread(Torus(1.0, tube), around(1.5, 16, 3), law, until)
    points = np.stack([1 + tube * np.cos(turn), 0 * turn, tube * np.sin(turn)], axis=1)
    np.testing.assert_allclose(state.surface.at(state.values, points), exact, atol=4e-3)


@pytest.mark.parametrize(("shape", "ndim"), [(Ellipse((1.0, 0.5)), 2), (Torus(0.9, 0.45), 3)])
def test_the_surface_integral_is_kept_to_round_off_else_to_order_two(shape, ndim):
    def law(p):
        return 1 + np.exp(2 * p[1])

    drifts = []
    for cells in (12, 24) if ndim == 2 else (12,):
        grid = around(1.4, cells, ndim)
        for keep in (True, False):
            start, state = spread(shape, grid, law, 0.05, keep=keep)
            drifts.append(abs(state.surface.integral(state.values) / start.mass - 1))
    assert max(drifts[::2]) < 1e-13
    assert 1e-8 < drifts[1] < 2e-3
    if ndim == 2:
        assert drifts[3] < drifts[1] / 3


def test_a_constant_stays_and_values_stay_between_their_extremes():
    grid = around(1, 16, 2)
    _, state = spread(Disk(1.0), grid, lambda p: np.full(p.shape[1], 3.0), 0.2)
    np.testing.assert_allclose(state.values, 3.0, rtol=1e-12)
    start, state = spread(Disk(1.0), grid, lambda p: np.exp(-20 * (p[0] - 1) ** 2), 0.05)
    assert start.values.min() - 1e-3 < state.values.min()
    assert state.values.max() < start.values.max()


def test_the_embedded_laplacian_is_that_of_laplace_beltrami():
    grid = around(1, 32, 3)
    surface = SurfaceBand.around(Sphere(1.0), grid)
    values = surface.closest[:, 0] * surface.closest[:, 2]
    found = surface.laplacian(values) / grid.spacing**2
    np.testing.assert_allclose(found, -6 * values, atol=0.02)
    near = np.abs(surface.distance) < 0.5 * grid.spacing
    phi, field = (surface.on_grid(v).reshape(grid.shape) for v in (surface.distance, values))
    other = laplace_beltrami(field, phi, grid, nodes=surface.nodes)
    np.testing.assert_allclose(found[near], other[near], atol=0.25)  # other radii, off the surface
    assert np.abs(found - other)[near].mean() < 0.1


def test_phi_need_not_be_a_distance_and_values_may_be_a_field():
    grid = around(1, 24, 2)
    x, y = grid.points()
    phi = (x * x + y * y - 1) * (2 + x)
    flow = SurfaceDiffusion(grid=grid, diffusivity=1.0)
    by_law = flow.start(Disk(1.0), lambda p: p[0] * p[1])
    by_field = flow.start(phi, x * y)
    np.testing.assert_allclose(by_field.mass, by_law.mass, atol=1e-5)
    angle = np.linspace(0, 2 * np.pi, 50)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for state in (by_law, by_field):
        found = state.surface.at(state.values, points)
        np.testing.assert_allclose(found, 0.5 * np.sin(2 * angle), atol=1e-4)


def test_a_cylinder_across_a_periodic_axis_knows_no_end():
    sides = ("unbounded", "unbounded", "periodic")
    grid = Grid((37, 37, 16), 1 / 12, (-1.47, -1.5, 0.0), sides)
    x, y, _ = grid.points()
    length = 16 / 12

    def law(p):
        return np.cos(2 * np.pi * p[2] / length) * p[0]

    flow = SurfaceDiffusion(grid=grid, diffusivity=1.0, stretch=5.0)
    start = state = flow.start(np.hypot(x, y) - 1, law)
    for _ in range(5):
        state = flow.step(state, 0.01)
    rate = 1 + (2 * np.pi / length) ** 2
    np.testing.assert_allclose(state.values, np.exp(-0.05 * rate) * start.values, atol=0.01)


def test_the_order_in_time_is_two():
    surface = SurfaceBand.around(Disk(1.0), around(1, 32, 2))
    flow = SurfaceDiffusion(grid=surface.grid, diffusivity=1.0)
    start = flow.start(surface, lambda p: p[0] ** 3)
    ends = []
    for steps in (4, 8, 16, 128):
        state = start
        for _ in range(steps):
            state = flow.step(state, 0.4 / steps)
        ends.append(state.values)
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.2)


def test_a_step_of_a_thousand_explicit_ones_damps_all_but_the_mean():
    start, state = spread(Disk(1.0), around(1, 24, 2), lambda p: 2 + p[0], 50.0, stretch=1e4)
    np.testing.assert_allclose(state.values, 2.0, atol=1e-3)
    assert state.step < 20
    assert start.mass == pytest.approx(4 * np.pi, rel=1e-5)


def test_an_implicit_stage_solves_its_equation():
    surface = SurfaceBand.around(Disk(1.0), around(1, 24, 2))
    right = surface.closest[:, 0]
    found = implicit(surface, right, 3.0, right)
    np.testing.assert_allclose(found - 3.0 * surface.laplacian(found), right, atol=1e-9)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_the_precision_asked_for_is_kept(dtype):
    grid = around(1, 16, 2)
    flow = SurfaceDiffusion(grid=grid, diffusivity=0.5)
    state = flow.start(Disk(1.0), lambda p: p[0], dtype=dtype)
    state = flow.step(state, 0.02)
    assert state.values.dtype == dtype
    assert flow.fields(state)["values"].dtype == dtype
    expected = np.exp(-0.01) * state.surface.closest[:, 0]
    np.testing.assert_allclose(state.values, expected, atol=1e-3)


def test_a_resumed_run_repeats_an_unbroken_one_bit_for_bit(tmp_path):
    grid = around(1, 12, 2)
    flow = SurfaceDiffusion(grid=grid, diffusivity=1.0)
    start = flow.start(Ellipse((1.0, 0.7)), lambda p: p[0] + p[1] ** 2)

    def stop(moment):
        if moment.step == 3:
            raise RuntimeError("enough")

    whole = run(flow, start, until=0.3, out=tmp_path / "whole")
    with pytest.raises(RuntimeError, match="enough"):
        run(flow, start, until=0.3, out=tmp_path / "parts", watch=[stop])
    parts = run(flow, start, until=0.3, out=tmp_path / "parts", resume=True)
    assert parts.step == whole.step
    np.testing.assert_array_equal(parts.values, whole.values)
    assert set(flow.ledger(whole)) == {"mass", "lowest", "highest"}
    assert flow.fields(whole)["phi"].shape == grid.shape


def test_starts_that_cannot_be_are_refused():
    grid = around(1, 16, 2)
    flow = SurfaceDiffusion(grid=grid, diffusivity=1.0)
    with pytest.raises(InputError, match="within five spacings of an unbounded edge"):
        flow.start(Box((2.5, 1.0)), lambda p: p[0])
    with pytest.raises(InputError, match="of one sign"):
        flow.start(Disk(0.2, center=(9.0, 0.0)), lambda p: p[0])
    with pytest.raises(InputError, match="finite"):
        flow.start(Disk(1.0), lambda p: p[0] * np.nan)
    with pytest.raises(InputError, match="grid's shape"):
        flow.start(Disk(1.0), np.zeros(3))
    with pytest.raises(InputError, match="another grid"):
        flow.start(SurfaceBand.around(Disk(1.0), around(1, 12, 2)), lambda p: p[0])
    for law in (lambda p: p, lambda p: p[0][:-1], lambda _: "a", np.full(grid.shape, "a")):
        with pytest.raises(InputError, match="values must be"):
            flow.start(Disk(1.0), law)
    with pytest.raises(InputError, match="a shape or numbers"):
        flow.start("a", lambda p: p[0])
    for name in ("diffusivity", "stretch"):
        with pytest.raises(InputError, match=f"{name} must be a number"):
            SurfaceDiffusion(**{"grid": grid, "diffusivity": 1.0, name: "a"})
    with pytest.raises(InputError, match="grid must be a Grid"):
        SurfaceDiffusion(grid=None, diffusivity=1.0)
    for wrong in ({"diffusivity": 0.0}, {"diffusivity": 1.0, "stretch": -1.0}):
        with pytest.raises(InputError, match="must be positive"):
            SurfaceDiffusion(grid=grid, **wrong)


@pytest.mark.parametrize("dt", [0.0, -0.1, np.nan, np.inf, "a"])
def test_steps_that_are_no_time_are_refused(dt):
    flow = SurfaceDiffusion(grid=around(1, 12, 2), diffusivity=1.0)
    with pytest.raises(InputError, match="dt must be"):
        flow.step(flow.start(Disk(1.0), lambda p: p[0]), dt)


def test_parts_of_a_surface_keep_their_own_integrals():
    left, right = Disk(0.5, center=(-1.0, 0.03)), Ellipse((0.6, 0.4)).moved(shift=(1.0, 0.0))
    start, state = spread(left | right, around(1.7, 16, 2), lambda p: np.maximum(p[0], 0.0), 0.1)
    assert start.masses.shape == (2,)
    found = state.surface.integrals(state.values)
    np.testing.assert_allclose(found, start.masses, rtol=1e-12, atol=1e-14)
    on_left = state.surface.closest[:, 0] < 0
    np.testing.assert_array_equal(state.values[on_left], 0.0)  # there was none, there is none


def test_values_that_leave_their_extremes_by_far_break_a_run(monkeypatch):
    flow = SurfaceDiffusion(grid=around(1, 12, 2), diffusivity=1.0)
    state = flow.start(Disk(1.0), lambda p: p[0])
    for wrong in (3.5, -3.5, np.nan):
        monkeypatch.setattr(
            surface_diffusion, "implicit", lambda *_, w=wrong, **__: w * state.values
        )
        with pytest.raises(BlowUpError, match="made values from"):
            flow.step(state, 0.01)


def test_threads_do_not_change_a_bit():
    ends = []
    for threads in (1, 2):
        grid = around(1, 12, 3)
        flow = SurfaceDiffusion(grid=grid, diffusivity=1.0, threads=threads)
        state = flow.step(flow.start(Sphere(1.0), lambda p: p[0] * p[2]), 0.01)
        ends.append(state.values)
    np.testing.assert_array_equal(*ends)
    assert flow == SurfaceDiffusion(grid=grid, diffusivity=1.0)
