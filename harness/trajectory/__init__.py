"""What an engine answered: states, contacts and ray hits as plain arrays in the world frame."""

from plumbline.harness.trajectory.trajectory import UNSHARED, Contacts, Floats, Hits, Image, Integers, State, Trajectory

__all__ = ["UNSHARED", "Contacts", "Floats", "Hits", "Image", "Integers", "State", "Trajectory"]
