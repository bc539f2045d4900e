"""Reads a URDF file with the standard library and prints the pose of every link in that of the root.

python3 read_urdf.py FILE ANGLES: ANGLES has a joint's name and angle (rad) a line. Prints name and the twelve numbers of
[R p], by rows. Ends with an error where the links are no tree or a joint has no angle.
"""
import sys
import xml.etree.ElementTree

import numpy as np


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def pose(origin):
    X = np.eye(4)
    roll, pitch, yaw = (float(a) for a in origin.get("rpy").split())
    X[:3, :3] = rotation((0, 0, 1), yaw) @ rotation((0, 1, 0), pitch) @ rotation((1, 0, 0), roll)
    X[:3, 3] = [float(a) for a in origin.get("xyz").split()]
    return X


def main():
    robot = xml.etree.ElementTree.parse(sys.argv[1]).getroot()
    with open(sys.argv[2]) as file:
        angles = {name: float(angle) for name, angle in (line.split() for line in file)}
    names = [link.get("name") for link in robot.iter("link")]
    assert len(set(names)) == len(names), "two links of one name"
    above = {}
    for joint in robot.iter("joint"):
        X = pose(joint.find("origin"))
        if joint.get("type") == "revolute":
            turn = np.eye(4)
            axis = [float(a) for a in joint.find("axis").get("xyz").split()]
            turn[:3, :3] = rotation(axis, angles.pop(joint.get("name")))
            X = X @ turn
        child = joint.find("child").get("link")
        assert child not in above, "two joints above " + child
        above[child] = (joint.find("parent").get("link"), X)
    assert not angles, f"no joints {list(angles)}"
    assert [name for name in names if name not in above] == ["waist"], "expected one root, waist"

    def pose_in_root(name):
        if name not in above:
            return np.eye(4)
        parent, X = above[name]
        return pose_in_root(parent) @ X

    for name in names:
        print(name, *pose_in_root(name)[:3].flatten())


main()
