"""Small robot files for tests: one link on one joint, as URDF and as MJCF, with what a test puts in."""

from pathlib import Path

from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Revolute
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.fidelity import Fidelity, Imported
from plumbline.harness.scene.importers.reading import read

INERTIAL = '<inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>'
BALL = '<geom size=".1"/>'
"""What an MJCF's body weighs."""
LIMIT = '<limit lower="-1" upper="1" effort="5" velocity="3"/>'


def urdf(*inside: str, base: str = "", arm: str = INERTIAL, joint: str = LIMIT, kind: str = "revolute") -> str:
    """A base and an arm on a joint about y, with more elements behind them."""
    return (
        f'<robot name="r">\n<link name="base">{base}</link>\n<link name="arm">{arm}</link>\n'
        f'<joint name="j" type="{kind}"><parent link="base"/><child link="arm"/><origin xyz="0 0 1"/>'
        f'<axis xyz="0 2 0"/>{joint}</joint>\n' + "\n".join(inside) + "</robot>"
    )


def mjcf(body: str, beside: str = "", world: str = "") -> str:
    """A model with one body in the world that holds `body`."""
    return (
        f'<mujoco model="m">\n{beside}\n<worldbody>{world}<body name="arm" pos="0 0 1">\n{body}\n</body></worldbody></mujoco>'
    )


def imported(
    folder: Path, text: str, companion: Companion | None = None, name: str | None = None, **wishes: object
) -> Imported:
    """The import of a text as a file in a folder; a URDF's root is fixed unless told."""
    is_urdf = "<robot" in text
    path = folder / (name or ("robot.urdf" if is_urdf else "robot.xml"))
    path.write_text(text, encoding="utf-8")
    told = companion or Companion()
    if is_urdf and told.root is None and "root" not in wishes and "scenario" not in wishes:
        wishes["root"] = "fixed"
    return read(path, Wishes(**wishes), told)  # type: ignore[arg-type]


def row(got: Imported, element: str, outcome: str | None = None) -> Fidelity:
    """The one row on elements of a kind."""
    (found,) = (one for one in got.fidelity if one.element == element and outcome in (None, one.outcome))
    return found


def joint(got: Imported) -> Revolute:
    """The one joint, of a test that knows it for a hinge or a slider."""
    (found,) = got.scene.joints
    return found  # type: ignore[return-value]
