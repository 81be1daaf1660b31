"""One colour and one marker shape per engine, the same on every page and in every chart.

Colours after Okabe & Ito, 'Color Universal Design' (2008), two of them darkened until each keeps a contrast of 3:1 (WCAG 2.2,
1.4.11) against the light and against the dark page. Shapes make the colours redundant.
"""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EngineLook:
    """A colour (#rrggbb) and a marker: an SVG path within -1..1, which Vega and HTML both draw."""

    colour: str
    path: str


CIRCLE = "M1,0A1,1,0,1,1,-1,0A1,1,0,1,1,1,0Z"
SQUARE = "M-.89,-.89H.89V.89H-.89Z"
DIAMOND = "M0,-1.2L1.1,0L0,1.2L-1.1,0Z"
TRIANGLE_UP = "M0,-1.1L1.1,.85H-1.1Z"
TRIANGLE_DOWN = "M0,1.1L1.1,-.85H-1.1Z"
CROSS = "M-.38,-1.1H.38V-.38H1.1V.38H.38V1.1H-.38V.38H-1.1V-.38H-.38Z"
PENTAGON = "M0,-1.1L1.05,-.34L.65,.9H-.65L-1.05,-.34Z"
BAR = "M-.45,-1.1H.45V1.1H-.45Z"
HOURGLASS = "M-1,-1H1L.3,0L1,1H-1L-.3,0Z"
FLAT = "M-1.1,-.45H1.1V.45H-1.1Z"

BACKGROUNDS = {"light": "#ffffff", "dark": "#15191f"}
"""What charts stand on; the style sheet uses the same two."""

ENGINES: dict[str, EngineLook] = {
    "reference": EngineLook("#d55e00", DIAMOND),
    "mujoco": EngineLook("#0077bb", CIRCLE),
    "bullet": EngineLook("#009e73", SQUARE),
    "dart": EngineLook("#c0639a", TRIANGLE_UP),
    "sapien": EngineLook("#a87900", TRIANGLE_DOWN),
    "drake": EngineLook("#2e93c9", CROSS),
    "newton": EngineLook("#7f7f8c", PENTAGON),
}
"""The engines that have an adapter here."""

SPARE: tuple[EngineLook, ...] = (
    EngineLook("#8f6bd1", BAR),
    EngineLook("#6b8e23", HOURGLASS),
    EngineLook("#c94c4c", FLAT),
    EngineLook("#a0723c", CIRCLE),
)
"""For engines of third parties, in alphabetical order of their names."""


def looks(names: Iterable[str]) -> dict[str, EngineLook]:
    """A look for each engine, in the order given; spare ones repeat only beyond the last."""
    listed = list(names)
    strangers = sorted(name for name in listed if name not in ENGINES)
    spare = {name: SPARE[index % len(SPARE)] for index, name in enumerate(strangers)}
    return {name: ENGINES.get(name) or spare[name] for name in listed}
