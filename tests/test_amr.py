"""Snapshots of adaptive meshes: what VTK reads in them, and that they come back bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from pmesh.run.amr import AdaptiveSnapshot, write_blocks
from pmesh.run.loop import run
from pmesh.run.snapshots import (
    Snapshots,
    read_snapshot,
    read_snapshots,
    write_index,
    write_snapshot,
)
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.limit import Limit
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.sampling import sampled
from remesh.multires.uniform import to_uniform
from remesh.multires.wavelets import WAVELETS, Wavelet

PLANE = AdaptiveMesh(
    grid=Grid((128, 64), 1 / 64, (-0.5, 0.25)), levels=2, block=8, tolerance=2e-3, wavelet="4.2"
)
SPACE = AdaptiveMesh(
    grid=Grid((64, 32, 32), 1 / 32, (0.0, 1.0, 2.0), "periodic"), levels=2, block=8,
    refinement=0.02, most_blocks=500,
)  # fmt: skip


@dataclass(frozen=True)
class OnBlocks:
    time: float
    step: int
    blocks: Blocks
    vorticity: np.ndarray[Any, Any]

    @property
    def grid(self) -> Grid:
        return self.blocks.mesh.grid

    @property
    def size(self) -> int:
        return self.blocks.active


@dataclass(frozen=True, kw_only=True)
class Travelling:
    """A bump that moves along x, its mesh with it."""

    mesh: AdaptiveMesh
    dtype: str = "float64"

    def at(self, time: float, step: int) -> OnBlocks:
        blocks, values = sampled(lambda x: bump(x, self.mesh, time), self.mesh)
        return OnBlocks(time, step, blocks, values.astype(self.dtype))

    def start(self) -> OnBlocks:
        return self.at(0.0, 0)

    def step(self, state: OnBlocks, dt: float) -> OnBlocks:
        return replace(self.at(state.time + dt, state.step + 1))

    def limit(self, state: OnBlocks) -> Limit:
        return Limit(0.15, "largest")

    def forces(self, state: OnBlocks) -> Mapping[str, float]:
        return {}

    def ledger(self, state: OnBlocks) -> Mapping[str, float]:
        return {"active": state.blocks.active}

    def fields(self, state: OnBlocks) -> Mapping[str, Any]:
        ndim = state.blocks.mesh.ndim
        velocity = np.stack([(k + 1) * state.vorticity for k in range(ndim)])
        return {"vorticity": state.vorticity, "velocity": velocity}


def bump(points: Any, mesh: AdaptiveMesh, time: float) -> Any:
    middle = [a + 0.5 * b for a, b in zip(mesh.grid.origin, mesh.grid.length, strict=True)]
    middle[0] += 0.5 * time - 0.25
    square = sum((x - c) ** 2 for x, c in zip(points, middle, strict=True))
    return np.exp(-square / (0.08 if mesh.ndim == 2 else 0.12) ** 2)


def a_run(out: Path, flow: Travelling) -> list[Any]:
    run(flow, flow.start(), until=0.6, out=out, watch=[Snapshots(every=0.3)])
    return read_snapshots(out)


def vtk_boxes(path: Path, time: float | None = None) -> list[tuple[int, Any]]:
    """Level and image of each box as VTK reads them."""
    import vtk

    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    if time is None:
        reader.Update()
    else:
        info, key = (
            reader.GetOutputInformation(0),
            vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS(),
        )
        assert [info.Get(key, k) for k in range(info.Length(key))] == pytest.approx([0.0, 0.3, 0.6])
        reader.UpdateTimeStep(time)
    found = reader.GetOutput()
    assert found.GetClassName() == "vtkOverlappingAMR"
    return [
        (level, found.GetDataSetAsImageData(level, box))
        for level in range(found.GetNumberOfLevels())
        for box in range(found.GetNumberOfBlocks(level))
    ]


def corners_of(cells: Any, points: tuple[int, ...]) -> Any:
    """Which points are corners of these cells; x runs fastest in both."""
    shape = points[::-1]
    part = cells.reshape([n - 1 for n in shape])
    result = np.zeros(shape, bool)
    for k in np.ndindex(2, 2, 2):
        result[tuple(slice(a, a + n - 1) for a, n in zip(k, shape, strict=True))] |= part
    return result.ravel()


def wrapped(points: Any, grid: Grid) -> Any:
    """Points in the box; the end of a periodic axis is its beginning."""
    low, length = np.array(grid.origin)[:, None], np.array(grid.length)[:, None]
    return low + (points - low) % length if all(grid.periodic) else points


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("mesh", [PLANE, SPACE], ids=["plane", "space"])
def test_blocks_and_their_fields_come_back_bit_for_bit(tmp_path, mesh, dtype):
    flow = Travelling(mesh=mesh, dtype=dtype)
    state = flow.start()
    fields = flow.fields(state)
    (tmp_path / "fields").mkdir()
    write_blocks(tmp_path / "fields/00000003.vtkhdf", state.blocks, fields, 3, 0.25)
    (shot,) = read_snapshots(tmp_path)
    assert isinstance(shot, AdaptiveSnapshot)
    assert (shot.step, shot.time) == (3, 0.25)
    assert shot.blocks.mesh == mesh
    assert shot.blocks.starts == state.blocks.starts
    assert np.array_equal(shot.blocks.places, state.blocks.places)
    assert set(shot.names) == {"vorticity", "velocity"}
    for name, field in fields.items():
        assert shot.on_blocks(name).dtype == dtype
        assert np.array_equal(shot.on_blocks(name), field)
        assert np.array_equal(shot[name], to_uniform(field, state.blocks, outside="last"))
    assert shot.grid == mesh.grid


@pytest.mark.parametrize("mesh", [PLANE, SPACE], ids=["plane", "space"])
def test_a_free_stream_is_shown_as_it_is_up_to_unbounded_ends_which_finer_blocks_touch(
    tmp_path, mesh
):
    blocks = Blocks.uniform(mesh).joined(2, np.zeros((1, mesh.ndim), np.int64))
    one = np.ones((mesh.ndim, *blocks.shape))
    shot = write_blocks(tmp_path / "one.vtkhdf", blocks, {"velocity": one}, 0, 0.0)
    assert abs(shot["velocity"] - 1).max() < 1e-12


@pytest.mark.parametrize(
    "wavelet",
    [
        Wavelet("mine", 4, 0, WAVELETS["4.4"].predict, (), "without a lifting"),
        Wavelet("4.4", 4, 2, WAVELETS["4.4"].predict, WAVELETS["2.2"].update, "another 4.4"),
    ],
    ids=["own name", "known name"],
)
def test_a_mesh_with_a_wavelet_of_ones_own_comes_back(tmp_path, wavelet):
    mesh = replace(PLANE, wavelet=wavelet)
    shots = a_run(tmp_path, Travelling(mesh=mesh))
    assert [shot.blocks.mesh for shot in shots] == [mesh] * 3
    known = replace(PLANE, wavelet=WAVELETS["4.4"])
    shot = write_blocks(tmp_path / "known.vtkhdf", Blocks.uniform(known), {}, 0, 0.0)
    assert read_snapshot(shot.path).blocks.mesh.wavelet is WAVELETS["4.4"]


@pytest.mark.parametrize("mesh", [PLANE, SPACE], ids=["plane", "space"])
def test_vtk_reads_values_at_their_places_and_times_and_blanks_what_is_refined(tmp_path, mesh):
    shots = a_run(tmp_path, Travelling(mesh=mesh))
    assert len({shot.blocks.starts for shot in shots}) > 1 or mesh.ndim == 2
    from vtk.util.numpy_support import vtk_to_numpy

    for shot in shots:
        boxes, seen, volume = vtk_boxes(tmp_path / "fields.vtkhdf", shot.time), 0, 0.0
        assert len(boxes) == shot.blocks.size
        assert max(level for level, _ in boxes) == shot.blocks.finest
        for level, image in boxes:
            spacing = mesh.spacing(level)
            assert image.GetSpacing()[: mesh.ndim] == pytest.approx((spacing,) * mesh.ndim)
            points = np.array([image.GetPoint(k) for k in range(image.GetNumberOfPoints())]).T
            data = image.GetPointData()
            found = vtk_to_numpy(data.GetArray("vorticity"))
            visible = vtk_to_numpy(image.GetCellData().GetArray("vtkGhostType")) == 0
            near = corners_of(visible, image.GetDimensions())
            given = bump(wrapped(points[: mesh.ndim], mesh.grid), mesh, shot.time)
            np.testing.assert_allclose(found[near], given[near], atol=5 * mesh.tolerance)
            velocity = vtk_to_numpy(data.GetArray("velocity"))
            np.testing.assert_allclose(velocity[:, 1], 2 * found, rtol=1e-12, atol=1e-15)
            assert velocity.shape[1] == 3
            shown = int(visible.sum())
            seen, volume = seen + shown, volume + shown * spacing**mesh.ndim
        layers = 2 if mesh.ndim == 2 else 1
        assert seen == layers * shot.blocks.active
        assert volume == pytest.approx(layers * mesh.grid.size * mesh.grid.cell_volume)


def test_a_single_snapshot_opens_too(tmp_path):
    shots = a_run(tmp_path, Travelling(mesh=PLANE))
    assert len(vtk_boxes(shots[-1].path)) == shots[-1].blocks.size


def test_a_field_goes_on_as_it_is_beyond_an_unbounded_end(tmp_path):
    blocks = Blocks.uniform(PLANE, 1)
    write_blocks(tmp_path / "one.vtkhdf", blocks, {"one": np.ones(blocks.shape)}, 0, 0.0)
    with h5py.File(tmp_path / "one.vtkhdf", "r") as file:
        for level in (0, 1):
            assert (file[f"VTKHDF/Level{level}/PointData/one"][()] == 1).all()


def contents(path):
    """All datasets of a file; its bytes also hold when virtual ones were made."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, part: found.update({name: part[()]} if hasattr(part, "dtype") else {})
        )
    return found


