// The parts of the view that need the simulator: the view of a run, which passes on the run's state as plain
// numbers; robots for playbacks and exports; and pictures of the recorded robot, from its waist pose and
// joint angles.
#include "sim/view/session.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <deque>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/camera/drawn_model.h"
#include "sim/camera/scene.h"
#include "sim/export/export.h"
#include "sim/files/json.h"
#include "sim/live/run.h"
#include "sim/live/setup.h"
#include "sim/physics/nominal_body.h"
#include "sim/physics/robot.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording.h"
#include "sim/scenario/robot.h"
#include "sim/view/live_view.h"
#include "sim/view/site.h"
#include "walking/plan.h"

namespace sim::view {
namespace {

using namespace camera;
using namespace physics;
using Eigen::Vector3d;

constexpr int kLargestPicture_px = 512;

/// Appends four-byte numbers in this machine's little-endian format.
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
                    {"alpha", piece.alpha},
                    {"vertices", piece.positions.size() / 3},
                    {"indices", piece.indices.size()}});
    for (const auto* const part : {&piece.positions, &piece.normals, &piece.colors, &piece.uv})
      put(numbers, *part);
    put(numbers, piece.indices);
  }
  Model model{with_length(files::json_text(list)) + numbers};
  model.pictures = [robot, seed] {
    std::vector<std::string> all;
    for (const cv::Mat3b& picture : robot->pictures(seed, kLargestPicture_px))
      all.push_back(recording::encode_png(picture));
    return all;
  };
  return model;
}

Eigen::AlignedBox2d sole_of(const walking::Robot& robot) {
  const walking::Leg& leg = robot.leg(walking::Side::left);
  return {leg.sole_min, leg.sole_max};
}

void require_joints(Eigen::Index count, const mjModel& model) {
  if (count != model.nu)
    throw std::runtime_error(fmt::format("the recording has {} joints, expected {}", count, model.nu));
}

std::shared_ptr<camera::PosedRobot> posed_robot(const scenario::Scenario& scenario, const fs::path& models) {
  return std::make_shared<camera::PosedRobot>(scenario::read_robot(scenario), scenario.world, models);
}

ShownRun shown_run(const scenario::Scenario& scenario, const std::shared_ptr<camera::PosedRobot>& robot) {
  ShownRun run{.label = fmt::format("{}, seed {}", scenario.name, scenario.seed)};
  run.moments = faults_of(scenario);
  run.model = model_of(robot, scenario.world.seed);
  run.sole = sole_of(robot->robot());
  if (scenario.camera) {
    run.camera = camera::camera_model(*scenario.camera);
    const std::vector<Eigen::Isometry3d> places(scenario.rig.size(), Eigen::Isometry3d::Identity());
    run.rig = rig::calibrated(scenario.rig, *run.camera, scenario.camera->rate_hz, scenario.camera->readout_s,
                              places);  // not needed by the page
  } else {
    run.missing.emplace_back("No head images: the scenario has no camera.");
  }
  if (!scenario.slam) run.missing.emplace_back("No estimate: the scenario has no filter.");
  return run;
}

/// The view of a run. Frames wait from their stamps until their images have been drawn and used by the
/// filter.
class LiveSession : public ViewSession {
 public:
  LiveSession(const ViewRequest& request, const scenario::ReadScenario& read, const fs::path& models)
      : robot_(posed_robot(read.scenario, models)),
        models_(models),
        wait_(request.wait),
        view_(request, shown_run(read.scenario, robot_), request.control, request.wait) {
    request.opened(url(view_.access()));
    observer_.begins = [this](const recording::RecordingSetup& setup) { view_.begin(setup); };
    observer_.ticked = [this](slam::Stamp t) { view_.pace(t); };
    observer_.stamped = [this](const live::StampedState& state) { stamp(state); };
    observer_.wants = [this](const slam::Observation& o) { return wants(o); };
    observer_.tracked = [this](const slam::Observation& o, const tracking::Tracking* t) { show(o, t); };
  }

