"""What a page of a scene of one's own says of its limits."""

import pytest

from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.trajectory.parting import NOTHING
from plumbline.reports.pages.scene import one_limit


@pytest.mark.parametrize(("agreed", "one"), [(("A", "B"), True), (("A", ""), False), (("", ""), False)])
def test_one_limit_is_drawn_only_where_engines_agree_in_every_scene(agreed: tuple[str, ...], one: bool) -> None:
    agreements = [
        Agreement(case="arm", where=f"n = {n}", duration=1.0, scale=NOTHING, granted=0.0, sides=(), differences=(), agreed=camp)
        for n, camp in enumerate(agreed)
    ]
    assert one_limit(agreements) is one
