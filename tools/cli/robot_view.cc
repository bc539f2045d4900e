// The robot as recorded, from outside: the true waist with the planned joints.
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "sim/world/model.h"
#include "sim/world/nominal_body.h"
#include "sim/world/scene.h"
#include "tools/cli/live.h"
#include "tools/cli/video_frame.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"
#include "walking/stabilizer.h"

namespace cli {
namespace {

using namespace sim::world;
using Eigen::Vector3d;

constexpr double kFocal_px = 620;
const Vector3d kFromWaist(2.0, 1.45, 1.1), kLookedAt(0, 0, 0.15);  // m, from the waist

Eigen::Isometry3d looking(const Vector3d& from, const Vector3d& at) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  const Vector3d z = (at - from).normalized(), x = z.cross(Vector3d::UnitZ()).normalized();
  X_WC.linear() << x, z.cross(x), z;
  X_WC.translation() = from;
  return X_WC;
}

class Drawing {
 public:
  Drawing(const sim::bench::Scenario& scenario, const std::filesystem::path& models)
      : model_(load_model(scenario.world.robot, scenario.world.room, models)),
        data_(mj_makeData(model_.get())),
        scene_(*model_, kPanelWidth, kPanelHeight, 4, scenario.world.seed),
        plan_(scenario.walk, nominal_body(scenario.world.robot, models)) {}

  cv::Mat draw(slam::Stamp t, const Eigen::Isometry3d& X_WB) {
    pose(t, X_WB);
    const Vector3d waist = X_WB.translation();
    const Pinhole view{
        kPanelWidth, kPanelHeight, kFocal_px, -0.5 * kPanelWidth / kFocal_px, -0.5 * kPanelHeight / kFocal_px,
        {}};
    cv::Mat picture;
    cv::flip(scene_.draw(*data_, looking(waist + kFromWaist, waist + kLookedAt), view, true), picture, 0);
    cv::cvtColor(picture, picture, cv::COLOR_RGB2BGR);
    return picture;
  }

 private:
  void pose(slam::Stamp t, const Eigen::Isometry3d& X_WB) {
    while (reference_.t_s < slam::seconds(t) && ticks_-- > 0) reference_ = plan_.next();
    const walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference_)).q;
    const Eigen::Quaterniond turned(X_WB.linear());
    Eigen::Map<Eigen::Matrix<double, 7, 1>> base(data_->qpos);  // the free joint
    base << X_WB.translation(), turned.w(), turned.vec();
    for (int joint = 0; joint < walking::kJoints; ++joint) data_->qpos[position_of(joint)] = q[joint];
    mj_kinematics(model_.get(), data_.get());
    mj_camlight(model_.get(), data_.get());
  }

  // The actuators are in the order of JointVector.
  int position_of(int joint) const { return model_->jnt_qposadr[model_->actuator_trnid[2 * joint]]; }

  Model model_;
  Data data_;
  Scene scene_;
  walking::PatternGenerator plan_;
  std::size_t ticks_ = plan_.ticks();
  walking::Reference reference_ = plan_.next();
};

}  // namespace

RobotView robot_from_outside(const sim::bench::Scenario& scenario, const std::filesystem::path& models) {
  const auto drawing = std::make_shared<Drawing>(scenario, models);
  return [drawing](slam::Stamp t, const Eigen::Isometry3d& X_WB) { return drawing->draw(t, X_WB); };
}

}  // namespace cli
