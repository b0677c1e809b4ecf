"""Velocity from vorticity: one solver per mesh, with its buffers, plans and multipliers kept."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from pmesh.spectral.checks import check_field, check_freestream, check_mean, output
from pmesh.spectral.convolve import Convolver, Field, Multiplier, Rows, Term
from pmesh.spectral.smoothing import Smoothing, make_smoothing, refuse_too_wide
from pmesh.spectral.solenoidal import projection
from pmesh.spectral.symbols import Box, Derivative, Greens, multipliers
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.threads import thread_count

Outputs = list[list[Term]]


class VelocitySolver:
    """Velocity, stream function and diffusion of a vorticity field on one grid, again and again.

    ``kernel``: "HEJ" (order 2 to 10, 8 by default; ``radius`` is its smoothing radius in spacings),
    "LGF" or "HE" (order 2); HEJ and HE are spectral in a fully periodic box. Vorticity:
    ``grid.shape`` in 2-D, ``(3, *grid.shape)`` in 3-D [1/T]. Velocity: ``(ndim, *grid.shape)``
    [L/T]. Results are new arrays unless ``out`` is given, bit for bit the same for any number of
    threads. Refuses wrong shapes, values that are not finite, and a mean in a fully periodic box.
    Cost: one transform per source and per output, on axes doubled where unbounded.
    """

    def __init__(
        self,
        grid: Grid,
        *,
        kernel: str = "HEJ",
        order: int | None = None,
        radius: float = 2.0,
        dtype: DTypeLike = np.float64,
        threads: int | None = None,
        backend: str | None = None,
    ) -> None:
        self.grid = grid
        self.greens = Greens(kernel=kernel, order=order, radius=radius)
        self.dtype = np.dtype(dtype)
        if self.dtype not in (np.dtype(np.float32), np.dtype(np.float64)):
            raise InputError(f"dtype must be float32 or float64, got {dtype}", hint="np.float64")
        self.box = Box.around(grid)
        self._convolver = Convolver(
            self.box, dtype=self.dtype, threads=thread_count(threads), backend=backend
        )
        self._smoothings: dict[Smoothing, Multiplier] = {}

    def velocity(
        self,
        vorticity: Field,
        *,
        out: Field | None = None,
        freestream: Sequence[float] | None = None,
        smoothing: Smoothing | None = None,
    ) -> Field:
        """Velocity curl(psi), laplace(psi) = -vorticity, plus the free stream [L/T].

        ``out`` may be the vorticity, of which all is read before anything is written.
        ``smoothing``: ``("heat", a)`` or ``("phi1", a)``, a [L^2], acts on the vorticity first.
        """
        sources = self._sources(vorticity)
        out = output(out, (self.grid.ndim, *self.grid.shape), self.dtype)
        self._run(sources, self._velocity_terms(), list(out), smoothing, freestream)
        return out

    def gradient(self, vorticity: Field, *, smoothing: Smoothing | None = None) -> Field:
        """Velocity gradient ``[i, j] = d u_i / d x_j``, shape ``(ndim, ndim, *shape)`` [1/T]."""
        result, targets = self._gradient_output()
        self._run(self._sources(vorticity), self._gradient_terms(), targets, smoothing)
        _close_trace(result)
        return result

    def velocity_and_gradient(
        self, vorticity: Field, *, freestream: Sequence[float] | None = None
    ) -> tuple[Field, Field]:
        """Velocity and its gradient, from one forward transform."""
        speed = output(None, (self.grid.ndim, *self.grid.shape), self.dtype)
        result, targets = self._gradient_output()
        terms = [*self._velocity_terms(), *self._gradient_terms()]
        self._run(self._sources(vorticity), terms, [*speed, *targets], None, freestream)
        _close_trace(result)
        return speed, result

    def stream(self, vorticity: Field, *, out: Field | None = None) -> Field:
        """Stream function psi, laplace(psi) = -vorticity, of the shape of the vorticity [L^2/T]."""
        sources = self._sources(vorticity)
        out = output(out, np.shape(vorticity), self.dtype)
        (table,) = self._tables([(0,) * self.grid.ndim])
        terms = [[Term(s, table)] for s in range(len(sources))]
        self._run(sources, terms, self._components(out), None)
        return out

    def potential_flow(self, source: Field) -> Field:
        """Velocity grad(phi), laplace(phi) = source [1/T], of a flow that swells [L/T]."""
        source = check_field(source, self.grid.shape, self.dtype, "source")
        out = output(None, (self.grid.ndim, *self.grid.shape), self.dtype)
        firsts = [_derivative(self.grid.ndim, axis) for axis in range(self.grid.ndim)]
        tables = self._tables(firsts)
        terms = [[_term(0, table, name, -1)] for table, name in zip(tables, firsts, strict=True)]
        self._run([source], terms, list(out), None)
        return out

    def solenoidal(self, vorticity: Field, *, out: Field | None = None) -> Field:
        """The divergence-free part of a vorticity in space; ``out`` may be the vorticity.

        w - D (D . w) / (D . D), D the central difference of order 6: what it tells of the
        divergence is round-off, at all nodes whose stencils lie inside the mesh. Of all such fields
        the nearest to w in a periodic box, where it keeps the sum; on unbounded axes w is zero
        beyond the mesh, and what reaches beyond it is cut. What no difference sees, the mean and
        waves from node to node, stays. One transform per component in and out, no array kept.
        Refuses the plane, where no vorticity has a divergence.
        """
        if self.grid.ndim != 3:
            raise InputError(
                "in the plane vorticity is a scalar: it has no divergence to take away",
                hint="a grid of three axes",
            )
        sources = self._sources(vorticity)
        out = output(out, (3, *self.grid.shape), self.dtype)
        self._run(sources, projection(self.box, self.dtype), list(out), None, solves=False)
        return out

    def poisson(self, rhs: Field, *, out: Field | None = None) -> Field:
        """Solution psi of laplace(psi) = rhs; ``rhs``: ``grid.shape``, or several in front."""
        shape, ndim = self.grid.shape, self.grid.ndim
        stacked = np.shape(rhs)[:-ndim]
        source = check_field(rhs, (*stacked, *shape), self.dtype, "rhs")
        out = output(out, source.shape, self.dtype)
        (table,) = self._tables([(0,) * ndim])
        pairs = zip(source.reshape(-1, *shape), out.reshape(-1, *shape), strict=True)
        for one, result in pairs:
            self._run([one], [[Term(0, table, turn=2)]], [result], None)
        return out

    def smoothed(
        self, vorticity: Field, amount: float, kind: str = "heat", *, out: Field | None = None
    ) -> Field:
        """Vorticity after ``amount`` [L^2] of heat flow, or its mean over that time ("phi1").

        Exact in time; in space exact on periodic axes, of order 8 on unbounded ones. Beyond an
        unbounded axis the field is zero, and what spreads there is cut. Conserves the sum and the
        first moments of what stays inside. No step limit but one: the spread sqrt(2 amount) must
        lie well below half of every unbounded axis. Refuses more than 1 / 5.26 of the axis, where
        1e-6 of a source at one edge would come around to the other.
        """
        sources = self._sources(vorticity)
        out = output(out, np.shape(vorticity), self.dtype)
        terms = [[Term(s)] for s in range(len(sources))]
        self._run(sources, terms, self._components(out), (kind, amount), solves=False)
        return out

    def diffuse(self, vorticity: Field, amount: float, *, out: Field | None = None) -> Field:
        """Heat flow exp(amount * laplace), amount = viscosity * dt [L^2]; see ``smoothed``."""
        return self.smoothed(vorticity, amount, "heat", out=out)

    def diffuse_and_velocity(
        self,
        vorticity: Field,
        amount: float,
        *,
        out: tuple[Field, Field] | None = None,
        freestream: Sequence[float] | None = None,
        rows: Rows = None,
    ) -> tuple[Field, Field]:
        """Diffused vorticity and its velocity, from one forward transform.

        ``rows``: of the first axis on which the velocity is wanted, ``(first, end)``; others mean
        nothing and may be zero.
        """
        sources = self._sources(vorticity)
        field = output(out[0] if out else None, np.shape(vorticity), self.dtype)
        shape = (self.grid.ndim, *self.grid.shape)
        given = np.zeros(shape, self.dtype) if rows is not None and out is None else None
        speed = output(out[1] if out else given, shape, self.dtype)
        wanted = [rows] * self.grid.ndim + [None] * len(sources)
        terms = [*self._velocity_terms(), *([Term(s)] for s in range(len(sources)))]
        targets = [*speed, *self._components(field)]
        self._run(sources, terms, targets, ("heat", amount), freestream, rows=wanted)
        return field, speed

    def lent(self, shape: tuple[int, ...]) -> AbstractContextManager[Field]:
        """An array of this shape to work in while nothing is solved: memory that lies idle."""
        return self._convolver.lent(shape)

    def _sources(self, vorticity: Field) -> list[Field]:
        shape = self.grid.shape if self.grid.ndim == 2 else (3, *self.grid.shape)
        return self._components(check_field(vorticity, shape, self.dtype, "vorticity"))

    def _components(self, field: Field) -> list[Field]:
        return [field] if field.ndim == self.grid.ndim else list(field)

    def _gradient_output(self) -> tuple[Field, list[Field]]:
        """The gradient and its entries but the last, which the others give: the trace is zero."""
        ndim = self.grid.ndim
        result = output(None, (ndim, ndim, *self.grid.shape), self.dtype)
        return result, list(result.reshape(ndim * ndim, *self.grid.shape))[:-1]

    def _tables(self, derivatives: list[Derivative]) -> list[NDArray[Any]]:
        return multipliers(self.box, self.greens, derivatives, self.dtype)

    def _velocity_terms(self) -> Outputs:
        """u = curl(G * w): d_j G * w_k - d_k G * w_j for (i, j, k) cyclic."""
        ndim = self.grid.ndim
        firsts = [_derivative(ndim, axis) for axis in range(ndim)]
        tables = self._tables(firsts)
        if ndim == 2:
            return [[_term(0, tables[1], firsts[1], 1)], [_term(0, tables[0], firsts[0], -1)]]
        return [
            [_term(k, tables[j], firsts[j], 1), _term(j, tables[k], firsts[k], -1)]
            for j, k in _CYCLES
        ]

    def _gradient_terms(self) -> Outputs:
        ndim = self.grid.ndim
        pairs = {_derivative(ndim, i, j) for i in range(ndim) for j in range(ndim)}
        names = sorted(pairs)
        tables = dict(zip(names, self._tables(names), strict=True))

        def second(source: int, i: int, j: int, sign: int) -> Term:
            name = _derivative(ndim, i, j)
            return _term(source, tables[name], name, sign)

        if ndim == 2:
            return [[second(0, 1, 0, 1)], [second(0, 1, 1, 1)], [second(0, 0, 0, -1)]]
        return [
            [second(k, j, axis, 1), second(j, k, axis, -1)]
            for i, (j, k) in enumerate(_CYCLES)
            for axis in range(3)
            if i + axis < 4
        ]

    def _run(
        self,
        sources: list[Field],
        outputs: Outputs,
        out: list[Field],
        smoothing: Smoothing | None,
        freestream: Sequence[float] | None = None,
        solves: bool = True,
        rows: Sequence[Rows] | None = None,
    ) -> None:
        shifts = check_freestream(freestream, self.grid.ndim)
        shifts += [0.0] * (len(outputs) - len(shifts))
        multiplier = None if smoothing is None else self._smoothing(smoothing)
        if smoothing is not None:
            refuse_too_wide(self.box, smoothing[1], sources)
        periodic = solves and all(self.grid.periodic)
        self._convolver.run(
            sources,
            outputs,
            out,
            smoothing=multiplier,
            shifts=shifts,
            rows=rows,
            check=lambda means: check_mean(means, sources, periodic=periodic),
        )

    def _smoothing(self, smoothing: Smoothing) -> Multiplier:
        """The last few smoothings are kept: a step asks for the same one again and again."""
        key = (str(smoothing[0]), float(smoothing[1]))
        if key not in self._smoothings:
            made = make_smoothing(self.box, key, self.dtype)
            while len(self._smoothings) >= 4:
                self._smoothings.pop(next(iter(self._smoothings)), None)
            self._smoothings[key] = made
        return self._smoothings[key]


_CYCLES = ((1, 2), (2, 0), (0, 1))


def _close_trace(gradient: Field) -> None:
    ndim = len(gradient)
    gradient[-1, -1] = -sum(gradient[i, i] for i in range(ndim - 1))


def _derivative(ndim: int, *axes: int) -> Derivative:
    return tuple(axes.count(axis) for axis in range(ndim))


def _term(source: int, table: NDArray[Any], derivative: Derivative, sign: int) -> Term:
    parity = tuple(count % 2 for count in derivative)
    return Term(source, table, parity, (sum(parity) + (2 if sign < 0 else 0)) % 4)
