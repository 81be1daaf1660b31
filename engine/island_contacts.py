"""The contacts of one island, solved in memory of its own: what it reads and writes is apart from all other islands.

The sweeps are those of `step_contact` in the same order, so the bits are the same, whoever solves the island.
"""

from typing import TypeVar

from engine.arena import (
    AROUSED,
    BODY,
    BODY_A,
    BODY_B,
    BODY_KIND,
    COUNT,
    DAMPING_RATIO,
    DT,
    DYNAMIC,
    FIRST_LOCAL,
    FIRST_MANIFOLD,
    GROUPED,
    GYROSCOPIC,
    HERTZ,
    HIT,
    ITERATIONS,
    LOAD,
    LOCAL_BODY,
    LOCAL_KIND,
    LOCAL_LOAD,
    LOCAL_OWNER,
    LOCAL_STATE,
    LOCAL_TURNED,
    MANIFOLD,
    MANIFOLD_KEY,
    MAX_PUSH,
    MOTION,
    OLD_KEY,
    OLD_MANIFOLD,
    OLD_POINT,
    POINT,
    POINTS,
    RELAXATIONS,
    SETTING,
    SPAN_OF_ISLAND,
    STATE,
    SUBSTEPS,
    TALLY,
    TURNED,
)  # fmt: skip
from engine.carve import floats_of, ints_of
from engine.contact_solver import approach, bounce, end_step, end_substep, friction_mode, refresh, sweep, warm_start
from engine.jit import kernel
from engine.motion import drift, kick
from engine.steps_contact import FRESH, slow_approach, soft_factors
from engine.vec import Floats, Ints

__all__ = ["advance_island", "bodies_of", "contacts_of", "copy_row", "give_island", "take_island"]

Table = TypeVar("Table", Floats, Ints)


@kernel
def copy_row(source: Table, i: int, target: Table, k: int) -> None:
    """Row i of one table to row k of another of its width."""
    for c in range(target.shape[1]):
        target[k, c] = source[i, c]


@kernel
def bodies_of(floats: Floats, ints: Ints, i: int) -> tuple[Floats, Floats, Floats, Floats, Ints]:
    """State, body, turned inertia, load and kind of the bodies of island i."""
    span = ints_of(ints, SPAN_OF_ISLAND)
    first, end = span[i, FIRST_LOCAL], span[i + 1, FIRST_LOCAL]
    return (
        floats_of(floats, ints, LOCAL_STATE)[first:end],
        floats_of(floats, ints, LOCAL_BODY)[first:end],
        floats_of(floats, ints, LOCAL_TURNED)[first:end],
        floats_of(floats, ints, LOCAL_LOAD)[first:end],
        ints_of(ints, LOCAL_KIND)[first:end],
    )


@kernel
def contacts_of(floats: Floats, ints: Ints, i: int) -> tuple[Floats, Floats, Ints]:
    """Manifolds, points and keys of island i. The last step's tables, which are done with, hold them."""
    span = ints_of(ints, SPAN_OF_ISLAND)
    first, end = span[i, FIRST_MANIFOLD], span[i + 1, FIRST_MANIFOLD]
    return (
        floats_of(floats, ints, OLD_MANIFOLD)[first:end],
        floats_of(floats, ints, OLD_POINT)[4 * first : 4 * end],
        ints_of(ints, OLD_KEY)[first:end],
    )


@kernel
def take_island(floats: Floats, ints: Ints, i: int) -> None:
    """Copy the bodies and contacts of island i into its own memory."""
    state, body, turned, load, kind = bodies_of(floats, ints, i)
    manifold, point, key = contacts_of(floats, ints, i)
    span, owner, grouped = ints_of(ints, SPAN_OF_ISLAND), ints_of(ints, LOCAL_OWNER), ints_of(ints, GROUPED)
    first = span[i, FIRST_LOCAL]
    all_states, all_bodies, all_kinds = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), ints_of(ints, BODY_KIND)
    all_turned, all_loads = floats_of(floats, ints, TURNED), floats_of(floats, ints, LOAD)
    for r in range(state.shape[0]):
        b = owner[first + r, 0]
        copy_row(all_states, b, state, r)
        copy_row(all_bodies, b, body, r)
        copy_row(all_turned, b, turned, r)
        copy_row(all_loads, b, load, r)
        copy_row(all_kinds, b, kind, r)
    all_manifolds, all_points = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT)
    all_keys = ints_of(ints, MANIFOLD_KEY)
    first = span[i, FIRST_MANIFOLD]
    for k in range(manifold.shape[0]):
        m = grouped[first + k, 0]
        copy_row(all_manifolds, m, manifold, k)
        for c in range(key.shape[1]):
            if c not in (BODY_A, BODY_B):
                key[k, c] = all_keys[m, c]
        for p in range(key[k, POINTS]):
            copy_row(all_points, 4 * m + p, point, 4 * k + p)


