// ROS 2 bags: the sensors, poses, and the topics that viewers draw.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "sim/export/export_context.h"
#include "sim/export/ros_messages.h"
#include "sim/files/csv.h"
#include "sim/recording/image_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {
namespace {

namespace fs = std::filesystem;
using Poses = std::vector<files::TimedPose>;
using Topic = std::uint16_t;

using ros::kCameraFrame, ros::kImuFrame;

constexpr const char *kWorld = "world", *kWaist = "waist", *kCamera = "camera";
const std::string kTrue = "ground_truth/";

/// run.mcap, and the content of metadata.yaml.
class Bag {
 public:
  explicit Bag(const fs::path& mcap_file) : mcap_(mcap_file) {}

  /// To be called before the first message. latched: late subscribers get its last message (transient_local).
  Topic add_topic(const std::string& name, const MessageType& type, bool latched = false) {
    // As version 5 of metadata.yaml writes them: numbers of rmw's enumerations.
    static const std::string forever = "\n    sec: 9223372036\n    nsec: 854775807\n";
    static const std::string profile =
        "- history: 1  # keep_last\n  depth: 1\n  reliability: 1  # reliable\n"
        "  durability: 1  # transient_local\n  deadline:" +
        forever + "  lifespan:" + forever + "  liveliness: 1\n  liveliness_lease_duration:" + forever +
        "  avoid_ros_namespace_conventions: false\n";
    const std::string qos = latched ? profile : "";
    std::string escaped;
    for (const char c : qos) escaped += c == '\n' ? std::string("\\n") : std::string(1, c);
    topics_.push_back(fmt::format(
        "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n"
        "        offered_qos_profiles: \"{}\"\n      message_count: ",
        name, type.name, escaped));
    return mcap_.add_channel(name, type, qos);
  }

  /// cdr: a message with the stamp t.
  void add(Topic topic, slam::Stamp t, const std::string& cdr) {
    mcap_.add_message(topic, recording::file_stamp(t), cdr);
  }

  /// Closes the file. Returns the text of metadata.yaml.
  std::string finish() {
    mcap_.finish();
    std::string topics;
    for (Topic channel = 1; channel <= topics_.size(); ++channel)
      topics += fmt::format("{}{}\n", topics_[channel - 1u], mcap_.messages(channel));
    const auto span = [this](const char* indent) {
      return fmt::format(
          "{0}duration:\n{0}  nanoseconds: {1}\n{0}starting_time:\n{0}  nanoseconds_since_epoch: {2}\n"
          "{0}message_count: {3}\n",
          indent, mcap_.end_ns() - mcap_.begin_ns(), mcap_.begin_ns(), mcap_.messages());
    };
    return "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n" + span("  ") +
           "  topics_with_message_count:\n" + topics +
           "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - run.mcap\n"
           "  files:\n    - path: run.mcap\n" +
           span("      ");
  }

 private:
  McapWriter mcap_;
  std::vector<std::string> topics_;  // of metadata.yaml, up to the number of messages
};

/// The rows of mav0/<sensor>/data.csv, merged with the observations by time; none without such a file.
struct RecordedRows {
  RecordedRows(const fs::path& folder, const std::string& sensor) {
    const recording::Manifest manifest(folder);
    const std::string file = recording::recording_format::body_sensor_rows(sensor);
    if (!manifest.lists(file)) return;
    rows.emplace(files::CsvReader(manifest.check(file), 1), recording::kEpoch);
    const std::vector<std::string>& titles = rows->row().titles();
    for (std::size_t i = 1; i < titles.size(); ++i)
      names.push_back(titles[i].substr(0, titles[i].find(" [")));
  }

  /// Calls each(stamp, values) for the rows until then that no earlier call has had.
  void until(slam::Stamp t, const std::function<void(slam::Stamp, const std::vector<double>&)>& each) {
    for (; rows && rows->stamp() && *rows->stamp() <= t; rows->advance()) {
      std::vector<double> values;
      for (std::size_t i = 1; i < rows->row().fields(); ++i) values.push_back(rows->row().number(i));
      each(*rows->stamp(), values);
    }
  }

