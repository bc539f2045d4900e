#!/usr/bin/env python3
"""A walking controller that runs a policy: a network (ONNX) and a page of YAML.

    tools/gaitslam run scenarios/g1_tangent_circle.yaml \\
        'walk.controller={program: [/usr/bin/python3, tools/examples/network_walker.py, tools/examples/policies/g1.yaml, policy.onnx]}'

policies/README.md describes the YAML; gaitslam_walker.h defines the messages. Needs Debian's python3-numpy, python3-onnx and
python3-yaml."""
import collections
import difflib
import os
import re
import struct
import sys

os.environ['OPENBLAS_NUM_THREADS'] = '1'  # networks are small

import numpy as np
import onnx
import onnx.numpy_helper
import yaml

VERSION = 2
START, READY, SENSORS, ANSWER, END = 1, 2, 3, 4, 5
HEADER = struct.Struct('<4sIQ')
START_HEAD = struct.Struct('<IIqdQQQQ')
JOINT_BYTES, PLAN_BYTES, STATE_NUMBERS = 144, 424, 56  # STATE_NUMBERS: in SENSORS before the joints
READY_HEAD = struct.Struct('<IIddddddIIIIIIII')
ANSWER_HEAD = struct.Struct('<qIIII')
STILL = 0.01  # commands below this, in m/s and rad/s, are zero


class Wrong(Exception):
    """An error in the page of YAML or in the network."""


class Keys:
    """The keys of a section of the YAML, taken one by one."""

    def __init__(self, file, node, name=''):
        self.file, self.node, self.name, self.values = file, node, name, {}
        if not isinstance(node, yaml.MappingNode):
            self.fail('expected keys with values')
        for key, value in node.value:
            if key.value in self.values:
                self.fail('is set twice', key.value, key)
            self.values[key.value] = (key, value)
        self.known = []

    def fail(self, problem, key='', node=None):
        mark, place = (node or self.node).start_mark, '.'.join(filter(None, (self.name, key)))
        raise Wrong(f'{self.file}:{mark.line + 1}:{mark.column + 1}: {place + ": " if place else ""}{problem}')

    def node_of(self, key, is_needed=False):
        """Returns the value of a key as a node; None if the key is missing or null."""
        self.known.append(key)
        value = self.values.pop(key, (None, None))[1]
        if value is not None and value.tag != 'tag:yaml.org,2002:null':
            return value
        if is_needed:
            self.fail('missing key', key)
        return None

    def section(self, key):
        node = self.node_of(key)
        return Keys(self.file, node or yaml.MappingNode('', [], self.node.start_mark), '.'.join(filter(None, (self.name, key))))

    def value(self, key, default, fits, expected):
        """Returns a value that fits; without default, the key must be there."""
        node = self.node_of(key, default is None)
        if node is None:
            return default
        try:
            value = yaml.SafeLoader('').construct_document(node)
            if fits(value):
                return value
        except (yaml.YAMLError, TypeError, ValueError, OverflowError):
            pass
        return self.fail(f'expected {expected}', key, node)

    def numbers(self, key, default, *shape, at_least=-np.inf):
        """Returns an array of this shape from finite numbers, or from one number or row for all."""
        rows = f' {" x ".join(map(str, shape))} of them' if shape else ''

        def fits(value):
            array = np.array(value, float)
            return np.isfinite(array).all() and (array >= at_least).all() and array.shape in [shape[i:] for i in range(len(shape) + 1)]
        bound = '' if at_least == -np.inf else f' of at least {at_least}'
        value = self.value(key, default, fits, f'a finite number{bound}{" or" + rows if rows else ""}')
        return np.broadcast_to(np.array(value, float), shape)

    def flag(self, key):
        return self.value(key, False, lambda value: isinstance(value, bool), 'true or false')

    def count(self, key, default):
        return self.value(key, default, lambda value: type(value) is int and 1 <= value <= 1000, 'a whole number from 1 to 1000')

    def end(self):
        for key, (node, _) in self.values.items():
            close = difflib.get_close_matches(key, self.known, 1)
            self.fail(f'unknown key, expected one of {", ".join(self.known)}' + (f'; did you mean {close[0]}?' if close else ''), key, node)


