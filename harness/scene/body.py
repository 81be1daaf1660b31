"""A rigid body: mass, inertia, shapes placed relative to the centre of mass, its state at the start, and how light meets it."""

from functools import lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.motion import Prescribed
from plumbline.harness.scene.shape import Box, Plane, Shape, Sphere, solid_inertia
from plumbline.harness.scene.values import FROZEN, Axis, Matrix3, Name, NonNegative, Probability, Quaternion, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Appearance:
    """Optics of a surface: of the light that arrives `mirror` is reflected, of the rest `transmission` goes through; the rest
    scatters.

    Terms:
        colour [1]: share of scattered light that is sent back, linear red, green, blue.
        reflectivity [1]: the same at the wavelength of range finders and depth cameras.
        mirror [1]: share reflected at the angle of incidence. transmission [1]: of the rest, the share
        that enters, with Fresnel's reflection beside it, into a solid of this refractive_index [1].
    """

    colour: tuple[Probability, Probability, Probability] = (0.8, 0.8, 0.8)
    reflectivity: Probability = 1.0
    mirror: Probability = 0.0
    transmission: Probability = 0.0
    refractive_index: Annotated[float, Field(ge=1, le=4)] = 1.5

    @property
    def scatters(self) -> float:
        """The share of light that is neither mirrored nor let through."""
        return (1.0 - self.mirror) * (1.0 - self.transmission)


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Sun:
    """Light from one direction and from the whole sky.

    Terms:
        towards_W: to the sun. irradiance [1]: of a surface that faces it; sky [1]: radiance of the sky, the same everywhere, so
        that a white surface under it, with nothing in the way, looks as bright as the sky.
        infrared [1]: sunlight on a surface that faces it over what an active sensor's own light is at 1 m.
    """

    towards_W: Axis = (0.48, 0.36, 0.8)
    irradiance: NonNegative = 1.0
    sky: NonNegative = 0.5
    infrared: NonNegative = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class PlacedShape:
    """A shape with the pose of its frame S in the body frame B (origin at the centre of mass)."""

    shape: Shape
    p_BS: Vector3 = (0.0, 0.0, 0.0)
    q_BS: Quaternion = (1.0, 0.0, 0.0, 0.0)


