// The recorded robot from outside: the true waist with the measured joint angles.
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "sim/camera/scene.h"
#include "sim/files/csv.h"
#include "sim/physics/model.h"
#include "sim/recording/recording.h"
#include "sim/view/session.h"
#include "sim/view/video_frame.h"
#include "walking/plan.h"

namespace sim::view {
namespace {

using namespace camera;
using namespace physics;
using Eigen::Vector3d;

constexpr int kDensity = 2;  // drawn so many times as dense, for smooth edges
constexpr double kFocal_px = 620;
const Pinhole kView{.width_px = kDensity * kPanelWidth,
                    .height_px = kDensity * kPanelHeight,
                    .focal_px = kDensity * kFocal_px,
                    .left = -0.5 * kPanelWidth / kFocal_px,
                    .top = -0.5 * kPanelHeight / kFocal_px};
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
  Drawing(const scenario::Scenario& scenario, const std::filesystem::path& recording,
          const std::filesystem::path& models)
      : model_(load_model(scenario.world.robot, scenario.world.room, models)),
        data_(mj_makeData(model_.get())),
        scene_(*model_, {kView}, scenario.world.seed, Channels::rgb, Robot::whole),
        encoders_(recording / "mav0/encoders0/data.csv", 1 + walking::kJoints),
        more_(encoders_.next()) {}

  cv::Mat draw(slam::Stamp t, const Eigen::Isometry3d& X_WB) {
    pose(t, X_WB);
    const Vector3d waist = X_WB.translation();
    cv::Mat picture;
    cv::resize(scene_.draw(*data_, looking(waist + kFromWaist, waist + kLookedAt)), picture,
               {kPanelWidth, kPanelHeight}, 0, 0, cv::INTER_AREA);
    cv::cvtColor(picture, picture, cv::COLOR_RGB2BGR);
    return picture;
  }

 private:
  void pose(slam::Stamp t, const Eigen::Isometry3d& X_WB) {
    for (; more_ && encoders_.integer(0) <= recording::file_stamp(t); more_ = encoders_.next())
      for (int joint = 0; joint < walking::kJoints; ++joint)
        data_->qpos[position_of(joint)] = encoders_.number(1 + static_cast<std::size_t>(joint));
    const Eigen::Quaterniond turned(X_WB.linear());
    Eigen::Map<Eigen::Matrix<double, 7, 1>> base(data_->qpos);  // the free joint
    base << X_WB.translation(), turned.w(), turned.vec();
    mj_kinematics(model_.get(), data_.get());
    mj_camlight(model_.get(), data_.get());
  }

  // The actuators are in the order of JointVector.
  int position_of(int joint) const { return model_->jnt_qposadr[model_->actuator_trnid[2 * joint]]; }

  physics::Model model_;
  physics::Data data_;
  camera::Scene scene_;
  files::CsvReader encoders_;
  bool more_;  ///< the reader is at a row that was not used yet
};

}  // namespace

RobotView robot_from_outside(const scenario::Scenario& scenario, const std::filesystem::path& recording,
                             const std::filesystem::path& models) {
  const auto drawing = std::make_shared<Drawing>(scenario, recording, models);
  return [drawing](slam::Stamp t, const Eigen::Isometry3d& X_WB) { return drawing->draw(t, X_WB); };
}

}  // namespace sim::view
