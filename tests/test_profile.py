"""How tall a swimmer in space is."""

import numpy as np
import pytest

from pmesh.bodies.profile import Arch
from remesh.errors import InputError


def test_the_arch_is_that_of_the_anguilliform_swimmer():
    # S. Kern, P. Koumoutsakos, J. Exp. Biol. 209, 4841 (2006), as tabulated by SophT's law
    places = np.array([0.0, 0.01, 0.3, 0.51, 1.0])
    heights = [0.0, 0.01576451077822886, 0.0729032159286102, 0.08, 0.02218374215487211]
    assert Arch().half_height(places) == pytest.approx(heights, abs=1e-15)


@pytest.mark.parametrize("options", [{"height": 0.0}, {"middle": 0.4}])
def test_arches_that_do_not_span_the_body_are_refused(options):
    with pytest.raises(InputError, match="an Arch needs"):
        Arch(**options)
