#!/usr/bin/env python3
"""An estimator without images: integrates the gyro to an orientation, and the planned velocity along it.

    tools/gaitslam replay RESULT 'estimator={program: [/usr/bin/python3, tools/examples/gyro_and_plan.py], name: gyro}'

gaitslam_estimator.h defines the messages."""
import os
import struct
import sys

import numpy as np

VERSION = 4
START, READY, OBSERVATION, ANSWER, END = 1, 2, 3, 4, 5
HEADER = struct.Struct('<4sIQ')
OBSERVATION_HEAD = struct.Struct('<qIIIIII')  # before the plan: 32 bytes
ANSWER_HEAD = struct.Struct('<qII')           # before the pose: 16 bytes
POSE, MOTION, READING = 96, 336, 40           # bytes; the motion is plan, leg odometry and command


def pose(data, at):
    """Rotation matrix and position at an offset in a message."""
    numbers = np.frombuffer(data, '<f8', 12, at)
    return numbers[:9].reshape(3, 3).copy(), numbers[9:].copy()


def exponential(turn):
    """The rotation matrix of a rotation vector, by Rodrigues' formula."""
    angle = np.linalg.norm(turn)
    a, b = (np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2) if angle > 1e-9 else (1, 0.5)
    x, y, z = turn
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + a * K + b * K @ K


class Estimator:
    def __init__(self, start):
        self.R_CG, _ = pose(start, 80)
        self.R_WC, self.p_W = pose(start, 80 + POSE)
        self.v_W, self.t_ns, self.has_plan = np.zeros(3), 0, False

    def process(self, data):
        t_ns, _, _, gyro_count, _, has_plan, _ = OBSERVATION_HEAD.unpack_from(data)
        if t_ns < self.t_ns:  # late
            return
        for i in range(gyro_count):
            at = OBSERVATION_HEAD.size + MOTION + i * READING
            begin, end = struct.unpack_from('<qq', data, at)
            turn_G = 1e-9 * (end - begin) * np.frombuffer(data, '<f8', 3, at + 16)
            self.R_WC = self.R_WC @ exponential(self.R_CG @ turn_G)
        if has_plan:
            v_W = self.R_WC @ np.frombuffer(data, '<f8', 3, OBSERVATION_HEAD.size + POSE)
            self.p_W = self.p_W + (self.v_W + v_W) / 2 * 1e-9 * (t_ns - self.t_ns)
            self.v_W, self.has_plan = v_W, True
        self.t_ns = t_ns

    def answer(self):
        head = ANSWER_HEAD.pack(self.t_ns, 0 if self.has_plan else 3, 0)  # ok or not ready, no covariance
        numbers = np.concatenate([self.R_WC.ravel(), self.p_W, np.zeros(36)])
        return head + numbers.astype('<f8').tobytes() + struct.pack('<II', 0, 0)


def read_exactly(stream, size):
    data = stream.read(size)
    if len(data) != size:
        sys.exit(0)  # GaitSLAM has closed the pipe
    return data


def main():
    # Only messages go to standard output; prints go to standard error.
    out = os.fdopen(os.dup(1), 'wb')
    os.dup2(2, 1)
    estimator = None
    while True:
        magic, kind, size = HEADER.unpack(read_exactly(sys.stdin.buffer, HEADER.size))
        assert magic == b'GSLM', magic
        data = read_exactly(sys.stdin.buffer, size)
        if kind == START:
            estimator = Estimator(data)
            kind, answer = READY, struct.pack('<II', VERSION, 0)
        elif kind == OBSERVATION:
            estimator.process(data)
            kind, answer = ANSWER, estimator.answer()
        else:
            return
        out.write(HEADER.pack(b'GSLM', kind, len(answer)) + answer)
        out.flush()


main()
