#!/usr/bin/env python3
"""A walking controller that runs a network from an .npz file, with numpy.

    tools/gaitslam run scenarios/g1_tangent_circle.yaml \\
        'walk.controller={program: [/usr/bin/python3, tools/examples/network_walker.py, policy.npz]}'

sim/controllers/README.md lists the arrays of the file; gaitslam_walker.h defines the messages."""
import os
import struct
import sys

import numpy as np

VERSION = 1
START, READY, SENSORS, ANSWER, END = 1, 2, 3, 4, 5
HEADER = struct.Struct('<4sIQ')
START_HEAD = struct.Struct('<IIqdQQQQ')
JOINT_BYTES, PLAN_BYTES, GO = 144, 424, 2
READY_HEAD = struct.Struct('<IIddddddIIIIII')
ANSWER_HEAD = struct.Struct('<qIIII')


def name_at(data, at):
    return data[at:at + 48].split(b'\0')[0].decode()


class Network:
    """Layers W0, b0, W1, b1, ... with tanh between them; with R0 the first one is recurrent: tanh(W0 x + R0 h + b0)."""

    def __init__(self, policy):
        self.layers = [(policy[f'W{i}'], policy[f'b{i}']) for i in range(100) if f'W{i}' in policy]
        self.recurrent = policy['R0'] if 'R0' in policy else None
        self.h = np.zeros(len(self.layers[0][1]))

    def __call__(self, x):
        for i, (W, b) in enumerate(self.layers):
            x = W @ x + b
            if i == 0 and self.recurrent is not None:
                x = x + self.recurrent @ self.h
            if i + 1 < len(self.layers):
                x = np.tanh(x)
            if i == 0:
                self.h = x
        return x


class Walker:
    def __init__(self, policy, data):
        self.policy, self.network = policy, Network(policy)
        count = START_HEAD.unpack_from(data)[1]
        names = [name_at(data, START_HEAD.size + i * JOINT_BYTES) for i in range(count)]
        self.joints = [str(joint) for joint in policy['joints']]
        self.index = [names.index(joint) if joint in names else 0 for joint in self.joints]  # GaitSLAM names a wrong one
        self.count, self.action = count, np.zeros(len(self.joints))

    def ready(self):
        p = self.policy
        head = READY_HEAD.pack(VERSION, 0, p['rate_hz'], p['settle_s'], *p['largest_speeds'], 0,
                               int(p['stands']), 0, 0, 0, len(self.joints), 0)
        joints = (joint.encode().ljust(48, b'\0') + struct.pack('<d', q) for joint, q in zip(self.joints, p['q0']))
        return head + bytes(PLAN_BYTES) + b''.join(joints)

    def answer(self, data):
        t_ns, command, _ = struct.unpack_from('<qII', data)
        numbers = np.frombuffer(data, '<f8', offset=16)
        q, dq = (numbers[36 + k * self.count:][self.index] for k in (0, 1))
        moves = command == GO or not self.policy['stands']
        phase = 2 * np.pi * 1e-9 * t_ns / self.policy['phase_s']
        known = {'command': numbers[0:3], 'gyro': numbers[15:18], 'up': numbers[21:24], 'q': q - self.policy['q0'], 'dq': dq,
                 'action': self.action, 'phase': moves * np.array([np.sin(phase), np.cos(phase)])}
        x = np.concatenate([scale * known[str(name)] for name, scale in
                            zip(self.policy['observations'], self.policy['observation_scales'])])
        self.action = self.network(x)
        target = self.policy['q0'] + self.policy['action_scale'] * self.action
        zero = np.zeros(len(target))
        rows = np.column_stack([target, zero, self.policy['kp'], self.policy['kd'], zero])
        return ANSWER_HEAD.pack(t_ns, 0, 0, len(target), 0) + bytes(PLAN_BYTES) + rows.astype('<f8').tobytes()


def main():
    # Only messages go to the standard output; prints go to the standard error.
    out = os.fdopen(os.dup(1), 'wb')
    os.dup2(2, 1)
    policy, walker = dict(np.load(sys.argv[1])), None
    while True:
        magic, kind, size = HEADER.unpack(sys.stdin.buffer.read(HEADER.size))
        assert magic == b'GSLM', magic
        data = sys.stdin.buffer.read(size)
        if kind == END:
            return
        if kind == START:
            walker = Walker(policy, data)
        kind, answer = (READY, walker.ready()) if kind == START else (ANSWER, walker.answer(data))
        out.write(HEADER.pack(b'GSLM', kind, len(answer)) + answer)
        out.flush()


main()
