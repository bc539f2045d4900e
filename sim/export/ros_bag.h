// A ROS 2 bag in parts: the file, the topics of the sensors, and those of poses, frames and the robot.
#pragma once

#include <memory>

#include "sim/export/ros_messages.h"

namespace sim::exports {

using Topic = std::optional<std::uint16_t>;  ///< of messages that the bag has

/// run.mcap, and the content of metadata.yaml.
class Bag {
 public:
  explicit Bag(const fs::path& mcap_file) : mcap_(mcap_file) {}
  /// To be called before the first message. latched: late subscribers get its last message (transient_local).
  Topic add_topic(const std::string& name, const MessageType& type, bool latched = false);
  /// cdr: a message with the stamp t; nothing is written without a topic.
  void add(Topic topic, slam::Stamp t, const std::string& cdr);
  /// Closes the file. Returns the text of metadata.yaml.
  std::string finish();

 private:
  McapWriter mcap_;
  std::vector<std::array<std::string, 3>> topics_;  // name, type, profile
};

/// Returns the frame of a sensor: optical axes (x right, y down, z forward) of a camera, else x forward, y
/// left, z up. Depth has that of the camera that it is aligned with.
std::string frame_of(const rig::RigSensor& sensor);

/// Writes the readings of the sensors into a bag: for viewers all, under the names of the sensors; else those
/// of gray cameras and IMUs, counted. The bag must outlive it.
class SensorTopics {
 public:
  SensorTopics(const ExportContext& out, Bag& bag, bool for_viewers);
  void write(const ExportedFrame& frame);

 private:
  struct Topics {
    Topic readings, info, registered, registered_info;
    int registered_to = 0;  ///< the camera with the pixels of registered depth
    std::optional<DepthRegistration> registration = {};
    bool as_png = false;
  };
  void add_registered(const std::string& name, int depth, Topics& topics);

  const ExportContext& out_;
  Bag& bag_;
  std::vector<Topics> topics_;  // by sensor
};

/// Writes poses into a bag, frame by frame; for viewers also frames, paths, map, joints and feet. An export
/// without truth has neither true poses nor those of the filter. The bag must outlive it.
class PoseTopics {
 public:
  PoseTopics(const ExportContext& out, Bag& bag, bool for_viewers);
  /// Writes the messages up to the stamp of a frame; stamps rise.
  void write(const ExportedFrame& frame);
  /// Writes the whole paths at the stamp of the last frame.
  void finish() {
    if (last_ != paths_written_) write_paths(*last_);
  }

 private:
  /// Poses in the world until now, and those to come.
  struct Moving {
    std::vector<files::TumRow> poses;
    Topic each = {}, path = {};
    bool with_covariance = false;
    std::string true_frame = {};  ///< in /ground_truth/tf
    std::size_t passed = 0;       ///< of the poses
  };

  void add(const std::string& prefix, const MessageType& type, std::vector<files::TumRow> poses,
           const std::string& true_frame = "");
  void add_true_frames(const recording::Truth& truth);
  void add_fixed_frames(const ExportContext& out);
  void add_viewer_topics(const ExportContext& out);
  void write_start(slam::Stamp t);
  void write_poses(slam::Stamp t);
  void write_body(slam::Stamp t);
  void write_paths(slam::Stamp t);

  Bag& bag_;
  const bool for_viewers_;
  std::vector<ros::Transform> fixed_, true_fixed_;
  std::vector<Moving> moving_;  // the plan first
  std::map<slam::Stamp, std::vector<ros::CloudPoint>> maps_;
  std::optional<RecordedRows> joints_, forces_;
  std::shared_ptr<const RobotDescription> robot_;
  struct {
    Topic tf, tf_static, true_tf, true_tf_static, description, joints, left_wrench, right_wrench, map;
  } topics_;
  std::optional<slam::Stamp> last_, paths_written_;
};

}  // namespace sim::exports
