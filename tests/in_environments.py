"""Tests of engines that are installed when they are asked for, each on the interpreter of its environment.

`python -m tests.in_environments rapier sapien` runs the scripts in each vendor's words, the planted faults, and 'tuned' beside
'default' in all cases; the environments are those that `plumbline check ENGINE --yes` makes. Exits with the first code that is
not 0.
"""

import subprocess
import sys
from pathlib import Path

from plumbline.harness.study.environments import home_of


def main(engines: list[str]) -> int:
    """Run the tests of these engines."""
    for engine in engines:
        home = home_of(engine)
        python = sys.executable if home is None else home.executable
        scripts = sorted(str(path) for path in Path("tests/vendor").glob(f"test_{engine}*.py"))
        files = [*scripts, "tests/conformance/test_faults_on_extras.py", "tests/conformance/test_tracks.py"]
        chosen = f"{engine} and not ladder"  # ladders of all cases take longer than the rest
        code = subprocess.run([python, "-m", "pytest", "-q", "-n", "2", "-k", chosen, *files], check=False).returncode
        if code:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