  const live::RunObserver& run_observer() const override { return observer_; }
  void wait_for_viewer() const override { view_.wait_for_viewer(); }
  void end(const std::string& how, const fs::path& result) override {
    view_.end(how, wait_ ? std::optional(read_playback(result, robot_maker(models_))) : std::nullopt);
  }

 private:
  void stamp(const live::StampedState& state) {
    Frame frame{.t = state.t};
    frame.bodies = body_poses(*state.world.model(), *state.world.data(), robot_->bodies());
    frame.truth = state.world.X_WC();
    frame.plan = state.X_PC;
    frame.feet = {FootPlace{state.feet.left}, FootPlace{state.feet.right}};
    frame.zmp = zero_moment_point({SoleForce{state.feet.left.truth, state.left.force, state.left.torque},
                                   SoleForce{state.feet.right.truth, state.right.force, state.right.torque}});
    stamped_.push_back(std::move(frame));
  }

  bool wants(const slam::Observation& observation) {
    while (!stamped_.empty() && stamped_.front().t < observation.t) stamped_.pop_front();
    view_.wants(observation);
    return !stamped_.empty() && stamped_.front().t == observation.t;
  }

  void show(const slam::Observation& observation, const tracking::Tracking* tracking) {
    Frame frame = std::move(stamped_.front());
    stamped_.pop_front();
    frame.image = tracking ? tracking->image() : observation.image;
    const bool with_map = view_.wants_map();
    if (const auto* const newest = tracking ? tracking->newest() : nullptr) {
      if (const auto& pose = newest->estimate)
        frame.estimate = pose->X_WC, frame.covariance = pose->covariance;
      frame.report = newest->report;
      if (with_map) frame.map = tracking->map();
    }
    view_.show(frame);
  }

  std::shared_ptr<camera::PosedRobot> robot_;
  fs::path models_;
  bool wait_;
  live::RunObserver observer_;
  std::deque<Frame> stamped_;
  LiveView view_;
};

constexpr int kDensity = 2;  // pictures are drawn at this many times the resolution, for smooth edges
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
  Drawing(const scenario::Scenario& scenario, const fs::path& recording, const fs::path& models)
      : model_(arranged(load_model(scenario::read_robot(scenario), scenario.world.room, models),
                        scenario.world)),
        data_(mj_makeData(model_.get())),
        scene_(*model_, {kView}, scenario.world.seed, Channels::rgb, Robot::whole),
        encoders_(recording, "encoders0") {
    if (std::ssize(encoders_.names) != model_->nu)
      throw files::FileError(recording / "mav0/encoders0/data.csv", "has {} joints, expected {}",
                             encoders_.names.size(), model_->nu);
  }

  cv::Mat draw(slam::Stamp t, const Eigen::Isometry3d& X_WB) {
    encoders_.until(t);
    walking::BodyPose pose{X_WB, walking::JointVector::Zero(model_->nu)};
    if (!encoders_.newest.empty())
      pose.q = Eigen::Map<const Eigen::VectorXd>(encoders_.newest.data(), model_->nu);
    Eigen::Map<Eigen::VectorXd>(data_->qpos, model_->nq) = robot_positions(*model_, pose);
    mj_kinematics(model_.get(), data_.get());
    mj_camlight(model_.get(), data_.get());
    const Vector3d waist = X_WB.translation();
    cv::Mat picture;
    cv::resize(scene_.draw(*data_, looking(waist + kFromWaist, waist + kLookedAt)), picture,
               {kPanelWidth, kPanelHeight}, 0, 0, cv::INTER_AREA);
    cv::cvtColor(picture, picture, cv::COLOR_RGB2BGR);
    return picture;
  }

 private:
  physics::Model model_;
  physics::Data data_;
  camera::Scene scene_;
  exports::RecordedRows encoders_;
};

}  // namespace

