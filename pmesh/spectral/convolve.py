"""Convolutions on a box: lines along the last axis, then one small transform per wavenumber of it.

Zeros are never transformed: of a doubled axis only the lines that hold data go in, and only the
lines that are kept come out. Neither the blocks of work nor the results depend on the threads.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import DTypeLike, NDArray

from pmesh.spectral.fft import Transform, aligned, check_backend, plan
from pmesh.spectral.sweeps import crop, pad, scale, to_modes, to_rows, transpose
from pmesh.spectral.symbols import Box
from remesh.threads import share

Field = NDArray[Any]
Rows = tuple[int, int] | None
_LINES = 32  # lines transformed at once: they fit the cache
_BLOCK = 32_768  # modes of the planes transformed at once in 3-D
_SMALL = 150_000  # padded modes below which threads cost more than they give


class Multiplier(Protocol):
    """An even real multiplier, made block by block: rows of wavenumbers of the last axis."""

    def block(self, low: int, high: int) -> NDArray[Any]:
        """Its values for the wavenumbers ``low:high`` of the last axis, axes reversed."""


class Table(Protocol):
    """Real values per wavenumber, axes reversed: an array, or made for each part asked for."""

    def __getitem__(self, part: slice, /) -> NDArray[Any]:
        """Those for some wavenumbers of the last axis."""


@dataclass(frozen=True)
class Term:
    """One summand of an output: i^turn times a real table times the transform of a source.

    ``parity`` tells per axis whether the table is odd; ``table=None`` stands for one.
    """

    source: int
    table: Table | None = None
    parity: tuple[int, ...] = ()
    turn: int = 0


class _Worker:
    """Scratch and plans of one thread."""

    def __init__(self, owner: Convolver, sources: int) -> None:
        box, dtype, backend = owner.box, owner.dtype, owner.backend
        spectral = np.result_type(dtype, np.complex64)
        n0, p0, last = box.shape[0], box.padded[0], box.padded[-1]
        rows, middle = owner.row_block
        self.line = aligned((rows, middle, last), dtype)
        self.line_hat = aligned((rows, middle, last // 2 + 1), spectral)
        self.to_hat = plan(self.line, self.line_hat, backend=backend)
        self.from_hat = plan(self.line_hat, self.line, inverse=True, backend=backend)
        self.spectra: list[Field] = []
        self.forward: list[Transform] = []
        for _ in range(sources + 1):
            spectrum = aligned((owner.mode_block, owner.padded_middle, p0), spectral)
            self.spectra.append(spectrum)
            self.forward.append(plan(spectrum, spectrum, backend=backend))
        self.result = self.spectra[-1]
        self.backward = plan(self.result, self.result, inverse=True, backend=backend)
        if owner.padded_middle > 1:
            self.plane = aligned((owner.mode_block, n0, owner.padded_middle), spectral)
            self.plane_forward = plan(self.plane, self.plane, backend=backend)
            self.plane_backward = plan(self.plane, self.plane, inverse=True, backend=backend)


class Convolver:
    """Applies sums of multipliers to fields on one box; keeps its buffers and plans between calls.

    ``run`` transforms each source once and each output once. Memory: one half-complex array, padded
    along the last axis only, per source or output (the more of them), plus a few lines per thread.
    """

    def __init__(
        self, box: Box, *, dtype: DTypeLike, threads: int, backend: str | None = None
    ) -> None:
        self.box = box
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        self.backend = check_backend(backend)
        shape, padded = box.shape, box.padded
        self.middle = shape[1] if len(shape) == 3 else 1
        self.padded_middle = padded[1] if len(shape) == 3 else 1
        self.modes = padded[-1] // 2 + 1
        if len(shape) == 3:
            self.row_block = (min(8, shape[0]), min(16, shape[1]))
            most = max(1, _BLOCK // (padded[0] * padded[1]))
        else:
            self.row_block = (min(_LINES, shape[0]), 1)
            most = _LINES
        self.mode_block = math.ceil(self.modes / math.ceil(self.modes / most))
        self.scale = 1.0 / math.prod(padded)
        self.threads = 1 if math.prod(padded[:-1]) * self.modes < _SMALL else threads
        self._storage: Field = np.empty((0, 0))  # of each field, one after another
        self._workers: list[_Worker] = []
        self._lock = threading.Lock()

    def run(
        self,
        sources: Sequence[Field],
        outputs: Sequence[Sequence[Term]],
        out: Sequence[Field],
        *,
        smoothing: Multiplier | None = None,
        shifts: Sequence[float] | None = None,
        check: Callable[[list[float]], None] | None = None,
        rows: Sequence[Rows] | None = None,
    ) -> None:
        """Write every output into ``out`` (plus its shift); ``out`` may be the sources.

        ``rows``: of the first axis that an output is wanted on, ``(first, end)``, None for all;
        others are left as they are. ``smoothing`` multiplies every source first. ``check`` sees
        the means of the sources, which are not finite where a source is not, and may raise before
        anything is written.
        """
        with self._lock:
            self._provide(len(sources), max(len(sources), len(outputs)))
            for s, field in enumerate(sources):
                self._rows_in(field, self._storage[s])
            if check is not None:
                check([self._mean(stored) for stored in self._storage[: len(sources)]])
            self._modes(len(sources), outputs, smoothing)
            for o, field in enumerate(out):
                wanted = rows[o] if rows else None
                self._rows_out(self._storage[o], field, shifts[o] if shifts else 0.0, wanted)

    @contextmanager
    def lent(self, shape: tuple[int, ...]) -> Iterator[Field]:
        """An array of this shape to work in, with any values: between runs the storage is idle.

        ``run`` waits until it is given back: the same thread must not call it before.
        """
        with self._lock:
            room = self._storage.reshape(-1).view(self.dtype)
            size = math.prod(shape)
            yield (room[:size] if room.size >= size else np.empty(size, self.dtype)).reshape(shape)

    def _mean(self, stored: Field) -> float:
        total = float(np.sum(stored[0].real, dtype=np.float64))
        return total / math.prod(self.box.shape)

    def _provide(self, sources: int, fields: int) -> None:
        if len(self._storage) < fields:
            self._storage = aligned(
                (fields, self.modes, self.middle, self.box.shape[0]),
                np.result_type(self.dtype, np.complex64),
            )
        if not self._workers or len(self._workers[0].spectra) < sources + 1:
            self._workers = [_Worker(self, sources) for _ in range(self.threads)]

    def _each(self, work: Callable[[_Worker, int], object], blocks: int) -> None:
        """Call ``work`` once for every block, with the scratch of the thread that does it."""

        def deal(first: int, blocks: int, step: int) -> None:
            for block in range(first, blocks, step):
                work(self._workers[first], block)

        share(deal, blocks, self.threads)

    def _row_blocks(self) -> tuple[int, int]:
        rows, middle = self.row_block
        return math.ceil(self.box.shape[0] / rows), math.ceil(self.middle / middle)

    def _rows_in(self, field: Field, stored: Field) -> None:
        rows, middle = self.row_block
        n0, last = self.box.shape[0], self.box.shape[-1]
        source = field.reshape(n0, self.middle, last)
        across, along = self._row_blocks()

        def work(own: _Worker, block: int) -> None:
            i, j = block // along * rows, block % along * middle
            part = source[i : i + rows, j : j + middle]
            a, b = part.shape[:2]
            pad(part, own.line)
            own.to_hat()
            to_modes(own.line_hat[:a, :b], stored[:, j : j + b, i : i + a])

        self._each(work, across * along)

    def _rows_out(self, stored: Field, field: Field, shift: float, wanted: Rows) -> None:
        rows, middle = self.row_block
        n0, last = self.box.shape[0], self.box.shape[-1]
        target = field.reshape(n0, self.middle, last)
        _, along = self._row_blocks()
        factor, offset = self.dtype.type(self.scale), self.dtype.type(shift)
        first, end = (0, n0) if wanted is None else wanted
        skipped = first // rows
        across = math.ceil(min(end, n0) / rows) - skipped

        def work(own: _Worker, block: int) -> None:
            i, j = (block // along + skipped) * rows, block % along * middle
            part = target[i : i + rows, j : j + middle]
            a, b = part.shape[:2]
            to_rows(stored[:, j : j + b, i : i + a], own.line_hat[:a, :b])
            own.from_hat()
            crop(own.line, factor, offset, part)

        self._each(work, across * along)

    def _modes(
        self, sources: int, outputs: Sequence[Sequence[Term]], smoothing: Multiplier | None
    ) -> None:
        blocks = math.ceil(self.modes / self.mode_block)

        def work(own: _Worker, block: int) -> None:
            low = block * self.mode_block
            high = min(low + self.mode_block, self.modes)
            count = high - low
            for s in range(sources):
                self._load(own, self._storage[s][low:high], own.spectra[s])
                own.forward[s]()
                if smoothing is not None:
                    self._apply(smoothing.block(low, high), Term(s), own.spectra[s][:count], None)
            for o, terms in enumerate(outputs):
                for number, term in enumerate(terms):
                    spectrum, result = own.spectra[term.source][:count], own.result[:count]
                    if term.table is None:
                        np.copyto(result, spectrum)
                    else:
                        self._apply(term.table[low:high], term, spectrum, result, add=number > 0)
                own.backward()
                self._store(own, own.result, self._storage[o][low:high])

        self._each(work, blocks)

    def _apply(
        self,
        table: NDArray[Any],
        term: Term,
        spectrum: Field,
        result: Field | None,
        add: bool = False,
    ) -> None:
        parity = term.parity or (0,) * len(self.box.shape)
        rows = parity[1] if len(self.box.shape) == 3 else 0
        odd = (term.turn & 2, rows, parity[0])
        signs = np.array([-1 if one else 1 for one in odd], dtype=self.dtype)
        target = spectrum if result is None else result
        if len(self.box.shape) == 2:
            spectrum, target, table = (
                spectrum.swapaxes(0, 1),
                target.swapaxes(0, 1),
                table[None],
            )
        scale(spectrum, table, signs, bool(term.turn & 1), add, target)

    def _load(self, own: _Worker, stored: Field, spectrum: Field) -> None:
        count = len(stored)
        if self.padded_middle == 1:
            pad(stored, spectrum[:count])
        else:
            transpose(stored, own.plane[:count])
            own.plane_forward()
            transpose(own.plane[:count], spectrum[:count])

    def _store(self, own: _Worker, spectrum: Field, stored: Field) -> None:
        n0, count = self.box.shape[0], len(stored)
        if self.padded_middle == 1:
            np.copyto(stored, spectrum[:count, :, :n0])
        else:
            transpose(spectrum[:count, :, :n0], own.plane[:count])
            own.plane_backward()
            transpose(own.plane[:count, :, : self.middle], stored)
