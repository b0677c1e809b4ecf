"""Fields that are computed when they are asked for."""

import numpy as np
import pytest

from pmesh.vortex.asked import AskedFields


def counted(calls, name):
    def law():
        calls.append(name)
        return np.full(3, float(len(name)))

    return law


def test_names_are_told_without_computing_and_each_field_is_computed_once():
    calls = []
    fields = AskedFields({name: counted(calls, name) for name in ("vorticity", "velocity", "chi")})
    assert list(fields) == ["vorticity", "velocity", "chi"]
    assert len(fields) == 3
    assert "velocity" in fields
    assert "speed" not in fields
    assert calls == []
    assert fields["chi"] is fields["chi"]
    assert calls == ["chi"]
    assert {name: field[0] for name, field in fields.items()} == {
        "vorticity": 9.0, "velocity": 8.0, "chi": 3.0,
    }  # fmt: skip
    assert calls == ["chi", "vorticity", "velocity"]


def test_a_name_that_is_not_there_is_an_error_as_of_any_mapping():
    with pytest.raises(KeyError):
        AskedFields({})["velocity"]
