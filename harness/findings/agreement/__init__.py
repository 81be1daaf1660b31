"""Where engines end in a scene without a truth: each against itself, then against each other, then what stays defined beyond."""

from harness.findings.agreement.beyond import Balance, Outlook, balances, outlooks
from harness.findings.agreement.errors import Errors, errors_of
from harness.findings.agreement.found import Agreement, Difference, Side, Word, agreements, scenes_to_judge

__all__ = [
    "Agreement",
    "Balance",
    "Difference",
    "Errors",
    "Outlook",
    "Side",
    "Word",
    "agreements",
    "balances",
    "errors_of",
    "outlooks",
    "scenes_to_judge",
]
