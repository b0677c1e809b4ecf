from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from toy import Decay

from pmesh.run.loop import run
from pmesh.run.snapshots import Snapshots, read_snapshots, write_index, write_snapshot
from remesh.errors import InputError, StorageError
from remesh.grid import Grid


def a_run(out: Path, grid: Grid, **options: Any) -> list[Any]:
    flow = Decay(grid=grid, **options)
    run(flow, flow.start(), until=0.5, out=out, watch=[Snapshots(every=0.25)])
    return read_snapshots(out)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("shape", [(7, 6), (5, 4, 6)])
def test_fields_come_back_bit_for_bit_in_our_axis_order(
    tmp_path: Path, shape: tuple[int, ...], dtype: str
) -> None:
    grid = Grid(shape, 0.1, boundary="periodic")
    flow = Decay(grid=grid, dtype=dtype)
    first, _, last = a_run(tmp_path, grid, dtype=dtype)
    assert (first.time, last.time) == (0.0, 0.5)
    assert first.grid == grid
    assert first["vorticity"].dtype == dtype
    np.testing.assert_array_equal(first["vorticity"], flow.start().vorticity)
    np.testing.assert_array_equal(first["velocity"], grid.points().astype(dtype))
    np.testing.assert_array_equal(first["chi"].astype(bool), grid.points()[0] > 0)


@pytest.mark.parametrize("shape", [(7, 6), (5, 4, 6)])
def test_each_snapshot_is_a_vtkhdf_image_with_x_fastest(
    tmp_path: Path, shape: tuple[int, ...]
) -> None:
    grid = Grid(shape, 0.5, origin=(-1.0, 2.0, 3.0)[: len(shape)])
    field = grid.points()[0] + 10 * grid.points()[1]
    write_snapshot(tmp_path / "s.vtkhdf", grid, {"w": field, "u": grid.points()}, 3, 0.25)
    with h5py.File(tmp_path / "s.vtkhdf", "r") as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"ImageData"
        assert list(root.attrs["Version"]) == [2, 0]
        ends = [n - 1 for n in shape] + [0] * (3 - len(shape))
        assert list(root.attrs["WholeExtent"]) == [0, ends[0], 0, ends[1], 0, ends[2]]
        assert list(root.attrs["Spacing"]) == [0.5, 0.5, 0.5]
        assert list(root.attrs["Origin"])[: len(shape)] == list(grid.origin)
        assert list(root.attrs["Direction"]) == list(np.eye(3).ravel())
        assert root["PointData/w"].shape == shape[::-1]
        assert root["PointData/u"].shape == (*shape[::-1], 3)
        along_x = root["PointData/w"][()].ravel()[: shape[0]]
        np.testing.assert_array_equal(np.diff(along_x), 0.5)


def test_the_index_holds_all_times_in_one_box_though_the_domain_grows(tmp_path: Path) -> None:
    snapshots = a_run(tmp_path, Grid((6, 5), 0.1), grows=2)
    last = snapshots[-1].grid
    assert last.shape[0] > 6
    with h5py.File(tmp_path / "fields.vtkhdf", "r") as file:
        root = file["VTKHDF"]
        assert list(root["Steps/Values"]) == [0.0, 0.25, 0.5]
        assert root["Steps"].attrs["NSteps"] == 3
        assert list(root["Steps/PointDataOffsets/vorticity"]) == [0, 1, 2]
        assert list(root.attrs["WholeExtent"]) == [0, last.shape[0] - 1, 0, 4, 0, 0]
        np.testing.assert_allclose(root.attrs["Origin"][:2], last.origin, atol=1e-14)
        data = root["PointData/vorticity"][()]
    assert data.shape == (3, 5, last.shape[0])
    outside = last.shape[0] - 6
    assert np.isnan(data[0, :, :outside]).all()
    np.testing.assert_array_equal(data[0, :, outside:].T, snapshots[0]["vorticity"])
    np.testing.assert_array_equal(data[2].T, snapshots[2]["vorticity"])


def test_a_run_directory_can_be_moved(tmp_path: Path) -> None:
    a_run(tmp_path / "here", Grid((6, 5), 0.1))
    (tmp_path / "here").rename(tmp_path / "there")
    with h5py.File(tmp_path / "there/fields.vtkhdf", "r") as file:
        assert np.isfinite(file["VTKHDF/PointData/vorticity"][()]).all()


def test_fields_can_be_chosen_and_stored_in_single_precision(tmp_path: Path) -> None:
    flow = Decay(grid=Grid((6, 5), 0.1))
    watch = [Snapshots(every=0.5, fields=["vorticity"], dtype="float32")]
    run(flow, flow.start(), until=0.5, out=tmp_path, watch=watch)
    snapshot = read_snapshots(tmp_path)[0]
    assert list(snapshot.names) == ["vorticity"]
    assert snapshot["vorticity"].dtype == "float32"


def test_snapshots_later_than_the_checkpoint_and_half_written_ones_are_forgotten(
    tmp_path: Path,
) -> None:
    grid = Grid((6, 5), 0.1)
    flow = Decay(grid=grid)
    a_run(tmp_path, grid)
    fields = tmp_path / "fields"
    write_snapshot(fields / "00000999.vtkhdf", grid, flow.fields(flow.start()), 999, 9.0)
    (fields / ".00001000.vtkhdf.part").write_bytes(b"half")
    run(flow, flow.start(), until=0.5, out=tmp_path, resume=True, watch=[Snapshots(every=0.25)])
    assert [s.time for s in read_snapshots(tmp_path)] == [0.0, 0.25, 0.5]
    assert not list(fields.glob(".*"))


def test_a_lattice_that_shifts_by_part_of_a_cell_is_refused(tmp_path: Path) -> None:
    (tmp_path / "fields").mkdir()
    shots = [
        write_snapshot(
            tmp_path / f"fields/{k}.vtkhdf", grid, {"w": np.zeros(grid.shape)}, k, 0.1 * k
        )
        for k, grid in enumerate([Grid((4, 4), 0.1), Grid((4, 4), 0.1, origin=(0.05, 0.0))])
    ]
    with pytest.raises(InputError, match="share one lattice"):
        write_index(tmp_path, shots)


def test_bad_requests_are_refused(tmp_path: Path) -> None:
    flow = Decay(grid=Grid((6, 5), 0.1))
    for every in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="every must be a positive time"):
            Snapshots(every=every)
    with pytest.raises(InputError, match="need a run directory"):
        run(flow, flow.start(), until=0.5, watch=[Snapshots(every=0.25)])
    with pytest.raises(InputError, match="got \\['pressure'\\]"):
        run(
            flow,
            flow.start(),
            until=0.5,
            out=tmp_path / "a",
            watch=[Snapshots(every=0.25, fields=["pressure"])],
        )
    with pytest.raises(InputError, match="must have the grid's shape"):
        write_snapshot(tmp_path / "s.vtkhdf", flow.grid, {"w": np.zeros((5, 6))}, 0, 0.0)
    (tmp_path / "fields").mkdir()
    (tmp_path / "fields/00000001.vtkhdf").write_bytes(b"cut")
    with pytest.raises(StorageError, match="missing, cut short or damaged"):
        read_snapshots(tmp_path)
