// ROS 2 bags: the sensors, poses, and the topics that viewers draw.
#include <fmt/format.h>

#include <regex>

#include "sim/export/export_context.h"
#include "sim/files/csv.h"
#include "sim/recording/image_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {
namespace {

namespace fs = std::filesystem;
using Poses = std::vector<files::TumRow>;
using Topic = std::optional<std::uint16_t>;  // of messages that the bag has

using ros::kCameraFrame;

constexpr const char *kWorld = "world", *kWaist = "waist", *kCamera = "camera";
const std::string kTrue = "ground_truth/";

/// run.mcap, and the content of metadata.yaml.
class Bag {
 public:
  explicit Bag(const fs::path& mcap_file) : mcap_(mcap_file) {}

  /// To be called before the first message. latched: late subscribers get its last message (transient_local).
  Topic add_topic(const std::string& name, const MessageType& type, bool latched = false) {
    const std::string qos = latched ? text_of("bag_latched.yaml") : "";
    topics_.push_back({name, type.name, std::regex_replace(qos, std::regex("\n"), "\\n")});
    return mcap_.add_channel(name, type, qos);
  }

  /// cdr: a message with the stamp t; nothing is written without a topic.
  void add(Topic topic, slam::Stamp t, const std::string& cdr) {
    if (topic) mcap_.add_message(*topic, recording::file_stamp(t), cdr);
  }

  /// Closes the file. Returns the text of metadata.yaml.
  std::string finish() {
    mcap_.finish();
    std::string topics;
    for (std::uint16_t channel = 1; const auto& [name, type, qos] : topics_)
      topics +=
          fmt::format(fmt::runtime(text_of("bag_topic.yaml")), name, type, qos, mcap_.messages(channel++));
    return fmt::format(fmt::runtime(text_of("bag_metadata.yaml")), mcap_.end_ns() - mcap_.begin_ns(),
                       mcap_.begin_ns(), mcap_.messages(), topics);
  }

 private:
  McapWriter mcap_;
  std::vector<std::array<std::string, 3>> topics_;  // name, type, profile
};

Poses rows_of(const std::vector<files::TimedPose>& poses) {
  Poses rows;
  for (const files::TimedPose& pose : poses) rows.push_back({pose, std::nullopt});
  return rows;
}

Poses rows_of(const std::vector<recording::TrueFeet>& feet, recording::TrueFoot recording::TrueFeet::*which) {
  Poses rows;
  for (const recording::TrueFeet& at : feet) {
    const Eigen::Vector3d& foot = (at.*which).truth;  // x, y, yaw
    files::TumRow& row = rows.emplace_back();
    row.t = at.t, row.X = Eigen::AngleAxisd(foot.z(), Eigen::Vector3d::UnitZ());
    row.X.translation() << foot.x(), foot.y(), 0;
  }
  return rows;
}

/// The frame of a sensor: optical axes (x right, y down, z forward) of a camera, else x forward, y left, z
/// up. Depth has that of the camera that it is aligned with.
std::string frame_of(const rig::RigSensor& sensor) {
  if (sensor.name == "imu0") return ros::kImuFrame;
  if (!rig::is_camera(sensor)) return sensor.name + "_frame";
  return (sensor.kind == rig::Kind::depth ? sensor.aligned_with : sensor.name) + "_optical_frame";
}

// The distance of a camera to the right of the head camera; 0 unless both look in the same direction, side by
// side, so that their images are rectified.
double right_of_head(const rig::RigSensor& camera) {
  const Eigen::Vector3d p = camera.X_CS.translation();
  const bool parallel = camera.X_CS.linear().isIdentity(1e-9) && std::hypot(p.y(), p.z()) < 1e-9;
  return camera.kind == rig::Kind::gray && parallel ? p.x() : 0;
}

/// Writes the readings of the sensors into a bag: for viewers all, under the names of the sensors; else those
/// of gray cameras and IMUs, counted.
class SensorTopics {
 public:
  SensorTopics(const ExportContext& out, Bag& bag, bool for_viewers)
      : out_(out), bag_(bag), topics_(out.sensors.size()) {
    using rig::Kind;
    for (const Kind kind : {Kind::gray, Kind::color, Kind::depth, Kind::lidar, Kind::imu})
      for (int number = 0; const int i : out.all(kind)) {
        if (!for_viewers && kind != Kind::gray && kind != Kind::imu) continue;
        const std::string name = !for_viewers
                                     ? fmt::format("/{}{}", kind == Kind::imu ? "imu" : "cam", number++)
                                 : i == out.head()  ? "/camera"
                                 : i == out.chest() ? ""
                                                    : "/rig/" + out.sensor(i).name;
        Topics& topics = topics_[static_cast<std::size_t>(i)];
        topics.as_png = for_viewers && kind != Kind::depth;  // readers of compressed depth disagree on it
        if (kind == Kind::lidar)
          topics.readings = bag.add_topic(name + "/points", ros::kPointCloud);
        else if (kind == Kind::imu)
          topics.readings = bag.add_topic(name + (for_viewers ? "/imu" : ""), ros::kImu);
        else if (topics.as_png)
          topics.readings = bag.add_topic(name + "/image/compressed", ros::kCompressedImage);
        else
          topics.readings = bag.add_topic(name + "/image_raw", ros::kImage);
        if (rig::is_camera(out.sensor(i)))
          topics.info = bag.add_topic(name + "/camera_info", ros::kCameraInfo);
      }
  }

