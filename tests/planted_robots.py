"""One robot file in each format with all that engines' own loaders are known to change."""

_MOMENTS = '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/>'

URDF = f"""<robot name="planted">
<link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 0.2" rpy="0.3 0 0"/><mass value="2"/>{_MOMENTS}</inertial></link>
<link name="coil"><inertial><mass value="0"/>{_MOMENTS}</inertial></link>
<link name="eye"/>
<link name="left"><inertial><mass value="0.5"/>{_MOMENTS}</inertial></link>
<link name="right"><inertial><mass value="0.5"/>{_MOMENTS}</inertial></link>
<joint name="swing" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 2 0"/>
<limit lower="-1" upper="1.5" effort="20" velocity="3"/><dynamics damping="0.2" friction="0.1"/></joint>
<joint name="glue" type="fixed"><parent link="arm"/><child link="coil"/></joint>
<joint name="mount" type="fixed"><parent link="left"/><child link="eye"/><origin xyz="0 0.2 0"/></joint>
<joint name="open" type="prismatic"><parent link="arm"/><child link="left"/><origin xyz="0 0.1 0.4"/><axis xyz="0 1 0"/>
<limit lower="0" upper="0.05" effort="5" velocity="1"/></joint>
<joint name="shut" type="prismatic"><parent link="arm"/><child link="right"/><origin xyz="0 -0.1 0.4"/><axis xyz="0 -1 0"/>
<limit lower="0" upper="0.05" effort="5" velocity="1"/><mimic joint="open" multiplier="0.5" offset="0.01"/></joint>
</robot>"""

MJCF = """<mujoco model="planted"><worldbody>
<body name="arm" pos="0 0 1"><joint name="swing" type="hinge" axis="0 2 0" limited="true" range="-60 90" damping="0.2"
stiffness="3" armature="0.1" frictionloss="0.1"/>
<inertial pos="0.1 0 0.2" mass="2" diaginertia="0.02 0.03 0.04"/><geom type="box" size="0.1 0.1 0.1"/>
<body name="fist" pos="0 0 0.4"><joint name="turn" type="hinge" axis="1 0 0" range="-90 90"/>
<geom type="sphere" size="0.05" mass="0.5" pos="0 0.2 0"/><geom type="sphere" size="0.05" mass="0.5" pos="0 0.3 0"/></body>
<body name="thumb" pos="0 0.1 0.4"><joint name="grip" type="hinge" axis="1 0 0"/>
<geom type="capsule" size="0.02 0.1" density="500"/></body></body></worldbody>
<equality><joint joint1="grip" joint2="turn" polycoef="0.1 0.5 0 0 0"/></equality></mujoco>"""
