"""Pictures by MuJoCo's own renderer: OpenGL on EGL, without a screen."""

import math
from typing import Any

import numpy as np

from plumbline.adapters.mujoco.shapes import BOTH_GROUP, VISUAL_GROUP
from plumbline.adapters.mujoco.vendor import flag
from plumbline.adapters.mujoco.world import World
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.rotations import matrix, products
from plumbline.harness.scene import WORLD, Camera
from plumbline.harness.trajectory import Floats, Image, Integers

SLICES = 192
"""Corners of a drawn circle: a sphere is off by up to (1 - cos(pi/192)) of its radius, about 1.3e-4."""


class Renderer:
    """The window of one world, opened for its first picture and as large as the largest."""

    def __init__(self, world: World) -> None:
        self._world, self._mj, self._m = world, world.mj, world.model
        self._window: tuple[Any, Any, Any] | None = None

    def render(self, camera: Camera, colour: bool) -> Image:
        """Depth and bodies in one pass, where every geom has a number for its colour; colours in another."""
        if camera.renderer != "rasterised":
            raise Unsupported(f"ray-traced image of camera '{camera.name}'", "MuJoCo draws by OpenGL's z-buffer alone")
        mj, d = self._mj, self._world.state
        gl, _, view = self._surface(camera)
        gl.make_current()
        self._world.renew_poses()
        drawn = mj.MjvOption()
        drawn.geomgroup[:] = [group in (BOTH_GROUP, VISUAL_GROUP) for group in range(6)]
        mj.mjv_updateScene(self._m, d, drawn, None, mj.MjvCamera(), mj.mjtCatBit.mjCAT_ALL.value, view)
        near, far = 0.01, max(100.0, 50 * float(self._m.stat.extent))
        self._aim(view, camera, near, far)
        raw, numbers = self._pass(camera, numbered=True)
        # The buffer holds reversed z: 1 at `near`, 0 at `far` and where nothing was drawn.
        with np.errstate(divide="ignore"):
            depth = np.where(raw > 0, near * far / (near + raw * (far - near)), np.inf)
        owner = np.full(view.maxgeom + 1, -1, dtype=np.int64)
        for geom in view.geoms[: view.ngeom]:
            owner[geom.segid + 1] = self._world.indices.owner[geom.objid]
        body = owner[numbers.astype(np.int64) @ (1, 256, 65536)]
        return Image(depth, np.where(raw > 0, body, -1), self._painted(camera, body) if colour else None)

    def _pass(self, camera: Camera, numbered: bool) -> tuple[Floats, Any]:
        """Draw the scene: the depth buffer (h, w) and the colours (h, w, 3) of 8 bits, from the top down."""
        mj = self._mj
        assert self._window is not None
        _, context, view = self._window
        view.flags[mj.mjtRndFlag.mjRND_SEGMENT] = view.flags[mj.mjtRndFlag.mjRND_IDCOLOR] = int(numbered)
        rectangle = mj.MjrRect(0, 0, camera.width, camera.height)
        depth, colour = (
            np.zeros((camera.height, camera.width), np.float32),
            np.zeros((camera.height, camera.width, 3), np.uint8),
        )
        mj.mjr_render(rectangle, view, context)
        mj.mjr_readPixels(colour, depth, rectangle, context)
        return depth[::-1].astype(np.float64), colour[::-1]

    def _painted(self, camera: Camera, body: Integers) -> Floats:
        """Linear colours under the scene's sun and sky, without shadows; what does not scatter shows the sky.

        OpenGL adds and multiplies plain numbers in 0..1, so the light is scaled down to that and the picture up again.
        """
        assert self._window is not None
        view, scene = self._window[2], self._world.scene
        sun, looks = scene.sun, [each.appearance for each in scene.bodies]
        direct = sun.irradiance / math.pi
        scale = max(direct + sun.sky, 1e-300)
        for geom in view.geoms[: view.ngeom]:
            look = looks[self._world.indices.owner[geom.objid]]
            geom.rgba[:] = (*(look.scatters * share for share in look.colour), 1.0)
            geom.emission = geom.specular = geom.shininess = geom.reflectance = 0.0
        view.nlight, light = 1, view.lights[0]
        light.headlight = light.castshadow = 0
        light.type = flag(self._mj, "mjtLightType", "mjLIGHT_DIRECTIONAL")
        light.dir[:] = -np.array(sun.towards_W)
        light.ambient[:], light.diffuse[:], light.specular[:] = sun.sky / scale, direct / scale, 0.0
        _, shades = self._pass(camera, numbered=False)
        through = np.array([*(1.0 - look.scatters for look in looks), 1.0])[body]
        painted: Floats = np.where((body >= 0)[..., None], shades * (scale / 255.0), 0.0) + (sun.sky * through)[..., None]
        return painted

    def _surface(self, camera: Camera) -> tuple[Any, Any, Any]:
        """Context, renderer and scene of a window in which the picture has room. Raises: Unsupported."""
        mj, buffer = self._mj, self._m.vis.global_
        if self._window is not None and camera.width <= buffer.offwidth and camera.height <= buffer.offheight:
            return self._window
        self.close()
        # One sample a pixel: the depth of several is that of any of them. Spheres are drawn as polyhedra, here fine ones.
        quality = self._m.vis.quality
        quality.offsamples, quality.numslices, quality.numstacks = 0, SLICES, SLICES // 2
        buffer.offwidth, buffer.offheight = max(camera.width, buffer.offwidth), max(camera.height, buffer.offheight)
        try:
            from mujoco.egl import GLContext

            gl = GLContext(buffer.offwidth, buffer.offheight)
            gl.make_current()
            context = mj.MjrContext(self._m, mj.mjtFontScale.mjFONTSCALE_100.value)
            mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        except Exception as error:
            raise Unsupported(
                "render", f"no OpenGL context through EGL on this machine ({type(error).__name__}: {error})"
            ) from error
        context.readDepthMap = mj.mjtDepthMap.mjDEPTH_ZEROFAR
        view = mj.MjvScene(self._m, max(1000, 2 * self._m.ngeom + 100))
        for effect in ("SHADOW", "REFLECTION", "HAZE", "FOG", "SKYBOX"):
            view.flags[getattr(mj.mjtRndFlag, f"mjRND_{effect}")] = 0
        self._window = (gl, context, view)
        return self._window

    def _aim(self, view: Any, camera: Camera, near: float, far: float) -> None:
        """The pinhole of `camera`: along +z of S, x right, y down."""
        indices, d = self._world.indices, self._world.state
        p_WB, q_WB = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
        if camera.body != WORLD:
            k = self._world.scene.index(camera.body)
            body = indices.body[k]
            p_WB, q_WB = d.xpos[body], d.xquat[body]
            if indices.q_MB is not None:
                q_WB = products(q_WB[None], indices.q_MB[k][None])[0]
        R_WB = matrix(q_WB)
        R_WS = R_WB @ matrix(camera.q_BS)
        left, right = -camera.centre_x / camera.focal_x * near, (camera.width - camera.centre_x) / camera.focal_x * near
        for eye in view.camera:
            eye.pos[:], eye.forward[:], eye.up[:] = p_WB + R_WB @ camera.p_BS, R_WS[:, 2], -R_WS[:, 1]
            eye.frustum_near, eye.frustum_far = near, far
            eye.frustum_center, eye.frustum_width = (left + right) / 2, (right - left) / 2
            eye.frustum_top = camera.centre_y / camera.focal_y * near
            eye.frustum_bottom = -(camera.height - camera.centre_y) / camera.focal_y * near

    def close(self) -> None:
        """Free the window, if there is one."""
        if self._window is not None:
            gl, context, _ = self._window
            self._window = None
            gl.make_current()
            context.free()
            gl.free()
