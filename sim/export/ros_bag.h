// A ROS 2 bag in parts: the file, the topics of the sensors, and the topics of poses, frames and the robot.
#pragma once

#include <map>
#include <memory>
#include <numeric>

#include "sim/export/ros_messages.h"
#include "sim/files/hash.h"

namespace sim::exports {

using Topic = std::optional<std::uint16_t>;  ///< absent: the bag has no such messages

/// An MCAP file (mcap.dev, format version 0) of ROS 2 messages in CDR: chunked, indexed, uncompressed, with a
/// checksum for each chunk. Keeps one chunk and the indexes in memory. Throws FileError.
class McapWriter {
 public:
  explicit McapWriter(const fs::path& file);

  /// Adds a channel before the first message; returns its number. qos: publisher's profiles in YAML or empty.
  std::uint16_t add_channel(const std::string& topic, const MessageType& type, const std::string& qos);
  void add_message(std::uint16_t channel, std::int64_t t_ns, std::string_view cdr);
  /// Writes the indexes and closes the file. Without them it is not a valid MCAP file.
  void finish();

  std::uint64_t messages() const { return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}); }
  std::uint64_t messages(std::uint16_t channel) const { return counts_.at(channel - 1u); }
  std::uint64_t begin_ns() const { return begin_; }
  std::uint64_t end_ns() const { return end_; }

 private:
  struct Chunk {  // its index
    std::uint64_t begin, end, offset, length, index_length, size;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
  };
  using Moments = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // time, offset in the chunk

  void put(std::string_view bytes);
  void close_chunk();

  files::HashedFile out_;
  std::uint64_t at_ = 0;
  std::vector<std::string> schemas_, channels_;  // records
  std::vector<std::uint64_t> counts_;            // messages per channel
  std::vector<Chunk> chunks_;
  std::string chunk_;
  std::map<std::uint16_t, Moments> moments_;
  std::uint64_t chunk_begin_ = ~0ull, chunk_end_ = 0, begin_ = ~0ull, end_ = 0;
};

/// run.mcap, and the content of metadata.yaml.
class Bag {
 public:
  explicit Bag(const fs::path& mcap_file) : mcap_(mcap_file) {}
  /// Must be called before the first message. latched: late subscribers get the topic's last message
  /// (transient_local).
  Topic add_topic(const std::string& name, const MessageType& type, bool latched = false);
  /// cdr: a message stamped t. Without a topic, nothing is written.
  void add(Topic topic, slam::Stamp t, const std::string& cdr);
  /// Closes the file. Returns the text of metadata.yaml.
  std::string finish();

 private:
  McapWriter mcap_;
  std::vector<std::array<std::string, 3>> topics_;  // name, type, profile
};

/// Returns the frame of a sensor. Cameras have optical axes (x right, y down, z forward), other sensors x
/// forward, y left, z up. A depth camera has the frame of the camera it is aligned with.
std::string frame_of(const rig::RigSensor& sensor);

/// Writes the sensors' readings into a bag. For viewers: all sensors under their own names. Otherwise: gray
/// cameras and IMUs, numbered. The bag must outlive this object.
class SensorTopics {
 public:
  SensorTopics(const ExportContext& out, Bag& bag, bool for_viewers);
  void write(const ExportedFrame& frame);

 private:
  struct Topics {
    Topic readings, info, registered, registered_info;
    int registered_to = 0;  ///< the camera whose pixels the registered depth has
    std::optional<DepthRegistration> registration = {};
    bool as_png = false;
  };
  void add_registered(const std::string& name, int depth, Topics& topics);

  const ExportContext& out_;
  Bag& bag_;
  std::vector<Topics> topics_;  // by sensor
};

/// Writes poses into a bag, frame by frame; for viewers also frames, paths, map, joints and feet. An export
/// without truth contains neither the true poses nor the filter's. The bag must outlive this object.
class PoseTopics {
 public:
  PoseTopics(const ExportContext& out, Bag& bag, bool for_viewers);
  /// Writes the messages up to a frame's stamp. Stamps must increase.
  void write(const ExportedFrame& frame);
  /// Writes the whole paths at the stamp of the last frame.
  void finish() {
    if (last_ != paths_written_) write_paths(*last_);
  }

 private:
  /// Poses in the world, past and to come.
  struct Moving {
    std::vector<files::TumRow> poses;
    Topic each = {}, path = {};
    bool with_covariance = false;
    std::string true_frame = {};  ///< in /ground_truth/tf
    std::size_t passed = 0;       ///< number of poses passed
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
  std::vector<Moving> moving_;  // the plan comes first
  std::map<slam::Stamp, std::vector<ros::CloudPoint>> maps_;
  std::optional<RecordedRows> joints_, forces_;
  std::shared_ptr<const RobotDescription> robot_;
  struct {
    Topic tf, tf_static, true_tf, true_tf_static, description, joints, left_wrench, right_wrench, map;
  } topics_;
  std::optional<slam::Stamp> last_, paths_written_;
};

}  // namespace sim::exports
