"""A badge: in a page's corner, whether anything got worse."""

from collections.abc import Collection

from plumbline.harness.findings.changes.values import ANSWERS, Changes

_LABEL = "plumbline"
_WIDTH, _PADDING, _HEIGHT = 7, 12, 20
"""Pixels of a letter, around a word, and of all of it."""
_WORSE, _BETTER, _SAME = "#b3261e", "#2e6da4", "#2e7d32"
"""White on each has a contrast of 4.5 to 1 or more."""


def badge(changes: Changes, gated: Collection[str] = ()) -> str:
    """An SVG with a title that says the same; without gated engines, all of them count."""
    worse = len(changes.regressions(gated)) if gated else sum(row.regression for row in changes.rows)
    better = sum(row.sense == "better" and row.kind in ANSWERS for row in changes.rows)
    message = f"{worse} worse" if worse else f"{better} better" if better else "no change"
    colour = _WORSE if worse else _BETTER if better else _SAME
    left, right = (len(text) * _WIDTH + _PADDING for text in (_LABEL, message))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + right}" height="{_HEIGHT}" role="img" '
        f'aria-label="{_LABEL}: {message}"><title>{_LABEL}: {message}</title>'
        f'<rect width="{left}" height="{_HEIGHT}" fill="#444"/>'
        f'<rect x="{left}" width="{right}" height="{_HEIGHT}" fill="{colour}"/>'
        f'<g fill="#fff" text-anchor="middle" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11">'
        f'<text x="{left / 2}" y="14">{_LABEL}</text><text x="{left + right / 2}" y="14">{message}</text></g></svg>\n'
    )