  void write(const ExportedFrame& frame) {
    for (const ExportedReading& reading : frame.readings) {
      const Topics& topics = topics_.at(static_cast<std::size_t>(reading.sensor));
      if (topics.readings)
        bag_.add(topics.readings, reading.t, message(reading, out_.sensor(reading.sensor), topics.as_png));
      if (topics.info) {
        const rig::RigSensor& camera = out_.sensor(reading.sensor);
        bag_.add(topics.info, reading.t,
                 ros::camera_info(reading.t, frame_of(camera), camera.camera, right_of_head(camera)));
      }
    }
  }

 private:
  struct Topics {
    Topic readings, info;
    bool as_png = false;
  };

  static std::string message(const ExportedReading& reading, const rig::RigSensor& sensor, bool as_png) {
    const std::string frame = frame_of(sensor);
    if (sensor.kind == rig::Kind::lidar) return ros::point_cloud(reading.t, frame, reading.points);
    if (as_png && rig::is_camera(sensor))
      return ros::compressed_image(reading.t, frame, recording::encode_png(reading.image));
    if (rig::is_camera(sensor)) return ros::image(reading.t, frame, reading.image);
    return ros::imu(reading, frame, std::pow(sensor.gyro_sigma_rad_s, 2),
                    std::pow(sensor.accelerometer_sigma_m_s2, 2));
  }

  const ExportContext& out_;
  Bag& bag_;
  std::vector<Topics> topics_;  // by sensor
};

/// Writes poses into a bag, frame by frame; for viewers also frames, paths, map, joints and feet. An export
/// without truth has neither true poses nor those of the filter.
class PoseTopics {
 public:
  /// The bag must outlive it.
  PoseTopics(const ExportContext& out, Bag& bag, bool for_viewers) : bag_(bag), for_viewers_(for_viewers) {
    const recording::Truth truth = out.truth();
    if (for_viewers) add_viewer_topics(out, truth);
    add("plan_camera", topics_.tf, {}, "/plan", ros::kPoseStamped);
    if (!truth.camera.empty())
      add(kTrue + kCamera, topics_.true_tf, rows_of(truth.camera), "/ground_truth", ros::kPoseStamped);
    if (const Poses estimate = out.estimate(); !estimate.empty())
      add("slam_camera", topics_.tf, estimate, "/slam", ros::kPoseWithCovarianceStamped);
  }

  /// Writes the messages up to the stamp of a frame; stamps rise.
  void write(const ExportedFrame& frame) {
    const slam::Stamp t = frame.t;
    if (!last_) write_start(t);
    last_ = t;
    for (Moving& moving : moving_)
      if (frame.plan && moving.frame == "plan_camera")
        moving.poses.push_back({{t, frame.plan->X_PC}, std::nullopt});
    write_poses(t);
    if (for_viewers_) write_body(t);
    for (; !maps_.empty() && maps_.begin()->first <= t; maps_.erase(maps_.begin()))
      bag_.add(topics_.map, maps_.begin()->first,
               ros::point_cloud(maps_.begin()->first, kWorld, maps_.begin()->second));
    if (!paths_written_ || t - *paths_written_ >= std::chrono::seconds(1)) write_paths(t);
  }

