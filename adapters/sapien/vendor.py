"""SAPIEN as it comes: the module loaded late, poses in its words, and a new world of PhysX."""

import importlib
import warnings
from typing import Any

from plumbline.harness.adapter import Settings, Unavailable
from plumbline.harness.scene import Quaternion, Vector3


def load() -> Any:
    """The module sapien. Raises: Unavailable."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that there is no Vulkan, which nothing is drawn with here
            importlib.import_module("sapien.physx")
            return importlib.import_module("sapien")
    except ImportError as error:
        raise Unavailable(f"sapien cannot be imported ({error}); install sapien 3.0.3 or later") from error


def pose(sapien: Any, p: Vector3, q: Quaternion) -> Any:
    """The pose of origin p [m], turned by the unit quaternion q = (w, x, y, z)."""
    return sapien.Pose(list(p), list(q))


def new_world(sapien: Any, gravity: Vector3, used: Settings) -> tuple[Any, Any]:
    """An empty scene and its system of PhysX. What is told here is one for the process, and read as a world is made."""
    physx, options = sapien.physx, used.options
    physx.set_scene_config(
        gravity=list(gravity),
        bounce_threshold=options["bounce_threshold"],
        enable_tgs=used.solver == "tgs",
        enable_enhanced_determinism=options["determinism"],
        cpu_workers=0,
    )
    physx.set_body_config(
        solver_position_iterations=used.iterations,
        solver_velocity_iterations=options["velocity_iterations"],
        sleep_threshold=0.005 if options["sleeping"] else 0.0,
    )
    physx.set_shape_config(contact_offset=options["contact_offset"], rest_offset=0.0)
    system = physx.PhysxCpuSystem()
    system.timestep = used.substep
    return sapien.Scene([system]), system
