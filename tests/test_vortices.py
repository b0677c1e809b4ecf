"""Vortices in space: which scalars are seen, at which levels, in which colours, where."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from vortex_shots import CORE, GRID, PEAK, RADIUS, ring, shot

import pmesh
from pmesh.cases import surfaces
from pmesh.cases.style import panels
from pmesh.cases.vortices import (
    GLASS,
    SHARES,
    Look,
    NothingToShowError,
    colour_limits,
    default_levels,
    extent,
    layers_of,
    looked,
    picture,
    scalar,
    show_isosurface,
    usual_field,
)
from pmesh.run.snapshots import write_snapshot
from remesh.errors import InputError
from remesh.grid import Grid

SMALL: dict[str, Any] = {"size": (120, 90), "ground": False}


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawn by plain loops: the same anywhere."""
    monkeypatch.setattr(surfaces, "can_render", lambda: False)


def test_a_vector_is_seen_by_its_length_and_a_component_by_its_name(tmp_path: Path) -> None:
    one = shot(tmp_path, 1)
    w = ring()
    assert scalar(one, "vorticity") == pytest.approx(np.sqrt((w**2).sum(axis=0)))
    assert scalar(one, "vorticity_y") == pytest.approx(w[1])


def test_the_criteria_are_those_of_the_velocity_held_or_else_of_the_vorticitys(
    tmp_path: Path,
) -> None:
    velocity = pmesh.velocity(ring(), GRID)
    bare, held = shot(tmp_path, 1), shot(tmp_path, 2, velocity=velocity + 5.0)
    for name, law in (("lambda2", pmesh.lambda2), ("q", pmesh.q_criterion)):
        exact = law(velocity, GRID)
        assert scalar(bare, name) == pytest.approx(exact, abs=1e-10)
        assert scalar(held, name) == pytest.approx(exact, abs=1e-10)
    assert scalar(bare, "helicity") == pytest.approx((velocity * ring()).sum(axis=0), abs=1e-12)


