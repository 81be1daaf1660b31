"""One arm written by hand in two formats, for tests: turned inertials, a turned fixed joint, a slide, dampers, dry friction."""

URDF = """<robot name="arm">
<link name="base"/>
<link name="upper"><inertial><origin xyz="0.02 0.01 0.2" rpy="0.3 -0.4 0.5"/><mass value="3"/>
<inertia ixx="0.05" ixy="0.002" ixz="-0.001" iyy="0.06" iyz="0.003" izz="0.02"/></inertial></link>
<link name="motor"><inertial><origin xyz="0.05 0 0" rpy="0.2 0.1 0"/><mass value="1.5"/>
<inertia ixx="0.002" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.005"/></inertial></link>
<link name="fore"><inertial><origin xyz="0 0.03 0.15"/><mass value="2"/>
<inertia ixx="0.03" ixy="0" ixz="0.001" iyy="0.025" iyz="0" izz="0.01"/></inertial></link>
<link name="finger"><inertial><mass value="0.4"/>
<inertia ixx="0.0006" ixy="0" ixz="0" iyy="0.0005" iyz="0" izz="0.0004"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.5" rpy="0 0.3 0"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="1.5" effort="80" velocity="3"/><dynamics damping="0.7" friction="0.2"/></joint>
<joint name="bolt" type="fixed"><parent link="upper"/><child link="motor"/><origin xyz="0.1 0 0.3" rpy="0.4 1.2 -0.3"/></joint>
<joint name="elbow" type="continuous"><parent link="motor"/><child link="fore"/><origin xyz="0 0.1 0.1" rpy="-0.5 0 0.2"/>
<axis xyz="1 1 0"/><dynamics damping="0.3"/></joint>
<joint name="grip" type="prismatic"><parent link="fore"/><child link="finger"/><origin xyz="0 0 0.3"/>
<axis xyz="0 0 1"/><limit lower="-0.02" upper="0.05" effort="10" velocity="0.5"/></joint>
</robot>"""

MJCF = """<mujoco model="arm"><compiler angle="radian" eulerseq="XYZ" autolimits="true"/>
<worldbody><body name="upper_arm" pos="0 0 0.5" euler="0 0.3 0">
<joint name="shoulder" type="hinge" axis="0 1 0" range="-2 1.5" damping="0.7" frictionloss="0.2" actuatorfrcrange="-80 80"/>
<body name="upper_casting" pos="0.02 0.01 0.2" euler="0.3 -0.4 0.5">
<inertial pos="0 0 0" mass="3" fullinertia="0.05 0.06 0.02 0.002 -0.001 0.003"/></body>
<body name="motor" pos="0.1 0 0.3" euler="0.4 1.2 -0.3">
<inertial pos="0.05 0 0" euler="0.2 0.1 0" mass="1.5" diaginertia="0.002 0.004 0.005"/>
<body name="forearm" pos="0 0.1 0.1" euler="-0.5 0 0.2">
<joint name="elbow" type="hinge" axis="2 2 0" damping="0.3"/>
<inertial pos="0 0.03 0.15" mass="2" fullinertia="0.03 0.025 0.01 0 0.001 0"/>
<body name="finger" pos="0 0 0.3">
<joint name="grip" type="slide" axis="0 0 1" range="-0.02 0.05" actuatorfrcrange="-10 10"/>
<inertial pos="0 0 0" mass="0.4" diaginertia="0.0006 0.0005 0.0004"/>
</body></body></body></body></worldbody></mujoco>"""
