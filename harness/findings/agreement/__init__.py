"""Where engines end in a scene without a truth: each against itself, then against each other, then what stays defined
beyond."""

from plumbline.harness.findings.agreement.found import AGREED_TRUTH, Errors, agreements, errors_of, scenes_to_judge, ways
from plumbline.harness.findings.agreement.judgement import judged
from plumbline.harness.findings.agreement.omissions import Omission, omission_words, omissions
from plumbline.harness.findings.agreement.perturbed_starts import (
    Balance,
    Outlook,
    balances,
    foreseeable_until,
    horizon_of,
    outlooks,
)
from plumbline.harness.findings.agreement.values import Agreement, Difference, Side, Word

__all__ = [
    "AGREED_TRUTH",
    "Agreement",
    "Balance",
    "Difference",
    "Errors",
    "Omission",
    "Outlook",
    "Side",
    "Word",
    "agreements",
    "balances",
    "errors_of",
    "foreseeable_until",
    "horizon_of",
    "judged",
    "omission_words",
    "omissions",
    "outlooks",
    "scenes_to_judge",
    "ways",
]
