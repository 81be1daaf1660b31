"""Cases and engines in words: the rows of the listings, kept in each run folder so that it explains itself."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.adapter.features import features_of
from plumbline.harness.case import Case
from plumbline.harness.study.plugins import version_of


def _plain(described: object, *names: str) -> dict[str, Any]:
    """Fields of an object by name, containers as those of JSON."""
    fields = {name: getattr(described, name) for name in names}
    return {n: dict(v) if isinstance(v, Mapping) else list(v) if isinstance(v, tuple) else v for n, v in fields.items()}


def describe_case(case: Case) -> dict[str, Any]:
    """A case as a JSON-ready row: question, truth, effects, source, parameters, checks with their derivations."""
    scene = case.scene(case.parameters)
    return {
        **_plain(case, "name", "family", "title", "question", "truth"),
        "effects": list(scene.effects.names),
        "features": list(features_of(scene).names),
        **_plain(case, "source", "parameters"),
        "bodies": len(scene.bodies),
        **_plain(case, "duration", "steady", "dt", "ladder", "headline", "scale", "converges", "ensemble"),
        "hard": None if case.hard is None else asdict(case.hard),
        "checks": [
            {
                "metric": check.metric.name,
                **_plain(check.metric, "unit", "better"),
                "at_most": check.bound(case.dt, case.parameters),
                **_plain(check, "because", "start", "end"),
                "source": check.metric.source,
            }
            for check in case.checks
        ],
        "insists": dict(case.insists),
        "observed": [metric.name for metric in case.observe],
    }


def describe_engine(engine: Adapter) -> dict[str, Any]:
    """An engine as a JSON-ready row: version or the reason why it is unavailable, features, tracks, findings."""
    version, reason = version_of(engine)
    return {
        **_plain(engine, "name", "title", "distribution"),
        "available": reason is None,
        "version": None if reason is not None else version,
        "unavailable": reason,
        "ours": engine.distribution == "plumbline",
        **_plain(engine, "licence", "platforms"),
        "features": list(engine.features.names),
        "tracks": {name: settings.plain() for name, settings in engine.tracks.items()},
        "knobs": {name: list(values) for name, values in engine.knobs.items()},
        "known_failures": dict(engine.known_failures),
        "trade_offs": [asdict(trade_off) for trade_off in engine.trade_offs],
        "deviations": list(engine.deviations),
        "emulated": [{"feature": law.feature.names[0], **_plain(law, "how", "where", "tracks")} for law in engine.emulated],
        "advantages": {name: asdict(advantage) for name, advantage in engine.advantages.items()},
        "batch": type(engine).build_batch is not Adapter.build_batch,
        "orders": dict(engine.orders),
    }
