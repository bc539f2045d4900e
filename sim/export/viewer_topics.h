// What viewers of bags draw besides images and poses: frames, paths, the map, joints and feet.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/export/bag.h"
#include "sim/export/export_context.h"
#include "sim/export/recorded_rows.h"
#include "sim/export/ros_messages.h"

namespace sim::exports {

/// Writes them into a bag, observation by observation. True poses and those of the filter are left out where
/// the export is to be without truth.
class ViewerTopics {
 public:
  /// The bag must outlive it.
  ViewerTopics(const ExportContext& out, Bag& bag);

  /// What is known at the stamp of an observation; stamps rise.
  void write(const slam::Observation& observation);
  /// The whole paths, at the stamp of the last observation.
  void finish();

 private:
  /// Poses of one frame in the world until now, and those to come.
  struct Moving {
    std::string frame;
    std::vector<files::TimedPose> poses;
    std::size_t passed = 0;  ///< of the poses
    std::optional<Bag::Topic> path = {};
  };

  void add(const std::string& frame, std::vector<files::TimedPose> poses, const char* path = nullptr);
  std::vector<ros::Transform> transforms_at(slam::Stamp t);
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
  std::optional<Bag::Topic> description_, joint_states_, left_wrench_, right_wrench_, map_;
  std::optional<slam::Stamp> last_, paths_written_;
};

}  // namespace sim::exports
