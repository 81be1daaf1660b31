"""Why DART as tuned keeps settings that one other value of a knob beats in some cases: what that value loses in others.

The figures are of `plumbline run dominance`, which tries every value in every case at the case's own step.
"""

from plumbline.harness.adapter import TradeOff

KNOB_TRADE_OFFS = (
    TradeOff(
        cases=("stack_tip_or_slide", "stand_hit", "system_far_origin"),
        at=("price",),
        why=(
            "the vendor's solver bounds friction along two axes and by the load without friction: friction_isotropy "
            "keeps 1 of 6 checks, spinning 4 of 8, thirteen cases in all lose some"
        ),
    ),
    TradeOff(
        cases=("friction_wall_pinch",),
        knob="options.detector",
        values=("dart",),
        why=("with DART's own detector impact_oblique errs 12 times as much, system_scale_length 10 times"),
    ),
    TradeOff(
        cases=("stand_hit",),
        knob="options.drives",
        values=("servo", "spring"),
        why=("other laws than the one that holds what stands: stand_humanoid and stand_quadruped lose 2 to 7 of 8 checks"),
    ),
    TradeOff(
        cases=(
            "friction_creep",
            "friction_roll_incline",
            "friction_slip_to_roll",
            "impact_momentum",
            "rest_penetration",
            "stack_tip_or_slide",
            "system_far_origin",
            "system_scale_length",
        ),
        knob="solver",
        values=("dantzig",),
        why=(
            "it bounds friction along two axes and by the load without friction: friction_isotropy keeps 1 of 6 "
            "checks, spinning 4 of 8, nine cases in all lose some"
        ),
    ),
    TradeOff(
        cases=("friction_painleve", "friction_roll_incline", "friction_slip_to_roll", "stack_card_house"),
        knob="solver",
        values=("matrix_free",),
        why=("14 cases keep fewer checks (isotropy 1 of 6, spinning 4 of 8), and a pyramid errs 49 times as much"),
    ),
    TradeOff(
        cases=(
            "friction_backspin",
            "friction_painleve",
            "friction_roll_incline",
            "friction_slip_to_roll",
            "impact_momentum",
            "stack_card_house",
            "stack_tip_or_slide",
            "system_far_origin",
        ),
        knob="solver",
        values=("pgs",),
        why=("16 cases keep fewer checks (isotropy 1 of 6, spinning 4 of 8), and what rests errs 12 times as much"),
    ),
    TradeOff(
        cases=("friction_isotropy", "friction_stop", "impact_pairs"),
        knob="options.split_impulse",
        values=(True,),
        why=("creep, gas, momentum, overhang and scale lose a check each, and boxes at rest stir 2.5 times as much"),
    ),
    TradeOff(
        cases=("spin_fast",),
        knob="substeps",
        values=(8,),
        why=(
            "it costs 1.4 times as much here and loses checks of eight cases: orbit_kepler 4 of 5, painleve, stop and "
            "those of impacts one each; far origin errs 18 times as much"
        ),
    ),
)