  std::optional<recording::StampedRows> rows;
  std::vector<std::string> names;  ///< the titles of the columns after the stamp, without units
};

Poses feet_of(const std::vector<recording::TrueFeet>& feet, recording::TrueFoot recording::TrueFeet::*which) {
  Poses poses;
  for (const recording::TrueFeet& at : feet) {
    const Eigen::Vector3d& foot = (at.*which).truth;  // x, y, yaw
    poses.push_back({at.t, Eigen::Translation3d(foot.x(), foot.y(), 0) *
                               Eigen::Isometry3d(Eigen::AngleAxisd(foot.z(), Eigen::Vector3d::UnitZ()))});
  }
  return poses;
}

std::string image_message(slam::Stamp t, const std::string& frame, const cv::Mat& image, bool compressed) {
  return compressed ? ros::compressed_image(t, frame, recording::encode_png(image))
                    : ros::image(t, frame, image);
}

// The distance of a camera to the right of the head camera; 0 unless both look in the same direction, side by
// side, so that their images are rectified.
double right_of_head(const rig::RigSensor& camera) {
  const Eigen::Vector3d p = camera.X_CS.translation();
  const bool parallel = camera.X_CS.linear().isIdentity(1e-9) && std::hypot(p.y(), p.z()) < 1e-9;
  return camera.kind == rig::Kind::grey && parallel ? p.x() : 0;
}

/// Writes the readings of the rig into a bag: for viewers all, under the names of the sensors; else those of
/// gray eyes and IMUs, counted.
class RigTopics {
 public:
  RigTopics(const ExportContext& out, Bag& bag, const BagLayout& layout)
      : out_(out), bag_(bag), compressed_(layout.compressed), topics_(out.setup.rig.size()) {
    for (const auto kind :
         {rig::Kind::grey, rig::Kind::color, rig::Kind::depth, rig::Kind::lidar, rig::Kind::imu})
      for (int number = 0; const int sensor : out.further(kind)) {
        ++number;
        if (layout.for_viewers)
          add(sensor, "/rig/" + out.sensor(sensor).name, "/imu");
        else if (kind == rig::Kind::grey || kind == rig::Kind::imu)
          add(sensor, fmt::format("/{}{}", kind == rig::Kind::imu ? "imu" : "cam", number), "");
      }
  }

  void write(const slam::Observation& observation) {
    for (const slam::RigReading& reading : observation.rig)
      if (const Topics& topics = topics_.at(static_cast<std::size_t>(reading.sensor)); topics.readings)
        write(reading, out_.sensor(reading.sensor), topics);
  }

 private:
  struct Topics {
    std::optional<Topic> readings, info;
  };

  void add(int index, const std::string& prefix, const std::string& imu_suffix) {
    Topics& topics = topics_[static_cast<std::size_t>(index)];
    const rig::RigSensor& sensor = out_.sensor(index);
    if (sensor.kind == rig::Kind::lidar) {
      topics.readings = bag_.add_topic(prefix + "/points", ros::kPointCloud);
    } else if (sensor.kind == rig::Kind::imu) {
      topics.readings = bag_.add_topic(prefix + imu_suffix, ros::kImu);
    } else {
      const bool compressed = is_compressed(sensor);
      topics.readings = bag_.add_topic(prefix + (compressed ? "/image/compressed" : "/image_raw"),
                                       compressed ? ros::kCompressedImage : ros::kImage);
      topics.info = bag_.add_topic(prefix + "/camera_info", ros::kCameraInfo);
    }
  }

  // Readers of compressed depth images disagree on their format.
  bool is_compressed(const rig::RigSensor& camera) const {
    return compressed_ && camera.kind != rig::Kind::depth;
  }

