"""A zoo of four robots of our own, in a package that is installed for the tests alone: nothing is fetched."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from plumbline.harness.study.zoo import robots
from plumbline.harness.study.zoo.robots import ZooRobot
from tests.robot_files import INERTIAL, mjcf, urdf

__all__ = ["FILES", "NAME", "listing", "tiny_zoo"]

NAME = "tiny-zoo"
FILES = {
    "arm.urdf": urdf(base=INERTIAL),
    "pair.xml": mjcf(
        '<joint name="upper" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.4 0 -0.3" size=".05"/>'
        '<body name="hand" pos="0.4 0 -0.3"><joint name="lower" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0.2 0 -0.1" size=".03"/></body>',
        beside='<equality><joint joint1="lower" joint2="upper" polycoef="0 1 0 0 0"/></equality>',
    ),
    "dropped.xml": mjcf('<freejoint name="root"/><geom size=".1"/>'),
    "broken.urdf": "<robot name='broken'><link name='a'/><link name='a'/></robot>",
}
"""One that all engines take, one whose joints are coupled, one that falls, one that is refused."""


def listing(folder: Path) -> Path:
    """The list of these robots, and of one whose package is nowhere."""
    rows = [
        f'[[packages.robots]]\nname = "{file.partition(".")[0]}"\ntitle = "A robot, {file}"\nfile = "{file}"\n'
        + ('companion = { root = "fixed" }\n' if file.endswith(".urdf") else "")
        for file in FILES
    ]
    head = '[[packages]]\ndistribution = "{}"\nunder = "{}"\nlicence = "{}"\n'
    path = folder / "list.toml"
    path.write_text(
        head.format(NAME, "tiny_zoo/files", "MIT")
        + "\n".join(rows)
        + head.format("no-such-zoo", "files", "MIT")
        + '[[packages.robots]]\nname = "away"\ntitle = "A robot that is away"\nfile = "away.urdf"\nlicence = "ISC"\n',
        encoding="utf-8",
    )
    return path


@contextmanager
def tiny_zoo(folder: Path) -> Iterator[list[ZooRobot]]:
    """The robots, while their package is installed in a folder of its own."""
    site = folder / "site"
    files, about = site / "tiny_zoo" / "files", site / "tiny_zoo-1.5.dist-info"
    for each in (files, about):
        each.mkdir(parents=True)
    for name, text in FILES.items():
        (files / name).write_text(text, encoding="utf-8")
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {NAME}\nVersion: 1.5\n", encoding="utf-8")
    sys.path.append(str(site))
    try:
        yield robots.robots(listing(folder))
    finally:
        sys.path.remove(str(site))
