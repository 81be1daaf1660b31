"""Why Bullet as tuned keeps settings that one other value of a knob beats in some cases: what that value loses in others.

The figures are of `plumbline run dominance`, which tries every value in every case at the case's own step.
"""

from plumbline.harness.adapter import TradeOff

KNOB_TRADE_OFFS = (
    TradeOff(
        cases=("sensor_streams", "stack_card_house", "stack_pile", "stack_pyramid"),
        at=("price",),
        why=("by default 45 of 92 cases keep fewer checks (flight_box 1 of 5), and boxes at rest stir 41 times as much"),
    ),
    TradeOff(
        cases=("system_determinism", "tunnel_sphere_wall"),
        knob="options.contact_erp",
        values=(0.8,),
        why=("overlap recovery keeps none of 4 checks, seven cases in all lose some"),
    ),
    TradeOff(
        cases=("stack_card_house",),
        knob="options.contact_slop",
        values=(0.0,),
        why=("without it a standing quadruped keeps 3 of 8 checks, mass ratio and invariance lose one each"),
    ),
    TradeOff(
        cases=("stack_pile", "stack_pyramid"),
        knob="options.contact_slop",
        values=(1e-06,),
        why=("at a micrometre stack_stirred and stack_mass_ratio err 1.5 times as much"),
    ),
    TradeOff(
        cases=(
            "friction_creep",
            "friction_slip_to_roll",
            "stack_arch",
            "stack_card_house",
            "stack_pyramid",
            "stack_tip_or_slide",
            "system_determinism",
            "system_predictability",
        ),
        knob="options.coordinates",
        values=("maximal",),
        why=(
            "in maximal coordinates friction bends to two directions of Bullet's own: isotropy and threshold keep 4 of "
            "6 checks, stop 6 of 8, wall pinch 5 of 7, spinning 6 of 7; which of its directions a scene slides in is "
            "not foreseen"
        ),
    ),
    TradeOff(
        cases=("stack_bowl",),
        knob="iterations",
        values=(1000,),
        why=("with 50, 200 and 1000 iterations at most a step costs .42, 1 and .47, in no order: no number is a rule"),
    ),
    TradeOff(
        cases=(
            "stack_bowl",
            "stack_card_house",
            "stack_overhang",
            "stack_overlap_recovery",
            "stack_pile",
            "stack_pyramid",
            "stack_tower",
            "system_determinism",
            "system_scaling",
        ),
        knob="iterations",
        values=(5, 10, 50),
        why=(
            "with 50 stack_mass_ratio keeps 1 of 4 checks, stack_heavy_on_two 2 of 3, boxes at rest stir 84 times as "
            "much and a humanoid 3.8 times; the early exit spares them where they are not needed"
        ),
    ),
    TradeOff(
        cases=("stack_card_house",),
        knob="solver",
        values=("dantzig",),
        why=("it bounds friction along two axes: isotropy keeps 1 of 6 checks, eleven cases in all lose some"),
    ),
    TradeOff(
        cases=("sensor_imu_noise", "sensor_streams"),
        knob="substeps",
        values=(1,),
        why=(
            "the vendor's longest step is 1/240 s, and a longer dt is cut, which halves what flies or slides errs by; "
            "nothing here does"
        ),
    ),
    TradeOff(
        cases=("tunnel_rod",),
        knob="substeps",
        values=(4, 8),
        why=(
            "it costs 3.7 and 7.8 times as much; overlap recovery and invariance lose a check each, a thin mesh 2 of "
            "3, and boxes at rest stir 4 to 17 times as much"
        ),
    ),
    TradeOff(
        cases=(
            "stack_card_house",
            "stack_overhang",
            "stack_overlap_recovery",
            "stack_pile",
            "stack_pyramid",
            "stack_tower",
            "system_scaling",
        ),
        knob="tolerance",
        values=(1e-07,),
        why=(
            "the vendor's own exit: creep, wall pinch, rest_jitter, humanoid and invariance lose a check each, and "
            "mass ratios err 2.8 times as much"
        ),
    ),
)
