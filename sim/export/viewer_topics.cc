#include "sim/export/ros_bag.h"
#include "sim/files/csv.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {
namespace {

namespace fs = std::filesystem;
using Poses = std::vector<files::TimedPose>;

constexpr const char *kFixed = "world", *kWaist = "waist", *kCamera = "camera";
const std::string kTrue = "ground_truth/";
constexpr slam::Stamp kPathEvery = std::chrono::seconds(1);  // each message has the whole path so far

Poses feet_of(const std::vector<recording::TrueFeet>& feet, recording::TrueFoot recording::TrueFeet::*which) {
  Poses poses;
  for (const recording::TrueFeet& at : feet) {
    const Eigen::Vector3d& foot = (at.*which).truth;  // x, y, yaw
    poses.push_back({at.t, Eigen::Translation3d(foot.x(), foot.y(), 0) *
                               Eigen::Isometry3d(Eigen::AngleAxisd(foot.z(), Eigen::Vector3d::UnitZ()))});
  }
  return poses;
}

// Once a second, each landmark a row: stamp, id, position.
std::map<slam::Stamp, std::vector<ros::CloudPoint>> maps_of(const ExportContext& out) {
  std::map<slam::Stamp, std::vector<ros::CloudPoint>> maps;
  const fs::path file = out.run.result / "map_over_time.csv";
  if (!out.run.with_truth || !fs::exists(file)) return maps;
  for (files::CsvReader rows(file, 5); rows.next();)
    maps[slam::Stamp(rows.integer(0))].push_back(
        {rows.vector(2), static_cast<std::uint32_t>(rows.integer(1))});
  return maps;
}

}  // namespace

RecordedRows::RecordedRows(const std::filesystem::path& folder, const std::string& sensor) {
  const recording::Manifest manifest(folder);
  const std::string file = recording::recording_format::body_sensor_rows(sensor);
  if (!manifest.lists(file)) return;
  rows_.emplace(files::CsvReader(manifest.check(file), 1), recording::kEpoch);
  const std::vector<std::string>& titles = rows_->row().titles();
  for (std::size_t i = 1; i < titles.size(); ++i) names_.push_back(titles[i].substr(0, titles[i].find(" [")));
}

std::vector<RecordedRows::Row> RecordedRows::until(slam::Stamp t) {
  std::vector<Row> rows;
  for (; rows_ && rows_->stamp() && *rows_->stamp() <= t; rows_->advance()) {
    Row& row = rows.emplace_back();
    row.t = *rows_->stamp();
    for (std::size_t i = 1; i < rows_->row().fields(); ++i) row.values.push_back(rows_->row().number(i));
  }
  return rows;
}

ViewerTopics::ViewerTopics(const ExportContext& out, Bag& bag)
    : bag_(bag),
      X_CG_(out.setup.calibration.X_CG),
      maps_(maps_of(out)),
      joints_(out.run.result / "recording", "encoders0"),
      forces_(out.run.result / "recording", "forces0"),
      robot_(out.run.robot),
      transforms_(bag.add_topic("/tf", ros::kTransforms)),
      fixed_transforms_(bag.add_topic("/tf_static", ros::kTransforms, Bag::Durability::transient_local)) {
  add("plan_camera", transforms_, {}, "/plan/path");
  add_truth(out.truth());
  const std::vector<files::TumRow> estimate = out.estimate();
  add("slam_camera", transforms_, Poses(estimate.begin(), estimate.end()), "/slam/path");
  if (!maps_.empty()) map_ = bag.add_topic("/slam/map", ros::kPointCloud);
  if (robot_)
    description_ = bag.add_topic("/robot_description", ros::kString, Bag::Durability::transient_local);
  if (!joints_.names().empty()) joint_states_ = bag.add_topic("/joint_states", ros::kJointState);
  if (forces_.names().empty()) return;
  left_wrench_ = bag.add_topic("/left_foot/wrench", ros::kWrench);
  right_wrench_ = bag.add_topic("/right_foot/wrench", ros::kWrench);
}

// Skips frames without poses, except the planned one: its poses come with the observations.
void ViewerTopics::add(const std::string& frame, Bag::Topic transforms, Poses poses, const char* path) {
  if (poses.empty() && frame != "plan_camera") return;
  moving_.push_back({frame, transforms, std::move(poses)});
  if (path) moving_.back().path = bag_.add_topic(path, ros::kPath);
}