def is_numbers(value):
    return np.isfinite(np.array(value, float)).all()


def sigmoid(x):
    return 0.5 + 0.5 * np.tanh(0.5 * x)  # does not overflow


def gemm(a, x, w, b=0.0):
    x, w = (m.T if a.get(f'trans{side}') else m for m, side in ((x, 'A'), (w, 'B')))
    return a.get('alpha', 1.0) * (x @ w) + a.get('beta', 1.0) * b


def split(a, x, sizes=None):
    sizes = a.get('split', sizes)
    count = a['outputs'] if sizes is None else np.cumsum(np.asarray(sizes, int))[:-1]
    return np.split(x, count, a.get('axis', 0))


def unsqueeze(a, x, axes=None):
    return np.expand_dims(x, tuple(np.atleast_1d(a.get('axes', axes)).astype(int)))


def squeeze(a, x, axes=None):
    axes = a.get('axes', axes)
    return np.squeeze(x, None if axes is None else tuple(np.atleast_1d(axes).astype(int)))


def recurrent(a, x, W, R, B, _, h, c=None):
    """An LSTM with the gates i o f c or a GRU with z r h, for one step."""
    units = a['hidden_size']
    x, h, W, R = np.reshape(x, -1), np.reshape(h, -1), W[0], R[0]
    at, back = (W @ x + B[0, :len(W)]).reshape(-1, units), (R @ h + B[0, len(W):]).reshape(-1, units)
    if c is not None:
        i, o, f, _ = sigmoid(at + back)
        c = f * np.reshape(c, -1) + i * np.tanh(at[3] + back[3])
        h = o * np.tanh(c)
    else:
        z, r, _ = sigmoid(at + back)
        if not a.get('linear_before_reset'):
            back[2] = R[2 * units:] @ (r * h) + B[0, -units:]
            r = 1
        h = (1 - z) * np.tanh(at[2] + r * back[2]) + z * h
    states = [value.reshape(1, 1, -1) for value in (h, c) if value is not None]
    return [states[0][None], *states]


# Their attributes, then their inputs. https://onnx.ai/onnx/operators
OPERATORS = {
    'Add': lambda a, x, y: x + y, 'Sub': lambda a, x, y: x - y, 'Mul': lambda a, x, y: x * y, 'Div': lambda a, x, y: x / y,
    'Gemm': gemm, 'MatMul': lambda a, x, y: x @ y, 'LSTM': recurrent, 'GRU': recurrent, 'Split': split,
    'Tanh': lambda a, x: np.tanh(x), 'Sigmoid': lambda a, x: sigmoid(x), 'Relu': lambda a, x: np.maximum(x, 0),
    'Elu': lambda a, x: np.where(x > 0, x, a.get('alpha', 1.0) * np.expm1(np.minimum(x, 0))),
    'LeakyRelu': lambda a, x: np.where(x > 0, x, a.get('alpha', 0.01) * x), 'Softplus': lambda a, x: np.logaddexp(0, x),
    'Sqrt': lambda a, x: np.sqrt(x), 'Exp': lambda a, x: np.exp(x), 'Identity': lambda a, x: x,
    'Clip': lambda a, x, low=None, high=None: np.clip(x, a.get('min', -np.inf if low is None else low), a.get('max', np.inf if high is None else high)),
    'Concat': lambda a, *x: np.concatenate(x, a['axis']), 'Constant': lambda a: a['value'], 'Unsqueeze': unsqueeze, 'Squeeze': squeeze,
    'Flatten': lambda a, x: x.reshape(int(np.prod(x.shape[:a.get('axis', 1)])), -1),
    'Reshape': lambda a, x, shape: x.reshape([x.shape[i] if n == 0 else int(n) for i, n in enumerate(shape)])}
# Their other attributes would change the result.
ATTRIBUTES = {'LSTM': ['hidden_size'], 'GRU': ['hidden_size', 'linear_before_reset']}


