"""The case `compress`: what it measures is so, and what it leaves can be read back."""

import json

import numpy as np
import pytest

from pmesh.cases.compress import FILE, CompressCase, filaments, moment_error
from pmesh.cases.runner import run_case
from pmesh.run.series import read_series
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.compression import compress
from remesh.multires.storage import load


@pytest.mark.parametrize("kind", ["filaments", "odd", "space", "vector", "image"])
def test_error_and_moments_hold_over_five_decades_of_any_field(tmp_path, kind):
    options = {"nodes": 96} if kind == "filaments" else {"file": str(tmp_path / "field.npy")}
    rng = np.random.default_rng(3)
    if kind == "odd":
        x, y = np.meshgrid(np.linspace(0, 1, 75), np.linspace(0, 1, 90), indexing="ij")
        np.save(options["file"], np.maximum(0.3 - np.hypot(x - 0.5, y - 0.4), 0) + x)
    if kind == "space":
        points = Grid((33, 28, 40), 1 / 40).points()
        np.save(options["file"], np.exp(-sum((p - 0.4) ** 2 for p in points) / 0.02))
    if kind == "vector":
        points = Grid((64, 48), 1 / 64).points()
        np.save(options["file"], np.sin(6 * points) * np.cos(4 * points[::-1]))
    if kind == "image":
        from matplotlib.image import imsave

        options["file"] = str(tmp_path / "field.png")
        imsave(options["file"], rng.uniform(size=(48, 61, 3)))
    case = CompressCase(**options, tolerance=1e-2)
    report = run_case("compress", case, tmp_path / "run")
    assert all(metric.passed is not False for metric in report.metrics)
    series = read_series(tmp_path / "run/series.csv")
    assert len(series["tolerance"]) == 21
    np.testing.assert_allclose(series["tolerance"][[0, -1]], [1e-1, 1e-6])
    assert (series["error"] <= 10 * series["tolerance"]).all()
    assert (np.diff(series["coefficients"]) >= 0).all()
    assert series["moments"].max() < 1e-12
    packed = load(tmp_path / "run" / FILE)
    field, grid = case.given()
    assert packed.grid == grid
    error = np.abs(packed.expand() - field).max()
    assert error <= 0.1 * np.abs(field).max()
    assert error == pytest.approx(packed.error_bound)


def test_a_run_that_was_cut_goes_on_to_the_same_series(tmp_path):
    short, whole = CompressCase(nodes=64, until=1.0), CompressCase(nodes=64, until=2.0)
    run_case("compress", short, tmp_path / "cut")
    run_case("compress", whole, tmp_path / "cut", resume=True)
    run_case("compress", whole, tmp_path / "whole")
    for name in ("series.csv", FILE):
        assert (tmp_path / "cut" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_moments_are_those_that_the_lifting_keeps():
    grid = Grid((65, 70), 1 / 64)
    field = filaments(2 * grid.points() - 1)
    for wavelet, least in (("4.4", 1e-13), ("2.2", 1e-13)):
        packed = compress(field, grid, tolerance=1e-2, wavelet=wavelet)
        assert moment_error(packed.expand(), field, grid, packed) < least
    packed = compress(field, grid, tolerance=1e-2, wavelet="4.0")
    assert moment_error(packed.expand(), field, grid, packed) > 1e-6
    shifted = field + 1e-6 * np.abs(field)
    packed = compress(field, grid, tolerance=1e-2)
    assert moment_error(shifted, field, grid, packed) == pytest.approx(1e-6, rel=1e-3)


def test_families_without_moments_are_not_judged_by_them(tmp_path):
    report = run_case(
        "compress", CompressCase(nodes=64, until=0.5, wavelet="4.0"), tmp_path / "run"
    )
    told = json.loads((tmp_path / "run/summary.json").read_text())["metrics"]
    assert len(report.metrics) == len(told) == 4
    assert not any("moment" in metric["name"] for metric in told)


def test_the_filaments_are_smooth_and_of_many_sizes():
    grid = Grid((256, 256), 2 / 256, (-1.0, -1.0), "periodic")
    field = filaments(grid.points())
    assert field.max() == pytest.approx(1.0, abs=0.02)
    assert field.min() < -0.5
    edge = np.concatenate([field[0], field[-1], field[:, 0], field[:, -1]])
    assert np.abs(edge).max() < 5e-5
    lines = np.abs(np.fft.rfft(field, axis=1)).sum(axis=0)
    assert lines[20:40].max() > 0.02 * lines.max()
    assert lines[120:].max() < 5e-3 * lines.max()


def test_what_cannot_be_compressed_is_refused():
    with pytest.raises(InputError, match="tolerance must be between 0 and 1"):
        CompressCase(tolerance=2.0)
    with pytest.raises(InputError, match="wavelet must be one of"):
        CompressCase(wavelet="5.5")
    with pytest.raises(InputError, match="there is no file"):
        CompressCase(file="nothing.npy").build()
