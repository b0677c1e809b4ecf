"""Laws of super-time-stepping."""

import numpy as np
import pytest

from levelset.stages import stage_count, stages


def grown(count, z):
    """What ``count`` stages make of 1 in a step of y' = z y, dt = 1."""
    weights = stages(count)
    before, value = 1.0, 1.0 + weights[0].rate * z
    for w in weights[1:]:
        before, value = (
            value,
            (w.last * value + w.before * before + w.first + w.rate * z * value + w.start * z),
        )
    return value


@pytest.mark.parametrize("count", [3, 5, 9, 21])
def test_the_stages_are_of_order_two(count):
    z = np.array([-0.02, -0.01, -0.005])
    errors = np.abs(grown(count, z) - np.exp(z))
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 3.0, atol=0.05)  # of one step


@pytest.mark.parametrize("count", [3, 5, 9, 21, 51])
def test_no_wave_grows_within_their_reach_and_all_are_damped(count):
    # explicit Euler holds to z = -2: so many times that far
    reach = 2.0 * (count**2 + count - 2) / 4.0
    gain = np.abs(grown(count, -np.linspace(0.02, 1.0, 4000) * reach))
    assert gain.max() < 1.0
    assert np.abs(grown(count, -1.5 * reach)) > 1.0


def test_as_few_stages_are_taken_as_reach_the_step():
    for ratio in (0.1, 2.5, 2.6, 7.0, 7.1, 30.0, 1000.0):
        count = stage_count(ratio)
        assert count % 2 == 1
        assert (count**2 + count - 2) / 4 >= ratio * (1 - 1e-9)
        assert count == 3 or ((count - 2) ** 2 + count - 4) / 4 < ratio


def test_the_weights_of_values_add_up_to_one():
    for count in (3, 7, 15):
        for w in stages(count):
            assert w.last + w.before + w.first == pytest.approx(1.0, abs=1e-14)
