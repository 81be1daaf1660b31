"""MJCF's sensors: accelerometers and gyroscopes as inertial units, range finders as single beams; the others are left out.

MuJoCo reads its sensors at every step, whatever the step is; here they are read RATE times a second. The noise that a file
states is left out by MuJoCo itself, and here.
"""

from collections.abc import Sequence

import numpy as np

from plumbline.harness.scene import Imu, Lidar, Sensor, axis_angle, multiply
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.poses import matrix, quaternion, vector

RATE = 240.0
"""Readings a second: one each coarsest step of a run of one's own scene."""
FARTHEST = 100.0
"""How far a range finder reaches whose file does not say [m]."""
_INERTIAL = ("accelerometer", "gyro")
_ALONG_Z = axis_angle((0.0, 1.0, 0.0), -np.pi / 2)
"""Turns the first beam of a range finder, x, into MuJoCo's, the site's z."""


def read(model: Model, names: Sequence[str]) -> tuple[tuple[Sensor, ...], list[Fidelity]]:
    """The sensors with the link of their site for a body, and what became of all of them. Args: names: of the links."""
    sensors: list[Sensor] = []
    units: dict[int, str] = {}
    beams: list[str] = []
    others: dict[str, list[str]] = {}
    for k, raw in enumerate(model.sensor_type):
        word, name, site = model.word("Sensor", int(raw)), model.name("sensor", k), int(model.sensor_objid[k])
        at_site = model.word("Obj", int(model.sensor_objtype[k])) == "site" and site >= 0
        if word in _INERTIAL and at_site:
            units.setdefault(site, name)
        elif word == "rangefinder" and at_site:
            beams.append(name)
            reach = float(model.sensor_cutoff[k]) or FARTHEST
            link, p, q = _mount(model, site, names)
            turned = multiply(q, _ALONG_Z)
            sensors.append(
                Lidar(
                    name=name,
                    body=link,
                    rate=RATE,
                    p_BS=p,
                    q_BS=turned,
                    channels=1,
                    columns=1,
                    elevation_low=0.0,
                    elevation_high=0.0,
                    max_range=reach,
                )
            )
        else:
            others.setdefault(word, []).append(name)
    for site, name in units.items():
        link, p, q = _mount(model, site, names)
        sensors.append(Imu(name=name, body=link, rate=RATE, p_BS=p, q_BS=q))
    return tuple(sensors), _rows(list(units.values()), beams, others)


def _mount(
    model: Model, site: int, names: Sequence[str]
) -> tuple[str, tuple[float, float, float], tuple[float, float, float, float]]:
    return (
        names[int(model.site_bodyid[site])],
        vector(np.array(model.site_pos[site], dtype=np.float64)),
        quaternion(matrix(model.site_quat[site])),
    )


def _rows(units: list[str], beams: list[str], others: dict[str, list[str]]) -> list[Fidelity]:
    rows = []
    for names, becomes in ((units, "an inertial unit without noise"), (beams, "a range finder of one beam")):
        if names:
            rows += Fidelity.approximated(
                "sensor",
                names,
                becomes,
                consequence="MuJoCo reads it at every step; here it is read at a rate of",
                value=RATE,
                unit="Hz",
            )
    for word, names in others.items():
        rows += Fidelity.left_out(f"sensor {word}", names, "it measures, and moves nothing")
    return rows
