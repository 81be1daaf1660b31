"""How much memory a model's data sets aside for contacts and constraints where the engine's own guess is out of reach."""

from plumbline.harness.scene import Scene

MANY = 1200
"""Bodies up to which the guess stands: it grows with their square, 1.8 GB for a thousand, 14 for three thousand."""
PAIR, BODY = 8, 100_000
"""Bytes for each ordered pair of bodies and for each body.

Measured with balls in a container: 4 n^2 for the pairs that may touch (401 MB of 10 000), 9 to 14 kB a body for contacts and
their rows. Of what is set aside the system gives what is touched.
"""


def arena_for(scene: Scene) -> int:
    """Bytes for a scene, -1 where the engine may guess. Source: MuJoCo, XML reference, size/memory."""
    n = len(scene.bodies)
    return -1 if n <= MANY else PAIR * n**2 + BODY * n
