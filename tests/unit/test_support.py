"""What is said of each engine before a run: it runs, or what it lacks."""

from dataclasses import fields, replace

from plumbline.harness.adapter import Feature
from plumbline.harness.adapter.features import features_of
from plumbline.harness.cli.run_study import support_lines
from plumbline.harness.study import plugins


def test_one_scene_runs_or_cannot_with_the_reason() -> None:
    case, adapter = plugins.case("friction_rolling_resistance"), plugins.adapter("reference")
    lacking = replace(adapter, name="lame", features=adapter.features & ~Feature.ROLLING_FRICTION)
    first, second = support_lines({case.name: case}, {"reference": adapter, "lame": lacking})
    assert first.startswith("reference ")
    assert first.endswith(": runs")
    assert second.startswith("lame ")
    assert second.endswith(": cannot: it lacks rolling_friction")


def test_what_a_robot_s_user_can_leave_out_is_said_by_its_option() -> None:
    case, adapter = plugins.case("joint_pendulum"), plugins.adapter("reference")
    (joint,) = case.scene(case.parameters).joints
    heavy = replace(case.scene(case.parameters), joints=(replace(joint, armature=0.1, friction_loss=0.1),))
    robot = {case.name: replace(case, scene=lambda _: heavy)}
    lame = {"lame": replace(adapter, features=adapter.features & ~(Feature.ARMATURE | Feature.FRICTION_LOSS))}
    (line,) = support_lines(robot, lame, droppable=True)
    assert line.endswith(": cannot: it lacks armature, friction_loss; it runs with --drop armature --drop friction_loss")
    assert support_lines(robot, lame)[0].endswith("it lacks armature, friction_loss")
    worse = {"lame": replace(lame["lame"], features=lame["lame"].features & ~Feature.REVOLUTE)}
    assert "--drop" not in support_lines(robot, worse, droppable=True)[0]


def test_of_many_scenes_counts_are_said_and_each_reason_once() -> None:
    names = ("flight_projectile", "friction_rolling_resistance", "stack_tower", "joint_pendulum")
    cases = {name: plugins.case(name) for name in names}
    adapter = plugins.adapter("reference")
    contact = [name for name, case in cases.items() if Feature.BOX in features_of(case.scene(case.parameters))]
    (line,) = support_lines(cases, {"reference": replace(adapter, features=adapter.features & ~Feature.BOX)})
    assert contact
    assert line.endswith(f": runs {4 - len(contact)} of 4 cases; lacks box ({len(contact)})")


def test_an_engine_that_is_not_there_says_why() -> None:
    case, adapter = plugins.case("flight_projectile"), plugins.adapter("reference")

    class Absent(type(adapter)):  # type: ignore[misc]
        def version(self) -> str:
            raise ImportError("no module named 'absent'")

    absent = Absent(**{field.name: getattr(adapter, field.name) for field in fields(adapter)})
    (line,) = support_lines({case.name: case}, {"absent": absent})
    assert line.startswith("absent: cannot: ")
    assert "no module named 'absent'" in line
