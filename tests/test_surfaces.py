"""Pictures of surfaces: where things are seen, how they are lit, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from pmesh.cases import surfaces
from pmesh.cases.offscreen import can_render
from pmesh.cases.style import panels
from pmesh.cases.surfaces import Layer, render, show_surface
from remesh.errors import InputError
from remesh.grid import Grid

needs_opengl = pytest.mark.skipif(not can_render(), reason="no OpenGL here")
both_ways = pytest.mark.usefixtures("way")
GRID = Grid((33, 33, 33), 1 / 16, (-1.0, -1.0, -1.0))
SMALL = {"size": (160, 120), "ground": False}
ROOM = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))


@pytest.fixture(params=[pytest.param("VTK", marks=needs_opengl), "plain"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """What draws."""
    if request.param == "plain":
        monkeypatch.setattr(surfaces, "can_render", lambda: False)


class Triangles(NamedTuple):
    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]


class WithNormals(NamedTuple):
    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64]


def ball(x: float = 0.0, y: float = 0.0, z: float = 0.0, radius: float = 0.5) -> tuple[Any, Grid]:
    points = GRID.points() - np.array([x, y, z])[:, None, None, None]
    return np.sqrt((points**2).sum(axis=0)) - radius, GRID


def reddish(image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return image[..., 0].astype(int) > image[..., 2].astype(int) + 20


def bluish(image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return image[..., 2].astype(int) > image[..., 0].astype(int) + 20


def middle(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Mean (row, column) of a set of pixels."""
    return np.argwhere(mask).mean(axis=0)


def pair(first: tuple[Any, Grid], second: tuple[Any, Grid], **options: Any) -> Any:
    """A red and a blue surface."""
    red, blue = Layer(surface=first, colour="#d03030"), Layer(surface=second, colour="#3030d0")
    return render(red, blue, bounds=ROOM, **(SMALL | options))