@lru_cache(maxsize=1024)
def _defect(inertia: Matrix3) -> str:
    """Why nothing has this inertia [kg m2], in words; '' where something may. Asked once of what many bodies have."""
    tensor = np.asarray(inertia)
    largest = float(np.abs(tensor).max())
    if np.abs(tensor - tensor.T).max() > 1e-9 * largest:
        return f"{tensor.tolist()} kg m2 is not symmetric"
    a, b, c = np.linalg.eigvalsh(tensor)
    if a <= 0 and largest > 0.0:
        return f"with principal moments ({a:g}, {b:g}, {c:g}) kg m2 is not positive"
    if a + b < c * (1 - 1e-9):
        return f"with principal moments ({a:g}, {b:g}, {c:g}) kg m2 breaks the triangle inequality"
    return ""


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Body:
    """A rigid body whose frame B has its origin at the centre of mass.

    Terms:
        mass [kg], inertia [kg m2] shape (3, 3), symmetric, about the centre of mass in B; all zero for a mass point, which
        nothing turns and which has no collision shapes. A body with neither stands between two joints with one coordinate
        each, so that several of them move the body behind it; its origin is any point of it.
        collision: the shapes that touch (several make a compound); visual: what is drawn, the same if None.
        material: the name that surfaces pair up. appearance: what light does at its surface.
        p_WB [m], q_WB, v_WB [m/s], w_WB [rad/s]: pose and velocity at time 0, in W.
        motion: static bodies never move, kinematic ones keep their velocity whatever touches them.
        prescribed: how a kinematic body moves beside its v_WB, as a law of time; None: as v_WB and w_WB alone say.
        linear_damping, angular_damping [1/s]: v' = -c v and w' = -c w beside all other accelerations.
    """

    name: Name
    mass: NonNegative = 1.0
    inertia: Matrix3 = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    collision: tuple[PlacedShape, ...] = ()
    visual: tuple[PlacedShape, ...] | None = None
    material: Name = "default"
    appearance: Appearance = Appearance()
    p_WB: Vector3 = (0.0, 0.0, 0.0)
    q_WB: Quaternion = (1.0, 0.0, 0.0, 0.0)
    v_WB: Vector3 = (0.0, 0.0, 0.0)
    w_WB: Vector3 = (0.0, 0.0, 0.0)
    motion: Literal["dynamic", "static", "kinematic"] = "dynamic"
    prescribed: Prescribed | None = None
    linear_damping: NonNegative = 0.0
    angular_damping: NonNegative = 0.0

    def __post_init__(self) -> None:
        where = f"body '{self.name}'"
        if defect := _defect(self.inertia):
            raise ValueError(f"{where}: inertia {defect}")
        if self.mass == 0 and (not self.movable or any(map(any, self.inertia)) or self.collision or self.visual):
            raise ValueError(
                f"{where}: mass is 0 kg, expected above 0; or of a body that stands between two joints, motion 'dynamic', an "
                "inertia of zero and no shapes"
            )
        if self.mass == 0 and (self.linear_damping or self.angular_damping):
            raise ValueError(f"{where}: damping of a body without mass; expected none")
        if self.collision and not any(map(any, self.inertia)):
            raise ValueError(
                f"{where}: inertia is zero, and it has shapes that touch; a mass point has none, expected that of a small "
                "ball, 2/5 m r^2"
            )
        if self.motion == "static" and (any(self.v_WB) or any(self.w_WB)):
            raise ValueError(f"{where}: a static body moves with v_WB {self.v_WB}, w_WB {self.w_WB}; expected zero")
        if self.prescribed is not None and self.motion != "kinematic":
            raise ValueError(f"{where}: its motion is prescribed; expected motion 'kinematic', got '{self.motion}'")
        if self.prescribed is not None and any(self.w_WB):
            raise ValueError(f"{where}: w_WB {self.w_WB} beside a prescribed motion; expected zero, and a turn for it")
        if self.motion == "dynamic" and any(placed.shape.type == "plane" for placed in self.collision):
            raise ValueError(f"{where}: a plane has no bounds; expected motion 'static' or 'kinematic', got 'dynamic'")

    @classmethod
    def solid(cls, name: str, shape: Shape, mass: float = 1.0, *, touches: bool = True, **fields: Any) -> Self:
        """A body [kg] of one shape at its origin, which touches, or is only seen.

        Args: fields: the others of a body; its inertia is that of a uniform solid unless it is among them.
        """
        fields["collision" if touches else "visual"] = (PlacedShape(shape=shape),)
        inertia = fields.pop("inertia", None) or solid_inertia(mass, shape)
        return cls(name=name, mass=mass, inertia=inertia, **fields)

    @classmethod
    def box(cls, name: str, half_extents: Vector3, mass: float = 1.0, **fields: Any) -> Self:
        """A solid box [m, kg]. Args: fields: as of `solid`."""
        return cls.solid(name, Box(half_extents=half_extents), mass, **fields)

    @classmethod
    def ball(cls, name: str, radius: float, mass: float = 1.0, **fields: Any) -> Self:
        """A solid ball [m, kg]. Args: fields: as of `solid`."""
        return cls.solid(name, Sphere(radius=radius), mass, **fields)

    @classmethod
    def fixed(cls, name: str, shape: Shape, **fields: Any) -> Self:
        """A static body of one shape at its origin. Args: fields: the others of a body."""
        return cls(name=name, motion="static", collision=(PlacedShape(shape=shape),), **fields)

    @classmethod
    def between(cls, name: str, p_WB: Vector3 = (0.0, 0.0, 0.0), **fields: Any) -> Self:
        """A body without mass that stands between two joints. Args: fields: its velocity, where what it hangs on moves."""
        nothing = (0.0, 0.0, 0.0)
        return cls(name=name, mass=0.0, inertia=(nothing, nothing, nothing), p_WB=p_WB, **fields)

    @classmethod
    def ground(cls, material: str = "ground") -> Self:
        """Level ground, solid below z = 0."""
        return cls.fixed("ground", Plane(), material=material)

    @property
    def only_shape(self) -> Shape | None:
        """The shape of a body of one that touches; None of one without any, or with several."""
        return self.collision[0].shape if len(self.collision) == 1 else None

    @property
    def mass_point(self) -> bool:
        """Is it a movable body without any inertia, that has mass?"""
        return self.movable and self.mass > 0 and not any(map(any, self.inertia))

    @property
    def massless(self) -> bool:
        """Does it stand between two joints, without mass and inertia?"""
        return self.mass == 0

    @property
    def velocity_at_start(self) -> tuple[Vector3, Vector3]:
        """v [m/s] of the centre of mass and w [rad/s] in W at time 0, with what is prescribed."""
        if self.prescribed is None:
            return self.v_WB, self.w_WB
        return self.prescribed.velocity_at_start(self.p_WB, self.v_WB)

    @property
    def movable(self) -> bool:
        """Does a force move it?"""
        return self.motion == "dynamic"