def number_array(tensor):
    array = onnx.numpy_helper.to_array(tensor)
    return array.astype(float) if array.dtype.kind == 'f' else array


class Network:
    """An ONNX graph, computed with numpy. Its first input is the observation and its first output the action. Other inputs start
    at zero and get the other outputs of the step before, and so do the states of LSTM and GRU that are not inputs."""

    def __init__(self, file):
        model = onnx.load(file)
        onnx.checker.check_model(model)
        graph = model.graph
        self.constants = {tensor.name: number_array(tensor) for tensor in graph.initializer}
        inputs = [i for i in graph.input if i.name not in self.constants]
        self.inputs, self.outputs = [i.name for i in inputs], [o.name for o in graph.output]
        if not inputs or len(inputs) > len(self.outputs):
            raise ValueError(f'has {len(inputs)} inputs and {len(self.outputs)} outputs, expected one for each input')
        self.states = {i.name: np.zeros([d.dim_value or 1 for d in i.type.tensor_type.shape.dim]) for i in inputs[1:]}
        self.nodes = []
        for node in graph.node:
            a = {each.name: onnx.helper.get_attribute_value(each) for each in node.attribute}
            wrong = set(a) - set(ATTRIBUTES.get(node.op_type, a))
            if node.op_type not in OPERATORS or wrong:
                raise ValueError(f'{node.op_type}{" with " + min(wrong) if wrong else ""} is not supported, expected any of {", ".join(sorted(OPERATORS))}')
            if node.op_type == 'Constant':
                a['value'] = number_array(a['value'])
            a['outputs'] = len(node.output)
            self.nodes.append((node.op_type, a, list(node.input), list(node.output)))

    def __call__(self, x):
        values = {'': None, **self.constants, self.inputs[0]: x[None], **self.states}
        for kind, a, inputs, outputs in self.nodes:
            made = OPERATORS[kind](a, *(values[name] for name in inputs))
            made = made if isinstance(made, list) else [made]
            values.update(zip(outputs, made))
            if kind in ATTRIBUTES:
                self.states.update((name, state) for name, state in zip(inputs[5:], made[1:]) if name in self.constants)
        self.states.update(zip(self.inputs[1:], (values[name] for name in self.outputs[1:])))
        return np.reshape(values[self.outputs[0]], -1)


class Term:
    """A term of the observation: each value clipped, then scaled; the newest frames, the oldest first."""

    def __init__(self, keys, size):
        self.clip = keys.numbers('clip', [-np.inf, np.inf], 2)
        self.scale = keys.numbers('scale', 1.0, size)
        self.frames = keys.count('history_length', 1)
        keys.end()
        self.history = collections.deque(maxlen=self.frames)

    def __call__(self, value):
        value = self.scale * np.clip(value, *self.clip)
        self.history.extend([value] * (1 if self.history else self.frames))
        return np.concatenate(self.history)


