"""A finding as a text that can be reported upstream, in Markdown: nothing in it needs this project."""

import ast
import platform

from plumbline.harness.findings.vendor.still_there import ScriptAnswer

_ASKED = {
    "bug": "Expected is what the documentation, or the format, says:",
    "trap": "This follows from what is documented; it is reported since it is easily missed. Documented is:",
    "limit": "This comes with the method; it is reported since its size may surprise. Documented is:",
}


def issue_text(standing: ScriptAnswer) -> str:
    """Title, versions, figure, the law that is expected, what is documented, the whole script, and what helps today."""
    finding = standing.finding
    sources = "\n".join(f"- {source}" for source in finding.sources)
    seen = ", ".join(finding.seen)
    today = f"{standing.verdict}: {standing.figure}" if standing.verdict in ("still there", "gone") else standing.figure
    version = standing.version or "not installed here"
    machine = f"Python {platform.python_version()}, {platform.system()} {platform.machine()}"
    needs = ", ".join(finding.requires) or finding.engine
    mended = standing.mended
    cured = f"\n\nWith it: {mended.verdict}: {mended.figure}." if mended else ""
    if mended and mended.price is not None:
        cured += f" Time of a {mended.unit} with it, over that without: {mended.price:.2f}."
    return f"""# {finding.title}

**Version**: {version} (first seen in {seen}); {machine}

**What happens**: {today}

**Expected**: {ast.get_docstring(ast.parse(finding.text))}

{_ASKED[finding.kind]} {finding.documented}

{sources}

**To reproduce**: needs {needs} and nothing else; the last line that it prints says whether it is still there. With \
`--mended` it does what helps, and says what that costs.

```python
{finding.standalone}
```

**What helps meanwhile**: {finding.mend}{cured}
"""
