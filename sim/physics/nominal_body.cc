#include "sim/physics/nominal_body.h"

#include <mujoco/mujoco.h>

#include <Eigen/LU>

namespace sim::physics {
namespace {

using RowMajor3X = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;

walking::BodyMomentum momentum(const mjModel& model, mjData& data, const walking::BodyMotion& motion) {
  Eigen::Map<Eigen::VectorXd>(data.qpos, model.nq) = robot_positions(model, motion.pose);
  const Eigen::Quaterniond turn(motion.pose.X_PB.linear());
  // A free joint's velocity: linear in the world, angular in the body.
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(data.qvel) << motion.v, turn.conjugate() * motion.w;
  for (int joint = 0; joint < model.nu; ++joint)
    data.qvel[model.jnt_dofadr[model.actuator_trnid[2 * joint]]] = motion.dq[joint];
  mj_kinematics(&model, &data);
  mj_comPos(&model, &data);
  mj_comVel(&model, &data);
  mj_subtreeVel(&model, &data);
  const int waist = model.jnt_bodyid[0];
  const auto of_waist = [&](const mjtNum* all) { return Eigen::Vector3d(all + 3 * waist); };
  const double mass = model.body_subtreemass[waist];
  return {mass, of_waist(data.subtree_com), mass * of_waist(data.subtree_linvel),
          of_waist(data.subtree_angmom)};
}

}  // namespace

walking::WholeBody nominal_body(Model on_floor) {
  const std::shared_ptr<const mjModel> model(std::move(on_floor));
  const std::shared_ptr<mjData> data(Data(mj_makeData(model.get())));
  return [=](const walking::BodyMotion& motion) { return momentum(*model, *data, motion); };
}

Eigen::VectorXd robot_positions(const mjModel& model, const walking::BodyPose& pose) {
  Eigen::VectorXd positions = Eigen::Map<const Eigen::VectorXd>(model.qpos0, model.nq);
  const Eigen::Quaterniond turn(pose.X_PB.linear());
  positions.head<7>() << pose.X_PB.translation(), turn.w(), turn.vec();
  for (int joint = 0; joint < model.nu; ++joint)
    positions[model.jnt_qposadr[model.actuator_trnid[2 * joint]]] = pose.q[joint];
  return positions;
}

LegLoads::LegLoads(Model on_floor, const walking::Robot& robot)
    : model_(std::move(on_floor)),
      data_(mj_makeData(model_.get())),
      legs_{robot.leg(walking::Side::left), robot.leg(walking::Side::right)},
      soles_{part(*model_, mjOBJ_SITE, "left_sole"), part(*model_, mjOBJ_SITE, "right_sole")} {}

std::array<walking::Wrench, 2> LegLoads::wrenches(const walking::JointVector& q,
                                                  const walking::JointVector& torque) const {
  const mjModel& m = *model_;
  mjData& d = *data_;
  Eigen::Map<Eigen::VectorXd>(d.qpos, m.nq) = robot_positions(m, {Eigen::Isometry3d::Identity(), q});
  mj_kinematics(&m, &d);
  mj_comPos(&m, &d);
  mj_comVel(&m, &d);  // at rest
  Eigen::VectorXd gravity(m.nv);
  mj_rne(&m, &d, 0, gravity.data());
  std::array<walking::Wrench, 2> wrenches;
  for (std::size_t foot = 0; foot < 2; ++foot) {
    const int site = soles_[foot];
    RowMajor3X forward(3, m.nv), turning(3, m.nv);
    mj_jac(&m, &d, forward.data(), turning.data(), d.site_xpos + 3 * site, m.site_bodyid[site]);
    Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> missing = Eigen::Matrix<double, 6, 1>::Zero();
    const auto joints = int(legs_[foot].joints.size());
    for (int i = 0; i < joints; ++i) {
      const int joint = legs_[foot].joints[std::size_t(i)];
      const int dof = m.jnt_dofadr[m.actuator_trnid[2 * joint]];
      J.col(i) << forward.col(dof), turning.col(dof);
      missing[i] = gravity[dof] - torque[joint];
    }
    Eigen::Matrix<double, 6, 1> wrench;
    if (joints == 6)
      wrench = J.transpose().partialPivLu().solve(missing);
    else  // the smallest wrench
      wrench = J.transpose().completeOrthogonalDecomposition().solve(missing);
    const Eigen::Matrix3d R = pose_in(d.site_xpos + 3 * site, d.site_xmat + 9 * site).linear();
    wrenches[foot] = {R.transpose() * wrench.head<3>(), R.transpose() * wrench.tail<3>()};
  }
  return wrenches;
}

}  // namespace sim::physics
