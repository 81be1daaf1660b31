"""The effects that a scene may call for; nothing else is computed."""

from enum import Flag, auto


class Effect(Flag):
    """One bit for each piece of physics that can be left out."""

    NONE = 0
    GRAVITY = auto()
    CONTACT = auto()
    FRICTION = auto()
    RESTITUTION = auto()
    ROLLING_FRICTION = auto()
    TORSIONAL_FRICTION = auto()
    CONTINUOUS_COLLISION = auto()
    GYROSCOPIC = auto()
    JOINTS = auto()
    DRIVES = auto()
    LINEAR_DAMPING = auto()
    ANGULAR_DAMPING = auto()
    SENSING = auto()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the bits that are set, in lower case, in the order of definition."""
        return tuple(effect.name.lower() for effect in Effect if effect in self and effect.name is not None)
