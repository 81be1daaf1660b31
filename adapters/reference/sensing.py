"""What a camera sees: the engine's eye and its pictures."""

from typing import TYPE_CHECKING

from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import WORLD, Camera, Scene, multiply, rotate
from plumbline.harness.trajectory import Image

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["picture"]


def picture(world: "engine.World", scene: Scene, camera: Camera, colour: bool) -> Image:
    """The engine's own picture, on as many threads as the world has. Raises: Unsupported."""
    from plumbline import engine

    try:
        seen = world.render(_eye(world, scene, camera), camera.renderer, colour=colour, threads=world.options.threads)
    except (engine.NotSupported, ValueError) as error:
        raise Unsupported(f"image of camera '{camera.name}'", str(error)) from error
    return Image(depth=seen.depth, body=seen.body, colour=seen.colour)


def _eye(world: "engine.World", scene: Scene, camera: Camera) -> "engine.Eye":
    """A camera in the engine's words, where its body is now."""
    from plumbline import engine

    p_WS, q_WS = camera.p_BS, camera.q_BS
    if camera.body != WORLD:
        row = world.state()[scene.index(camera.body)].tolist()
        q_WB = (row[3], row[4], row[5], row[6])
        x, y, z = rotate(q_WB, camera.p_BS)
        p_WS, q_WS = (row[0] + x, row[1] + y, row[2] + z), multiply(q_WB, camera.q_BS)
    bent = camera.distortion
    return engine.Eye(
        p_WE=p_WS,
        q_WE=q_WS,
        width=camera.width,
        height=camera.height,
        focal_x=camera.focal_x,
        focal_y=camera.focal_y,
        centre_x=camera.centre_x,
        centre_y=camera.centre_y,
        lens=None if bent is None else engine.Lens(k1=bent.k1, k2=bent.k2, k3=bent.k3, p1=bent.p1, p2=bent.p2),
        samples=camera.samples,
    )
