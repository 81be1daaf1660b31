"""Sound engines that look odd: what the contract leaves open, used as no engine here uses it. Every check must pass them."""

from zlib import crc32

import numpy as np

from plumbline.harness.trajectory import Contacts, State
from tests.planted_faults.planting import Wrapped


class EitherSign(Wrapped):
    """Hands out q or -q, which are one rotation: by the parity of a hash of each state, so that equal runs stay equal."""

    def state(self, out: State) -> None:
        self.inner.state(out)
        for k, (p, q) in enumerate(zip(out.p_WB, out.q_WB, strict=True)):
            if crc32(p.tobytes() + q.tobytes()) & 1:
                out.q_WB[k] = -q


class AnyOrder(Wrapped):
    """Hands out contacts in the opposite order, which has no meaning."""

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        back = np.arange(len(got))[::-1]
        return Contacts(
            got.body_A[back], got.body_B[back], got.point_W[back], got.normal_W[back], got.gap[back], got.force_W[back]
        )