  void write(const slam::RigReading& reading, const rig::RigSensor& sensor, const Topics& topics) {
    const std::string frame = frame_of(sensor);
    if (sensor.kind == rig::Kind::lidar) {
      bag_.add(*topics.readings, reading.t, ros::point_cloud(reading.t, frame, reading.points));
    } else if (sensor.kind == rig::Kind::imu) {
      const auto square = [](double sigma) { return sigma * sigma; };
      const ImuReading imu{middle(reading), reading.gyro, reading.accelerometer};
      bag_.add(
          *topics.readings, imu.t,
          ros::imu(imu, frame, square(sensor.gyro_sigma_rad_s), square(sensor.accelerometer_sigma_m_s2)));
    } else if (!reading.image.empty()) {
      bag_.add(*topics.readings, reading.t,
               image_message(reading.t, frame, out_.exported(reading.image, reading.sensor),
                             is_compressed(sensor)));
      bag_.add(*topics.info, reading.t,
               ros::camera_info(reading.t, frame, sensor.camera, right_of_head(sensor)));
    }
  }

  const ExportContext& out_;
  Bag& bag_;
  const bool compressed_;
  std::vector<Topics> topics_;  // by sensor
};

/// Writes frames, paths, map, joints and feet into a bag, observation by observation. An export without truth
/// has neither true poses nor those of the filter.
class ViewerTopics {
 public:
  /// The bag must outlive it.
  ViewerTopics(const ExportContext& out, Bag& bag)
      : bag_(bag),
        fixed_{{{}, kCameraFrame, kImuFrame, out.setup.calibration.X_CG}},
        joints_(out.run.result / "recording", "encoders0"),
        forces_(out.run.result / "recording", "forces0"),
        robot_(out.run.robot),
        transforms_(bag.add_topic("/tf", ros::kTransforms)),
        fixed_transforms_(bag.add_topic("/tf_static", ros::kTransforms, true)) {
    for (const rig::RigSensor& sensor : out.setup.rig)
      if (sensor.kind != rig::Kind::depth)  // its frame is another camera's
        fixed_.push_back({{}, kCameraFrame, frame_of(sensor), sensor.X_CS});
    add("plan_camera", transforms_, {}, "/plan/path");
    add_truth(out.truth());
    const std::vector<files::TumRow> estimate = out.estimate();
    add("slam_camera", transforms_, Poses(estimate.begin(), estimate.end()), "/slam/path");
    read_maps(out);
    if (robot_) description_ = bag.add_topic("/robot_description", ros::kString, true);
    if (!joints_.names.empty()) joint_states_ = bag.add_topic("/joint_states", ros::kJointState);
    if (forces_.names.empty()) return;
    left_wrench_ = bag.add_topic("/left_foot/wrench", ros::kWrench);
    right_wrench_ = bag.add_topic("/right_foot/wrench", ros::kWrench);
  }

  /// Writes the messages up to the stamp of an observation; stamps rise.
  void write(const slam::Observation& observation) {
    const slam::Stamp t = observation.t;
    if (!last_) write_start(t);
    last_ = t;
    if (observation.plan) moving_.front().poses.push_back({t, observation.plan->X_PC});
    write_transforms(t);
    write_body(t);
    for (; !maps_.empty() && maps_.begin()->first <= t; maps_.erase(maps_.begin()))
      bag_.add(*map_, maps_.begin()->first,
               ros::point_cloud(maps_.begin()->first, kWorld, maps_.begin()->second));
    if (!paths_written_ || t - *paths_written_ >= std::chrono::seconds(1)) write_paths(t);
  }

  /// Writes the whole paths at the stamp of the last observation.
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
    std::optional<Topic> path = {};
  };

