"""Constant torques in drives: exact on every engine, refused beside motors that hold a velocity, absent where none is told."""

from dataclasses import replace

import pytest

from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.features import features_of
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.scene import WORLD, Body, Drive, Prismatic, Scene
from plumbline.harness.scene.file import dump_json, dump_toml, parse
from tests.conformance.engines import adapter

SLIDE = Prismatic(name="slide", parent=WORLD, child="body", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0))


def pushed(**drive: float) -> Scene:
    """A body of 2 kg on an upright slide with a drive."""
    return Scene(bodies=(Body(name="body", mass=2.0),), joints=(replace(SLIDE, drive=Drive(**drive)),))


@pytest.mark.parametrize("engine", ["reference", "mujoco", "bullet", "dart"])
@pytest.mark.parametrize("track", ["default", "tuned"])
def test_a_motor_that_bears_the_weight_holds_what_it_bears(engine: str, track: str) -> None:
    one = adapter(engine)
    end = Engine(one, one.tracks[track]).final(pushed(feedforward=2.0 * 9.81), 1.0, dt=1 / 240)
    # A force of one part in 2^52 too little lets it fall by 1e-15 m in a second.
    assert end.p_WB[0] == pytest.approx((0.0, 0.0, 0.0), abs=1e-13)
    assert end.v_WB[0] == pytest.approx((0.0, 0.0, 0.0), abs=1e-13)


@pytest.mark.parametrize(("engine", "option"), [("bullet", "motor"), ("dart", "servo")])
def test_a_motor_that_holds_a_velocity_takes_no_torque_beside(engine: str, option: str) -> None:
    one = adapter(engine)
    settings = replace(one.tracks["tuned"], options={**one.tracks["tuned"].options, "drives": option})
    with pytest.raises(Unsupported, match="'slide': feedforward"):
        one.build(pushed(stiffness=10.0, feedforward=1.0), settings)
    assert Engine(one, settings).final(pushed(feedforward=2.0 * 9.81), 0.1, dt=1e-3).p_WB[0] == pytest.approx(
        (0, 0, 0), abs=1e-13
    )


def test_a_drive_without_it_is_written_as_before() -> None:
    plain, constant = pushed(stiffness=1.0), pushed(feedforward=1.5)
    assert "feedforward" not in dump_json(plain) + dump_toml(plain)
    assert parse(dump_toml(constant), "scene.toml") == constant
    assert "feedforward" not in features_of(plain).names
    assert "feedforward" in features_of(constant).names