def test_a_resumed_run_leaves_the_same_snapshots(tmp_path):
    flow = Travelling(mesh=PLANE)
    whole = a_run(tmp_path / "whole", flow)
    run(flow, flow.start(), until=0.3, out=tmp_path / "cut", watch=[Snapshots(every=0.3)])
    late = flow.at(0.9, 99)
    write_blocks(tmp_path / "cut/fields/00000099.vtkhdf", late.blocks, flow.fields(late), 99, 0.9)
    run(flow, flow.start(), until=0.6, out=tmp_path / "cut", resume=True,
        watch=[Snapshots(every=0.3)])  # fmt: skip
    assert [s.step for s in read_snapshots(tmp_path / "cut")] == [s.step for s in whole]
    for shot in whole:
        other = tmp_path / "cut/fields" / shot.path.name
        assert other.read_bytes() == shot.path.read_bytes()
    one, other = (contents(tmp_path / part / "fields.vtkhdf") for part in ("cut", "whole"))
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name])


def test_large_meshes_are_told_on_a_coarser_level(tmp_path):
    mesh = AdaptiveMesh(grid=Grid((4096, 4096), 1.0), levels=5, block=16)
    blocks = Blocks.uniform(mesh, 0)
    shot = write_blocks(tmp_path / "s.vtkhdf", blocks, {"w": np.ones(blocks.shape)}, 0, 0.0)
    assert shot.grid == mesh.level_grid(4)
    assert shot["w"].shape == shot.grid.shape


def test_wrong_shapes_names_and_mixed_runs_are_refused(tmp_path):
    blocks = Blocks.uniform(PLANE, 1)
    with pytest.raises(InputError, match="must have the blocks' shape"):
        write_blocks(tmp_path / "s.vtkhdf", blocks, {"w": np.ones(PLANE.grid.shape)}, 0, 0.0)
    values = {"w": np.ones(blocks.shape)}
    one = write_blocks(tmp_path / "s.vtkhdf", blocks, values, 0, 0.0)
    with pytest.raises(InputError, match="got 'u'"):
        one.on_blocks("u")
    other = replace(PLANE, grid=Grid((64, 64), 1 / 64))
    two = Blocks.uniform(other, 1)
    shots = [one, write_blocks(tmp_path / "t.vtkhdf", two, {"w": np.ones(two.shape)}, 1, 0.1)]
    with pytest.raises(InputError, match="share one adaptive mesh"):
        write_index(tmp_path, shots)
    grid = PLANE.grid
    shots[1] = write_snapshot(tmp_path / "u.vtkhdf", grid, {"w": np.ones(grid.shape)}, 1, 0.1)
    with pytest.raises(InputError, match="others on a grid"):
        write_index(tmp_path, shots)
