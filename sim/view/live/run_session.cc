// The view of a run: passes the state of the simulator on as plain numbers.
#include <fmt/format.h>

#include <deque>
#include <memory>

#include "sim/camera/drawn_model.h"
#include "sim/camera/urdf.h"
#include "sim/export/export.h"
#include "sim/live/recorded.h"
#include "sim/live/run.h"
#include "sim/view/live_view.h"
#include "sim/view/playback.h"
#include "sim/view/session.h"

namespace sim::view {
namespace {

constexpr int kLargestPicture_px = 512;

Model model_of(const std::shared_ptr<camera::PosedRobot>& robot, std::uint64_t seed) {
  Model model;
  for (const camera::DrawnPiece& piece : robot->drawn().pieces)
    model.pieces.push_back(
        {piece.body, piece.picture, piece.positions, piece.normals, piece.colours, piece.uv, piece.indices});
  model.pictures = [robot, seed] {
    return drawn_pictures(robot->model(), robot->drawn(), seed, kLargestPicture_px);
  };
  return model;
}

std::shared_ptr<camera::PosedRobot> posed_robot(const scenario::Scenario& scenario,
                                                const std::filesystem::path& models) {
  return std::make_shared<camera::PosedRobot>(scenario.world.robot, scenario.world.room, models);
}

ShownRun shown_run(const scenario::ReadScenario& read, const std::shared_ptr<camera::PosedRobot>& robot,
                   bool next_follows) {
  const scenario::Scenario& scenario = read.scenario;
  ShownRun run{.label = fmt::format("{}, seed {}", read.scenario.name, scenario.seed),
               .next_follows = next_follows};
  run.moments = faults_of(scenario);
  run.model = model_of(robot, scenario.world.seed);
  if (scenario.camera)
    run.camera = live::intrinsics(camera::camera_model(*scenario.camera));
  else
    run.missing.emplace_back("No head images: the scenario has no camera.");
  if (!scenario.slam) run.missing.emplace_back("No estimate: the scenario has no filter.");
  return run;
}

FootPlace place_of(const recording::TrueFoot& foot) {
  return {foot.truth, foot.plan, foot.planned_down, foot.load_n};
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
        view_(Access{request.address, request.port, request.token},
              shown_run(read, robot_, request.next_follows), request.control) {
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
    if (!bodies_) bodies_.emplace(*state.world.model(), robot_->drawn().bodies);
    Frame frame{.t = state.t};
    frame.bodies = bodies_->of(*state.world.data());
    frame.truth = state.world.X_WC();
    frame.plan = state.X_PC;
    frame.feet = {place_of(state.feet.left), place_of(state.feet.right)};
    frame.zmp = zero_moment_point({SoleForce{state.feet.left.truth, state.left.force, state.left.torque},
                                   SoleForce{state.feet.right.truth, state.right.force, state.right.torque}});
    frame.planned_zmp = state.plan.zmp;
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
  std::optional<camera::BodyPoses> bodies_;  // of the plant
  std::deque<Frame> stamped_;
  LiveView view_;
};

}  // namespace

std::shared_ptr<const exports::RobotDescription> robot_description(const scenario::Scenario& scenario,
                                                                   const std::filesystem::path& models) {
  const auto robot = posed_robot(scenario, models);
  auto description = std::make_shared<exports::RobotDescription>();
  description->urdf = camera::urdf(robot->model());
  description->links = robot->drawn().bodies;
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
