"""What changed for a build server: one test for each case and engine, which fails where something is worse than before.

Source: the XML schema that Jenkins and others share: testsuites, testsuite, testcase, failure, skipped, system-out.
"""

from collections.abc import Collection
from xml.etree import ElementTree

from plumbline.harness.findings.changes.values import Change, Changes
from plumbline.harness.findings.changes.words import command, gate_in_short, judged_in_short, sentence
from plumbline.harness.intake.safe_text import LONGEST_TEXT, readable, visible
from plumbline.harness.store.store import Store


def junit(changes: Changes, store: Store, gated: Collection[str] = (), least: float = 0.0) -> str:
    """The document. A case that has no answer on an engine is skipped; without gated engines, all of them count.

    Args: least: see `gate_in_short`; where too little could be judged, a test of its own fails.
    """
    cells = {(str(case), str(engine)): trials for (case, engine), trials in store.trials.groupby(["case", "engine"], sort=True)}
    rows: dict[tuple[str, str], list[Change]] = {cell: [] for cell in cells}
    for row in changes.rows:
        if (row.case, row.engine) in rows or (not row.case and row.engine and row.kind == "price"):
            rows.setdefault((row.case or "all cases", row.engine), []).append(row)
    suite = ElementTree.Element("testsuite", name="plumbline diff")
    failures = skipped = 0
    for (case, engine), changed in rows.items():
        test = ElementTree.SubElement(suite, "testcase", classname=visible(engine, ""), name=visible(case, ""), time="0")
        worse = [row for row in changed if row.regression and (not gated or engine in gated)]
        trials = cells.get((case, engine))
        if worse:
            failures += 1
            failure = ElementTree.SubElement(test, "failure", type=worse[0].kind, message=_clean(sentence(worse[0])))
            failure.text = _clean("\n".join(f"{sentence(row)}\n  {command(row, changes)}" for row in worse))
        elif trials is not None and trials["status"].isin(("unsupported", "unavailable", "interrupted")).all():
            skipped += 1
            ElementTree.SubElement(test, "skipped", message=_clean(f"{trials['status'].iloc[0]}: {trials['reason'].iloc[0]}"))
        if others := [row for row in changed if row not in worse]:
            ElementTree.SubElement(test, "system-out").text = _clean("\n".join(map(sentence, others)))
    if gated and changes.judged_of(gated).share < least:
        failures += 1
        rows["gate", "judged"] = []
        test = ElementTree.SubElement(suite, "testcase", classname="gate", name="judged", time="0")
        message = _clean(gate_in_short(changes, gated, least))
        ElementTree.SubElement(test, "failure", type="not judged", message=message)
    for name, count in (("tests", len(rows)), ("failures", failures), ("errors", 0), ("skipped", skipped)):
        suite.set(name, str(count))
    suite.set("time", "0")
    judged = ElementTree.SubElement(suite, "system-out")
    judged.text = _clean(judged_in_short(changes.judged_of(gated)) if not gated else gate_in_short(changes, gated, least))
    # Of all suites together the schema of Jenkins (junit-10.xsd) has no count of what was skipped.
    root = ElementTree.Element("testsuites", {name: value for name, value in suite.attrib.items() if name != "skipped"})
    root.append(suite)
    text: str = ElementTree.tostring(root, encoding="unicode", xml_declaration=False)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _clean(text: str) -> str:
    return readable(text, LONGEST_TEXT)