class Policy:
    """The page of YAML: observation from SENSORS, commands of joints from the network's output."""

    def __init__(self, file):
        with open(file, 'rb') as text:
            keys = Keys(file, yaml.compose(text, yaml.SafeLoader) or yaml.ScalarNode('', '', yaml.Mark(file, 0, 0, 0, None, None)))
        names = keys.value('joints', None, lambda v: all(isinstance(each, str) for each in v) and len(set(v)) == len(v) > 0, 'a list of different names')
        every = range(len(names))
        order = keys.value('joint_ids_map', [*every], lambda v: sorted(v) == [*every], f'the numbers from 0 to {len(names) - 1}')
        self.stiffness, self.damping = (keys.numbers(key, None, len(names), at_least=0)[order] for key in ('stiffness', 'damping'))
        self.joints, self.start = [names[i] for i in order], keys.numbers('default_joint_pos', None, len(names))
        self.step_dt = keys.numbers('step_dt', None, at_least=0.005)
        self.settle_s, self.stands = keys.numbers('settle_s', 2.0, at_least=0), keys.flag('stands')
        self.read_action(action := keys.section('actions').section('JointPositionAction'))
        command = keys.section('commands').section('base_velocity')
        ranges = command.section('ranges')
        self.ranges = np.array([ranges.numbers(key, None, 2) for key in ('lin_vel_x', 'lin_vel_y', 'ang_vel_z')]).T
        ranges.node_of('heading')
        self.rate = command.numbers('rate', np.inf, 3, at_least=0)
        self.read_observation(keys)
        for section in (action, ranges, command, keys):
            section.end()
        self.steps, self.command, self.yaw = 0, np.zeros(3), 0.0

    def read_action(self, keys):
        patterns = keys.value('joint_names', ['.*'], lambda v: all(re.compile(each) for each in v), 'a list of regular expressions')
        self.moved = [i for i, joint in enumerate(self.joints) if any(re.fullmatch(each, joint) for each in patterns)]
        n = len(self.moved)
        keys.node_of('joint_ids')  # repeats joint_names
        self.scale, self.offset = keys.numbers('scale', 1.0, n), keys.numbers('offset', self.start[self.moved], n)
        self.clip = keys.numbers('clip', [-np.inf, np.inf], n, 2)
        self.output_clip, self.tanh = keys.numbers('output_clip', [-np.inf, np.inf], 2), keys.flag('tanh')
        self.action = np.zeros(n)

    def read_observation(self, keys):
        n = len(self.moved)
        sizes = {'base_lin_vel': 3, 'base_ang_vel': 3, 'projected_gravity': 3, 'base_euler': 3, 'velocity_commands': 3,
                 'joint_pos_rel': n, 'joint_vel_rel': n, 'last_action': n, 'gait_phase': 2, 'constant': 1}
        terms = keys.section('observations')
        self.terms, self.size = {}, 0
        for name in [*terms.values]:
            if name not in sizes:
                terms.known = [*sizes]
                terms.end()
            term = terms.section(name)
            params = term.section('params')
            if name == 'gait_phase':
                self.period = params.numbers('period', None, at_least=0.01)
                self.offsets = np.atleast_1d(params.value('offsets', 0.0, is_numbers, 'numbers'))
                sizes[name] = 2 * len(self.offsets)
                self.cos_first = params.flag('cos_first')
                self.at_rest = params.numbers('at_rest', np.nan, sizes[name])
            elif name == 'constant':
                self.constant = np.atleast_1d(params.value('values', None, is_numbers, 'numbers')).astype(float)
                sizes[name] = len(self.constant)
            params.node_of('command_name')
            params.end()
            self.terms[name] = Term(term, sizes[name])
            self.size += self.terms[name].frames * sizes[name]
        self.stack = collections.deque(maxlen=keys.count('stacked_frames', 1))
        self.size *= self.stack.maxlen
        normal = keys.section('normalization')
        self.mean, self.std = normal.numbers('mean', 0.0, self.size), normal.numbers('std', 1.0, self.size, at_least=1e-9)
        normal.end()

    def phase(self):
        if not np.isnan(self.at_rest).any() and np.linalg.norm(self.command) < STILL:
            return self.at_rest
        angle = 2 * np.pi * (self.steps * self.step_dt / self.period + self.offsets)
        return np.concatenate([np.cos(angle), np.sin(angle)] if self.cos_first else [np.sin(angle), np.cos(angle)])

    def observe(self, numbers, q, dq, R_BG):
        """numbers: of SENSORS; q, dq: in the policy's order."""
        wanted = np.clip(numbers[0:3], *self.ranges)
        self.command = self.command + np.clip(wanted - self.command, -self.rate * self.step_dt, self.rate * self.step_dt)
        up, gyro = numbers[21:24], R_BG @ numbers[15:18]
        self.yaw = np.angle(np.exp(1j * (self.yaw + self.step_dt * (up @ gyro))))  # within π
        known = {'base_lin_vel': numbers[36:39], 'base_ang_vel': gyro, 'projected_gravity': -up,
                 'base_euler': [np.arctan2(up[1], up[2]), np.arcsin(np.clip(-up[0], -1, 1)), self.yaw],
                 'velocity_commands': self.command, 'joint_pos_rel': (q - self.start)[self.moved], 'joint_vel_rel': dq[self.moved],
                 'last_action': self.action}
        if 'gait_phase' in self.terms:
            known['gait_phase'] = self.phase()
        if 'constant' in self.terms:
            known['constant'] = self.constant
        self.steps += 1
        frame = np.concatenate([term(known[name]) for name, term in self.terms.items()])
        self.stack.extend([frame] * (1 if self.stack else self.stack.maxlen))
        return (np.concatenate(self.stack) - self.mean) / self.std

    def act(self, output):
        """Returns the target angles, in the policy's order."""
        self.action = np.clip(np.tanh(output) if self.tanh else output, *self.output_clip)
        target = self.start.copy()
        target[self.moved] = np.clip(self.offset + self.scale * self.action, *self.clip.T)
        return target