  // Skips frames without poses, except the planned one: its poses come with the observations.
  void add(const std::string& frame, Topic transforms, Poses poses, const char* path = nullptr) {
    if (poses.empty() && frame != "plan_camera") return;
    moving_.push_back({frame, transforms, std::move(poses)});
    if (path) moving_.back().path = bag_.add_topic(path, ros::kPath);
  }

  // Not in /tf: there the program under test publishes the poses of the robot (REP 105).
  void add_truth(const recording::Truth& truth) {
    if (truth.camera.empty()) return;
    const Topic moving = bag_.add_topic("/ground_truth/tf", ros::kTransforms);
    true_fixed_transforms_ = bag_.add_topic("/ground_truth/tf_static", ros::kTransforms, true);
    add(kTrue + kCamera, moving, truth.camera, "/ground_truth/path");
    add(kTrue + kWaist, moving, truth.waist);
    add(kTrue + "left_foot", moving, feet_of(truth.feet, &recording::TrueFeet::left));
    add(kTrue + "right_foot", moving, feet_of(truth.feet, &recording::TrueFeet::right));
  }

  // Once a second, each landmark a row: stamp, id, position.
  void read_maps(const ExportContext& out) {
    const fs::path file = out.run.result / "map_over_time.csv";
    if (!out.run.with_truth || !fs::exists(file)) return;
    for (files::CsvReader rows(file, 5); rows.next();)
      maps_[slam::Stamp(rows.integer(0))].push_back(
          {rows.vector(2), static_cast<std::uint32_t>(rows.integer(1))});
    if (!maps_.empty()) map_ = bag_.add_topic("/slam/map", ros::kPointCloud);
  }

  void write_start(slam::Stamp t) {
    const auto same = Eigen::Isometry3d::Identity();
    for (ros::Transform& transform : fixed_) transform.t = t;
    bag_.add(fixed_transforms_, t, ros::transforms(fixed_));
    if (true_fixed_transforms_)
      bag_.add(
          *true_fixed_transforms_, t,
          ros::transforms({{t, kTrue + kCamera, kCameraFrame, same}, {t, kTrue + kWaist, kWaist, same}}));
    if (description_) bag_.add(*description_, t, ros::string(robot_->urdf));
  }

  void write_transforms(slam::Stamp t) {
    std::map<Topic, std::vector<ros::Transform>> all;
    for (Moving& moving : moving_) {
      const std::size_t before = moving.passed;
      while (moving.passed < moving.poses.size() && moving.poses[moving.passed].t <= t) ++moving.passed;
      if (moving.passed == before) continue;
      const files::TimedPose& now = moving.poses[moving.passed - 1];
      all[moving.transforms].push_back({now.t, kWorld, moving.frame, now.X});
    }
    for (const auto& [topic, now] : all) bag_.add(topic, t, ros::transforms(now));
  }

  // Readings at their full rate, the links at the last one until each frame.
  void write_body(slam::Stamp t) {
    std::optional<std::pair<slam::Stamp, std::vector<double>>> last;
    joints_.until(t, [&](slam::Stamp at, const std::vector<double>& q) {
      if (joint_states_) bag_.add(*joint_states_, at, ros::joint_state(at, joints_.names, q));
      last = {at, q};
    });
    if (robot_ && last) {
      const auto& [at, q] = *last;
      const auto poses =
          robot_->poses(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
      std::vector<ros::Transform> links;
      for (std::size_t i = 0; i < poses.size(); ++i)
        links.push_back({at, kWaist, robot_->links[i], poses[i]});
      bag_.add(transforms_, at, ros::transforms(links));
    }
    forces_.until(t, [&](slam::Stamp at, const std::vector<double>& values) {
      if (values.size() < 12) return;
      const auto vector = [&](std::size_t first) { return Eigen::Vector3d(&values[first]); };
      bag_.add(*left_wrench_, at, ros::wrench(at, "left_foot", vector(0), vector(3)));
      bag_.add(*right_wrench_, at, ros::wrench(at, "right_foot", vector(6), vector(9)));
    });
  }

  void write_paths(slam::Stamp t) {
    paths_written_ = t;
    for (const Moving& moving : moving_)
      if (moving.path)
        bag_.add(*moving.path, t, ros::path(t, kWorld, std::span(moving.poses).first(moving.passed)));
  }

  Bag& bag_;
  std::vector<ros::Transform> fixed_;
  std::vector<Moving> moving_;
  std::map<slam::Stamp, std::vector<ros::CloudPoint>> maps_;
  RecordedRows joints_, forces_;
  const std::shared_ptr<const RobotDescription> robot_;
  Topic transforms_, fixed_transforms_;
  std::optional<Topic> true_fixed_transforms_, description_, joint_states_, left_wrench_, right_wrench_, map_;
  std::optional<slam::Stamp> last_, paths_written_;
};

}  // namespace

