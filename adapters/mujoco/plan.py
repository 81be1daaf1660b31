"""What a scene means to MuJoCo, worked out before anything of it is made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbline.adapters.mujoco.frames import principal
from plumbline.adapters.mujoco.heavy_loads import impedance_for
from plumbline.adapters.mujoco.options import Options, checked
from plumbline.adapters.mujoco.trees import Link, forest, in_one_body
from plumbline.harness.adapter import Settings
from plumbline.harness.adapter.rolling import CORRECTIONS, balls_alone
from plumbline.harness.adapter.rotations import matrix
from plumbline.harness.scene import Body, Effect, Joint, Quaternion, Scene, Vector3, multiply
from plumbline.harness.trajectory import Floats


@dataclass(frozen=True, slots=True)
class Plan:
    """A scene, its settings and what follows from both.

    Terms:
        effects: the scene's, worked out once. h [s]: the sub-step that is taken. joints: none where the scene does not call for
        them. links: the bodies in their trees, from the roots down; loops: the joints that close loops. chains: as
        `in_one_body`; carrier: of each body the one whose native joints end at it, itself but of one without mass. index: of
        each body its place in the scene. held: the bodies that joints hold. Of each body, in the order of the scene: moments
        [kg m2] about its principal axes, q_BM, q_WM and R_WM of its principal frame M, p [m], its centre of mass in W.
    """

    scene: Scene
    settings: Settings
    options: Options
    effects: Effect
    h: float
    joints: Sequence[Joint]
    links: Sequence[Link]
    loops: Sequence[Joint]
    chains: Mapping[int, Sequence[Link]]
    carrier: Mapping[int, int]
    index: Mapping[str, int]
    held: frozenset[str]
    moments: Sequence[Vector3]
    q_BM: Sequence[Quaternion]
    q_WM: Sequence[Floats]
    R_WM: Sequence[Floats]
    p: Sequence[Floats]

    @classmethod
    def of(cls, scene: Scene, settings: Settings) -> "Plan":
        """The plan of a scene under some settings. Raises: SettingsError."""
        options, effects, h = checked(settings), scene.effects, settings.dt / (settings.substeps or 1)
        if options.by_scene and options.contact_impedance is None and Effect.CONTACT in effects:
            options = replace(options, contact_impedance=impedance_for(scene, options, h))
        if options.rolling_impratio is not None and balls_alone(scene):
            options = replace(
                options, impratio=options.rolling_impratio, noslip_iterations=options.noslip_iterations or CORRECTIONS
            )
        joints = scene.joints if Effect.JOINTS in effects else ()
        links, loops = forest(scene, joints)
        chains = in_one_body(scene, links)
        moments, q_BM = zip(*(principal(body) for body in scene.bodies), strict=True)
        q_WM = [np.array(multiply(body.q_WB, q)) for body, q in zip(scene.bodies, q_BM, strict=True)]
        return cls(
            scene=scene,
            settings=settings,
            options=options,
            effects=effects,
            h=h,
            joints=joints,
            links=links,
            loops=loops,
            chains=chains,
            carrier={link.body: body for body, chain in chains.items() for link in chain},
            index={body.name: k for k, body in enumerate(scene.bodies)},
            held=frozenset(name for joint in scene.joints for name in (joint.parent, joint.child)),
            moments=moments,
            q_BM=q_BM,
            q_WM=q_WM,
            R_WM=[matrix(q) for q in q_WM],
            p=[np.array(body.p_WB) for body in scene.bodies],
        )

    @property
    def speculative(self) -> bool:
        """Are contacts made for the way of the whole step before bodies touch? Unless set, where the scene calls for it."""
        asked = self.options.speculative
        return self.options.by_scene and Effect.CONTINUOUS_COLLISION in self.effects if asked is None else asked

    @property
    def passable(self) -> bool:
        """Does the scene call for continuous collision, and goes without?"""
        return Effect.CONTINUOUS_COLLISION in self.effects and not self.speculative

    def planted(self, body: Body) -> bool:
        """Do its shapes stand in the world's own body? Those of what stands still do, unless a joint holds it.

        MuJoCo searches the shapes of a body by their bounding volumes, and body after body. Source: MuJoCo, XML reference,
        compiler/fusestatic.
        """
        return not (body.movable or self.prescribed(body) or body.name in self.held)

    def prescribed(self, body: Body) -> bool:
        """Is it a kinematic body that moves?"""
        return body.motion == "kinematic" and (any(body.v_WB) or any(body.w_WB) or body.prescribed is not None)
