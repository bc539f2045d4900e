#!/usr/bin/python3
"""When soles move on the ground: turning and way of both feet by the time since each touched down.
Usage: slip_by_time.py RESULT... (result folders with their recording)"""
import sys

import numpy

EDGES = [0, 0.1, 0.2, 0.7, 0.8, 1.0]  # s
TOUCH = 5.58  # N, a hundredth of the weight of the robot
BOUNCE, STAND = 6, 200  # samples of 5 ms: in the air for less is no step; on the ground for more is standing
COLUMNS = 11  # of each foot: x, y, yaw, plan, planned_down, load, creep


def stances(load):
    """Pairs of first and last sample on the ground."""
    down = numpy.flatnonzero(load > TOUCH)
    groups = numpy.split(down, numpy.flatnonzero(numpy.diff(down) > BOUNCE) + 1)
    return [(g[0], g[-1]) for g in groups if g[0] > 0 and g[-1] - g[0] < STAND]


def slip(feet):
    """Per interval of EDGES: summed turn to the left, deg, and way, mm."""
    total = numpy.zeros((len(EDGES) - 1, 2))
    for foot in (feet[:, 1 : 1 + COLUMNS], feet[:, 1 + COLUMNS :]):
        for begin, end in stances(foot[:, 7]):
            moved = numpy.diff(foot[begin : end + 1, :3], axis=0)
            since = 1e-9 * (feet[begin:end, 0] - feet[begin, 0])
            interval = numpy.digitize(since, EDGES) - 1
            numpy.add.at(total[:, 0], interval, numpy.degrees(moved[:, 2]))
            numpy.add.at(total[:, 1], interval, 1e3 * numpy.hypot(moved[:, 0], moved[:, 1]))
    return total


if len(sys.argv) < 2:
    sys.exit(__doc__)
print("| turn to the left, way; s since touching down |", *(f" {a} to {b} |" for a, b in zip(EDGES, EDGES[1:])), sep="")
print("|---" * len(EDGES) + "|")
for result in sys.argv[1:]:
    feet = numpy.loadtxt(result + "/recording/truth/feet.csv", delimiter=",", comments="#")
    print(f"| {result} |", *(f" {turn:.1f}°, {way:.0f} mm |" for turn, way in slip(feet)), sep="")
