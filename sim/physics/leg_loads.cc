#include "sim/physics/leg_loads.h"

#include <mujoco/mujoco.h>

#include <Eigen/LU>

namespace sim::physics {

using RowMajor3X = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;

LegLoads::LegLoads(Model on_floor, const walking::Robot& robot)
    : model_(std::move(on_floor)),
      data_(mj_makeData(model_.get())),
      legs_{robot.leg(walking::Side::left), robot.leg(walking::Side::right)},
      soles_{part(*model_, mjOBJ_SITE, "left_sole"), part(*model_, mjOBJ_SITE, "right_sole")} {}

std::array<walking::Wrench, 2> LegLoads::wrenches(const walking::JointVector& q,
                                                  const walking::JointVector& torque) const {
  const mjModel& m = *model_;
  mjData& d = *data_;
  Eigen::Map<Eigen::Matrix<double, 7, 1>>(d.qpos) << 0, 0, 0, 1, 0, 0, 0;
  for (int joint = 0; joint < m.nu; ++joint) d.qpos[m.jnt_qposadr[m.actuator_trnid[2 * joint]]] = q[joint];
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
    Eigen::Matrix<double, 6, 6> J;
    Eigen::Matrix<double, 6, 1> missing;
    for (int i = 0; i < 6; ++i) {
      const int joint = legs_[foot].joints[static_cast<std::size_t>(i)];
      const int dof = m.jnt_dofadr[m.actuator_trnid[2 * joint]];
      J.col(i) << forward.col(dof), turning.col(dof);
      missing[i] = gravity[dof] - torque[joint];
    }
    const Eigen::Matrix<double, 6, 1> wrench = J.transpose().partialPivLu().solve(missing);
    const Eigen::Matrix3d R = pose_in(d.site_xpos + 3 * site, d.site_xmat + 9 * site).linear();
    wrenches[foot] = {R.transpose() * wrench.head<3>(), R.transpose() * wrench.tail<3>()};
  }
  return wrenches;
}

}  // namespace sim::physics
