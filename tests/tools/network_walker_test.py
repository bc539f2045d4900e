"""The example that walks with a network: what it reads, what the network gets and what the joints get, against numbers computed by
hand and by torch 1.13.1."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import onnx
from onnx import TensorProto, helper

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / 'tools/examples'))
import network_walker  # noqa: E402

PAGE = '''joints: [left, right]
joint_ids_map: [1, 0]
step_dt: 0.02
stiffness: [10, 20]
damping: 1
default_joint_pos: [0.1, 0.2]
commands: {base_velocity: {ranges: {lin_vel_x: [-0.5, 1], lin_vel_y: [-1, 1], ang_vel_z: [-1, 1]}, rate: [5, 50, 50]}}
actions: {JointPositionAction: {scale: 0.5, output_clip: [-1, 1], clip: [-0.3, 9]}}
stacked_frames: 2
observations:
  base_ang_vel: {scale: [2, 2, 2], clip: [-1, 1]}
  velocity_commands: {}
  joint_pos_rel: {history_length: 2}
  last_action: {}
  gait_phase: {params: {period: 0.08, offsets: [0, 0.5], at_rest: [7, 7, 8, 8]}}
normalization: {mean: 1, std: 2}
'''


def save(file, nodes, size, outputs, **arrays):
    tensors = [onnx.numpy_helper.from_array(np.asarray(array, np.float32), name) for name, array in arrays.items()]
    info = [helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, count]) for name, count in (('obs', size), ('actions', outputs))]
    onnx.save(helper.make_model(helper.make_graph(nodes, 'policy', info[:1], info[1:], tensors),
                                opset_imports=[helper.make_opsetid('', 11)], ir_version=7), str(file))


def weights(*shape):
    return np.sin(1 + np.arange(np.prod(shape))).reshape(shape)


class NetworkWalker(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def write(self, page):
        (self.folder / 'p.yaml').write_text(page)
        return str(self.folder / 'p.yaml')

    def test_the_network_gets_its_terms_clipped_scaled_and_stacked_and_the_joints_get_its_action(self):
        W = np.zeros((2, 32))
        W[0, 3], W[1, 19] = 4, -2  # the older and the newer command ahead
        save(self.folder / 'p.onnx', [helper.make_node('Gemm', ['obs', 'W', 'b'], ['actions'], transB=1)], 32, 2, W=W, b=[0, 0])
        walker = network_walker.read(self.write(PAGE), str(self.folder / 'p.onnx'))
        turned = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])  # the IMU in the base
        joints = b''.join(name.ljust(48, b'\0') + bytes(96) for name in (b'head', b'left', b'right'))
        start = network_walker.START_HEAD.pack(2, 3, 5000000, 9.81, 1, 0, 0, 0) + joints + b'imu'.ljust(48, b'\0') + turned.astype('<f8').tobytes()
        ready = network_walker.READY_HEAD.unpack_from(walker.ready(start))
        self.assertEqual(ready[2:8], (50, 2, 0.5, 1, 1, 0))
        self.assertEqual(ready[-4:], (2, 0, 0, 0))
        inputs = []
        walker.network, network = lambda x: (inputs.append(2 * x + 1), network(x))[1], walker.network
        answers = []
        for speed in (0, 3):
            numbers = np.zeros(network_walker.STATE_NUMBERS + 9)
            numbers[0], numbers[15:18] = speed, [0.2, 0.4, 0.9]
            numbers[network_walker.STATE_NUMBERS:][:3] = [9, 0.5, 0.3 + speed]  # head, left, right
            answers.append(np.frombuffer(walker.answer(bytes(16) + numbers.tobytes()), '<f8', offset=24 + 424).reshape(2, 5))
        gyro = [-0.8, 0.4, 1.8]  # turned, clipped at 1 and doubled: -0.4, 0.2, 0.9
        rest = [*gyro, 0, 0, 0, 0.2, 0.3, 0.2, 0.3, 0, 0, 7, 7, 8, 8]
        np.testing.assert_allclose(inputs[0], rest[:16] * 2, atol=1e-6)
        # output: 4 (0 - 1) / 2 = -2, -2 (0 - 1) / 2 = 1; the action is -1, 1
        np.testing.assert_allclose(answers[0], [[-0.3, 0, 20, 1, 0], [0.7, 0, 10, 1, 0]], atol=1e-6)
        # 5 m/s² for 0.02 s: 0.1 m/s; a quarter of the period
        np.testing.assert_allclose(inputs[1], rest + [*gyro, 0.1, 0, 0, 0.2, 0.3, 3.2, 0.3, -1, 1, 1, -1, 0, 0], atol=1e-6)

    def test_integrated_yaw_stays_within_half_a_turn(self):
        policy = network_walker.Policy(self.write(PAGE.split('stacked')[0] + 'observations: {base_euler: {}}'))
        numbers = np.zeros(network_walker.STATE_NUMBERS)
        numbers[17], numbers[23] = 4, 1  # rad/s; upright
        yaws = [policy.observe(numbers, np.zeros(2), np.zeros(2), np.eye(3))[2] for _ in range(50)]
        np.testing.assert_allclose([yaws[38], yaws[39], yaws[49]], [3.12, 3.2 - 2 * np.pi, 4 - 2 * np.pi])

    def test_layers_compute_like_torch(self):
        for gates, activation, expected in ((4, 'Elu', [-0.5320223790, -0.1518338052]), (3, 'Elu', [-0.5964973203, -0.3505637169]),
                                            (0, 'Tanh', [-0.7615941560, 0.9640275801]), (0, 'Relu', [0, 2]), (0, 'Elu', [-0.6321205588, 2])):
            order = {4: [0, 3, 1, 2], 3: [1, 0, 2], 0: []}[gates]  # of torch's gates in ONNX
            rows, nodes, arrays = 2 * gates, [], {'E': np.eye(2), 'b': np.zeros(2)}
            if gates:
                W, R, b_i, b_h = (each.reshape(gates, 2, -1)[order].reshape(rows, -1) for each in (
                    weights(rows, 3), weights(rows, 2), weights(rows), weights(rows) / 2))
                arrays |= {'W': W[None], 'R': R[None], 'B': np.concatenate([b_i, b_h]).T, 'h': np.zeros((1, 1, 2)), 'c': np.zeros((1, 1, 2))}
                nodes = [helper.make_node('Unsqueeze', ['obs'], ['s'], axes=[0]), helper.make_node(
                    {4: 'LSTM', 3: 'GRU'}[gates], ['s', 'W', 'R', 'B', '', 'h'] + ['c'] * (gates == 4), ['y'] + ['H', 'C'][:gates - 2],
                    hidden_size=2, **{'linear_before_reset': 1} if gates == 3 else {}), helper.make_node('Squeeze', ['y'], ['x'], axes=[0, 1])]
            nodes += [helper.make_node('Gemm', ['x' if gates else 'obs', 'E', 'b'], ['z']), helper.make_node(activation, ['z'], ['actions'])]
            save(self.folder / 'p.onnx', nodes, 3 if gates else 2, 2, **arrays)
            network = network_walker.Network(str(self.folder / 'p.onnx'))
            outputs = [network(np.cos([t, t + 1, t + 2]) if gates else np.array([-1, 2])) for t in range(5)]
            np.testing.assert_allclose(outputs[-1], expected, atol=1e-7)  # of float weights

    def test_the_shipped_pages_have_the_inputs_of_their_networks(self):
        sizes = {file.stem: network_walker.Policy(str(file)).size for file in (ROOT / 'tools/examples/policies').glob('*.yaml')}
        self.assertEqual(sizes, {
            'unitree_rl_gym_g1': 47, 'unitree_rl_gym_h1': 41, 'unitree_rl_gym_h1_2': 47, 'unitree_rl_lab_g1': 480, 'booster_gym_t1': 47,
            'mujoco_playground_g1': 103, 'mujoco_playground_t1': 85, 'tienkung_lab': 750, 'humanoid_gym_xbot_l': 705})

    def test_a_wrong_page_or_network_is_one_line_with_its_place_and_exit_code_2(self):
        save(self.folder / 'p.onnx', [helper.make_node('Softmax', ['obs'], ['actions'])], 32, 2)
        save(self.folder / 'q.onnx', [helper.make_node('Tanh', ['obs'], ['actions'])], 32, 32)
        for network, old, new, message in (
                ('p.onnx', '', '', 'p.onnx: with the 32 numbers of p.yaml: Softmax is not supported, expected any of Add, '),
                ('q.onnx', '', '', 'q.onnx: has 32 outputs, expected 2, one for each joint of actions in p.yaml'),
                ('r.onnx', '', '', "r.onnx: with the 32 numbers of p.yaml: [Errno 2] No such file or directory: 'r.onnx'"),
                ('q.onnx', 'damping', 'dampin', 'p.yaml:1:1: damping: missing key'),
                ('q.onnx', 'stiffness: [10', 'stiffness: [-1', 'p.yaml:4:12: stiffness: expected a finite number of at least 0 or 2 of them'),
                ('q.onnx', 'period: 0.08', 'period: .nan', 'p.yaml:15:33: observations.gait_phase.params.period: expected a finite number of at least 0.01'),
                ('q.onnx', '[1, 0]', '[1, 1]', 'p.yaml:2:16: joint_ids_map: expected the numbers from 0 to 1'),
                ('q.onnx', 'base_ang_vel', 'base_ang_val', 'p.yaml:11:3: observations.base_ang_val: unknown key, expected one of base_lin_vel, '),
                ('q.onnx', 'stacked_frames', 'stacked_frame', 'p.yaml:9:1: stacked_frame: unknown key, expected one of joints, '),
                ('q.onnx', 'stacked_frames: 2', 'damping: 2', 'p.yaml:9:1: damping: is set twice'),
                ('q.onnx', 'actions: {', 'actions: ', 'p.yaml:8:')):
            self.write(PAGE.replace(old, new, 1) if old else PAGE)
            made = subprocess.run(['/usr/bin/python3', '-B', network_walker.__file__, 'p.yaml', network], cwd=self.folder, capture_output=True,
                                  text=True, check=False)
            self.assertEqual((made.returncode, made.stderr.count('\n'), made.stderr[:len(message)]), (2, 1, message), made.stderr)


if __name__ == '__main__':
    unittest.main()