std::shared_ptr<const exports::RobotDescription> robot_description(const scenario::Scenario& scenario,
                                                                   const fs::path& models) {
  const RobotFile file = scenario::read_robot(scenario);
  const std::shared_ptr model = load_model(file, scenario.world.room, models);
  const walking::Robot nominal = read_robot(*model, file);
  if (scenario.camera && !scenario.camera->is_default()) mount_camera(*model, *scenario.camera);
  const int camera = part(*model, mjOBJ_CAMERA, "head_camera"),
            root = model->body_rootid[model->cam_bodyid[camera]];
  const auto name_of = [&](int body) {
    return body == root ? std::string("waist") : mj_id2name(model.get(), mjOBJ_BODY, body);
  };
  exports::RobotDescription robot;
  robot.urdf = camera::urdf(*model),
  robot.soles = {name_of(model->site_bodyid[part(*model, mjOBJ_SITE, "left_sole")]),
                 name_of(model->site_bodyid[part(*model, mjOBJ_SITE, "right_sole")])};
  std::vector<int> bodies;
  for (int body = root + 1; body < model->nbody; ++body)
    if (model->body_rootid[body] == root) bodies.push_back(body), robot.links.push_back(name_of(body));

  const std::shared_ptr data = std::shared_ptr<mjData>(mj_makeData(model.get()), mj_deleteData);
  const auto pose = [data](int body) { return pose_in(data->xpos + 3 * body, data->xmat + 9 * body); };
  const auto take = [model, data](const walking::JointVector& q) {
    Eigen::Map<Eigen::VectorXd>(data->qpos, model->nq) =
        robot_positions(*model, {Eigen::Isometry3d::Identity(), q});
    mj_kinematics(model.get(), data.get());
  };
  robot.poses = [bodies, pose, take, root, model](const Eigen::VectorXd& q) {
    require_joints(q.size(), *model);
    take(q);
    const Eigen::Isometry3d X_BW = pose(root).inverse();
    std::vector<Eigen::Isometry3d> all;
    for (const int body : bodies) all.push_back(X_BW * pose(body));
    return all;
  };
  // The calibration's posture of the body above the legs.
  walking::JointVector q = nominal.posture;
  for (const walking::Leg& leg : nominal.legs) walking::set_leg_angles(leg, walking::LegVector::Zero(), q);
  take(q);
  mj_camlight(model.get(), data.get());
  Eigen::Isometry3d X_WC = pose_in(data->cam_xpos + 3 * camera, data->cam_xmat + 9 * camera);
  X_WC.linear() *= Vector3d(1, -1, -1).asDiagonal();  // MuJoCo's camera: y up, looking along -z
  const auto mount = [&](const std::string& sensor, int body) {
    robot.mountings[sensor] = {name_of(body), pose(body).inverse() * X_WC};
  };
  mount(rig::kHeadCamera, model->cam_bodyid[camera]);
  mount(rig::kChestImu, scenario.imu.on_link() ? place_of(*model, scenario.imu).body
                                               : model->site_bodyid[part(*model, mjOBJ_SITE, "imu")]);
  const std::vector<Place> places = live::places(scenario.rig, *model);
  for (std::size_t i = 0; i < places.size(); ++i) mount(rig::name_of(scenario.rig[i]), places[i].body);
  return std::make_shared<exports::RobotDescription>(std::move(robot));
}

MakeRobot robot_maker(const fs::path& models) {
  return [models](const scenario::Scenario& scenario) {
    const auto robot = posed_robot(scenario, models);
    return RobotModel{model_of(robot, scenario.world.seed), sole_of(robot->robot()),
                      [robot](const Eigen::VectorXd& q, const Eigen::Isometry3d& X_WB) {
                        require_joints(q.size(), robot->model());
                        return robot->poses({X_WB, q});
                      }};
  };
}

std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const scenario::ReadScenario& read,
                                         const fs::path& models) {
  if (!request.view) return nullptr;
  return std::make_unique<LiveSession>(request, read, models);
}

RobotView robot_from_outside(const scenario::Scenario& scenario, const fs::path& recording,
                             const fs::path& models) {
  const auto drawing = std::make_shared<Drawing>(scenario, recording, models);
  return [drawing](slam::Stamp t, const Eigen::Isometry3d& X_WB) { return drawing->draw(t, X_WB); };
}

}  // namespace sim::view
