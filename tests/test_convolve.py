"""The blocked, pruned convolution against one plain padded FFT."""

import numpy as np
import pytest

from pmesh.spectral.convolve import Convolver, Term
from pmesh.spectral.smoothing import make_smoothing
from pmesh.spectral.symbols import Box

BOXES = [
    ((37, 50), (False, False)),
    ((40, 33), (True, False)),
    ((9, 45), (False, True)),
    ((35, 21), (True, True)),
    ((11, 19, 12), (False, False, False)),
    ((9, 7, 15), (True, False, True)),
    ((12, 33, 5), (False, True, False)),
]


def whole(box, table, parity):
    """The table for all wavenumbers, axes in natural order."""
    full = table.T
    for axis, p in enumerate(box.padded):
        mirrored = np.flip(np.take(full, range(1, (p + 1) // 2), axis=axis), axis=axis)
        full = np.concatenate([full, -mirrored if parity[axis] else mirrored], axis=axis)
    return full


def whole_axis(box, axis, values):
    """An even symbol of one axis for all its wavenumbers, shaped to broadcast."""
    mirrored = values[(box.padded[axis] - 1) // 2 : 0 : -1]
    return box.along(axis, np.concatenate([values, mirrored]))


def plain(box, fields, terms, smoothing):
    axes = range(len(box.shape))
    hats = [np.fft.fftn(field, box.padded, axes=axes) * smoothing for field in fields]
    total = sum(1j**t.turn * whole(box, t.table, t.parity) * hats[t.source] for t in terms)
    kept = np.fft.ifftn(total, axes=axes)[tuple(slice(0, n) for n in box.shape)]
    return kept.real


@pytest.mark.parametrize(("shape", "periodic"), BOXES)
@pytest.mark.parametrize(("dtype", "tolerance"), [("f8", 1e-13), ("f4", 1e-5)])
def test_pruned_blocks_equal_the_plain_padded_transform(shape, periodic, dtype, tolerance):
    rng = np.random.default_rng(8)
    box = Box(shape, 0.1, periodic)
    fields = [rng.standard_normal(shape).astype(dtype) for _ in range(2)]
    even, odd = (0,) * len(shape), (1,) + (0,) * (len(shape) - 1)
    tables = [rng.standard_normal(box.half[::-1]).astype(dtype) for _ in range(2)]
    tables[1][..., 0] = 0  # an odd table vanishes at zero and at Nyquist
    if box.padded[0] % 2 == 0:
        tables[1][..., -1] = 0
    outputs = [
        [Term(0, tables[0], even, 2)],
        [Term(1, tables[1], odd, 1), Term(0, tables[0], even, 0)],
        [Term(1, tables[1], odd, 3)],
    ]
    smoothing = make_smoothing(box, ("heat", 1e-3), dtype)
    spreads = [whole_axis(box, axis, box.spread(axis)) for axis in range(len(shape))]
    symbol = np.exp(-1e-3 * np.asarray(sum(spreads)))
    for threads in (1, 2):
        convolver = Convolver(box, dtype=dtype, threads=threads)
        convolver.threads = threads  # small boxes would use one
        out = [np.empty(shape, dtype) for _ in outputs]
        seen = []
        convolver.run(
            fields, outputs, out, smoothing=smoothing, shifts=[0.0, 0.5, 0.0], check=seen.extend
        )
        assert np.allclose(seen, [field.mean() for field in fields], atol=tolerance)
        for result, terms, shift in zip(out, outputs, (0.0, 0.5, 0.0), strict=True):
            exact = plain(box, fields, terms, symbol) + shift
            assert np.abs(result - exact).max() <= tolerance * np.abs(exact).max()


def test_a_source_that_is_not_finite_shows_in_its_mean_before_anything_is_written():
    def refuse(means):
        if not np.isfinite(means).all():
            raise ArithmeticError("not finite")

    box = Box((8, 8), 0.1, (False, False))
    convolver = Convolver(box, dtype="f8", threads=1)
    for bad in (np.nan, np.inf):
        field = np.zeros((8, 8))
        field[3, 4] = bad
        out = np.full((8, 8), 7.0)
        with pytest.raises(ArithmeticError):
            convolver.run([field], [[Term(0)]], [out], check=refuse)
        assert np.all(out == 7.0)


def test_the_output_may_be_the_source():
    box = Box((8, 12), 0.1, (False, True))
    convolver = Convolver(box, dtype="f8", threads=1)
    field = np.random.default_rng(0).standard_normal((8, 12))
    kept = field.copy()
    convolver.run([field], [[Term(0)]], [field])
    assert np.allclose(field, kept, atol=1e-15)
