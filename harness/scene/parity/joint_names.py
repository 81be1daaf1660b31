"""A file that says which joint of one robot is which of another: TOML, a table `joints` of names in A to names in B."""

from pathlib import Path

from plumbline.harness.intake.documents import InputError, document, named
from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene.parity.facts import RobotFacts


def joint_names(path: Path, a: RobotFacts, b: RobotFacts) -> dict[str, str]:
    """A's names by B's. Raises: RobotError, naming the file, the joint and those that there are."""
    where = named(path)
    try:
        content = document(path)
    except InputError as error:
        raise RobotError(str(error)) from None
    table = content.get("joints") if isinstance(content, dict) else None
    if not isinstance(table, dict) or len(content) != 1:
        raise RobotError(f'{where}: expected one table, [joints], with a line "name in A" = "name in B" for each joint')
    names: dict[str, str] = {}
    for name_A, name_B in table.items():
        for side, name, robot in (("A", name_A, a), ("B", name_B, b)):
            known = [joint.name for joint in robot.joints]
            if not isinstance(name, str) or name not in known:
                shown = quoted(str(name), 80)
                hint = did_you_mean(str(name), known)
                raise RobotError(f"{where}: joints > {shown} is no joint of {side}, expected one of {listed(known, 12)}{hint}")
        if name_B in names:
            raise RobotError(f"{where}: joints > {quoted(name_B, 80)} of B is given twice, expected once")
        names[name_B] = name_A
    return names