def test_what_is_not_held_is_refused_with_what_is(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no field 'pressure'") as said:
        scalar(shot(tmp_path, 1), "pressure")
    assert "helicity, lambda2, q, vorticity" in str(said.value)
    with pytest.raises(InputError, match="no field 'vorticity_w'"):
        scalar(shot(tmp_path, 1), "vorticity_w")
    alone = write_snapshot(tmp_path / "1.vtkhdf", GRID, {"heat": np.ones(GRID.shape)}, 0, 0.0)
    with pytest.raises(InputError, match="no field 'q'"):
        scalar(alone, "q")


def test_the_level_is_a_share_of_the_extreme_on_the_side_of_it(tmp_path: Path) -> None:
    one = shot(tmp_path, 1)
    assert default_levels([one], "vorticity") == pytest.approx(
        (SHARES["vorticity"] * PEAK,), rel=0.1
    )
    lowest = scalar(one, "lambda2").min()
    assert default_levels([one], "lambda2") == pytest.approx((SHARES["lambda2"] * lowest,), rel=0.1)
    up, down = default_levels([one], "vorticity_x")
    assert up == -down > 0
    with pytest.raises(InputError, match="is zero in the snapshots"):
        default_levels([one], "vorticity_z")


def test_vorticity_at_a_wall_does_not_set_the_level_of_a_wake(tmp_path: Path) -> None:
    wall = np.zeros((3, *GRID.shape))
    wall[0, 14:19, 14:19, 14:19] = 1000.0  # in the ball and at its wall
    one = write_snapshot(
        tmp_path / "1.vtkhdf", GRID,
        {"vorticity": ring() + wall, "chi": shot(tmp_path, 1, chi=True)["chi"]}, 0, 0.0,
    )  # fmt: skip
    (level,) = default_levels([one], "vorticity")
    assert 0.1 * PEAK < level < PEAK
    assert (usual_field(one), usual_field(shot(tmp_path, 2))) == ("lambda2", "vorticity")


def test_a_surface_of_gaussian_cores_is_the_torus_that_it_is(tmp_path: Path) -> None:
    from levelset.surface import triangles

    one, level = shot(tmp_path, 1), 1.5
    (layer,) = layers_of(one, looked([one], "vorticity", levels=[level]))
    found = triangles(*layer.surface)  # type: ignore[misc]
    core = CORE * math.sqrt(math.log(PEAK / level))
    x, y, z = found.vertices.T
    assert np.abs(np.hypot(np.hypot(x, y) - RADIUS, z) - core).max() < 0.02 * GRID.spacing
    low, high = extent([layer], GRID)
    assert low == pytest.approx([-RADIUS - core] * 2 + [-core], abs=1.01 / 8)
    assert high == pytest.approx(-low, abs=1e-12)


def test_of_several_levels_the_outer_ones_are_glass_and_a_signed_field_has_two_colours(
    tmp_path: Path,
) -> None:
    one = shot(tmp_path, 1)
    layers = layers_of(one, looked([one], "vorticity", levels=(1.0, 3.0)))
    assert [layer.opacity for layer in layers] == [GLASS, 1.0]
    layers = layers_of(one, looked([one], "vorticity_x"))
    assert len({layer.colour for layer in layers}) == 2
    assert [layer.opacity for layer in layers] == [1.0, 1.0]


def test_colours_end_at_what_is_found_on_the_surface_even_if_signed(tmp_path: Path) -> None:
    x = GRID.points()[0]
    one = shot(tmp_path, 1, heat=x, warmth=x + 3.0)
    core = CORE * math.sqrt(math.log(4 / 1.5))
    most = RADIUS + core
    low, high = colour_limits([one], "heat", "vorticity", [1.5])
    assert low == -high
    assert high == pytest.approx(most, abs=0.1)
    assert colour_limits([one], "warmth", "vorticity", [1.5]) == pytest.approx(
        (3 - most, 3 + most), abs=0.1
    )


def test_what_is_at_a_wall_does_not_stretch_the_colours(tmp_path: Path) -> None:
    chi = shot(tmp_path, 1, chi=True)["chi"]
    wall = 1.0 * (chi > 0)
    fields = {"vorticity": ring() + 9.0 * wall, "heat": 1.0 + 500.0 * wall, "chi": chi}
    one = write_snapshot(tmp_path / "1.vtkhdf", GRID, fields, 0, 0.0)
    assert colour_limits([one], "heat", "vorticity", [1.5]) == pytest.approx((0.5, 1.5))


def test_bodies_stand_beside_and_what_is_weaker_than_the_level_leaves_white(tmp_path: Path) -> None:
    one = shot(tmp_path, 1, chi=True)
    assert len(layers_of(one, Look("vorticity", (1.5,)))) == 2
    empty = picture(shot(tmp_path, 2), Look("vorticity", (99.0,)), **SMALL)
    assert (empty.shape, empty.min()) == ((90, 120, 3), 255)


def test_all_of_a_surface_is_in_the_picture_and_fills_it(tmp_path: Path) -> None:
    one = shot(tmp_path, 1, side=0.3)
    image = picture(one, looked([one], "vorticity"), **SMALL)
    seen = np.argwhere((image < 250).any(axis=-1))
    assert (seen.min(axis=0) > 0).all()
    assert (seen.max(axis=0) < (89, 119)).all()
    assert np.ptp(seen, axis=0)[1] > 0.75 * 120


def test_a_periodic_flow_is_shown_in_its_box(tmp_path: Path) -> None:
    grid = Grid((16,) * 3, 1 / 16, boundary="periodic")
    wave = np.cos(2 * np.pi * grid.points()[0])
    one = write_snapshot(tmp_path / "1.vtkhdf", grid, {"heat": 2.0 + wave}, 0, 0.0)
    layers = layers_of(one, Look("heat", (2.5,)))
    low, high = extent(layers, grid)
    assert (low.tolist(), high.tolist()) == ([0.0] * 3, [1.0] * 3)
    assert picture(one, Look("heat", (2.5,)), **SMALL).min() < 200


def test_a_panel_has_the_picture_and_a_bar_and_tells_what_it_shows(tmp_path: Path) -> None:
    figure, axes = panels(1, 2, (4.0, 2.0))
    one = shot(tmp_path, 1, heat=GRID.points()[2])
    look = show_isosurface(axes[0, 0], one, "vorticity", colour_by="heat", title="a ring", **SMALL)
    assert [len(axes[0, 0].images), len(figure.axes)] == [1, 3]
    assert figure.axes[2].get_ylabel() == "heat"
    again = show_isosurface(
        axes[0, 1], one, look.field, levels=look.levels, colour_by="heat", limits=look.limits,
        label="", **SMALL,
    )  # fmt: skip
    assert (again, len(figure.axes)) == (look, 3)


def test_levels_that_enclose_nothing_are_refused(tmp_path: Path) -> None:
    for levels in ((), (0.0,), (math.nan,)):
        with pytest.raises(InputError, match="levels must be finite numbers that are not zero"):
            looked([shot(tmp_path, 1)], "vorticity", levels=levels)


def test_where_only_walls_have_a_vortex_it_is_looked_for_beside_them(tmp_path: Path) -> None:
    """A box just around a ball: no node is three away from it, and some are outside."""
    grid = Grid((8, 8, 8), 1 / 8, (-0.4375,) * 3)
    x, y, z = grid.points()
    chi = np.clip((0.5 - np.sqrt(x**2 + y**2 + z**2)) / 0.1, 0.0, 1.0)
    fields = {"vorticity": np.stack([2.0 + 0 * x, 0 * x, 0 * x]), "chi": chi}
    one = write_snapshot(tmp_path / "1.vtkhdf", grid, fields, 0, 0.0)
    assert default_levels([one], "vorticity") == pytest.approx((2.0 * SHARES["vorticity"],))


def test_layers_without_a_vortex_are_shown_by_their_vorticity(tmp_path: Path) -> None:
    """Where a flow is strained and does not turn, lambda-2 is positive."""
    x, y, z = GRID.points()
    strained = {"velocity": np.stack([-0.5 * x, -0.5 * y, z]), "vorticity": ring()}
    chi = shot(tmp_path, 1, chi=True)["chi"]
    one = write_snapshot(tmp_path / "1.vtkhdf", GRID, {**strained, "chi": chi}, 0, 0.0)
    assert usual_field(one) == "lambda2"
    assert looked([one]).field == "vorticity"
    with pytest.raises(NothingToShowError, match="'lambda2' is nowhere negative"):
        looked([one], "lambda2")


def test_snapshots_in_which_a_field_is_zero_do_not_lower_its_level(tmp_path: Path) -> None:
    full, empty = shot(tmp_path, 1, heat=ring()[0]), shot(tmp_path, 2, heat=0 * ring()[0])
    assert default_levels([empty, full, empty], "heat") == default_levels([full], "heat")


def test_a_panel_without_anything_to_show_says_so(tmp_path: Path) -> None:
    still = {"vorticity": 0 * ring()}
    one = write_snapshot(tmp_path / "1.vtkhdf", GRID, still, 0, 0.0)
    panel, other = panels(1, 2, (4.0, 2.0))[1].ravel()
    assert show_isosurface(panel, one, "vorticity", colour_by="vorticity_x", **SMALL).levels == ()
    show_isosurface(other, shot(tmp_path, 2), "vorticity", levels=[100.0], **SMALL)
    said = [text.get_text() for one in (panel, other) for text in one.texts]
    assert said == ["nothing to show of vorticity"] * 2
