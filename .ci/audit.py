"""Known vulnerabilities of what requirements.lock installs, as pip-audit finds them in its database.

Exit codes: 0 none known, 1 some are known, 4 the database did not answer: then nothing was audited, and a line says so.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

LOCK = Path(__file__).parents[1] / "requirements.lock"
CLEAN, VULNERABLE, NOT_AUDITED = 0, 1, 4


def judge(said: str, complaint: str) -> tuple[int, list[str]]:
    """The exit code and the lines to print.

    Args: said: the report in JSON. complaint: the last of what stands on standard error, for where there is no report.
    """
    try:
        found: list[dict[str, Any]] = json.loads(said)["dependencies"]
    except (ValueError, KeyError, TypeError):
        return NOT_AUDITED, [f"NOT AUDITED: pip-audit gave no report: {complaint}"]
    lines = [
        f"{one['name']} {one['version']}: {flaw['id']}, mended in {', '.join(flaw['fix_versions']) or 'no version yet'}"
        for one in found
        for flaw in one.get("vulns", ())
    ]
    # A database that does not answer looks to pip-audit like one that knows no such package.
    left_out = [one["name"] for one in found if "skip_reason" in one]
    if len(left_out) == len(found):
        return NOT_AUDITED, [f"NOT AUDITED: the database knows none of {len(found)} packages: can it be reached from here?"]
    lines += [f"not audited, the database does not know it: {name}" for name in left_out]
    flaws = sum(len(one.get("vulns", ())) for one in found)
    lines.append(f"{len(found) - len(left_out)} of {len(found)} packages audited, {flaws} known vulnerabilities")
    return VULNERABLE if flaws else CLEAN, lines


def main() -> int:
    """Audit the lock file."""
    command = [sys.executable, "-m", "pip_audit", "--require-hashes", "--disable-pip", "--format", "json"]
    done = subprocess.run([*command, "--progress-spinner", "off", "-r", str(LOCK)], capture_output=True, text=True, check=False)
    code, lines = judge(done.stdout, (done.stderr.strip().splitlines() or ["nothing said"])[-1])
    print("\n".join(lines))
    return code


if __name__ == "__main__":
    sys.exit(main())
