// A ROS 2 bag that is being written, and the topics that viewers draw. All members throw FileError.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/export/export_context.h"
#include "sim/export/mcap.h"
#include "sim/export/ros_messages.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {

/// run.mcap, and the content of metadata.yaml.
class Bag {
 public:
  using Topic = std::uint16_t;

  explicit Bag(const std::filesystem::path& mcap_file) : mcap_(mcap_file) {}

  enum class Durability { volatile_, transient_local };
  /// To be called before the first message. transient_local: late subscribers get its last message.
  Topic add_topic(const std::string& name, const MessageType& type,
                  Durability durability = Durability::volatile_);
  /// cdr: a message with the stamp t.
  void add(Topic topic, slam::Stamp t, const std::string& cdr);
  /// Closes the file. Returns the text of metadata.yaml.
  std::string finish();

 private:
  struct NamedTopic {
    std::string name, type, qos;
    Topic channel;
  };

  McapWriter mcap_;
  std::vector<NamedTopic> topics_;
};

/// The rows of mav0/<sensor>/data.csv, merged with the observations by time; none without such a file.
class RecordedRows {
 public:
  RecordedRows(const std::filesystem::path& recording, const std::string& sensor);

  /// The titles of the columns after the stamp, without units.
  const std::vector<std::string>& names() const { return names_; }
  struct Row {
    slam::Stamp t{0};
    std::vector<double> values;
  };
  /// Returns the rows until then that no earlier call has returned.
  std::vector<Row> until(slam::Stamp t);

 private:
  std::optional<recording::StampedRows> rows_;
  std::vector<std::string> names_;
};

/// Writes frames, paths, map, joints and feet into a bag, observation by observation. An export without truth
/// has neither true poses nor those of the filter.
class ViewerTopics {
 public:
  /// The bag must outlive it.
  ViewerTopics(const ExportContext& out, Bag& bag);

  /// Writes the messages up to the stamp of an observation; stamps rise.
  void write(const slam::Observation& observation);
  /// Writes the whole paths at the stamp of the last observation.
  void finish();

 private:
  /// Poses of one frame in the world until now, and those to come.
  struct Moving {
    std::string frame;
    Bag::Topic transforms;
    std::vector<files::TimedPose> poses;
    std::size_t passed = 0;  ///< of the poses
    std::optional<Bag::Topic> path = {};
  };

  void add(const std::string& frame, Bag::Topic transforms, std::vector<files::TimedPose> poses,
           const char* path = nullptr);
  void add_truth(const recording::Truth& truth);
  void write_start(slam::Stamp t);
  void write_transforms(slam::Stamp t);
  void write_body(slam::Stamp t);
  void write_links(const RecordedRows::Row& joints);
  void write_map(slam::Stamp t);
  void write_paths(slam::Stamp t);

  Bag& bag_;
  const Eigen::Isometry3d X_CG_;
  std::vector<Moving> moving_;
  std::map<slam::Stamp, std::vector<ros::CloudPoint>> maps_;
  RecordedRows joints_, forces_;
  const std::shared_ptr<const RobotDescription> robot_;
  Bag::Topic transforms_, fixed_transforms_;
  std::optional<Bag::Topic> true_fixed_transforms_, description_, joint_states_, left_wrench_, right_wrench_,
      map_;
  std::optional<slam::Stamp> last_, paths_written_;
};

}  // namespace sim::exports
