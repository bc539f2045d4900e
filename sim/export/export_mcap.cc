#include "sim/export/export_mcap.h"

#include "sim/export/ros_bag.h"

namespace sim::exports {
namespace {

constexpr const char* kMcapReadme =
    R"(`run.mcap` holds ROS 2 messages (CDR), `metadata.yaml` makes the folder a bag:

    ros2 bag play FOLDER                      # or: ros2 bag info FOLDER
    evo_ape mcap FOLDER/run.mcap /ground_truth/pose /slam/pose

Foxglove, Lichtblick and Rerun open `run.mcap` itself. In a 3D panel with the frame `world`, switch on `/tf`, the paths, `/slam/map` and the robot of `/robot_description`;
`/camera/image/compressed` goes into an image panel, `/joint_states` and the wrenches into plots.

| topic | type | content |
|---|---|---|
| /camera/image/compressed | sensor_msgs/CompressedImage | PNG, lossless |
| /camera/camera_info | sensor_msgs/CameraInfo | with each image |
| /imu | sensor_msgs/Imu | chest IMU |
| /ground_truth/pose | geometry_msgs/PoseStamped | true camera pose in the world |
| /plan/pose | geometry_msgs/PoseStamped | planned camera pose |
| /slam/pose | geometry_msgs/PoseWithCovarianceStamped | estimated camera pose, if there was an estimate |
| /tf | tf2_msgs/TFMessage | at each frame, in `world`: true `camera`, `waist`, `left_foot` and `right_foot`, `plan_camera`, `slam_camera`; the robot's links in `waist` |
| /tf_static | tf2_msgs/TFMessage | `imu` in `camera`, as calibrated |
| /ground_truth/path, /plan/path, /slam/path | nav_msgs/Path | camera path so far, once a second and at the end |
| /slam/map | sensor_msgs/PointCloud2 | landmarks, once a second: x, y, z and id |
| /robot_description | std_msgs/String | the robot as URDF, at the start; where the program that exported has the simulator |
| /joint_states | sensor_msgs/JointState | joint encoders, the last reading until each frame |
| /left_foot/wrench, /right_foot/wrench | geometry_msgs/WrenchStamped | force and torque of the ground on each sole, likewise |
)";

}  // namespace

void export_mcap(const ExportContext& out) {
  write_ros_bag(out, {"", "/camera/image/compressed", "/camera/camera_info", "/imu", true, true});
  out.write_readme(kMcapReadme);
}

}  // namespace sim::exports
