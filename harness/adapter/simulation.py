"""The protocol of a simulation: one scene in one engine."""

from collections.abc import Mapping
from typing import Protocol

from plumbline.harness.adapter.notice import Notice
from plumbline.harness.adapter.settings import Settings
from plumbline.harness.scene import Camera
from plumbline.harness.trajectory import Contacts, Floats, Hits, Image, State


class Simulation(Protocol):
    """One scene in one engine."""

    @property
    def resolved(self) -> Settings:
        """The settings that the engine really uses, defaults filled in, read back from the engine where it lets us."""

    def step(self, count: int = 1) -> None:
        """Advance by count * dt; a count of 0 changes nothing. Raises: Diverged."""

    def state(self, out: State) -> None:
        """Write the present state into the arrays of `out`."""

    def contacts(self) -> Contacts:
        """The contacts of the last step. Raises: Unsupported."""

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        """First hit of each ray within max_range [m]; origins (r, 3) m, directions (r, 3) unit, in W.

        A ray that starts inside a solid meets its far side, whose normal points along the ray. Raises: Unsupported.
        """

    def render(self, camera: Camera, colour: bool = True) -> Image:
        """The engine's own picture by `camera.renderer`, without colours if these are not wanted. Raises: Unsupported."""

    def command(self, targets: Mapping[str, float]) -> None:
        """Set the targets [rad or m] of drives by the names of their joints, until told otherwise."""

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        """Apply f_B_W (n, 3) N at the centres of mass and tau_B_W (n, 3) N m in every step from now on. Raises: Unsupported."""

    def warnings(self) -> tuple[str | Notice, ...]:
        """What the engine or the adapter has to say: numerical warnings, and effects that could not be switched off.

        A plain text is a note.
        """

    def save(self) -> object:
        """All that decides the future, bit for bit. Raises: Unsupported."""

    def restore(self, saved: object) -> None:
        """Back to a saved state. Raises: Unsupported."""

    def close(self) -> None:
        """Free the engine's memory; may be called twice."""
