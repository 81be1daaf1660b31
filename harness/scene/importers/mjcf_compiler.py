"""MuJoCo's own compiler in a process of its own: a folder with model.xml in, out come its arrays, or what it says.

Run as a file, not imported: nothing of ours is loaded, memory and time are bounded, and a crash of the compiler costs nothing
but this process. Nothing is simulated here; the compiler stands where another format has a parser.
"""

import json
import sys
from pathlib import Path
from typing import Any

ARRAYS = (
    "body_parentid", "body_pos", "body_quat", "body_mass", "body_inertia", "body_ipos", "body_iquat", "body_jntadr",
    "body_jntnum", "body_mocapid", "body_gravcomp", "jnt_type", "jnt_pos", "jnt_axis", "jnt_range", "jnt_limited",
    "jnt_stiffness", "jnt_stiffnesspoly", "jnt_springyield", "jnt_qposadr", "jnt_dofadr", "jnt_actfrclimited",
    "jnt_actfrcrange", "jnt_margin", "jnt_solref", "jnt_solimp", "dof_armature", "dof_damping", "dof_dampingpoly",
    "dof_frictionloss", "qpos0", "qpos_spring", "geom_type", "geom_size", "geom_pos", "geom_quat", "geom_bodyid",
    "geom_contype", "geom_conaffinity", "geom_condim", "geom_friction", "geom_priority", "geom_dataid", "geom_margin",
    "geom_gap", "geom_solref", "geom_solimp", "geom_solmix", "geom_adhesion", "geom_surfacevel", "pair_geom1", "pair_geom2",
    "pair_dim", "pair_friction", "pair_adhesion", "exclude_signature", "eq_type", "eq_obj1id", "eq_obj2id", "eq_objtype",
    "eq_active0", "eq_data", "eq_solref", "site_bodyid", "site_pos", "actuator_trntype", "actuator_trnid", "actuator_gear",
    "actuator_gaintype", "actuator_gainprm", "actuator_biastype", "actuator_biasprm", "actuator_dyntype",
    "actuator_forcelimited", "actuator_forcerange", "actuator_ctrllimited", "actuator_ctrlrange", "actuator_ctrladr",
    "actuator_armature", "actuator_damping", "tendon_stiffness", "tendon_damping", "tendon_frictionloss", "tendon_limited",
    "tendon_armature", "tendon_stiffnesspoly", "tendon_dampingpoly", "tendon_springyield", "tendon_lengthspring",
    "tendon_range", "tendon_actfrclimited", "tendon_actfrcrange", "tendon_adr", "tendon_num", "wrap_type", "wrap_objid",
    "wrap_prm",
    "mesh_vert", "mesh_vertadr", "mesh_vertnum", "mesh_face", "mesh_faceadr", "mesh_facenum",
    "geom_rgba", "geom_matid", "mat_rgba", "key_qpos", "key_qvel", "key_ctrl", "site_quat", "sensor_type", "sensor_objtype",
    "sensor_objid", "sensor_cutoff", "sensor_noise",
    "cam_mode", "cam_bodyid", "cam_pos", "cam_quat", "cam_fovy", "cam_resolution", "cam_sensorsize", "cam_projection",
)  # fmt: skip
"""What is read of a compiled model."""
NAMED = ("body", "joint", "geom", "equality", "actuator", "tendon", "key", "sensor", "camera", "light", "site")
COUNTS = ("nflex", "nplugin", "nskin", "nsensor", "ncam", "nlight", "nsite", "ntex", "nuserdata")
MEMORY = 4 << 30
"""Bytes that the compiler may take."""
CPU = 60
"""Seconds of a core that it may take."""


def compiled() -> dict[str, Any]:
    """The arrays, names and options of model.xml in the present folder. Raises: ValueError, with what the compiler says."""
    import mujoco
    import numpy as np

    model = mujoco.MjSpec.from_file("model.xml").compile()
    kept: dict[str, Any] = {name: np.asarray(getattr(model, name)) for name in ARRAYS}
    option = model.opt
    for name in ("gravity", "wind"):
        kept[f"opt_{name}"] = np.asarray(getattr(option, name))
    for name in ("density", "viscosity", "timestep", "disableflags"):
        kept[f"opt_{name}"] = np.asarray(getattr(option, name))
    for name in COUNTS:
        kept[name] = np.asarray(getattr(model, name))
    names = {
        kind: [
            mujoco.mj_id2name(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), k) or ""
            for k in range(
                getattr(
                    model, {"joint": "njnt", "camera": "ncam", "equality": "neq", "actuator": "nactuator"}.get(kind, f"n{kind}")
                )
            )
        ]
        for kind in NAMED
    }
    enums = {
        kind: {
            member.removeprefix(f"mj{prefix}_").lower(): int(getattr(getattr(mujoco, f"mjt{kind}"), member))
            for member in dir(getattr(mujoco, f"mjt{kind}"))
            if member.startswith(f"mj{prefix}_")
        }
        for kind, prefix in (
            ("Joint", "JNT"),
            ("Geom", "GEOM"),
            ("Eq", "EQ"),
            ("Trn", "TRN"),
            ("Gain", "GAIN"),
            ("Bias", "BIAS"),
            ("Dyn", "DYN"),
            ("Wrap", "WRAP"),
            ("DisableBit", "DSBL"),
            ("Obj", "OBJ"),
            ("Sensor", "SENS"),
            ("CamLight", "CAMLIGHT"),
        )
    }
    kept["words"] = np.frombuffer(
        json.dumps({"names": names, "enums": enums, "version": mujoco.__version__}).encode(), np.uint8
    )
    return kept


def schema() -> str:
    """What this compiler knows, as it prints it; nothing where there is none."""
    try:
        import mujoco
    except ImportError:
        return ""
    return str(mujoco.mj_printSchema(False, False))


def main(folder: str) -> None:
    """Compile what lies in a folder; out.npz or error.txt is there afterwards."""
    import os
    import resource

    os.chdir(folder)
    for limit, value in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CPU, CPU), (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(limit, (value, value))
    import numpy as np

    try:
        kept = compiled()
    except Exception as error:  # whatever the compiler raises is what it has to say
        Path("error.txt").write_text(f"{type(error).__name__}: {error}"[:20_000], encoding="utf-8", errors="replace")
        return
    finally:
        Path("schema.txt").write_text(schema(), encoding="utf-8")
    np.savez("out.npz", allow_pickle=False, **kept)


if __name__ == "__main__":
    main(sys.argv[1])