  /// Writes the whole paths at the stamp of the last frame.
  void finish() {
    if (last_ != paths_written_) write_paths(*last_);
  }

 private:
  /// Poses of one frame in the world until now, and those to come.
  struct Moving {
    std::string frame;
    Topic transforms;
    Poses poses;
    std::size_t passed = 0;  ///< of the poses
    bool with_covariance = false;
    Topic each = {}, path = {};
  };

  void add(const std::string& frame, Topic transforms, Poses poses, const std::string& prefix,
           const MessageType& type) {
    moving_.push_back({frame, transforms, std::move(poses)});
    moving_.back().with_covariance = &type == &ros::kPoseWithCovarianceStamped;
    moving_.back().each = bag_.add_topic(prefix + "/pose", type);
    if (for_viewers_) moving_.back().path = bag_.add_topic(prefix + "/path", ros::kPath);
  }

  void add_viewer_topics(const ExportContext& out, const recording::Truth& truth) {
    topics_.tf = bag_.add_topic("/tf", ros::kTransforms);
    topics_.tf_static = bag_.add_topic("/tf_static", ros::kTransforms, true);
    fixed_.push_back({{}, kCameraFrame, ros::kImuFrame, out.setup.calibration.X_CG});
    for (const rig::RigSensor& sensor : out.setup.rig)
      if (sensor.kind != rig::Kind::depth)  // its frame is another camera's
        fixed_.push_back({{}, kCameraFrame, frame_of(sensor), sensor.X_CS});
    if (!truth.camera.empty()) {  // not in /tf: the program under test publishes the poses there (REP 105)
      topics_.true_tf = bag_.add_topic("/ground_truth/tf", ros::kTransforms);
      topics_.true_tf_static = bag_.add_topic("/ground_truth/tf_static", ros::kTransforms, true);
      moving_.push_back({kTrue + kWaist, topics_.true_tf, rows_of(truth.waist)});
      for (const auto& [foot, which] :
           {std::pair("left_foot", &recording::TrueFeet::left), {"right_foot", &recording::TrueFeet::right}})
        moving_.push_back({kTrue + foot, topics_.true_tf, rows_of(truth.feet, which)});
    }
    const fs::path maps = out.run.result / "map_over_time.csv";
    if (out.run.with_truth && fs::exists(maps))  // once a second, each landmark a row: stamp, id, position
      for (files::CsvReader rows(maps, 5); rows.next();) {
        const Eigen::Vector3f p = rows.vector(2).cast<float>();
        maps_[slam::Stamp(rows.integer(0))].push_back(
            {p.x(), p.y(), p.z(), static_cast<std::uint32_t>(rows.integer(1))});
      }
    if (!maps_.empty()) topics_.map = bag_.add_topic("/slam/map", ros::kPointCloud);
    robot_ = out.run.robot;
    if (robot_) topics_.description = bag_.add_topic("/robot_description", ros::kString, true);
    joints_.emplace(out.run.result / "recording", "encoders0");
    if (!joints_->names.empty()) topics_.joints = bag_.add_topic("/joint_states", ros::kJointState);
    forces_.emplace(out.run.result / "recording", "forces0");
    if (forces_->names.empty()) return;
    topics_.left_wrench = bag_.add_topic("/left_foot/wrench", ros::kWrench);
    topics_.right_wrench = bag_.add_topic("/right_foot/wrench", ros::kWrench);
  }

  void write_start(slam::Stamp t) {
    const auto same = Eigen::Isometry3d::Identity();
    for (ros::Transform& transform : fixed_) transform.t = t;
    bag_.add(topics_.tf_static, t, ros::transforms(fixed_));
    bag_.add(topics_.true_tf_static, t,
             ros::transforms({{t, kTrue + kCamera, kCameraFrame, same}, {t, kTrue + kWaist, kWaist, same}}));
    if (robot_) bag_.add(topics_.description, t, ros::string(robot_->urdf));
  }

