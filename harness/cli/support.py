"""What each engine can express of the scenes of a run, as a line an engine, before the run begins."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter
    from plumbline.harness.case import Case


def support_lines(cases: "Mapping[str, Case]", adapters: "Mapping[str, Adapter]", droppable: bool = False) -> list[str]:
    """By the features that scenes use and adapters claim; building one may still be refused, which is then its outcome.

    Reasons stand once, with the number of cases that each keeps from running.

    Args: droppable: is the one scene of a robot's file, of which `--drop` can leave out what an engine lacks?
    """
    from plumbline.harness.adapter.features import features_of
    from plumbline.harness.case.undropped import KINDS
    from plumbline.harness.study.plugins import version_of

    used = {name: features_of(case.scene(case.parameters)) for name, case in cases.items()}
    lines = []
    for name, adapter in adapters.items():
        version, reason = version_of(adapter)
        if reason is not None:
            lines.append(f"{name}: cannot: {reason}")
            continue
        lacking = {case: features & ~adapter.features for case, features in used.items()}
        runs = sum(not features for features in lacking.values())
        counts: dict[str, int] = {}
        for features in lacking.values():
            for word in features.names:
                counts[word] = counts.get(word, 0) + 1
        ranked = sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))
        if len(cases) == 1:
            kinds = {**KINDS, "tendon": "tendon"}
            drops = " ".join(f"--drop {kinds[word]}" for word in counts if word in kinds)
            without = f"; it runs with {drops}" if droppable and counts.keys() <= kinds.keys() else ""
            lines.append(f"{name} {version}: " + ("runs" if runs else f"cannot: it lacks {', '.join(counts)}{without}"))
        else:
            without = ", ".join(f"{word} ({count})" for word, count in ranked)
            lines.append(f"{name} {version}: runs {runs} of {len(cases)} cases" + (f"; lacks {without}" if without else ""))
    return lines
