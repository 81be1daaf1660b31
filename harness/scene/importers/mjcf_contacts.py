"""MJCF's contact filtering by bit masks, and friction per geom, as laws per pair of contact keys.

Two geoms touch where the type of one and the affinity of the other share a bit. Their friction is the larger one, number by
number, or that of the geom of higher priority; whether they slide, twist and roll follows the larger dimension likewise.
Source: MuJoCo, "Computation", collision detection; "Modeling", contact parameters.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from plumbline.harness.scene import Surface
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.mjcf_model import Model
from plumbline.harness.scene.importers.robot import ContactRules


@dataclass(frozen=True, slots=True)
class _Sort:
    """What tells geoms apart for contacts. Terms: alone: the geom's own place, where a <pair> names it; -1 elsewhere."""

    contype: int
    conaffinity: int
    condim: int
    priority: int
    friction: tuple[float, float, float]
    alone: int


def read(model: Model, names: list[str]) -> tuple[dict[int, str], ContactRules, list[Fidelity]]:
    """The contact key of each geom that can touch, the laws between keys, what is said of contacts. Args: names of bodies."""
    count = len(model.geom_type)
    if model.flag("contact") or model.flag("constraint"):
        rows = Fidelity.exact("geom", "", count=count, consequence="the file switches contacts off")
        return {}, ContactRules(), rows
    paired = {int(k) for k in (*model.pair_geom1, *model.pair_geom2)}
    sorts: dict[int, _Sort] = {}
    for k in range(count):
        if model.geom_contype[k] or model.geom_conaffinity[k] or k in paired:
            sorts[k] = _Sort(
                int(model.geom_contype[k]),
                int(model.geom_conaffinity[k]),
                int(model.geom_condim[k]),
                int(model.geom_priority[k]),
                (float(model.geom_friction[k][0]), float(model.geom_friction[k][1]), float(model.geom_friction[k][2])),
                k if k in paired else -1,
            )
    keys = {
        sort: ("robot" if number == 0 else f"robot_{number + 1}") for number, sort in enumerate(dict.fromkeys(sorts.values()))
    }
    laws = {frozenset((keys[a], keys[b])): law for a, b in combinations_with_replacement(keys, 2) if (law := _law(a, b, keys))}
    paired_laws = _pairs(model, sorts, keys)
    laws |= paired_laws
    contacts = ContactRules(
        laws=tuple(laws.values()),
        excluded=tuple((names[int(s) >> 16], names[int(s) & 0xFFFF]) for s in model.exclude_signature),
        paired=frozenset(paired_laws),
    )
    return {k: keys[sort] for k, sort in sorts.items()}, contacts, _rows(model, sorts, count)


def _law(a: _Sort, b: _Sort, keys: dict[_Sort, str]) -> Surface | None:
    if not (a.contype & b.conaffinity or b.contype & a.conaffinity):
        return None
    if a.priority != b.priority:
        chosen = a if a.priority > b.priority else b
        friction, dimension = chosen.friction, chosen.condim
    else:
        friction = (max(a.friction[0], b.friction[0]), max(a.friction[1], b.friction[1]), max(a.friction[2], b.friction[2]))
        dimension = max(a.condim, b.condim)
    return _surface((keys[a], keys[b]), friction, dimension)


def _surface(between: tuple[str, str], friction: tuple[float, float, float], dimension: int) -> Surface:
    slide, twist, roll = friction
    slides = slide if dimension >= 3 else 0.0
    return Surface(
        between=between,
        static_friction=slides,
        kinetic_friction=slides,
        torsional_friction=twist if dimension >= 4 else 0.0,
        rolling_friction=roll if dimension >= 6 else 0.0,
    )


def _pairs(model: Model, sorts: dict[int, _Sort], keys: dict[_Sort, str]) -> dict[frozenset[str], Surface]:
    """The laws of <pair>, which hold whatever the masks say."""
    surfaces = {}
    for k in range(len(model.pair_geom1)):
        a, b = keys[sorts[int(model.pair_geom1[k])]], keys[sorts[int(model.pair_geom2[k])]]
        mu = model.pair_friction[k]
        friction = (float(mu[0]), float(mu[2]), float(mu[3]))
        surfaces[frozenset((a, b))] = _surface((a, b), friction, int(model.pair_dim[k]))
    return surfaces


def _rows(model: Model, sorts: dict[int, _Sort], count: int) -> list[Fidelity]:
    rows, colliding = list[Fidelity](), len(sorts)
    masks = {(sort.contype, sort.conaffinity) for sort in sorts.values()}
    choosy = {(t, a) for t, a in masks if not all(t & affinity or contype & a for contype, affinity in masks)}
    masked = [model.name("geom", k) for k, sort in sorts.items() if (sort.contype, sort.conaffinity) in choosy]
    rows += Fidelity.exact("contype, conaffinity", masked, "materials, of which some pairs never touch")
    if count > colliding:
        rows += Fidelity.told("geom of no contact", "of no contact", count=count - colliding)
    if colliding:
        rows += Fidelity.left_out("solref, solimp", "", "how soft a contact is and how fast it rebounds is each engine's own")
    away = [model.name("geom", k) for k in np.flatnonzero((model.geom_margin != 0) | (model.geom_gap != 0))]
    if away:
        rows += Fidelity.told("margin", away, float(np.abs(model.geom_margin).max()))
    return rows
