// The view of a run: passes the state of the simulator on as plain numbers.
#include <fmt/format.h>

#include <array>
#include <deque>
#include <memory>
#include <nlohmann/json.hpp>

#include "sim/camera/drawn_model.h"
#include "sim/export/export.h"
#include "sim/files/json.h"
#include "sim/live/recorded.h"
#include "sim/live/run.h"
#include "sim/view/live_view.h"
#include "sim/view/playback.h"
#include "sim/view/session.h"

namespace sim::view {
namespace {

constexpr int kLargestPicture_px = 512;

/// Numbers of four bytes, as this little-endian machine has them.
void put(std::string& to, const auto& numbers) {
  static_assert(sizeof(numbers[0]) == 4);
  to.append(reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size());
}

Model model_of(const std::shared_ptr<camera::PosedRobot>& robot, std::uint64_t seed) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::string numbers;
  for (const camera::DrawnPiece& piece : robot->pieces()) {
    list.push_back({{"body", piece.body},
                    {"picture", piece.picture},
                    {"vertices", piece.positions.size() / 3},
                    {"indices", piece.indices.size()}});
    for (const auto* const part : {&piece.positions, &piece.normals, &piece.colours, &piece.uv})
      put(numbers, *part);
    put(numbers, piece.indices);
  }
  std::string head = files::json_text(list);
  head.append((4 - head.size() % 4) % 4, ' ');
  Model model;
  put(model.pieces, std::array{static_cast<std::uint32_t>(head.size())});
  model.pieces += head + numbers;
  model.pictures = [robot, seed] {
    std::string bytes;
    for (const cv::Mat3b& picture : robot->pictures(seed, kLargestPicture_px)) {
      put(bytes, std::array{picture.cols, picture.rows});
      for (int row = 0; row < picture.rows; ++row)
        bytes.append(reinterpret_cast<const char*>(picture.ptr(row)),
                     3 * static_cast<std::size_t>(picture.cols));
    }
    return bytes;
  };
  return model;
}

std::shared_ptr<camera::PosedRobot> posed_robot(const scenario::Scenario& scenario,
                                                const std::filesystem::path& models) {
  return std::make_shared<camera::PosedRobot>(scenario.world.robot, scenario.world.room, models);
}

ShownRun shown_run(const scenario::Scenario& scenario, const std::shared_ptr<camera::PosedRobot>& robot) {
  ShownRun run{.label = fmt::format("{}, seed {}", scenario.name, scenario.seed)};
  run.moments = faults_of(scenario);
  run.model = model_of(robot, scenario.world.seed);
  if (scenario.camera)
    run.camera = live::intrinsics(camera::camera_model(*scenario.camera));
  else
    run.missing.emplace_back("No head images: the scenario has no camera.");
  if (!scenario.slam) run.missing.emplace_back("No estimate: the scenario has no filter.");
  return run;
}

void require_joints(const Eigen::VectorXd& q) {
  if (q.size() != walking::kJoints)
    throw std::runtime_error(
        fmt::format("the recording has {} joints, expected {}", q.size(), walking::kJoints));
}

/// Frames wait from their stamp until their image is drawn and the filter has used it.
class LiveSession : public ViewSession {
 public:
  LiveSession(const ViewRequest& request, const scenario::ReadScenario& read,
              const std::filesystem::path& models)
      : robot_(posed_robot(read.scenario, models)),
        view_(request, shown_run(read.scenario, robot_), request.control) {
    request.opened(url(view_.access()));
    if (request.wait) view_.wait_for_viewer();
    observer_.begins = [this](const recording::RecordingSetup& setup) { view_.begin(setup); };
    observer_.ticked = [this](slam::Stamp t) { view_.pace(t); };
    observer_.stamped = [this](const live::StampedState& state) { stamp(state); };
    observer_.tracking.wants = [this](const slam::Observation& o) { return wants(o); };
    observer_.tracking.tracked = [this](const slam::Observation& o, const tracking::Tracking* t) {
      show(o, t);
    };
  }

  const live::RunObserver& run_observer() const override { return observer_; }
  const tracking::TrackingObserver& tracking_observer() const override { return observer_.tracking; }
  void end(const std::string& how) override { view_.end(how); }

 private:
  void stamp(const live::StampedState& state) {
    if (!view_.has_viewers()) return;
    Frame frame{.t = state.t};
    frame.bodies = body_poses(*state.world.model(), *state.world.data(), robot_->bodies());
    frame.truth = state.world.X_WC();
    frame.plan = state.X_PC;
    frame.feet = {place_of(state.feet.left), place_of(state.feet.right)};
    frame.zmp = zero_moment_point({SoleForce{state.feet.left.truth, state.left.force, state.left.torque},
                                   SoleForce{state.feet.right.truth, state.right.force, state.right.torque}});
    stamped_.push_back(std::move(frame));
  }

  bool wants(const slam::Observation& observation) {
    while (!stamped_.empty() && stamped_.front().t < observation.t) stamped_.pop_front();
    return view_.wants(observation) && !stamped_.empty() && stamped_.front().t == observation.t;
  }

  void show(const slam::Observation& observation, const tracking::Tracking* tracking) {
    Frame frame = std::move(stamped_.front());
    stamped_.pop_front();
    add_tracked(frame, observation, tracking, view_.wants_map());
    view_.show(frame);
  }

  std::shared_ptr<camera::PosedRobot> robot_;
  live::RunObserver observer_;
  std::deque<Frame> stamped_;
  LiveView view_;
};

}  // namespace

std::shared_ptr<const exports::RobotDescription> robot_description(const scenario::Scenario& scenario,
                                                                   const std::filesystem::path& models) {
  const auto robot = posed_robot(scenario, models);
  auto description = std::make_shared<exports::RobotDescription>();
  description->urdf = camera::urdf(robot->model());
  description->links = robot->bodies();
  description->poses = [robot](const Eigen::VectorXd& q) {
    require_joints(q);
    const std::vector<float> poses = robot->poses({Eigen::Isometry3d::Identity(), q});
    std::vector<Eigen::Isometry3d> all;
    for (std::size_t i = 0; i < poses.size(); i += 7)  // p, then q as x, y, z, w
      all.push_back(Eigen::Translation3d(Eigen::Map<const Eigen::Vector3f>(&poses[i]).cast<double>()) *
                    Eigen::Isometry3d(Eigen::Quaternionf(&poses[i + 3]).cast<double>().normalized()));
    return all;
  };
  return description;
}

MakeRobot robot_maker(const std::filesystem::path& models) {
  return [models](const scenario::Scenario& scenario) {
    const auto robot = posed_robot(scenario, models);
    const auto poses = [robot](const Eigen::VectorXd& q, const Eigen::Isometry3d& X_WB) {
      require_joints(q);
      return robot->poses({X_WB, q});
    };
    return RobotModel{model_of(robot, scenario.world.seed), poses};
  };
}

std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const scenario::ReadScenario& read,
                                         const std::filesystem::path& models) {
  if (!request.view) return nullptr;
  return std::make_unique<LiveSession>(request, read, models);
}

}  // namespace sim::view
