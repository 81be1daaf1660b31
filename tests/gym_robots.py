"""Robots with the structure of those that reinforcement learning began with: planar roots, geared motors, a target on slides.

The keyframe `push` has a motor beyond its range, and others within.
"""

from tests.robot_files import mjcf

__all__ = ["CHEETAH", "REACHER", "SWIMMER", "WALKER"]

_LIMITED = (
    '<compiler angle="radian"/><default><joint limited="true"/><geom conaffinity="0"/>'
    '<motor ctrllimited="true" ctrlrange="-1 1"/></default>'
)
_PLANAR = (
    '<joint name="x" type="slide" axis="1 0 0" limited="false"/><joint name="z" type="slide" axis="0 0 1" limited="false"/>'
    '<joint name="turn" axis="0 1 0" limited="false"/>'
)
_FLOOR = '<geom name="floor" type="plane" size="9 9 1" pos="0 0 -1" conaffinity="1"/>'


def _motors(**gears: float) -> str:
    each = "".join(f'<motor joint="{joint}" gear="{gear}"/>' for joint, gear in gears.items())
    controls = " ".join(("3", "-.5", ".25", "-.75", ".5", "-.25")[: len(gears)])
    return f'{_LIMITED}<actuator>{each}</actuator><keyframe><key name="push" ctrl="{controls}"/></keyframe>'


def _hinge(name: str, lower: float, upper: float, more: str = "") -> str:
    return f'<joint name="{name}" axis="0 1 0" range="{lower} {upper}" {more}/>'


def _capsule(length: float, size: float) -> str:
    return f'<geom type="capsule" fromto="0 0 0 0 0 -{length}" size="{size}"/>'


_SPRINGY = 'stiffness="120" damping="4" armature=".1"'


def _springy_leg(side: str, at: float) -> str:
    return (
        f'<body name="{side}_thigh" pos="{at} 0 0">{_hinge(f"{side}_hip", -0.5, 1.0, _SPRINGY)}{_capsule(0.28, 0.045)}'
        f'<body name="{side}_shin" pos="0 0 -.3">{_hinge(f"{side}_knee", -0.8, 0.8, _SPRINGY)}{_capsule(0.25, 0.04)}'
        f'<body name="{side}_foot" pos="0 0 -.3">{_hinge(f"{side}_ankle", -0.4, 0.8, _SPRINGY)}{_capsule(0.1, 0.04)}'
        "</body></body></body>"
    )


CHEETAH = mjcf(
    _PLANAR
    + '<geom type="capsule" fromto="-.5 0 0 .5 0 0" size=".05"/>'
    + _springy_leg("back", -0.5)
    + _springy_leg("front", 0.5),
    _motors(back_hip=120, back_knee=90, back_ankle=60, front_hip=120, front_knee=60, front_ankle=30),
    _FLOOR,
)


_DAMPED = 'damping=".1"'


def _leg(side: str) -> str:
    return (
        f'<body name="{side}_thigh" pos="0 0 -.2">{_hinge(f"{side}_hip", -2.5, 0.2, _DAMPED)}{_capsule(0.43, 0.05)}'
        f'<body name="{side}_shin" pos="0 0 -.45">{_hinge(f"{side}_knee", -2.5, 0.2, _DAMPED)}{_capsule(0.48, 0.04)}'
        f'<body name="{side}_foot" pos="0 0 -.5">{_hinge(f"{side}_ankle", -0.7, 0.7, _DAMPED)}'
        '<geom type="capsule" fromto="-.05 0 0 .2 0 0" size=".05"/></body></body></body>'
    )


WALKER = mjcf(
    f"{_PLANAR}{_capsule(0.2, 0.05)}{_leg('right')}{_leg('left')}",
    _motors(right_hip=100, right_knee=100, right_ankle=40, left_hip=100, left_knee=100, left_ankle=40),
    _FLOOR,
)
SWIMMER = mjcf(
    '<joint name="x" type="slide" axis="1 0 0" limited="false"/><joint name="y" type="slide" axis="0 1 0" limited="false"/>'
    '<joint name="turn" axis="0 0 1" limited="false"/><geom type="capsule" fromto="1.4 0 0 .6 0 0" size=".1"/>'
    '<body name="middle" pos=".5 0 0"><joint name="first" axis="0 0 1" range="-1.7 1.7"/>'
    '<geom type="capsule" fromto="0 0 0 -.8 0 0" size=".1"/><body name="tail" pos="-1 0 0">'
    '<joint name="second" axis="0 0 1" range="-1.7 1.7"/><geom type="capsule" fromto="0 0 0 -.8 0 0" size=".1"/></body></body>',
    _motors(first=150, second=150) + '<option density="4000" viscosity=".1"/>',
)
REACHER = mjcf(
    '<joint name="shoulder" axis="0 0 1" limited="false" damping="1" armature="1"/>'
    '<geom type="capsule" fromto="0 0 0 .1 0 0" size=".01"/><body name="fore" pos=".1 0 0">'
    '<joint name="elbow" axis="0 0 1" range="-3 3" damping="1" armature="1"/>'
    '<geom type="capsule" fromto="0 0 0 .1 0 0" size=".01" contype="0"/></body>',
    _motors(shoulder=200, elbow=200),
    '<body name="target" pos=".1 -.1 1"><joint name="to_x" type="slide" axis="1 0 0" limited="false"/>'
    '<joint name="to_y" type="slide" axis="0 1 0" limited="false"/>'
    '<geom type="sphere" size=".01" contype="0" conaffinity="0"/></body>',
)
