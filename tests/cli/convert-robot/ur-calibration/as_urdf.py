"""The joints that ur_description makes of a kinematics file, as a URDF."""

import re
import sys

text = open(sys.argv[1]).read()
links = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"]
keys = ["x", "y", "z", "roll", "pitch", "yaw"]
joints = []


def joint(name, kind, parent, child, xyz, rpy):
    joints.append(f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
                  f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/></joint>')


joint("inertia", "fixed", "base_link", "base_link_inertia", "0 0 0", "0 0 3.141592653589793")
joint("base", "fixed", "base_link", "base", "0 0 0", "0 0 3.141592653589793")
parent = "base_link_inertia"
for link in links:
    block = text[re.search(rf"^  {link}:", text, re.M).end():]
    numbers = [re.search(rf"\b{key}: *([-+.\de]+)", block)[1] for key in keys]
    joint(link, "continuous", parent, link + "_link", " ".join(numbers[:3]), " ".join(numbers[3:]))
    parent = link + "_link"
joint("flange", "fixed", parent, "flange", "0 0 0", "0 -1.5707963267948966 -1.5707963267948966")
joint("tool0", "fixed", "flange", "tool0", "0 0 0", "1.5707963267948966 0 1.5707963267948966")
names = ["base_link", "base_link_inertia", "base"] + [link + "_link" for link in links] + ["flange", "tool0"]
print('<robot name="ur">' + "".join(f'<link name="{name}"/>' for name in names) + "\n".join(joints) + "</robot>")
