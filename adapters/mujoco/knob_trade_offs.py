"""Why MuJoCo as tuned keeps settings that one other value of a knob beats in some cases: what that value loses in others.

The figures are of `plumbline run dominance`, which tries every value in every case at the case's own step.
"""

from plumbline.harness.adapter import TradeOff

FIRST_ORDER = (
    "one stage for four, of first order: what flies errs 98 times as much, a top 50 times, a double pendulum "
    "51 times; these scenes ask for what both have right, or for what Euler keeps"
)

KNOB_TRADE_OFFS = (
    TradeOff(
        cases=("stack_pile", "stack_stirred", "system_scaling"),
        why="where heaps come to rest is chance: by default stack_stirred errs .89 times as much, and 30 balls .85 times",
    ),
    TradeOff(
        cases=(
            "joint_conical_pendulum",
            "joint_long_run",
            "orbit_kepler",
            "sensor_imu_free_fall",
            "sensor_imu_noise",
            "sensor_imu_readout",
            "sensor_lidar_noise",
            "sensor_lidar_room",
            "spin_intermediate_axis",
            "spin_principal",
        ),
        at=("price",),
        why=FIRST_ORDER,
    ),
    TradeOff(
        cases=("stack_pile", "system_determinism", "system_scaling"),
        at=("price",),
        why=(
            "the vendor's contacts are soft, and friction_creep keeps 4 of its 6 checks, friction_isotropy 2 of 6, and "
            "an arch errs 121 times as much"
        ),
    ),
    TradeOff(
        cases=(
            "joint_conical_pendulum",
            "joint_limits",
            "joint_long_run",
            "orbit_kepler",
            "sensor_imu_free_fall",
            "sensor_imu_noise",
            "sensor_imu_readout",
            "sensor_lidar_noise",
            "sensor_lidar_room",
            "spin_intermediate_axis",
            "spin_principal",
            "system_scaling",
        ),
        knob="integrator",
        values=("euler", "discrete", "implicit", "implicitfast"),
        why=FIRST_ORDER,
    ),
    TradeOff(
        cases=("system_determinism", "system_scaling"),
        knob="options.cone",
        values=("pyramidal",),
        why=(
            "a pyramid's friction goes with the direction: friction_isotropy keeps 2 of the 6 checks that the cone "
            "keeps, rolling resistance, spinning and wall pinch lose one each, and a ball in a bowl errs 24 times as "
            "much"
        ),
    ),
    TradeOff(
        cases=("friction_turntable", "stack_stirred", "system_scaling"),
        knob="options.contact_impedance",
        values=(0.95,),
        why=(
            "the vendor's own: stack_mass_ratio keeps none of its 4 checks, a standing quadruped errs 43 times as much "
            "and an arch 20 times"
        ),
    ),
    TradeOff(
        cases=("impact_momentum", "system_determinism", "system_scale_length"),
        knob="options.contact_steps",
        values=(0.5, 2.0, 4.0),
        why=(
            "stiffer contacts lift what slides: with two steps friction_backspin keeps 5 of 7 checks, slip to roll, "
            "threshold and overlap recovery lose one each and friction_painleve errs 69 times as much; with four it "
            "errs 15 times"
        ),
    ),
    TradeOff(
        cases=("impact_momentum", "system_determinism", "system_scale_length"),
        knob="options.slowest",
        values=(0.001, 0.005),
        why=(
            "stiffer contacts lift what slides: friction_backspin keeps 5 of 7 checks, slip to roll, threshold and "
            "overlap recovery lose one each and friction_painleve errs 10 to 69 times as much"
        ),
    ),
    TradeOff(
        cases=("system_scale_length",),
        knob="options.slowest",
        values=(0.1,),
        why=("slower contacts are softer: 12 cases keep fewer checks, and a pyramid errs 12 times as much"),
    ),
    TradeOff(
        cases=("friction_turntable",),
        knob="options.impratio",
        values=(1.0,),
        why=("without it a block creeps ten times as far down an incline, and a pyramid drifts 2.7 times as far"),
    ),
    TradeOff(
        cases=("system_scaling",),
        knob="iterations",
        values=(5,),
        why=(
            "five iterations lose 2 of 5 checks of impact_gas and 2 of 7 of impact_momentum; twenty err 1.2 times as "
            "much in a stirred heap"
        ),
    ),
    TradeOff(
        cases=("impact_oblique",),
        knob="options.rebound_steps",
        values=(5,),
        why="with five steps impact_bounce loses a check",
    ),
    TradeOff(
        cases=("friction_turntable",),
        knob="solver",
        values=("pgs",),
        why=(
            "with pgs threshold, wall pinch, rest_jitter (2 of 7) and far origin lose checks, and a standing humanoid "
            "errs 9 times as much; with cg 13 cases lose some"
        ),
    ),
    TradeOff(
        cases=("friction_spinning", "system_scale_length"),
        knob="substeps",
        values=(2, 4, 8),
        why=("with two sub-steps friction_stop keeps 5 of 7 checks and five cases lose one each, at twice the price"),
    ),
)
