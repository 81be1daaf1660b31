"""The planted faults of contacts and shapes: forces, gaps and normals handed out wrongly, shapes and poses lost on the way."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from harness.adapter import Settings, Simulation
from harness.conformance.faults.plant import Wrapped
from harness.scene import (
    Body,
    PlacedShape,
    Plane,
    Scene,
    Surface,
)
from harness.trajectory import Contacts, Floats

__all__ = [
    "FlippedNormal",
    "FrictionScaled",
    "HalfForce",
    "HalfGap",
    "LateForce",
    "LingeringForce",
    "NormalOfOnePair",
    "PositiveGap",
    "first_shapes",
    "friction_times",
    "level_planes",
    "restitution_times",
    "unplaced_later_shapes",
    "unturned_later_shapes",
]


class FlippedNormal(Wrapped):
    """Hands out normals from B to A."""

    def contacts(self) -> Contacts:
        """As inside, the normal turned round."""
        got = self.inner.contacts()
        return replace(got, normal_W=-got.normal_W)


class PositiveGap(Wrapped):
    """Hands out penetration as a positive number."""

    def contacts(self) -> Contacts:
        """As inside, the gap with the other sign."""
        got = self.inner.contacts()
        return replace(got, gap=-got.gap)


class HalfForce(Wrapped):
    """Loses half of each contact force, as one who reads two impulses as one would."""

    def contacts(self) -> Contacts:
        """As inside, the forces halved."""
        got = self.inner.contacts()
        return replace(got, force_W=got.force_W / 2)


def _along(got: Contacts) -> Floats:
    """The normal parts (k, 3) N of the forces."""
    along: Floats = np.sum(got.force_W * got.normal_W, axis=1)[:, None] * got.normal_W
    return along


class LateForce(Wrapped):
    """Hands out the contacts of the step before."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        self._before = Contacts.none()

    def step(self, count: int = 1) -> None:
        """As inside; the contacts before the last step are kept."""
        if count > 1:
            self.inner.step(count - 1)
        if count > 0:
            self._before = self.inner.contacts()
            self.inner.step()

    def contacts(self) -> Contacts:
        """Those kept."""
        return self._before


class LingeringForce(Wrapped):
    """Goes on with the last forces when bodies have parted."""

    def __init__(self, inner: Simulation, scene: Scene, settings: Settings) -> None:
        super().__init__(inner, scene, settings)
        self._last = Contacts.none()

    def contacts(self) -> Contacts:
        """As inside, or the last that bore a force."""
        got = self.inner.contacts()
        if got.force_W.any():
            self._last = got
        return self._last


class FrictionScaled(Wrapped):
    """Hands out contact forces with their friction times a factor."""

    factor = 0.0

    def contacts(self) -> Contacts:
        """As inside, the part across the normal scaled."""
        got = self.inner.contacts()
        normal = _along(got)
        return replace(got, force_W=normal + self.factor * (got.force_W - normal))


class HalfGap(Wrapped):
    """Hands out half the gap."""

    def contacts(self) -> Contacts:
        """As inside, gaps halved."""
        got = self.inner.contacts()
        return replace(got, gap=got.gap / 2)


class NormalOfOnePair(Wrapped):
    """Turns normals and forces round where a box meets a sphere."""

    def contacts(self) -> Contacts:
        """As inside, one pair of shapes the other way."""
        got = self.inner.contacts()
        kinds = [{placed.shape.type for placed in body.collision} for body in self.scene.bodies]
        odd = np.array(
            [kinds[a] | kinds[b] == {"box", "sphere"} for a, b in zip(got.body_A, got.body_B, strict=True)], dtype=bool
        )
        sign = np.where(odd, -1.0, 1.0)[:, None]
        return replace(got, normal_W=sign * got.normal_W, force_W=sign * got.force_W)


def first_shapes(count: int) -> Callable[[Body], Body]:
    """A body keeps its first `count` shapes."""
    return lambda body: replace(body, collision=body.collision[:count])


def _later(change: Callable[[PlacedShape], PlacedShape]) -> Callable[[Body], Body]:
    return lambda body: replace(body, collision=body.collision[:1] + tuple(change(placed) for placed in body.collision[1:]))


unplaced_later_shapes = _later(lambda placed: replace(placed, p_BS=(0.0, 0.0, 0.0)))
"""All shapes of a body but the first sit at its centre of mass."""
unturned_later_shapes = _later(lambda placed: replace(placed, q_BS=(1.0, 0.0, 0.0, 0.0)))
"""All shapes of a body but the first stand as the body does."""


def level_planes(body: Body) -> Body:
    """Planes lose their pose in the body."""
    level = tuple(PlacedShape(shape=p.shape) if isinstance(p.shape, Plane) else p for p in body.collision)
    return replace(body, collision=level)


def friction_times(factor: float) -> Callable[[Surface], Surface]:
    """Friction times a factor."""
    return lambda law: replace(
        law, static_friction=factor * law.static_friction, kinetic_friction=factor * law.kinetic_friction
    )


def restitution_times(factor: float) -> Callable[[Surface], Surface]:
    """Restitution times a factor."""
    return lambda law: replace(law, restitution=factor * law.restitution)
