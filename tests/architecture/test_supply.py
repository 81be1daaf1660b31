"""What the build takes from others: pinned, and audited without a false all-clear."""

import json
import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
judge = runpy.run_path(str(ROOT / ".ci" / "audit.py"))["judge"]
EXTRAS = [str(path.relative_to(ROOT)) for path in sorted((ROOT / "adapters").glob("*/requirements.lock"))]
SOUND = {"name": "numpy", "version": "2.4.6", "vulns": []}
FLAWED = {"name": "jinja2", "version": "2.0", "vulns": [{"id": "CVE-2019-8341", "fix_versions": ["2.8.1"]}]}
UNKNOWN = {"name": "tomli-w", "skip_reason": "Dependency not found"}


def test_every_action_of_a_workflow_is_pinned_by_commit_and_says_its_version() -> None:
    used = [
        (path.name, line.strip())
        for path in (*sorted((ROOT / ".github" / "workflows").glob("*.y*ml")), ROOT / "docs" / "nightly-workflow.yml")
        for line in path.read_text().splitlines()
        if "uses:" in line
    ]
    assert len(used) == 29
    for name, line in used:
        assert re.search(r"uses: [\w.-]+/[\w./-]+@[0-9a-f]{40} +# v\d+\.\d+\.\d+$", line), f"{name}: {line}"


@pytest.mark.parametrize("name", ["requirements.lock", ".ci/audit.lock", *EXTRAS])
def test_everything_that_is_installed_is_locked_by_version_and_content(name: str) -> None:
    packages = re.split(r"\n(?=\S)", (ROOT / name).read_text().strip())
    assert len(packages) > (0 if name in EXTRAS else 20)
    for package in packages:
        assert re.match(r"[\w.-]+==\S+ ", package), package[:80]
        assert "--hash=sha256:" in package, package[:80]


@pytest.mark.parametrize(
    ("said", "code", "line"),
    [
        (json.dumps({"dependencies": [SOUND]}), 0, "1 of 1 packages audited, 0 known vulnerabilities"),
        (json.dumps({"dependencies": [SOUND, FLAWED]}), 1, "jinja2 2.0: CVE-2019-8341, mended in 2.8.1"),
        (json.dumps({"dependencies": [SOUND, UNKNOWN]}), 0, "not audited, the database does not know it: tomli-w"),
        (json.dumps({"dependencies": [UNKNOWN, UNKNOWN]}), 4, "NOT AUDITED: the database knows none of 2 packages"),
        ("", 4, "NOT AUDITED: pip-audit gave no report: no route"),
        ("[]", 4, "NOT AUDITED: pip-audit gave no report: no route"),
    ],
)
def test_an_audit_that_did_not_take_place_is_no_all_clear(said: str, code: int, line: str) -> None:
    told, lines = judge(said, "no route")
    assert told == code
    assert any(one.startswith(line) for one in lines), lines