class Walker:
    def __init__(self, policy, network):
        self.policy, self.network = policy, network

    def ready(self, data):
        p = self.policy
        self.count = START_HEAD.unpack_from(data)[1]
        starts = range(START_HEAD.size, START_HEAD.size + self.count * JOINT_BYTES, JOINT_BYTES)
        names = [data[at:at + 48].split(b'\0')[0].decode() for at in starts]
        self.index = [names.index(joint) if joint in names else 0 for joint in p.joints]  # GaitSLAM reports an unknown one
        self.R_BG = np.frombuffer(data, '<f8', 9, starts.stop + 48).reshape(3, 3)
        head = READY_HEAD.pack(VERSION, 0, 1 / p.step_dt, p.settle_s, *np.minimum(-p.ranges[0], p.ranges[1]), 0, p.stands, 0, 0, 0,
                               len(p.joints), 0, 0, 0)
        joints = (joint.encode().ljust(48, b'\0') + struct.pack('<d', q) for joint, q in zip(p.joints, p.start))
        return head + bytes(PLAN_BYTES) + b''.join(joints)

    def answer(self, data):
        p, t_ns = self.policy, struct.unpack_from('<q', data)[0]
        numbers = np.frombuffer(data, '<f8', STATE_NUMBERS + 2 * self.count, 16)
        q, dq = (numbers[STATE_NUMBERS + k * self.count:][self.index] for k in (0, 1))
        target = p.act(self.network(p.observe(numbers, q, dq, self.R_BG)))
        zero = np.zeros(len(target))
        rows = np.column_stack([target, zero, p.stiffness, p.damping, zero])
        return ANSWER_HEAD.pack(t_ns, 0, 0, len(target), 0) + bytes(PLAN_BYTES) + rows.astype('<f8').tobytes()


def read(policy_file, network_file):
    """Returns a walker. Raises Wrong, OSError or yaml.YAMLError."""
    policy = Policy(policy_file)
    try:
        network = Network(network_file)
        outputs = len(Network(network_file)(np.zeros(policy.size)))
    except Exception as error:  # onnx raises many kinds
        raise Wrong(f'{network_file}: with the {policy.size} numbers of {policy_file}: {error}') from error
    if outputs != len(policy.moved):
        raise Wrong(f'{network_file}: has {outputs} outputs, expected {len(policy.moved)}, one for each joint of actions in {policy_file}')
    return Walker(policy, network)


def main():
    # Only messages go to standard output; prints go to standard error.
    out = os.fdopen(os.dup(1), 'wb')
    os.dup2(2, 1)
    if len(sys.argv) != 3:
        print(f'usage: {sys.argv[0]} POLICY.yaml POLICY.onnx', file=sys.stderr)
        sys.exit(2)
    try:
        walker = read(*sys.argv[1:])
    except (Wrong, OSError, yaml.YAMLError) as error:
        mark = getattr(error, 'problem_mark', None)
        text = f'{mark.name}:{mark.line + 1}:{mark.column + 1}: {error.problem}' if mark else str(error)
        print(' '.join(text.split()), file=sys.stderr)
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
