"""A case made of a scene file of the user's own: no truth is known of it, so that engines are asked where they end and who
agrees.

What a run shows of itself is observed beside that: balances of energy and momentum, gaps of joints, depths, laws of contact.
They stay defined where no two runs can be compared any more.
"""

from pathlib import Path

from plumbline.harness.case import Case, Check
from plumbline.harness.case.undropped import kinds_left_out, title_of, undropped_scene
from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError
from plumbline.harness.metrics import conservation, contacts, errors, joints, readings
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.scene.importers.companion import beside, load_companion
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.sensors.recorder import steps_between_readings, steps_of_latency

HEADLINE = "distance_from_limit"
"""Not measured in a trial: how far it is from what all end at is known when all have run (`harness.findings.agreement`)."""
DURATION = 5.0
"""How long a scene runs [s] whose companion says nothing of it."""
LADDER = (1 / 240, 1 / 480, 1 / 960)
"""The time steps [s] that a ladder begins with; it goes on from there (`harness.search.refined_ladder`). A companion's own
`dt` is the first, and the others are the same parts of it."""
SAMPLED = 1 / 60
"""About how far apart samples are [s]."""
OBSERVED = (
    conservation.energy_drift_max,
    conservation.energy_drift_final,
    conservation.energy_drift_staggered_max,
    conservation.energy_gain_max,
    conservation.energy_growth_rate,
    conservation.energy_rise_max,
    conservation.held_energy_gain_max,
    conservation.momentum_drift_max,
    conservation.angular_momentum_drift_max,
    joints.joint_gap_max,
    joints.limit_overshoot_max,
    contacts.penetration,
    contacts.signorini_residual,
    contacts.cone_residual,
    contacts.dissipation_residual,
)


def own_case(path: Path, prefix: str, duration: float = DURATION) -> Case:
    """The case that asks every engine to carry a scene file through `duration` [s]; its name is `prefix` and the path.

    What the companion file beside it, `NAME.plumb.toml`, says of duration, time step and commands goes before.

    Raises:
        SceneError: where the file is no scene. RobotError: where its companion is none, or a sensor cannot be read at the step.
    """
    companion = load_companion(beside(path))
    scene: Scene = read(path, companion=companion).scene
    duration, dt = companion.duration or duration, companion.dt or LADDER[0]
    _check_rates(scene, dt, named(path))
    whole = undropped_scene(path)
    return Case(
        name=f"{prefix}{path}",
        title=title_of(path),
        question="Where does each engine end as its time step goes to zero, who agrees with whom, and at what cost?",
        source=f"the file {path.name}",
        truth="agreed limit",
        scene=lambda _: scene,
        checks=(
            Check(
                errors.divergence,
                0.0,
                "every number of every sampled state has to be finite; whether it is right, engines have to agree on",
            ),
        ),
        observe=(*OBSERVED, readings.gyroscope_off_motion, readings.range_off_geometry) if scene.sensors else OBSERVED,
        duration=duration,
        dt=dt,
        # Whole steps, so that the runs of all steps are sampled at the same instants.
        sample_interval=dt * max(1, round(SAMPLED / dt)),
        headline=HEADLINE,
        ladder=tuple(dt / (LADDER[0] / step) for step in LADDER),
        with_contacts=Effect.CONTACT in scene.effects,
        undropped=whole if whole is not None and kinds_left_out(scene, whole) else None,
    )


def _check_rates(scene: Scene, dt: float, where: str) -> None:
    """Refuse sensors that are not read at whole numbers of the coarsest steps. Raises: RobotError."""
    for sensor in scene.sensors:
        try:
            steps_between_readings(sensor, dt)
            steps_of_latency(sensor, dt)
        except ValueError as error:
            raise RobotError(f"{where}: {error}; --dt X sets another step") from None
