"""Why the reference engine as tuned keeps settings that one value of a knob beats in some cases: what that loses in others.

The figures are of `plumbline run dominance`, which tries every value in every case at the case's own step.
"""

from plumbline.harness.adapter import TradeOff

__all__ = ["KNOB_TRADE_OFFS"]

KNOB_TRADE_OFFS = (
    TradeOff(
        cases=(
            "friction_backspin",
            "friction_creep",
            "friction_isotropy",
            "friction_roll_incline",
            "friction_slip_to_roll",
            "friction_spinning",
            "impact_momentum",
            "rest_jitter",
            "rest_penetration",
            "stack_bowl",
            "stack_card_house",
            "stack_heavy_on_two",
            "stack_overhang",
            "stack_pile",
            "stack_pyramid",
            "stack_stirred",
            "system_determinism",
            "system_invariance",
            "system_scale_length",
            "system_scaling",
            "tunnel_dynamic_pair",
            "tunnel_rod",
            "tunnel_sphere_wall",
        ),
        at=("price",),
        why=(
            "by default impact_bounce errs 37 times as much, what flies 25 times, and stack_mass_ratio keeps none of "
            "its 4 checks"
        ),
    ),
    TradeOff(
        cases=(
            "friction_backspin",
            "friction_creep",
            "friction_isotropy",
            "friction_roll_incline",
            "friction_slip_to_roll",
            "friction_spinning",
            "impact_bounce",
            "impact_cradle",
            "impact_momentum",
            "rest_jitter",
            "rest_penetration",
            "sensor_imu_rest",
            "stack_bowl",
            "stack_card_house",
            "stack_overhang",
            "stack_pile",
            "stack_pyramid",
            "stack_stirred",
            "stack_tip_or_slide",
            "stand_hit",
            "system_determinism",
            "system_far_origin",
            "system_invariance",
            "system_predictability",
            "system_scale_length",
            "system_scaling",
            "tunnel_dynamic_pair",
            "tunnel_rod",
            "tunnel_sphere_wall",
            "tunnel_thin_mesh",
        ),
        knob="substeps",
        values=(1, 2, 4),
        why=(
            "contacts give way by what a sub-step takes: at half of them what slides errs twice as much and what "
            "stands 4 times, at a quarter an arch 17 times, at an eighth 82 times, and stack_overhang loses a check"
        ),
    ),
    TradeOff(
        cases=("stack_heavy_on_two", "system_scaling"),
        knob="solver",
        values=("tgs_soft", "sequential_impulses"),
        why=(
            "springs give way under unlike masses, impulses of ten sweeps under all: stack_mass_ratio keeps 1 of 4 "
            "checks with the one, stop and painleve 6 of 8 with the other"
        ),
    ),
)
