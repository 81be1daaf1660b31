"""What bodies are to each other and to an eye: whether any two may touch, and the shapes that one is drawn with."""

from collections.abc import Sequence

from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.shapes import Placed


def looks_of(body: Body) -> Sequence[Placed]:
    """What a body is drawn with."""
    return body.shapes if body.visual is None else body.visual


def may_touch(bodies: Sequence[Body]) -> bool:
    """Whether two bodies have shapes and one of them is dynamic."""
    solid = [body for body in bodies if body.shapes]
    return len(solid) > 1 and any(body.motion == "dynamic" for body in solid)
