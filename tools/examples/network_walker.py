#!/usr/bin/env python3
"""A walking controller that runs a network from an .npz file with numpy.

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


ACTIVATIONS = {'tanh': np.tanh, 'relu': lambda x: np.maximum(x, 0),
               'elu': lambda x: np.where(x > 0, x, np.expm1(np.minimum(x, 0)))}


class Arrays(dict):
    """The arrays of a file by name."""

    def take(self, name, *shapes, words=None):
        """Removes an array and returns it: finite numbers (or text, if words are given) in one of the shapes (None: any size).
        Raises ValueError."""
        if name not in self:
            raise ValueError(f'{name}: missing array')
        array, kinds = np.asarray(self.pop(name)), 'biuf' if words is None else 'U'
        if array.dtype.kind not in kinds or words is None and not np.isfinite(array).all():
            raise ValueError(f'{name}: expected ' + ('finite numbers' if words is None else 'text'))
        if array.size == 0 or not any(len(shape) == array.ndim and all(a in (None, b) for a, b in zip(shape, array.shape))
                                      for shape in shapes):
            expected = ' or '.join(str(shape).replace('None', 'any') for shape in shapes)
            raise ValueError(f'{name}: has shape {array.shape}, expected {expected}')
        unknown = [word for word in array.flat if words and word not in words]
        if unknown:
            raise ValueError(f'{name}: unknown "{unknown[0]}", expected any of {", ".join(words)}')
        return array


class Network:
    """Recurrent layers l0, l1, ..., then layers W0, b0, W1, b1, ... with the activation between them.

    The arrays, the order of gates (LSTM i f g o, GRU r z n) and the formulas of recurrent layers follow PyTorch's documentation
    (https://pytorch.org/docs/stable/generated/torch.nn.LSTM.html and torch.nn.GRU.html)."""

    def __init__(self, arrays, size, outputs):
        self.cells, self.layers = [], []
        while any(name.endswith(layer := f'_l{len(self.cells)}') for name in arrays):
            units = (np.shape(arrays.get(f'weight_hh{layer}')) or (0,))[-1]
            R = arrays.take(f'weight_hh{layer}', (4 * units, units), (3 * units, units))
            W = arrays.take(f'weight_ih{layer}', (len(R), size))
            b_i, b_h = (arrays.take(f'bias_{side}h{layer}', (len(R),)) for side in 'ih')
            self.cells.append((W, R, b_i, b_h, np.zeros((2, size := units))))
        count = max(1, *(sum(name.startswith(kind) for name in arrays) for kind in 'Wb'))
        for i in range(count):
            W = arrays.take(f'W{i}', (None if i + 1 < count else outputs, size))
            self.layers.append((W, arrays.take(f'b{i}', (size := len(W),))))
        self.activation = ACTIVATIONS[str(arrays.take('activation', (), words=ACTIVATIONS))]

    def __call__(self, x):
        for W, R, b_i, b_h, state in self.cells:
            h, c = state.copy()
            a, b = (y.reshape(-1, len(h)) for y in (W @ x + b_i, R @ h + b_h))
            sigmoid = 0.5 + 0.5 * np.tanh(0.5 * (a + b))  # does not overflow
            if len(a) == 4:
                i, f, _, o = sigmoid
                c = f * c + i * np.tanh(a[2] + b[2])
                x = o * np.tanh(c)
            else:
                r, z, _ = sigmoid
                x = (1 - z) * np.tanh(a[2] + r * b[2]) + z * h
            state[:] = x, c
        for i, (W, b) in enumerate(self.layers):
            x = W @ (self.activation(x) if i else x) + b
        return x


class Walker:
    def __init__(self, arrays):
        joints = arrays.take('joints', (None,), words=())
        n = len(joints)
        sizes = {'command': 3, 'gyro': 3, 'up': 3, 'q': n, 'dq': n, 'action': n, 'phase': 2}
        observations = arrays.take('observations', (None,), words=sizes)
        counts = [sizes[name] for name in observations]
        shapes = {'q0': [(n,)], 'kp': [(n,)], 'kd': [(n,)], 'action_scale': [(), (n,)], 'largest_speeds': [(3,)],
                  'rate_hz': [()], 'settle_s': [()], 'phase_s': [()], 'stands': [()],
                  'observation_scales': [(len(counts),), (sum(counts),)]}
        self.policy = {name: arrays.take(name, *each) for name, each in shapes.items()}
        if self.policy['phase_s'] <= 0:
            raise ValueError('phase_s: expected more than 0')
        self.joints, self.observations, self.action = list(map(str, joints)), observations, np.zeros(n)
        scales = self.policy['observation_scales']
        self.scales = np.repeat(scales, counts) if len(scales) == len(counts) else scales
        self.network = Network(arrays, sum(counts), n)
        if arrays:
            raise ValueError(f'{min(arrays)}: unknown array')

    def ready(self, data):
        p = self.policy
        self.count = START_HEAD.unpack_from(data)[1]
        starts = range(START_HEAD.size, START_HEAD.size + self.count * JOINT_BYTES, JOINT_BYTES)
        names = [data[at:at + 48].split(b'\0')[0].decode() for at in starts]
        self.index = [names.index(joint) if joint in names else 0 for joint in self.joints]  # GaitSLAM reports an unknown one
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
        self.action = self.network(self.scales * np.concatenate([known[name] for name in self.observations]))
        target = self.policy['q0'] + self.policy['action_scale'] * self.action
        zero = np.zeros(len(target))
        rows = np.column_stack([target, zero, self.policy['kp'], self.policy['kd'], zero])
        return ANSWER_HEAD.pack(t_ns, 0, 0, len(target), 0) + bytes(PLAN_BYTES) + rows.astype('<f8').tobytes()


def main():
    # Only messages go to standard output; prints go to standard error.
    out = os.fdopen(os.dup(1), 'wb')
    os.dup2(2, 1)
    if len(sys.argv) != 2:
        print(f'usage: {sys.argv[0]} POLICY.npz', file=sys.stderr)
        sys.exit(2)
    try:
        walker = Walker(Arrays(np.load(sys.argv[1])))
    except Exception as error:  # numpy raises many kinds
        print(f'{sys.argv[1]}: {" ".join(str(error).split())}', file=sys.stderr)
        sys.exit(2)
    while True:
        head = sys.stdin.buffer.read(HEADER.size)
        if len(head) < HEADER.size:
            sys.exit('standard input ended without END')
        magic, kind, size = HEADER.unpack(head)
        assert magic == b'GSLM', magic
        data = sys.stdin.buffer.read(size)
        if kind == END:
            return
        kind, answer = (READY, walker.ready(data)) if kind == START else (ANSWER, walker.answer(data))
        out.write(HEADER.pack(b'GSLM', kind, len(answer)) + answer)
        out.flush()


if __name__ == '__main__':
    main()
