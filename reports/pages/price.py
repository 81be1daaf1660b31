"""The page on price: what accuracy costs in time, how often each engine gives it, and how far it may step for it."""

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.cost_point import ALIKE
from plumbline.harness.findings.prices import priced
from plumbline.harness.findings.standing import pair_leads
from plumbline.harness.findings.tables.profile import FACTOR, TIME, hinges, profile, without
from plumbline.harness.findings.tables.steps import largest_steps
from plumbline.harness.store.store import Store
from plumbline.reports.charts.largest_steps import allowances, steps_chart
from plumbline.reports.charts.marks import TRACKS
from plumbline.reports.charts.performance_profile import profile_chart
from plumbline.reports.charts.work_precision import miniatures
from plumbline.reports.html.template import filled_page
from plumbline.reports.tables.limit_table import standings
from plumbline.reports.tables.price_list import SHOWN, price_list, scenes, tried, wins
from plumbline.reports.words.catalogue import ours
from plumbline.reports.words.text import power

FEW = 40
"""Rows of a table that stand open; more fold."""


def concerns(store: Store) -> bool:
    """Only where a setting was clocked at several time steps: a price lies between two of them."""
    steps = {((s.name, p.engine, p.track), p.dt) for s in scenes(store) for p in s.points if p.clocked}
    return max(Counter(setting for setting, _ in steps).values(), default=0) > 1


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    prices = priced(store).prices
    shares, steps = profile(prices), largest_steps(store)
    profiles = [figure for limit in (FACTOR, TIME) if (figure := profile_chart(store, shares, limit)) is not None]
    largest = steps_chart(store, steps)
    return {
        "wins": wins(prices),
        "standings": standings(pair_leads(prices, priced(store).points)),
        "hinges": [
            (row, *without(row))
            for row in hinges(share for share in shares if share.limit == FACTOR and share.engine not in ours(store))
        ],
        "profiles": profiles,
        "lines": price_list(store),
        "tried": tried(store),
        "alike": ALIKE,
        "first": power(round(math.log10(SHOWN))),
        "miniatures": miniatures(store),
        "largest": largest,
        "allowances": allowances(store, steps),
        "tracks": TRACKS,
        "few": FEW,
    }


PAGE = filled_page("price", "Price", 10, told, tables=("price", "profile", "steps"), concerns=concerns)