// Not in /tf: there the program under test publishes the poses of the robot (REP 105).
void ViewerTopics::add_truth(const recording::Truth& truth) {
  if (truth.camera.empty()) return;
  const Bag::Topic moving = bag_.add_topic("/ground_truth/tf", ros::kTransforms);
  true_fixed_transforms_ =
      bag_.add_topic("/ground_truth/tf_static", ros::kTransforms, Bag::Durability::transient_local);
  add(kTrue + kCamera, moving, truth.camera, "/ground_truth/path");
  add(kTrue + kWaist, moving, truth.waist);
  add(kTrue + "left_foot", moving, feet_of(truth.feet, &recording::TrueFeet::left));
  add(kTrue + "right_foot", moving, feet_of(truth.feet, &recording::TrueFeet::right));
}

void ViewerTopics::write_transforms(slam::Stamp t) {
  std::map<Bag::Topic, std::vector<ros::Transform>> all;
  for (Moving& moving : moving_) {
    const std::size_t before = moving.passed;
    while (moving.passed < moving.poses.size() && moving.poses[moving.passed].t <= t) ++moving.passed;
    if (moving.passed == before) continue;
    const files::TimedPose& now = moving.poses[moving.passed - 1];
    all[moving.transforms].push_back({now.t, kFixed, moving.frame, now.X});
  }
  for (const auto& [topic, now] : all) bag_.add(topic, t, ros::transforms(now));
}

void ViewerTopics::write_start(slam::Stamp t) {
  const auto same = Eigen::Isometry3d::Identity();
  bag_.add(fixed_transforms_, t, ros::transforms({{t, kCamera, "imu", X_CG_}}));
  if (true_fixed_transforms_)
    bag_.add(*true_fixed_transforms_, t,
             ros::transforms({{t, kTrue + kCamera, kCamera, same}, {t, kTrue + kWaist, kWaist, same}}));
  if (description_) bag_.add(*description_, t, ros::string(robot_->urdf));
}

void ViewerTopics::write(const slam::Observation& observation) {
  const slam::Stamp t = observation.t;
  if (!last_) write_start(t);
  last_ = t;
  if (observation.plan) moving_.front().poses.push_back({t, observation.plan->X_PC});
  write_transforms(t);
  write_body(t);
  write_map(t);
  if (!paths_written_ || t - *paths_written_ >= kPathEvery) write_paths(t);
}

// Readings at their full rate, the links at the last one until each frame.
void ViewerTopics::write_body(slam::Stamp t) {
  if (joint_states_) {
    const std::vector<RecordedRows::Row> rows = joints_.until(t);
    for (const RecordedRows::Row& row : rows)
      bag_.add(*joint_states_, row.t, ros::joint_state(row.t, joints_.names(), row.values));
    if (robot_ && !rows.empty()) write_links(rows.back());
  }
  if (!left_wrench_) return;
  for (const RecordedRows::Row& row : forces_.until(t)) {
    if (row.values.size() < 12) continue;
    const auto vector = [&](std::size_t first) { return Eigen::Vector3d(&row.values[first]); };
    bag_.add(*left_wrench_, row.t, ros::wrench(row.t, "left_foot", vector(0), vector(3)));
    bag_.add(*right_wrench_, row.t, ros::wrench(row.t, "right_foot", vector(6), vector(9)));
  }
}

void ViewerTopics::write_links(const RecordedRows::Row& joints) {
  const std::vector<Eigen::Isometry3d> poses = robot_->poses(Eigen::Map<const Eigen::VectorXd>(
      joints.values.data(), static_cast<Eigen::Index>(joints.values.size())));
  std::vector<ros::Transform> all;
  for (std::size_t i = 0; i < poses.size(); ++i)
    all.push_back({joints.t, kWaist, robot_->links[i], poses[i]});
  bag_.add(transforms_, joints.t, ros::transforms(all));
}

void ViewerTopics::write_map(slam::Stamp t) {
  for (; !maps_.empty() && maps_.begin()->first <= t; maps_.erase(maps_.begin()))
    bag_.add(*map_, maps_.begin()->first,
             ros::point_cloud(maps_.begin()->first, kFixed, maps_.begin()->second));
}

void ViewerTopics::write_paths(slam::Stamp t) {
  paths_written_ = t;
  for (const Moving& moving : moving_)
    if (moving.path)
      bag_.add(*moving.path, t, ros::path(t, kFixed, std::span(moving.poses).first(moving.passed)));
}

void ViewerTopics::finish() {
  if (last_ && *last_ != paths_written_) write_paths(*last_);
}

}  // namespace sim::exports
