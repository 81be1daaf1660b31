"""Cases and engines in words: the rows of the listings, kept in each run folder so that it explains itself."""

from dataclasses import asdict
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.adapter.features import features_of
from plumbline.harness.case import Case
from plumbline.harness.study.plugins import version_of


def describe_case(case: Case) -> dict[str, Any]:
    """A case as a JSON-ready row: question, truth, effects, source, parameters, checks with their derivations."""
    scene = case.scene(case.parameters)
    return {
        "name": case.name,
        "family": case.family,
        "title": case.title,
        "question": case.question,
        "truth": case.truth,
        "effects": list(scene.effects.names),
        "features": list(features_of(scene).names),
        "source": case.source,
        "parameters": dict(case.parameters),
        "bodies": len(scene.bodies),
        "duration": case.duration,
        "steady": case.steady,
        "dt": case.dt,
        "ladder": list(case.ladder),
        "headline": case.headline,
        "scale": case.scale,
        "converges": case.converges,
        "ensemble": case.ensemble,
        "hard": None if case.hard is None else asdict(case.hard),
        "checks": [
            {
                "metric": check.metric.name,
                "unit": check.metric.unit,
                "better": check.metric.better,
                "at_most": check.bound(case.dt, case.parameters),
                "because": check.because,
                "start": check.start,
                "end": check.end,
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
        "name": engine.name,
        "title": engine.title,
        "distribution": engine.distribution,
        "available": reason is None,
        "version": None if reason is not None else version,
        "unavailable": reason,
        "ours": engine.distribution == "plumbline",
        "licence": engine.licence,
        "platforms": list(engine.platforms),
        "features": list(engine.features.names),
        "tracks": {name: settings.plain() for name, settings in engine.tracks.items()},
        "knobs": {name: list(values) for name, values in engine.knobs.items()},
        "known_failures": dict(engine.known_failures),
        "trade_offs": [asdict(trade_off) for trade_off in engine.trade_offs],
        "deviations": list(engine.deviations),
        "emulated": [
            {
                "feature": emulation.feature.names[0],
                "how": emulation.how,
                "where": emulation.where,
                "tracks": list(emulation.tracks),
            }
            for emulation in engine.emulated
        ],
        "advantages": {name: asdict(advantage) for name, advantage in engine.advantages.items()},
        "batch": type(engine).build_batch is not Adapter.build_batch,
        "orders": dict(engine.orders),
    }
