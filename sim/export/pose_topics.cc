#include "sim/export/ros_bag.h"

namespace sim::exports {
namespace {

constexpr const char *kWorld = "world", *kBase = "base_link", *kWaist = "waist";
const std::string kTrue = "ground_truth/";

std::vector<files::TumRow> rows_of(const std::vector<files::TimedPose>& poses) {
  std::vector<files::TumRow> rows;
  for (const files::TimedPose& pose : poses) rows.push_back({pose, std::nullopt});
  return rows;
}

std::vector<files::TumRow> rows_of(const std::vector<recording::TrueFeet>& feet,
                                   recording::TrueFoot recording::TrueFeet::*which) {
  std::vector<files::TumRow> rows;
  for (const recording::TrueFeet& at : feet) {
    const Eigen::Vector3d& foot = (at.*which).truth;  // x, y, yaw
    files::TumRow& row = rows.emplace_back();
    row.t = at.t, row.X = Eigen::AngleAxisd(foot.z(), Eigen::Vector3d::UnitZ());
    row.X.translation() << foot.x(), foot.y(), 0;
  }
  return rows;
}

}  // namespace

PoseTopics::PoseTopics(const ExportContext& out, Bag& bag, bool for_viewers)
    : bag_(bag), for_viewers_(for_viewers) {
  const recording::Truth truth = out.truth();
  add(ros::kPlanTopics, ros::kPoseStamped, {});
  if (!truth.camera.empty())
    add(ros::kTrueTopics, ros::kPoseStamped, rows_of(truth.camera), kTrue + "camera");
  if (auto estimate = out.estimate(); !estimate.empty())
    add(ros::kSlamTopics, ros::kPoseWithCovarianceStamped, std::move(estimate));
  if (!for_viewers) return;
  if (!truth.camera.empty()) add_true_frames(truth);
  add_viewer_topics(out);
  add_fixed_frames(out);
}

void PoseTopics::add(const std::string& prefix, const MessageType& type, std::vector<files::TumRow> poses,
                     const std::string& true_frame) {
  Moving& moving = moving_.emplace_back();
  moving.poses = std::move(poses);
  moving.each = bag_.add_topic(prefix + ros::kPoseTopic, type);
  if (for_viewers_) moving.path = bag_.add_topic(prefix + "/path", ros::kPath);
  moving.with_covariance = &type == &ros::kPoseWithCovarianceStamped;
  moving.true_frame = true_frame;
}

// The truth is not in /tf: the program under test publishes the poses of base_link there (REP 105).
void PoseTopics::add_true_frames(const recording::Truth& truth) {
  topics_.true_tf = bag_.add_topic("/ground_truth/tf", ros::kTransforms);
  topics_.true_tf_static = bag_.add_topic("/ground_truth/tf_static", ros::kTransforms, true);
  const auto add_true = [&](const std::string& frame, std::vector<files::TumRow> poses) {
    moving_.emplace_back().poses = std::move(poses);
    moving_.back().true_frame = kTrue + frame;
  };
  add_true(kWaist, rows_of(truth.waist));
  add_true("left_foot", rows_of(truth.feet, &recording::TrueFeet::left));
  add_true("right_foot", rows_of(truth.feet, &recording::TrueFeet::right));
}

// Mounts are calibration: transforms to the sensors from their links, or from the head camera if there is no
// robot.
void PoseTopics::add_fixed_frames(const ExportContext& out) {
  topics_.tf_static = bag_.add_topic("/tf_static", ros::kTransforms, true);
  const bool has_links = topics_.tf && topics_.joints && !robot_->mountings.empty();
  if (has_links) fixed_.push_back({{}, kBase, kWaist, Eigen::Isometry3d::Identity()});
  for (const rig::RigSensor& sensor : out.sensors) {
    if (sensor.kind == rig::Kind::depth) continue;  // its frame belongs to another camera
    if (has_links) {
      const RobotDescription::Mounting& mounting = robot_->mountings.at(sensor.name);
      fixed_.push_back({{}, mounting.link, frame_of(sensor), mounting.X_LC * sensor.X_CS});
    } else if (sensor.name != rig::kHeadCamera) {
      fixed_.push_back({{}, ros::kCameraFrame, frame_of(sensor), sensor.X_CS});
    }
  }
  const auto same = Eigen::Isometry3d::Identity();
  true_fixed_ = {has_links ? ros::Transform{{}, kTrue + kWaist, kBase, same}
                           : ros::Transform{{}, kTrue + "camera", ros::kCameraFrame, same}};
}

void PoseTopics::add_viewer_topics(const ExportContext& out) {
  const fs::path maps = out.run.result / "map_over_time.csv";
  if (out.run.with_truth && fs::exists(maps))  // once a second, a row per landmark: stamp, id, position
    for (files::CsvReader rows(maps); rows.next();) {
      const Eigen::Vector3f p = rows.vector(2).cast<float>();
      maps_[slam::Stamp(rows.integer(0))].push_back({p.x(), p.y(), p.z(), std::uint32_t(rows.integer(1))});
    }
  if (!maps_.empty()) topics_.map = bag_.add_topic("/slam/map", ros::kPointCloud);
  const recording::Manifest manifest(out.run.result / "recording");
  joints_.emplace(manifest, recording::recording_format::sensor_rows("encoders0"));
  if (!joints_->names.empty()) topics_.joints = bag_.add_topic("/joint_states", ros::kJointState);
  robot_ = out.run.robot;
  if (robot_) {
    topics_.description = bag_.add_topic("/robot_description", ros::kString, true);
    topics_.tf = bag_.add_topic("/tf", ros::kTransforms);
  }
  forces_.emplace(manifest, recording::recording_format::sensor_rows("forces0"));
  if (forces_->names.empty()) return;
  topics_.left_wrench = bag_.add_topic("/left_foot/wrench", ros::kWrench);
  topics_.right_wrench = bag_.add_topic("/right_foot/wrench", ros::kWrench);
}

void PoseTopics::write(const ExportedFrame& frame) {
  const slam::Stamp t = frame.t;
  if (!last_) write_start(t);
  last_ = t;
  if (const auto& plan = frame.motion.plan) moving_.front().poses.push_back({{t, plan->X_PC}, std::nullopt});
  write_poses(t);
  if (for_viewers_) write_body(t);
  for (; !maps_.empty() && maps_.begin()->first <= t; maps_.erase(maps_.begin()))
    bag_.add(topics_.map, maps_.begin()->first,
             ros::point_cloud(maps_.begin()->first, kWorld, maps_.begin()->second));
  if (!paths_written_ || t - *paths_written_ >= std::chrono::seconds(1)) write_paths(t);
}

void PoseTopics::write_start(slam::Stamp t) {
  for (auto* fixed : {&fixed_, &true_fixed_})
    for (ros::Transform& transform : *fixed) transform.t = t;
  bag_.add(topics_.tf_static, t, ros::transforms(fixed_));
  bag_.add(topics_.true_tf_static, t, ros::transforms(true_fixed_));
  if (robot_) bag_.add(topics_.description, t, ros::string(robot_->urdf));
}

void PoseTopics::write_poses(slam::Stamp t) {
  std::vector<ros::Transform> true_frames;
  for (Moving& moving : moving_) {
    const std::size_t before = moving.passed;
    for (; moving.passed < moving.poses.size() && moving.poses[moving.passed].t <= t; ++moving.passed) {
      const files::TumRow& pose = moving.poses[moving.passed];
      bag_.add(moving.each, pose.t,
               moving.with_covariance
                   ? ros::pose_with_covariance_stamped(pose.t, kWorld, pose.X,
                                                       pose.covariance.value_or(files::Matrix6d::Zero()))
                   : ros::pose_stamped(pose.t, kWorld, pose.X));
    }
    if (moving.passed == before || moving.true_frame.empty()) continue;
    const files::TimedPose& now = moving.poses[moving.passed - 1];
    true_frames.push_back({now.t, kWorld, moving.true_frame, now.X});
  }
  if (!true_frames.empty()) bag_.add(topics_.true_tf, t, ros::transforms(true_frames));
}

// Writes readings at their full rate, and the links' poses at the last reading before each frame.
void PoseTopics::write_body(slam::Stamp t) {
  std::optional<std::pair<slam::Stamp, std::vector<double>>> last;
  joints_->until(t, [&](slam::Stamp at, const std::vector<double>& q) {
    bag_.add(topics_.joints, at, ros::joint_state(at, joints_->names, q));
    last = {at, q};
  });
  if (robot_ && last) {
    const auto& [at, q] = *last;
    const auto poses = robot_->poses(Eigen::Map<const Eigen::VectorXd>(q.data(), std::ssize(q)));
    std::vector<ros::Transform> links;
    for (std::size_t i = 0; i < poses.size(); ++i) links.push_back({at, kWaist, robot_->links[i], poses[i]});
    bag_.add(topics_.tf, at, ros::transforms(links));
  }
  forces_->until(t, [&](slam::Stamp at, const std::vector<double>& values) {
    if (values.size() < 12) return;
    const auto vector = [&](std::size_t first) { return Eigen::Vector3d(&values[first]); };
    bag_.add(topics_.left_wrench, at,
             ros::wrench(at, robot_ ? robot_->soles[0] : "left_foot", vector(0), vector(3)));
    bag_.add(topics_.right_wrench, at,
             ros::wrench(at, robot_ ? robot_->soles[1] : "right_foot", vector(6), vector(9)));
  });
}

void PoseTopics::write_paths(slam::Stamp t) {
  paths_written_ = t;
  for (const Moving& moving : moving_)
    if (moving.path)
      bag_.add(moving.path, t, ros::path(t, kWorld, std::span(moving.poses).first(moving.passed)));
}

}  // namespace sim::exports