@kernel
def press_island(
    state: Floats, body: Floats, turned: Floats, load: Floats, kind: Ints, manifold: Floats, point: Floats, key: Ints,
    setting: Floats, count: Ints, patience: int,
) -> bool:  # fmt: skip
    """Kick, solve with the position error, drift, and relax an island. Returns: whether it is to bounce."""
    n, h = manifold.shape[0], setting[0, DT] / count[0, SUBSTEPS]
    rate, mass_scale, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    slow, most = slow_approach(setting, h), setting[0, MAX_PUSH]
    for b in range(state.shape[0]):
        kick(state, body, kind, turned, load, setting, b, h)
    approach(state, kind, setting, n, manifold, key, point, h, slow)
    warm_start(state, body, turned, n, manifold, key, point)
    for _ in range(count[0, ITERATIONS] * patience):
        sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 1, 0)
    for b in range(state.shape[0]):
        drift(state, body, kind, turned, b, h, count[0, GYROSCOPIC])
    refresh(state, 0, n, manifold, key, point)
    for _ in range(count[0, RELAXATIONS] * patience):
        sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 0)
    return bounce(n, manifold, key, point)


@kernel
def release_island(
    state: Floats, body: Floats, turned: Floats, manifold: Floats, point: Floats, key: Ints, setting: Floats, count: Ints,
    hit: int,
) -> None:  # fmt: skip
    """Restitution of an island, where any was hit, and the end of the sub-step."""
    n, h = manifold.shape[0], setting[0, DT] / count[0, SUBSTEPS]
    rate, mass_scale, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    if hit == 1:
        for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
            sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, setting[0, MAX_PUSH], 0, 1)
    friction_mode(state, body, n, manifold, key, point)
    end_substep(n, key, point)


@kernel
def give_island(floats: Floats, ints: Ints, i: int) -> None:
    """End the step of island i, and copy its dynamic bodies and its contacts back from its own memory."""
    state, _, turned, _, kind = bodies_of(floats, ints, i)
    manifold, point, key = contacts_of(floats, ints, i)
    span, owner, grouped = ints_of(ints, SPAN_OF_ISLAND), ints_of(ints, LOCAL_OWNER), ints_of(ints, GROUPED)
    first = span[i, FIRST_LOCAL]
    all_states, all_turned = floats_of(floats, ints, STATE), floats_of(floats, ints, TURNED)
    for r in range(state.shape[0]):
        if kind[r, MOTION] == DYNAMIC:
            copy_row(state, r, all_states, owner[first + r, 0])
            copy_row(turned, r, all_turned, owner[first + r, 0])
    all_manifolds, all_points = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT)
    all_keys = ints_of(ints, MANIFOLD_KEY)
    end_step(manifold.shape[0], manifold, key, point)
    first = span[i, FIRST_MANIFOLD]
    for k in range(manifold.shape[0]):
        m = grouped[first + k, 0]
        copy_row(manifold, k, all_manifolds, m)
        for c in range(key.shape[1]):
            if c not in (BODY_A, BODY_B):
                all_keys[m, c] = key[k, c]
        for p in range(key[k, POINTS]):
            copy_row(point, 4 * k + p, all_points, 4 * m + p)


@kernel
def advance_island(floats: Floats, ints: Ints, i: int, first: int, end: int, hit: int) -> None:
    """The stages first..end - 1 of the step of island i, out of one more than there are sub-steps.

    Each stage ends the sub-step before it and begins the next, for what stands between the two is all that islands have to
    know of each other: whether any of them was hit and is to bounce.
    """
    state, body, turned, load, kind = bodies_of(floats, ints, i)
    span = ints_of(ints, SPAN_OF_ISLAND)
    span[i, HIT] = 0
    if state.shape[0] == 0:
        return
    manifold, point, key = contacts_of(floats, ints, i)
    setting, count = floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    fresh = ints_of(ints, TALLY)[0, AROUSED] > 0
    for stage in range(first, end):
        if stage == 0:
            take_island(floats, ints, i)
        else:
            release_island(state, body, turned, manifold, point, key, setting, count, hit)
        if stage < count[0, SUBSTEPS]:
            patience = FRESH if stage == 0 and fresh else 1
            span[i, HIT] = press_island(state, body, turned, load, kind, manifold, point, key, setting, count, patience)
        else:
            give_island(floats, ints, i)