std::string frame_of(const rig::RigSensor& sensor) {
  if (!rig::is_camera(sensor)) return sensor.name + "_frame";
  return (sensor.kind == rig::Kind::depth ? sensor.aligned_with : sensor.name) + "_optical_frame";
}

// Truth and estimate have the stamps of the frames; they are merged with the observations by time.
void write_ros_bag(const ExportContext& out, const BagLayout& layout) {
  Bag bag(out.new_file(layout.folder + "run.mcap"));
  const Topic images =
                  bag.add_topic(layout.image_topic, layout.compressed ? ros::kCompressedImage : ros::kImage),
              infos = bag.add_topic(layout.info_topic, ros::kCameraInfo),
              readings = bag.add_topic(layout.imu_topic, ros::kImu),
              true_poses = bag.add_topic("/ground_truth/pose", ros::kPoseStamped),
              plans = bag.add_topic("/plan/pose", ros::kPoseStamped);
  const Poses truth = out.truth().camera;
  const std::vector<files::TumRow> estimate = out.estimate();
  const Topic estimates =
      estimate.empty() ? Topic{0} : bag.add_topic("/slam/pose", ros::kPoseWithCovarianceStamped);
  RigTopics rig(out, bag, layout);
  std::optional<ViewerTopics> viewer;
  if (layout.for_viewers) viewer.emplace(out, bag);
  const auto variance = [&](double density) { return density * density * out.setup.imu_rate_hz; };
  auto true_pose = truth.begin();
  auto estimated = estimate.begin();
  ImuMerger imu_merger(out.setup.imu_rate_hz);
  for (recording::FilterInput input = out.filter_input(); auto o = out.next(input);) {
    for (const ImuReading& reading : imu_merger.merge(*o))
      bag.add(readings, reading.t,
              ros::imu(reading, kImuFrame, variance(out.noise.gyro_density),
                       variance(out.noise.accelerometer_density)));
    if (!o->image.empty()) {
      const cv::Mat image = out.exported(o->image);
      bag.add(images, o->t, image_message(o->t, kCameraFrame, image, layout.compressed));
      bag.add(infos, o->t, ros::camera_info(o->t, kCameraFrame, out.camera()));
    }
    rig.write(*o);
    if (o->plan) bag.add(plans, o->t, ros::pose_stamped(o->t, kWorld, o->plan->X_PC));
    for (; true_pose != truth.end() && true_pose->t <= o->t; ++true_pose)
      bag.add(true_poses, true_pose->t, ros::pose_stamped(true_pose->t, kWorld, true_pose->X));
    for (; estimated != estimate.end() && estimated->t <= o->t; ++estimated)
      bag.add(estimates, estimated->t,
              ros::pose_with_covariance_stamped(estimated->t, kWorld, estimated->X,
                                                estimated->covariance.value_or(files::Matrix6d::Zero())));
    if (viewer) viewer->write(*o);
  }
  if (viewer) viewer->finish();
  out.write(layout.folder + "metadata.yaml", bag.finish());
}

}  // namespace sim::exports
