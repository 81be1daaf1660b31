"""A scene file to begin with: a pendulum above a ball on the ground, with what else can be said in comments."""

TEMPLATE = """\
# A scene in SI units. W is right-handed with z up; quaternions are (w, x, y, z).
# 'plumbline scene schema' prints all fields; 'plumbline scene show FILE' says what was understood.

gravity = [0.0, 0.0, -9.81]

# Bodies: mass [kg], inertia about the centre of mass [kg m2] (zero: a mass point; with mass 0 as
# well: what stands between two joints), p_WB [m] and q_WB at the start.
[[bodies]]
name = "ground"
motion = "static"           # dynamic (the default), static, kinematic: it keeps its velocity, or is led:
# prescribed = { shifts = [{ axis_W = [1.0, 0.0, 0.0], motion = { type = "sinusoid", amplitude = 0.1, frequency = 2.0 } }] }
# prescribed = { turn = { anchor_W = [0.0, 0.0, 0.0], axis_W = [0.0, 0.0, 1.0], motion = ... } }
material = "floor"
[[bodies.collision]]
shape = { type = "plane" }  # solid below z = 0 of its body

[[bodies]]
name = "ball"
mass = 1.0
inertia = [[0.004, 0.0, 0.0], [0.0, 0.004, 0.0], [0.0, 0.0, 0.004]]
material = "rubber"
p_WB = [0.0, 0.0, 0.5]
v_WB = [0.5, 0.0, 0.0]      # [m/s]; w_WB is the angular velocity [rad/s]
[[bodies.collision]]
shape = { type = "sphere", radius = 0.1 }
# box: half_extents = [x, y, z]; ellipsoid: semi_axes = [x, y, z]; capsule, cylinder: radius,
# half_length along z; convex_hull: vertices; triangle_mesh: vertices, faces. p_BS and q_BS place a shape in its body.

[[bodies]]
name = "bob"
mass = 0.5
inertia = [[0.001, 0.0, 0.0], [0.0, 0.001, 0.0], [0.0, 0.0, 0.001]]
material = "rubber"
p_WB = [1.0, 0.0, 1.5]

# Joints: revolute, prismatic (both with position and what stands in comments below), ball, fixed, distance (a rod; with limits
# a rope; with a spring alone a spring between anchor_W on the parent and child_anchor_W on the child).
[[joints]]
type = "revolute"
name = "hinge"
parent = "world"
child = "bob"
anchor_W = [1.0, 0.0, 2.0]  # in W at the start
axis_W = [0.0, 1.0, 0.0]
# limits = { lower = -1.0, upper = 1.0 }
# spring = { stiffness = 0.0, damping = 0.1, rest = 0.0 }
# drive = { stiffness = 10.0, damping = 1.0, target = 0.5, limit = 5.0 }
# drive = { feedforward = 0.2 }  # a motor of constant torque [N m], or force [N] of a slide
# armature = 0.01             # rotor inertia about the axis [kg m2; kg of a slide]
# friction_loss = 0.2         # dry friction, at most [N m; N of a slide]
# speed_limit = 2.0           # the most of the coordinate's rate, either way [rad/s; m/s of a slide]
# coupling = { joint = "other", ratio = 2.0, offset = 0.0 }  # this coordinate is ratio times the other's, plus offset
# Its target moves with motion = { type = "sinusoid", amplitude = 0.3, frequency = 1.0, phase = 0.0 } in the drive, or
# { type = "samples", time = [0.0, 1.0], target = [0.0, 0.5] }.

# One law for each pair of materials that can touch; pairs in `apart` pass through each other.
[[surfaces]]
between = ["floor", "rubber"]
static_friction = 0.6
kinetic_friction = 0.6
restitution = 0.0
"""
