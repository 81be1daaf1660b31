"""What a step costs through the harness, against the engine's own loop; measured and printed, never asserted."""

import gc
import statistics
import time

import pytest

from plumbline.harness.adapter import Unavailable
from plumbline.harness.study import plugins
from plumbline.harness.trial.bench import clock_steps

STEPS, BLOCKS = 500, 11


def test_a_step_through_the_harness_is_measured_against_the_bare_loop(capsys: pytest.CaptureFixture[str]) -> None:
    """A 10-box stack in MuJoCo: the call that the timing run clocks, and `mj_step(m, d, n)`, block by block in one process."""
    adapter = plugins.adapter("mujoco")
    try:
        adapter.version()
    except Unavailable as error:
        pytest.skip(f"MuJoCo is not installed: {error}")
    import mujoco

    case = plugins.case("stack_tower")
    scene = case.scene(case.parameters)
    ours = adapter.build(scene, adapter.tracks["tuned"])
    bare = adapter.build(scene, adapter.tracks["tuned"])
    model, state = bare._m, bare._d  # the vendor's own handles
    for simulation in (ours, bare):
        simulation.step(500)
    ratios = []
    gc.disable()
    try:
        for block in range(BLOCKS):
            harness_first = block % 2 == 0
            cpu = 0.0
            if harness_first:
                cpu, _ = clock_steps(ours, STEPS)
            start = time.process_time()
            mujoco.mj_step(model, state, STEPS)
            alone = time.process_time() - start
            if not harness_first:
                cpu, _ = clock_steps(ours, STEPS)
            ratios.append(cpu / alone)
    finally:
        gc.enable()
    ours.close()
    bare.close()
    with capsys.disabled():
        low, high = min(ratios), max(ratios)
        print(f"\nharness / bare mj_step, 10-box stack: median {statistics.median(ratios):.4f} ({low:.4f}..{high:.4f})")
    assert all(ratio > 0 for ratio in ratios)
