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


@pytest.mark.parametrize(
    ("count", "reach"), [(3, 2.5), (5, 7.0), (7, 13.5), (9, 22.0), (11, 32.5), (63, 1007.5)]
)
def test_as_few_stages_are_taken_as_reach_the_step(count, reach):
    # explicit steps that a method of so many stages reaches: Meyer, Balsara & Aslam 2014, eq. 14
    assert stage_count(0.999 * reach) == stage_count(reach) == count
    assert stage_count(1.001 * reach) == count + 2


def test_a_short_step_takes_three_stages():
    assert stage_count(0.1) == 3


def test_three_stages_are_those_of_the_paper():
    # b = 1/3, 1/3, 1/3, 5/12 and w = 2/5 in equations 15 to 17, by hand
    first, second, third = stages(3)
    assert first == pytest.approx((1, 0, 0, 2 / 15, 0))
    assert second == pytest.approx((3 / 2, -1 / 2, 0, 3 / 5, -2 / 5))
    assert third == pytest.approx((25 / 12, -5 / 6, -1 / 4, 5 / 6, -5 / 9))


def test_the_weights_of_values_add_up_to_one():
    for count in (3, 7, 15):
        for w in stages(count):
            assert w.last + w.before + w.first == pytest.approx(1.0, abs=1e-14)
