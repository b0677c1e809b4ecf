"""Adaptive representations of fields: the error follows the tolerance."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires import pyramid
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.sampling import sampled
from remesh.multires.uniform import to_uniform

FIELDS = {
    "smooth": lambda x: np.exp(-(radius(x) ** 2) / 0.07**2),
    "kinked": lambda x: np.maximum(0.25 - radius(x), 0),
    "jump": lambda x: np.where(radius(x) < 0.25, 1.0, 0.0),
}


def radius(points):
    return np.sqrt(sum((x - 0.5 - 0.01 * a) ** 2 for a, x in enumerate(points)))


def recipe(ndim, **more):
    nodes, levels = (512, 4) if ndim == 2 else (64, 2)
    boundary = ("periodic", *("unbounded",) * (ndim - 1))
    grid = Grid((nodes,) * ndim, 1 / nodes, boundary=boundary)
    return AdaptiveMesh(grid=grid, levels=levels, block=8, **more)


def error(field, mesh):
    blocks, values = sampled(field, mesh)
    want = field(mesh.grid.points()) if callable(field) else field
    return abs(to_uniform(values, blocks) - want).max() / abs(want).max(), blocks


@pytest.mark.parametrize("kind", ["law", "array"])
@pytest.mark.parametrize("name", ["2.2", "4.2", "4.4", "6.2"])
@pytest.mark.parametrize("side", FIELDS)
@pytest.mark.parametrize("ndim", [2, 3])
def test_the_error_stays_below_ten_times_the_tolerance_over_five_decades(ndim, side, name, kind):
    tolerances = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5]
    if ndim == 3 or name != "4.4":
        tolerances = tolerances[1::2]
    for tolerance in tolerances:
        mesh = recipe(ndim, wavelet=name, tolerance=tolerance)
        field = FIELDS[side] if kind == "law" else FIELDS[side](mesh.grid.points())
        assert error(field, mesh)[0] < 10 * tolerance


@pytest.mark.parametrize("side", ["bumps", "kinked"])
def test_the_error_is_proportional_to_the_tolerance_over_five_decades(side):
    rng = np.random.default_rng(1)
    centers, widths = rng.uniform(0.2, 0.8, (8, 2)), rng.uniform(0.03, 0.12, 8)

    def bumps(x):
        """Gaussians of many widths: details of all sizes."""
        away = (((x[0] - a) ** 2 + (x[1] - b) ** 2) for a, b in centers)
        return sum(np.exp(-r / w**2) for r, w in zip(away, widths, strict=True))

    tolerances = 10.0 ** -np.arange(1, 6.25, 0.5)
    law = bumps if side == "bumps" else FIELDS[side]
    errors = [error(law, recipe(2, tolerance=tolerance))[0] for tolerance in tolerances]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert slope == pytest.approx(1, abs=0.16)
    assert max(errors / tolerances) < 10


def test_a_finer_tolerance_costs_more_nodes_and_all_are_far_fewer_than_the_uniform_ones():
    sizes = []
    for tolerance in (1e-2, 1e-3, 1e-4):
        blocks = error(FIELDS["smooth"], recipe(2, tolerance=tolerance))[1]
        sizes.append(blocks.active)
    assert sizes[0] < sizes[1] < sizes[2] < 512**2 / 10


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_law_and_its_array_get_the_same_blocks_where_they_are_smooth(ndim):
    mesh = recipe(ndim, tolerance=1e-4)
    one = sampled(FIELDS["smooth"], mesh)[0]
    other = sampled(FIELDS["smooth"](mesh.grid.points()), mesh)[0]
    assert abs(one.size - other.size) <= 0.1 * other.size


@pytest.mark.parametrize("ndim", [2, 3])
def test_values_are_consistent_and_may_have_components(ndim):
    mesh = recipe(ndim)
    blocks, values = sampled(lambda x: np.stack([FIELDS["smooth"](x), x[0] * 0]), mesh)
    assert values.shape == (2, *blocks.shape)
    assert (values[1] == 0).all()
    assert np.allclose(pyramid.restricted(values, blocks), values, rtol=0, atol=1e-14)


def test_arrays_keep_their_sums_and_their_precision():
    mesh = recipe(2, tolerance=1e-2)
    field = FIELDS["kinked"](mesh.grid.points())
    blocks, values = sampled(field, mesh)
    own = values[blocks.of(0)]
    assert own.sum() * 4**mesh.levels == pytest.approx(field.sum(), rel=1e-12)
    blocks, values = sampled(field.astype(np.float32), mesh)
    assert values.dtype == np.float32


def test_what_lies_between_the_nodes_of_the_first_levels_is_found_from_a_finer_one():
    def law(x):
        """A bump between the nodes of level 2."""
        return np.exp(-sum((a - 0.5 - 1 / 256) ** 2 for a in x) / 0.001**2)

    mesh = recipe(2)
    assert sampled(law, mesh, scale=1.0)[0].finest == 0
    blocks, values = sampled(law, mesh, scale=1.0, least=4)
    assert blocks.finest == mesh.levels
    want = law(mesh.grid.points())
    assert abs(to_uniform(values, blocks) - want).max() < 1e-2 * want.max()


def test_what_is_no_field_is_refused():
    mesh = recipe(2)
    with pytest.raises(InputError, match="field must have shape"):
        sampled(np.ones((8, 8)), mesh)
    with pytest.raises(InputError, match="the law must give values"):
        sampled(lambda x: np.ones(3), mesh)
    for least in (0, 1.5, True):
        with pytest.raises(InputError, match="least must be"):
            sampled(FIELDS["smooth"], mesh, least=least)
