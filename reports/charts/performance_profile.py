"""The charts of the performance profile: the share of answers over what they may cost, engine beside engine."""

from collections.abc import Sequence

from plumbline.harness.findings.tables.profile import FACTOR, TIME, Share
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled
from plumbline.reports.charts.grammar import Row, channel, chart, hovering
from plumbline.reports.charts.marks import POINT, SHARES, Marks, decades, finished, logarithmic
from plumbline.reports.words.catalogue import labels, titled
from plumbline.reports.words.text import amount

AXES = {FACTOR: "times the CPU time of the fastest", TIME: "CPU time per simulated second [s]"}


def profile_chart(store: Store, shares: Sequence[Share], limit: str) -> Figure | None:
    """One line an engine, with the band that leaving one case out spans; None without a share, and none over the fastest where
    one engine alone has any."""
    if limit == FACTOR and len({share.engine for share in shares if share.share > 0}) < 2:
        return None
    reached = {share.within for share in shares if share.limit == limit and share.share > 0}
    rows: list[Row] = [
        {
            "engine": labels(store)[share.engine],
            "track": "tuned",
            "within": share.within,
            "share": share.share,
            "low": share.low,
            "high": share.high,
            "without_low": titled(store, *share.without_low),
            "without_high": titled(store, *share.without_high),
        }
        for share in shares
        if share.limit == limit and share.within in reached
    ]
    if not rows:
        return None
    factor = limit == FACTOR
    style = Marks(store, rows)
    x = logarithmic("within", AXES[limit], decades(row["within"] for row in rows))
    scale = {"domain": [0, 1], "nice": False, "padding": 6}
    y = channel("share:Q", title="share of the cases", scale=scale, axis=SHARES)
    low = channel("low:Q", title="share of the cases", scale=scale)
    shape = channel("engine:N", title=None, scale={"domain": style.engines, "range": style.paths})
    tooltips = hovering(
        "engine:N",
        ("within:Q", AXES[limit], ".3~g"),
        ("share:Q", "", ".1%"),
        ("low:Q", "least, one case left out", ".1%"),
        ("without_low:N", "without"),
        ("high:Q", "most, one case left out", ".1%"),
        ("without_high:N", "without "),
    )
    layers = [
        chart(rows).marked("line", strokeWidth=1.8).encode(x=x, y=y, detail="engine:N", color=style.colour()),
        chart(rows)
        .marked("point", **POINT | {"size": 45})
        .encode(x=x, y=y, color=style.colour(), shape=shape, tooltip=tooltips),
        chart(rows).marked("area", opacity=0.18).encode(x=x, y=low, y2="high:Q", detail="engine:N", color=style.colour()),
    ]
    pairs = max(share.pairs for share in shares if share.limit == limit)
    caption = (
        "Higher is better; at 1: how often an engine is the fastest to deploy."
        if factor
        else "Higher is better; 1 is real time."
    )
    how = (
        f"The share of {pairs} pairs of case and error, each reached by at least one engine to deploy, that an engine answers "
        f"within {'so many times the cheapest price' if factor else 'so much CPU time'}. At the right: how often it gets there "
        "at all. Bands span the shares with one case left out."
    )
    table = tabled(
        rows,
        "engine",
        f"{AXES[limit]}=within",
        ("share", lambda row: f"{amount(100 * row['share'])} %"),
        ("least", lambda row: f"{amount(100 * row['low'])} %"),
        "without=without_low",
        ("most", lambda row: f"{amount(100 * row['high'])} %"),
        "without=without_high",
    )
    title = "Share of cases solved within N times of the fastest" if factor else "Share of cases solved within a CPU time"
    spec = finished(layers, height=300)
    return Figure("profile-factor" if factor else "profile-time", title, caption, spec, *table, how)
