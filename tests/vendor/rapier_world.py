"""Worlds and bodies of Rapier, in rapier3d's own words."""

import pytest

rapier = pytest.importorskip("rapier3d", reason="installed when it is asked for")

G = 9.81
STILL = rapier.Rotation3(1.0, 0.0, 0.0, 0.0)


def world(gravity: float = G, dt: float = 1 / 240, substeps: int = 4) -> rapier.PhysicsWorld:
    made = rapier.PhysicsWorld(gravity=(0.0, 0.0, -gravity))
    made.integration_parameters.dt = dt
    made.integration_parameters.num_solver_iterations = substeps
    return made


def solid(mass: float, moments: tuple[float, float, float], p: tuple[float, float, float]) -> rapier.RigidBodyBuilder:
    inertia = rapier.MassProperties((0.0, 0.0, 0.0), mass, moments, STILL)
    return rapier.RigidBody.dynamic().can_sleep(False).additional_mass_properties(inertia).position(rapier.Isometry3(p, STILL))
