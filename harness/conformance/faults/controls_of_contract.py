"""The negative controls of the contract: saves, refusals, settings, repetition, and what is claimed."""

from dataclasses import replace

from harness.adapter import Feature
from harness.conformance.faults.broken_contract import (
    ClosesOnce,
    ForgetfulSave,
    OddWarnings,
    Taciturn,
    approximating,
    deaf_to_methods,
    deaf_to_options,
    entangled,
    unrepeatable,
)
from harness.conformance.faults.broken_motion import repairing
from harness.conformance.faults.broken_states import (
    NanWithoutAWord,
    NoSpinWritten,
)
from harness.conformance.faults.broken_steps import ReshapesWrench, RestoreKeepsTargets, RestoreKeepsWrench
from harness.conformance.faults.control import Control
from harness.conformance.faults.plant import changed_scene, plant, simulated, wrapped
from harness.scene import Effect

__all__ = ["CONTRACT_CONTROLS"]

_W, _D = Feature.WRENCH, Feature.PRISMATIC | Feature.DRIVES

CONTRACT_CONTROLS: tuple[Control, ...] = (
    Control(
        name="nan_repaired_in_silence",
        fault="a state that is not finite is replaced by the start at rest",
        plant=simulated(repairing),
        caught_by=("nan_is_reported",),
    ),
    Control(
        name="save_keeps_nothing",
        fault="restore goes nowhere",
        plant=wrapped(ForgetfulSave),
        caught_by=("save_and_restore_is_exact",),
        needs=Feature.SAVE,
    ),
    Control(
        name="unknown_options_dropped",
        fault="an option that the adapter does not know is ignored",
        plant=deaf_to_options,
        caught_by=("unknown_option_is_refused",),
    ),
    Control(
        name="unknown_methods_dropped",
        fault="an integrator or solver that the engine does not have is replaced by its own",
        plant=deaf_to_methods,
        caught_by=("unknown_integrator_is_refused", "unknown_solver_is_refused"),
    ),
    Control(
        name="claims_too_much",
        fault="every feature is claimed",
        plant=lambda adapter: replace(plant(adapter), features=~Feature.NONE),
        caught_by=("claimed_features_build",),
    ),
    Control(
        name="closes_once",
        fault="closing a second time fails",
        plant=wrapped(ClosesOnce),
        caught_by=("close_may_be_called_twice",),
    ),
    Control(
        name="resolved_says_nothing",
        fault="the settings in use are not told",
        plant=wrapped(Taciturn),
        caught_by=("resolved_settings_are_complete",),
    ),
    Control(
        name="angular_velocity_not_written",
        fault="the caller's w is left as it was",
        plant=wrapped(NoSpinWritten),
        caught_by=("state_is_written_into_the_given_arrays", "initial_state_comes_back"),
    ),
    Control(
        name="nan_without_a_word",
        fault="positions become NaN after fifty steps and nobody says so",
        plant=wrapped(NanWithoutAWord),
        caught_by=("heavy_on_light_is_finite_or_diverged",),
        needs=Feature.BOX,
        applies_to_cases=("flight_*", "rest_*"),
    ),
    Control(
        name="surplus_by_no_name",
        fault="a surplus is declared that is no effect",
        plant=wrapped(OddWarnings),
        caught_by=("surplus_names_effects",),
    ),
    Control(
        name="not_repeatable",
        fault="each build differs by a rounding",
        plant=unrepeatable,
        caught_by=("same_input_same_hash",),
    ),
    Control(
        name="simulations_entangled",
        fault="stepping one simulation steps the others",
        plant=entangled,
        caught_by=("two_simulations_share_no_state",),
    ),
    Control(
        name="narrowing_ignored",
        fault="effects that the scene leaves out are simulated all the same, and not declared",
        plant=changed_scene(lambda scene: replace(scene, narrow=Effect.NONE)),
        caught_by=("narrowed_gravity_is_left_out", "narrowed_contact_is_left_out"),
        needs=Feature.SPHERE,
    ),
    Control(
        name="approximates_in_silence",
        fault="what is not supported is left out without a word",
        plant=approximating,
        caught_by=("unclaimed_features_raise_unsupported",),
    ),
    Control(
        name="wrench_of_any_shape",
        fault="a wrench of a wrong shape, type or content is made to fit",
        plant=wrapped(ReshapesWrench),
        caught_by=("bad_wrenches_are_refused",),
        needs=_W,
    ),
    Control(
        name="restore_keeps_the_wrench",
        fault="the wrench outlives a restore",
        plant=wrapped(RestoreKeepsWrench),
        caught_by=("restore_brings_back_the_wrench",),
        needs=Feature.SAVE | _W,
    ),
    Control(
        name="restore_keeps_the_targets",
        fault="the targets of drives outlive a restore",
        plant=wrapped(RestoreKeepsTargets),
        caught_by=("restore_brings_back_the_targets",),
        needs=Feature.SAVE | _D,
    ),
)
"""Each on one engine that has what it needs."""
