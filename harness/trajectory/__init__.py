"""What an engine answered: states, contacts and ray hits as plain arrays in the world frame."""

from harness.trajectory.trajectory import (
    Contacts,
    Floats,
    Hits,
    Image,
    Integers,
    State,
    Trajectory,
)

__all__ = [
    "Contacts",
    "Floats",
    "Hits",
    "Image",
    "Integers",
    "State",
    "Trajectory",
]