@both_ways
def test_a_picture_is_of_the_asked_size_and_white_around_the_surface() -> None:
    image = render(ball(), **SMALL)
    assert (image.shape, image.dtype) == ((120, 160, 3), np.uint8)
    assert (image[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all()
    assert (image[60, 80] < 255).any()


@both_ways
def test_z_points_up_and_x_right_seen_from_azimuth_minus_90() -> None:
    image = pair(ball(0.5, radius=0.3), ball(-0.5, radius=0.3), view=(-90.0, 10.0))
    assert middle(reddish(image))[1] > middle(bluish(image))[1] + 40
    image = pair(ball(z=0.5, radius=0.3), ball(z=-0.5, radius=0.3))
    assert middle(reddish(image))[0] < middle(bluish(image))[0] - 30


@both_ways
def test_what_is_nearer_hides_what_is_behind_unless_it_is_translucent() -> None:
    near, far = ball(y=-0.6, radius=0.35), ball(y=0.4, radius=0.3)
    assert not bluish(pair(near, far, view=(-90.0, 0.1))).any()
    assert not reddish(pair(near, ball(y=0.5, radius=0.2), view=(90.0, 0.1)))[60, 80]
    glass = Layer(surface=near, colour="#ffffff", opacity=0.3)
    image = render(glass, Layer(surface=far, colour="#3030d0"), view=(-90.0, 0.1), **SMALL)
    assert bluish(image)[60, 80]


@both_ways
def test_light_comes_from_the_upper_left() -> None:
    image = render(ball(), **SMALL).astype(float).mean(axis=-1)
    assert image[40, 65] > image[85, 100] + 30


@needs_opengl
def test_hollows_are_darker_than_open_faces() -> None:
    """A deep round hole towards the camera: its floor gets less light than the face around it."""
    x, y, z = GRID.points()
    block = np.maximum.reduce([abs(x), abs(y), abs(z)]) - 0.8
    hole = np.maximum(np.hypot(x, z) - 0.25, y - 0.3)
    image = render((np.maximum(block, -hole), GRID), view=(-90.0, 0.1), **SMALL).astype(float)
    assert image[60, 80].mean() < 0.95 * image[60, 55].mean()


@both_ways
def test_a_sheet_thinner_than_a_cell_is_lit_like_a_thick_plate() -> None:
    """phi rises six times as steeply below it: its gradient at the nodes inside points down."""
    z = GRID.points()[2]
    options: dict[str, Any] = {"bounds": ROOM, "view": (-90.0, 60.0), **SMALL}
    sheet = render((np.maximum(z, -6 * z) - 0.05 * GRID.spacing, GRID), **options).astype(float)
    plate = render((np.abs(z) - 0.1, GRID), **options)
    assert sheet[60, 80] == pytest.approx(plate[60, 80], rel=0.1)


@both_ways
def test_normals_that_point_inward_do_not_turn_the_light_off() -> None:
    import pyvista

    mesh = pyvista.Icosphere(radius=0.5, nsub=4)
    inward = WithNormals(mesh.points, mesh.regular_faces, -mesh.points / 0.5)
    one = render(inward, bounds=ROOM, **SMALL).astype(float)
    assert np.abs(one - render(ball(), bounds=ROOM, **SMALL)).mean() < 2.0


@both_ways
def test_all_of_a_surface_is_seen_and_it_fills_the_picture() -> None:
    for shift in (0.0, 0.45):
        seen = np.argwhere((render(ball(shift, shift, -shift), **SMALL) < 250).any(axis=-1))
        low, high = seen.min(axis=0), seen.max(axis=0)
        assert (low > 0).all()
        assert (high < (119, 159)).all()
        assert (high - low).max() > 0.8 * 120


@both_ways
def test_bounds_hold_the_camera_still() -> None:
    large, little = (
        (render(ball(radius=r), bounds=ROOM, **SMALL) < 250).any(axis=-1).sum() for r in (0.6, 0.3)
    )
    assert large / little == pytest.approx(4.0, rel=0.1)


@both_ways
def test_triangles_and_a_level_set_of_one_sphere_give_one_picture() -> None:
    import pyvista

    mesh = pyvista.Icosphere(radius=0.5, nsub=5)
    surface = Triangles(mesh.points, mesh.regular_faces)
    one = render(surface, bounds=ROOM, **SMALL).astype(float)
    other = render(ball(), bounds=ROOM, **SMALL).astype(float)
    assert np.abs(one - other).mean() < 2.0


@both_ways
def test_values_colour_the_surface_between_their_limits() -> None:
    x = GRID.points()[0]
    layer = Layer(surface=ball(), values=x, colours="coolwarm", limits=(-0.5, 0.5))
    image = render(layer, view=(-90.0, 10.0), **SMALL)
    assert middle(reddish(image))[1] > middle(bluish(image))[1] + 30
    cold = Layer(surface=ball(), values=x, colours="coolwarm", limits=(0.5, 1.5))
    assert not reddish(render(cold, **SMALL)).any()


@both_ways
def test_without_a_background_the_picture_has_alpha_and_colours_of_its_own() -> None:
    white = render(ball(), size=(160, 120))
    clear = render(ball(), size=(160, 120), background=None)
    assert clear.shape == (120, 160, 4)
    assert clear[0, 0, 3] == 0
    assert clear[60, 80, 3] == 255
    alpha = clear[..., 3:] / 255.0
    again = clear[..., :3] * alpha + 255.0 * (1.0 - alpha)
    assert np.abs(again - white).mean() < 2.0
    shadow = clear[(clear[..., 3] > 30) & (clear[..., 3] < 120)]
    assert np.median(shadow[:, :3], axis=0).max() < 90


@both_ways
def test_the_shadow_lies_below_and_is_left_out_when_seen_from_there() -> None:
    options: dict[str, Any] = {"bounds": ROOM, "size": (160, 120)}
    dry = render(ball(), ground=False, **options).astype(int)
    lit = render(ball(), **options).astype(int)
    shadow = (lit < dry - 20).any(axis=-1)
    assert shadow.sum() > 500
    assert middle(shadow)[0] > 15 + middle((dry < 250).any(axis=-1))[0]
    assert lit[88, 82].max() < 225  # its middle is filled
    from_below = [render(ball(), view=(-55.0, -20.0), ground=g, **options) for g in (True, False)]
    assert np.array_equal(*from_below)


@both_ways
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_box_is_drawn_in_grey(dtype: type) -> None:
    phi, grid = ball(radius=0.1)
    surface = (phi.astype(dtype), grid)
    bare, boxed = (render(surface, box=b, bounds=ROOM, **SMALL) for b in (False, True))
    drawn = (bare != boxed).any(axis=-1) & (bare == 255).all(axis=-1)
    assert drawn.sum() > 300
    assert np.ptp(boxed[drawn].astype(int), axis=-1).max() <= 2


@both_ways
def test_the_same_surface_is_drawn_the_same_twice_and_nothing_given_is_changed() -> None:
    phi, grid = ball()
    kept = phi.copy()
    assert np.array_equal(render((phi, grid), **SMALL), render((phi, grid), **SMALL))
    assert np.array_equal(phi, kept)


@needs_opengl
def test_a_machine_without_opengl_draws_the_same_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shadow, box, values and highlights included; only hollows differ, and here are none."""
    x, y, z = GRID.points()
    away = np.sqrt((x / 0.7) ** 2 + (y / 0.5) ** 2 + (z / 0.4) ** 2) - 1.0
    options: dict[str, Any] = {"size": (320, 240), "background": "#e0e8f0"}
    for layer, box in (
        (Layer(surface=(away, GRID), colour=surfaces.COPPER), True),
        (Layer(surface=(away, GRID), values=np.sin(6 * z), colours="coolwarm"), False),
        (Layer(surface=(away, GRID), opacity=0.5), False),
    ):
        one = render(layer, box=box, bounds=ROOM, **options).astype(float)
        with monkeypatch.context() as patch:
            patch.setattr(surfaces, "can_render", lambda: False)
            other = render(layer, box=box, bounds=ROOM, **options)
        assert np.abs(one - other).mean() < 1.0
        assert np.quantile(np.abs(one - other), 0.95) < 6.0


@both_ways
def test_values_that_are_not_known_are_grey() -> None:
    values = np.where(GRID.points()[0] > 0, np.nan, 0.0)
    layer = Layer(surface=ball(), values=values, colours="coolwarm", limits=(0.0, 1.0))
    image = render(layer, view=(-90.0, 10.0), **SMALL)
    assert bluish(image)[60, 50]
    assert np.ptp(image[60, 110].astype(int)) < 20


@both_ways
def test_a_picture_from_a_level_height_or_from_above_is_drawn_too() -> None:
    for elevation in (0.0, 1e-9, 5.0, 90.0):
        image = render(ball(), view=(0.0, elevation), size=(80, 60))
        assert bluish(image)[30, 40]


def test_a_panel_shows_a_picture_without_axes_and_with_a_bar_if_asked() -> None:
    figure, axes = panels(1, 2, (4, 2))
    image = np.full((30, 40, 3), 200, np.uint8)
    show_surface(axes[0, 0], image, title="t = 0")
    show_surface(axes[0, 1], image, limits=(0.0, 1.0), label="c")
    assert axes[0, 0].get_title() == "t = 0"
    assert not axes[0, 0].axison
    assert [panel.get_ylabel() for panel in figure.axes[2:]] == ["c"]


CORNER = Triangles(np.eye(3), np.array([[0, 1, 2]]))
REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: render(), "at least one surface"),
    (lambda: render((np.ones(GRID.shape), GRID)), "no contour"),
    (lambda: render((np.full(GRID.shape, np.nan), GRID)), "finite"),
    (lambda: render((np.zeros((4, 4)), Grid((4, 4), 1.0))), "a grid in space"),
    (lambda: render(Layer(surface=ball(), values=np.zeros(5))), "values must have the shape"),
    (lambda: render(Triangles(np.zeros((3, 2)), np.zeros((1, 3), int))), "vertices must have"),
    (lambda: render(Triangles(np.eye(3), np.zeros((0, 3), int))), "no triangles"),
    (lambda: render(Triangles(np.inf * np.ones((3, 3)), CORNER.faces)), "vertices must be finite"),
    (lambda: render(Triangles(np.eye(3), np.array([[0, 1, 3]]))), "places in 3 vertices"),
    (lambda: render(Triangles(np.eye(3), np.array([[0.0, 1.0, 2.0]]))), "places in 3 vertices"),
    (lambda: render(Layer(surface=CORNER, values=np.zeros(5))), r"values must have shape \(3,\)"),
    (lambda: render(ball(), bounds=((1, 1, 1), (0, 0, 0))), "bounds must be"),
]


@pytest.mark.parametrize(("wrong", "told"), REFUSED)
def test_what_cannot_be_drawn_is_refused(wrong: Callable[[], object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        wrong()
