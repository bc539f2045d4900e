// A ROS 2 bag of a run: run.mcap and metadata.yaml.
#pragma once

#include <string>

#include "sim/export/export_context.h"

namespace sim::exports {

struct BagLayout {
  std::string folder;  ///< of run.mcap and metadata.yaml, with a slash behind it; may be empty
  std::string image_topic, info_topic, imu_topic;
  bool compressed;           ///< images as PNG (sensor_msgs/CompressedImage), else raw (sensor_msgs/Image)
  bool for_viewers = false;  ///< with frames, paths, map, joints and feet
};

void write_ros_bag(const ExportContext& out, const BagLayout& layout);

}  // namespace sim::exports
