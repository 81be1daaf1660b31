"""A case made of a scene file of the user's own: no truth is known of it, so that engines are asked where they end and who
agrees.

What a run shows of itself is observed beside that: balances of energy and momentum, gaps of joints, depths, laws of contact.
They stay defined where no two runs can be compared any more.
"""

from pathlib import Path

from harness.case import Case, Check
from harness.metrics import contact_residuals, divergence, energy, joint_gap, limits, momentum, penetration
from harness.scene import Effect, Scene
from harness.scene.file import load
from harness.scene.importers.companion import beside, load_companion

__all__ = ["HEADLINE", "LADDER", "OBSERVED", "own_case", "title_of"]

HEADLINE = "distance_from_limit"
"""Not measured in a trial: how far it is from what all end at is known when all have run (`harness.findings.agreement`)."""
LADDER = (1 / 240, 1 / 480, 1 / 960)
"""The time steps [s] that a ladder begins with; it goes on from there (`harness.search.refined_ladder`)."""
OBSERVED = (
    *energy.METRIC,
    momentum.MOMENTUM_MAX,
    momentum.ANGULAR_MOMENTUM_MAX,
    joint_gap.JOINT_GAP_MAX,
    limits.LIMIT_OVERSHOOT_MAX,
    penetration.PENETRATION,
    *contact_residuals.METRIC,
)


def title_of(path: Path) -> str:
    """'My arm' of my_arm.toml."""
    words = " ".join(path.stem.replace("_", " ").replace("-", " ").split()) or path.stem
    return words[:1].upper() + words[1:]


def own_case(path: Path, prefix: str, duration: float = 5.0) -> Case:
    """The case that asks every engine to carry a scene file through `duration` [s]; its name is `prefix` and the path.

    What the companion file beside it, `NAME.plumb.toml`, says of the duration goes before.

    Raises:
        SceneError: where the file is no scene. RobotError: where its companion is none.
    """
    scene: Scene = load(path)
    duration = load_companion(beside(path)).duration or duration
    return Case(
        name=f"{prefix}{path}",
        title=title_of(path),
        question="Where does each engine end as its time step goes to zero, who agrees with whom, and at what cost?",
        source=f"the file {path.name}",
        truth="agreed limit",
        scene=lambda: scene,
        checks=(
            Check(
                metric=divergence.METRIC,
                at_most=0.0,
                because="every number of every sampled state has to be finite; whether it is right, engines have to agree on",
            ),
        ),
        observe=OBSERVED,
        duration=duration,
        headline=HEADLINE,
        ladder=LADDER,
        with_contacts=Effect.CONTACT in scene.effects,
    )
