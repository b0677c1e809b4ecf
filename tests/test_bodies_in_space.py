"""Bodies in flows in space: routes of force and torque, led bodies, closed surfaces, threads."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import levelset
from levelset.shapes import Ellipsoid, Sphere, TriangleMesh
from pmesh.bodies.body import RigidBody
from pmesh.bodies.motion import Prescribed
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

DT, STEPS = 0.03, 5


def stepped(
    body: RigidBody | list[RigidBody], side: int = 20, **options: Any
) -> tuple[VortexFlow, Any]:
    """A flow around bodies near the origin after a few steps from an impulsive start."""
    bodies = body if isinstance(body, list) else [body]
    grid = Grid((side,) * 3, 0.1, (0.05 - 0.05 * side,) * 3)
    flow = VortexFlow(grid=grid, viscosity=0.02, bodies=tuple(bodies), **options)
    state = flow.start()
    for _ in range(STEPS):
        state = flow.step(state, DT)
    return flow, state


def told(body: RigidBody | list[RigidBody], side: int = 20, **options: Any) -> dict[str, float]:
    """Its forces in the last step."""
    flow, state = stepped(body, side, **options)
    return dict(flow.forces(state))


def vector(row: dict[str, float], name: str) -> np.ndarray:
    return np.array([row[f"{name}_{axis}"] for axis in "xyz"])


def test_both_routes_tell_one_force_and_one_torque_of_two_bodies():
    """Torques about the origin: those about the centres and the arms of the forces."""
    centers = ((-0.45, 0.3, 0.0), (0.5, -0.35, 0.2))
    bodies = [
        RigidBody(Sphere(radius=0.45, center=centers[0])),
        RigidBody(Ellipsoid((0.5, 0.42, 0.42)).moved(centers[1], (0.2, 0.5, -0.3))),
    ]
    row = told(bodies, 28, freestream=(1.0, 0.4, -0.2))
    forces = [vector(row, f"body{n}_force") for n in (0, 1)]
    torques = [vector(row, f"body{n}_torque") for n in (0, 1)]
    total = sum(forces)
    turning = sum(torques) + sum(
        np.cross(center, force) for center, force in zip(centers, forces, strict=True)
    )
    size = np.linalg.norm(total)
    np.testing.assert_allclose(vector(row, "impulse_force"), total, atol=0.01 * size)
    np.testing.assert_allclose(vector(row, "impulse_torque"), turning, atol=0.01 * size)
    assert np.linalg.norm(turning) > 0.05 * size, "there is something to compare"


def test_a_towed_body_feels_what_one_that_is_held_in_a_stream_does():
    """To the mesh that it crosses: 2.8 % here, 0.6 % with 16 nodes across and half the step."""
    wind = np.array([0.8, 0.5, -0.3])
    ball = Sphere(radius=0.5)
    held = told(RigidBody(ball), freestream=tuple(wind))
    led = Prescribed(shift=lambda t: tuple(-wind * t), velocity=lambda t: tuple(-wind))
    towed = told(RigidBody(ball, motion=led))
    drag = vector(held, "body0_force")
    size = np.linalg.norm(drag)
    np.testing.assert_allclose(vector(towed, "body0_force"), drag, atol=0.03 * size)
    np.testing.assert_allclose(np.cross(drag, wind), 0.0, atol=2e-3 * size)
    power = float(wind @ vector(towed, "body0_force"))
    assert towed["body0_power"] == pytest.approx(power, rel=1e-9)


def test_a_closed_surface_of_triangles_is_held_like_the_shape_that_it_was_drawn_from():
    egg, lean = Ellipsoid((0.55, 0.45, 0.45)), (0.0, 0.3, 0.5)
    box = Grid((32, 32, 32), 0.04, (-0.62, -0.62, -0.62))
    surface = levelset.triangles(egg.distance(box.points()), box)
    drawn = TriangleMesh(surface.vertices, surface.faces)
    rows = [
        told(RigidBody(shape.moved(None, lean)), freestream=(1.0, 0.0, 0.0))
        for shape in (egg, drawn)
    ]
    for name in ("body0_force", "body0_torque"):
        exact, found = (vector(row, name) for row in rows)
        size = np.linalg.norm(vector(rows[0], "body0_force"))
        np.testing.assert_allclose(found, exact, atol=0.02 * size)


def test_the_number_of_threads_changes_no_bit():
    ball = RigidBody(Sphere(radius=0.5))
    one, two = (stepped(ball, freestream=(1.0, 0.0, 0.0), threads=n)[1] for n in (1, 2))
    np.testing.assert_array_equal(one.vorticity, two.vorticity)
    assert one.loads == two.loads


def test_a_step_leaves_the_state_before_as_it_was():
    flow, state = stepped(RigidBody(Sphere(radius=0.5)), freestream=(1.0, 0.0, 0.0))
    kept = replace(state, vorticity=state.vorticity.copy())
    again = [flow.step(state, DT) for _ in range(2)]
    np.testing.assert_array_equal(state.vorticity, kept.vorticity)
    np.testing.assert_array_equal(again[0].vorticity, again[1].vorticity)
