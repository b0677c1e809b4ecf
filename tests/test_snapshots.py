from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from toy import Decay

from pmesh.run.loop import run
from pmesh.run.snapshots import (
    Snapshots,
    read_snapshots,
    snapshot_names,
    write_index,
    write_snapshot,
)
from pmesh.vortex.asked import AskedFields
from remesh.errors import InputError, StorageError
from remesh.grid import Grid
from remesh.halving import halved, halved_grid


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


class Unasked(Decay):
    """A flow whose velocity nobody may ask for."""

    def fields(self, state: Any) -> Any:
        """The velocity is not there to be computed."""

        def never() -> Any:
            raise AssertionError("the velocity was computed")

        return AskedFields({"vorticity": lambda: state.vorticity, "velocity": never})


def test_fields_that_are_not_written_are_not_computed(tmp_path: Path) -> None:
    flow = Unasked(grid=Grid((6, 5), 0.1))
    watch = [Snapshots(every=0.5, fields=["vorticity"])]
    run(flow, flow.start(), until=0.5, out=tmp_path / "one", watch=watch)
    assert len(read_snapshots(tmp_path / "one")) == 2
    with pytest.raises(AssertionError, match="was computed"):
        run(flow, flow.start(), until=0.5, out=tmp_path / "all", watch=[Snapshots(every=0.5)])
    none = [Snapshots(every=0.5, fields=["speed"])]
    with pytest.raises(InputError, match="velocity"):
        run(flow, flow.start(), until=0.5, out=tmp_path / "none", watch=none)


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


def both(out: Path, flow: Decay, until: float = 0.5, **options: Any) -> tuple[list[Any], list[Any]]:
    """Snapshots in full and reduced by 2, of one run."""
    watch = [Snapshots(every=0.25), Snapshots(every=0.125, reduce=2, dtype="float32")]
    run(flow, flow.start(), until=until, out=out, watch=watch, **options)
    return read_snapshots(out), read_snapshots(out, "fields-2")


@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
@pytest.mark.parametrize("shape", [(8, 12), (8, 10, 12)])
def test_reduced_snapshots_stand_beside_full_ones_at_the_places_of_every_second_node(
    tmp_path: Path, shape: tuple[int, ...], boundary: Any
) -> None:
    grid = Grid(shape, 0.1, (-1.0, 2.0, 0.5)[: len(shape)], boundary)
    full, small = both(tmp_path, Decay(grid=grid))
    assert [s.time for s in full] == [0.0, 0.25, 0.5]
    assert [s.time for s in small] == [0.0, 0.125, 0.25, 0.375, 0.5]
    assert (small[0].grid, small[0]["vorticity"].dtype) == (halved_grid(grid), "float32")
    assert small[2]["vorticity"] == pytest.approx(halved(full[1]["vorticity"], grid), abs=1e-6)
    if boundary == "unbounded":
        assert small[0]["velocity"] == pytest.approx(small[0].grid.points(), abs=1e-6)
    assert set(np.unique(small[0]["chi"])) <= {0, 1}
    with h5py.File(tmp_path / "fields-2.vtkhdf", "r") as file:
        root = file["VTKHDF"]
        assert list(root.attrs["Spacing"]) == [0.2] * 3
        assert list(root.attrs["Origin"])[: len(shape)] == list(grid.origin)
        np.testing.assert_array_equal(root["PointData/vorticity"][-1].T, small[-1]["vorticity"])


def test_reduced_nodes_stay_on_one_lattice_when_the_domain_grows_by_odd_numbers_of_nodes(
    tmp_path: Path,
) -> None:
    flow = Decay(grid=Grid((12, 10), 0.1), grows=3)
    full, small = both(tmp_path / "whole", flow)
    assert len({round(s.grid.origin[0] / 0.1) % 2 for s in full}) == 2
    assert {round(s.grid.origin[0] / 0.1) % 2 for s in small} == {0}
    for shot in small:
        assert shot["velocity"] == pytest.approx(shot.grid.points(), abs=1e-6)
    both(tmp_path / "cut", flow, until=0.25)
    again = both(tmp_path / "cut", flow, resume=True)[1]
    assert [s.time for s in again] == [s.time for s in small]
    for one, other in zip(again, small, strict=True):
        assert one.grid == other.grid
        np.testing.assert_array_equal(one["vorticity"], other["vorticity"])


def test_a_new_run_in_the_place_of_an_old_one_leaves_none_of_its_reduced_snapshots(
    tmp_path: Path,
) -> None:
    flow = Decay(grid=Grid((12, 10), 0.1))
    both(tmp_path, flow)
    (tmp_path / "fields-mine").mkdir()
    (tmp_path / "fields-mine/notes.txt").write_text("kept")
    run(flow, flow.start(), until=0.5, out=tmp_path, overwrite=True)
    assert sorted(p.name for p in tmp_path.glob("fields*")) == ["fields-mine"]


def test_a_run_with_reduced_snapshots_only_is_read_without_naming_them(tmp_path: Path) -> None:
    flow = Decay(grid=Grid((16, 20), 0.1))
    watch = [Snapshots(every=0.5, reduce=4)]
    run(flow, flow.start(), until=0.5, out=tmp_path, watch=watch)
    assert snapshot_names(tmp_path) == ["fields-4"]
    assert [s.grid.shape for s in read_snapshots(tmp_path)] == [(4, 5)] * 2


def test_what_cannot_be_reduced_and_names_used_twice_are_refused(tmp_path: Path) -> None:
    flow = Decay(grid=Grid((8, 9), 0.1, boundary="periodic"))
    with pytest.raises(InputError, match="every 2th node of axis 1 cannot be kept"):
        both(tmp_path / "odd", flow)
    assert not (tmp_path / "odd").exists()
    with pytest.raises(InputError, match="reduce must be one of 1, 2, 4, 8, 16, got 3"):
        Snapshots(every=0.1, reduce=3)
    with pytest.raises(InputError, match="below 'fields' or 'fields-word', got 'mine'"):
        Snapshots(every=0.1, name="mine")
    watch = [Snapshots(every=0.1), Snapshots(every=0.2, fields=["chi"])]
    with pytest.raises(InputError, match="two watchers write snapshots below 'fields'"):
        run(flow, flow.start(), until=0.5, out=tmp_path / "two", watch=watch)


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
