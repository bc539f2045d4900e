#include "sim/export/export_mcap.h"

#include "sim/export/ros_bag.h"

namespace sim::exports {
namespace {

constexpr const char* kMcapReadme =
    R"(`run.mcap` holds ROS 2 messages (CDR), `metadata.yaml` makes the folder a bag:

    ros2 bag play FOLDER                      # or: ros2 bag info FOLDER
    evo_ape mcap FOLDER/run.mcap /ground_truth/pose /slam/pose

Foxglove, Lichtblick and Rerun open `run.mcap` itself.

| topic | type | content |
|---|---|---|
| /camera/image/compressed | sensor_msgs/CompressedImage | PNG, lossless |
| /camera/camera_info | sensor_msgs/CameraInfo | with each image |
| /imu | sensor_msgs/Imu | chest IMU |
| /ground_truth/pose | geometry_msgs/PoseStamped | true camera pose in the world |
| /plan/pose | geometry_msgs/PoseStamped | planned camera pose |
| /slam/pose | geometry_msgs/PoseWithCovarianceStamped | camera pose of GaitSLAM's filter, if one ran |
)";

}  // namespace

void export_mcap(const ExportContext& out) {
  write_ros_bag(out, {"", "/camera/image/compressed", "/camera/camera_info", "/imu", true});
  out.write_readme(kMcapReadme);
}

}  // namespace sim::exports
