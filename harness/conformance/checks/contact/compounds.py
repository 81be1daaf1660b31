"""Checks of bodies of several shapes, and of shapes that stand askew in their body: none is left out, each keeps its pose."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, NotApplicable, firm, near, refusable
from plumbline.harness.conformance.engine import COARSE, Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, UPRIGHT, Y, Z, aligned, vector
from plumbline.harness.conformance.scenes import G, ball, free, ground, on_ground, shaped, without_gravity
from plumbline.harness.scene import Box, PlacedShape, Plane, Scene, Shape, Sphere, axis_angle, principal_inertia

_INERTIA = principal_inertia(0.05, 0.05, 0.05)


@firm("Does a body of three shapes touch with each of them, the last one too?", Feature.COMPOUND | Feature.SPHERE)
def compound_stands_on_every_shape(engine: Engine) -> Comparisons:
    """Tables whose centre of mass hangs over one leg each: whichever leg of the three is missing, one of them tips at once."""
    corners = [(0.3, 0.0), (-0.15, 0.26), (-0.15, -0.26)]
    tables = []
    for k in range(3):
        # The centre of mass lies above the middle of the triangle, moved half way towards leg k.
        moved = 0.5 * np.array(corners[k])
        legs = (PlacedShape(shape=Sphere(radius=0.05), p_BS=vector((*(corner - moved), -0.2))) for corner in np.array(corners))
        tables.append(shaped(f"table{k}", *legs, inertia=_INERTIA, p_WB=(2.0 * k, 0.0, 0.25)))
    end = engine.final(on_ground(engine, *tables, friction=0.0), 0.2)
    yield near("heights of three tables [m]", end.p_WB[1:, 2], [0.25] * 3, 3e-3, "contacts give way by less than 3 mm")
    because = "3 mm over .3 m; without its leg one tips by more than .1 rad"
    yield aligned("their tilts [rad]", end.q_WB[1:], [UPRIGHT] * 3, 0.02, because)


@firm("Is each shape of a body turned by its own q_BS, the later ones too?", Feature.COMPOUND | Feature.SPHERE | Feature.BOX)
def compound_keeps_the_turn_of_every_shape(engine: Engine) -> Comparisons:
    """A frame on a ball and two long boxes, the first laid along y and the second stood upright by their q_BS.

    Its centre of mass hangs 5 cm beside the line of the places of its shapes: 40 cm of box hold it, 6 cm do not.
    """
    long = Box(half_extents=(0.2, 0.03, 0.03))
    along_y, upright = axis_angle(Z, pi / 2), axis_angle(Y, pi / 2)
    shapes = (
        PlacedShape(shape=Sphere(radius=0.05), p_BS=(0.4, 0.05, -0.2)),
        PlacedShape(shape=long, p_BS=(-0.4, 0.05, -0.22), q_BS=along_y),
        PlacedShape(shape=long, p_BS=(0.0, 0.05, -0.05), q_BS=upright),
    )
    body = shaped("frame", *shapes, inertia=_INERTIA, p_WB=(0.0, 0.0, 0.25))
    end = engine.final(on_ground(engine, body, friction=0.0), 0.4)
    yield near("height of the frame [m]", end.p_WB[1, 2], 0.25, 5e-3, "it stands on a ball and two boxes")
    yield aligned("its tilt [rad]", end.q_WB[1], UPRIGHT, 0.05, "g .035/.11 t^2/2 = .25 rad where it falls")


@firm("Does a plane stand where p_BS and q_BS place it in its body, or is it refused?", Feature.PLANE | Feature.SPHERE)
def plane_is_placed_in_its_body(engine: Engine) -> Comparisons:
    """A plane raised by p_BS and turned by q_BS in a body that is turned itself holds a ball; or it is refused."""
    placed = PlacedShape(shape=Plane(), p_BS=(0.0, 0.0, 0.4), q_BS=axis_angle(Y, 0.5))
    wall = shaped("wall", placed, motion="static", material="ground", p_WB=Z, q_WB=axis_angle(Y, -0.2))
    turn = 0.3
    normal = np.array([np.sin(turn), 0.0, np.cos(turn)])
    on_plane = np.array([-0.4 * np.sin(0.2), 0.0, 1.0 + 0.4 * np.cos(0.2)])
    p = on_plane + 0.1 * normal
    scene = Scene(bodies=(wall, ball(p=vector(p))), surfaces=(ground(),), gravity=vector(-G * normal))
    with refusable():
        end = engine.final(scene, 0.15)
    yield near("ball on a plane that is placed in its body [m]", end.p_WB[1], p, 3e-3, "contacts give way by less than 3 mm")


@firm("Does a force act at the centre of mass, wherever the shapes are?", Feature.WRENCH)
def push_acts_at_the_centre_of_mass(engine: Engine) -> Comparisons:
    """A force on a body whose only shape is off its centre of mass moves the centre of mass and turns nothing."""
    if not engine.features & (Feature.SPHERE | Feature.BOX):
        raise NotApplicable("the engine claims neither a sphere nor a box that could be off the centre of mass")
    shape: Shape = Sphere(radius=0.1) if Feature.SPHERE in engine.features else Box(half_extents=(0.1, 0.1, 0.1))
    placed = PlacedShape(shape=shape, p_BS=(0.3, -0.2, 0.4))
    body = replace(free(p=(1.0, 2.0, 3.0), q=TURNED), collision=(placed,))
    scene, f, t = without_gravity(body), np.array([[3.0, -5.0, 4.0]]), 24 * COARSE
    with engine.built(scene, COARSE) as simulation:
        simulation.wrench(f, np.zeros((1, 3)))
        simulation.step(24)
        end = state_of(simulation, scene)
    size = sqrt(50.0) * t / 2.0
    yield near("v_WB after a push [m/s]", end.v_WB[0], f[0] * t / 2.0, 0.01 * size, "F t/m; 1 % for default damping")
    yield near("w_WB after a push [rad/s]", end.w_WB[0], ORIGIN, 1e-6, "at the shape it would turn at 1 rad/s")