  void write_poses(slam::Stamp t) {
    std::map<Topic, std::vector<ros::Transform>> all;
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
      if (moving.passed == before) continue;
      const files::TimedPose& now = moving.poses[moving.passed - 1];
      all[moving.transforms].push_back({now.t, kWorld, moving.frame, now.X});
    }
    for (const auto& [topic, now] : all) bag_.add(topic, t, ros::transforms(now));
  }

  // Readings at their full rate, the links at the last one until each frame.
  void write_body(slam::Stamp t) {
    std::optional<std::pair<slam::Stamp, std::vector<double>>> last;
    joints_->until(t, [&](slam::Stamp at, const std::vector<double>& q) {
      bag_.add(topics_.joints, at, ros::joint_state(at, joints_->names, q));
      last = {at, q};
    });
    if (robot_ && last) {
      const auto& [at, q] = *last;
      const auto poses = robot_->poses(Eigen::Map<const Eigen::VectorXd>(q.data(), std::ssize(q)));
      std::vector<ros::Transform> links;
      for (std::size_t i = 0; i < poses.size(); ++i)
        links.push_back({at, kWaist, robot_->links[i], poses[i]});
      bag_.add(topics_.tf, at, ros::transforms(links));
    }
    forces_->until(t, [&](slam::Stamp at, const std::vector<double>& values) {
      if (values.size() < 12) return;
      const auto vector = [&](std::size_t first) { return Eigen::Vector3d(&values[first]); };
      bag_.add(topics_.left_wrench, at, ros::wrench(at, "left_foot", vector(0), vector(3)));
      bag_.add(topics_.right_wrench, at, ros::wrench(at, "right_foot", vector(6), vector(9)));
    });
  }

  void write_paths(slam::Stamp t) {
    paths_written_ = t;
    for (const Moving& moving : moving_)
      if (moving.path)
        bag_.add(moving.path, t, ros::path(t, kWorld, std::span(moving.poses).first(moving.passed)));
  }

  Bag& bag_;
  const bool for_viewers_;
  std::vector<ros::Transform> fixed_;
  std::vector<Moving> moving_;
  std::map<slam::Stamp, std::vector<ros::CloudPoint>> maps_;
  std::optional<RecordedRows> joints_, forces_;
  std::shared_ptr<const RobotDescription> robot_;
  struct {
    Topic tf, tf_static, true_tf, true_tf_static, description, joints, left_wrench, right_wrench, map;
  } topics_;
  std::optional<slam::Stamp> last_, paths_written_;
};

}  // namespace

RecordedRows::RecordedRows(const fs::path& recording, const std::string& sensor) {
  const recording::Manifest manifest(recording);
  const std::string file = recording::recording_format::sensor_rows(sensor);
  if (!manifest.lists(file)) return;
  rows_.emplace(files::CsvReader(manifest.check(file), 1), recording::kEpoch);
  const std::vector<std::string>& titles = rows_->row().titles();
  for (std::size_t i = 1; i < titles.size(); ++i) names.push_back(titles[i].substr(0, titles[i].find(" [")));
}

void RecordedRows::until(slam::Stamp t,
                         const std::function<void(slam::Stamp, const std::vector<double>&)>& each) {
  for (; rows_ && rows_->stamp() && *rows_->stamp() <= t; rows_->advance()) {
    newest.clear();
    for (std::size_t i = 1; i < rows_->row().fields(); ++i) newest.push_back(rows_->row().number(i));
    each(*rows_->stamp(), newest);
  }
}

void write_ros_bag(const ExportContext& out, const std::string& folder, bool for_viewers) {
  Bag bag(out.new_file(folder + "run.mcap"));
  SensorTopics sensors(out, bag, for_viewers);
  PoseTopics poses(out, bag, for_viewers);
  for (Frames frames(out); const auto frame = frames.next();) {
    sensors.write(*frame);
    poses.write(*frame);
  }
  poses.finish();
  out.write(folder + "metadata.yaml", bag.finish());
}

}  // namespace sim::exports
