"""A recorded robot beside every engine: one row a joint, engine and track, with fits of friction, damping and delay."""

from dataclasses import fields

from plumbline.harness.findings.columns import Column, Table, plain
from plumbline.harness.findings.recorded_robot import JointError, joint_errors, recorded_words


def _explains(name: str) -> Column:
    return Column("explains", lambda row: f"{100 * row[f'{name}_explains']:.0f} %")


TABLE = Table(
    columns=tuple(field.name for field in fields(JointError)),
    objects=joint_errors,
    shown=(
        *plain("engine", "track", "joint"),
        Column("rms", lambda row: f"{row['rms']:.3g} {row['unit']}"),
        Column("largest", "largest", ".3g"),
        Column("friction (fit)", "friction", ".3g"),
        _explains("friction"),
        Column("damping (fit)", "damping", ".3g"),
        _explains("damping"),
        Column("delay (fit)", "delay", ".3g", " s"),
        _explains("delay"),
    ),
    sentences=lambda rows: recorded_words([JointError(**row) for row in rows], {}),
)
"""The rows."""
