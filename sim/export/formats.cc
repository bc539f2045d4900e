// The TUM RGB-D layout, OpenVINS, and bags for viewers.
#include <fmt/format.h>

#include <cmath>

#include "sim/export/export_context.h"
#include "sim/export/ros_messages.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {
namespace {

constexpr const char* kTumReadme =
    R"(Layout of the TUM RGB-D benchmark (Sturm et al. 2012): `rgb/`, `rgb.txt`, `accelerometer.txt`, and true
camera poses in `groundtruth.txt`; `plan.txt` has the camera poses of the walking plan, `estimate.txt` (if a filter
ran) those of GaitSLAM's filter. `settings.yaml` is for ORB-SLAM3 (v1.0). In the folder of ORB-SLAM3:

    ./Examples/Monocular/mono_tum Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER
    evo_ape tum FOLDER/groundtruth.txt KeyFrameTrajectory.txt --align --correct_scale
)";

// Three lines before the first row: readers skip that many.
std::string header(const char* what, const ExportContext& out, const char* columns) {
  return fmt::format("# {}\n# file: {}, seed {}\n# {}\n", what, out.run.name, out.run.seed, columns);
}

constexpr const char* kMcapReadme =
    R"(`run.mcap` holds ROS 2 messages (CDR), `metadata.yaml` makes the folder a bag:

    ros2 bag play FOLDER                      # or: ros2 bag info FOLDER
    evo_ape mcap FOLDER/run.mcap /ground_truth/pose /slam/pose

Foxglove, Lichtblick and Rerun open `run.mcap` itself. In a 3D panel with the frame `world`, switch on `/tf`, `/ground_truth/tf`, the paths, `/slam/map` and the robot of `/robot_description`;
`/camera/image/compressed` goes into an image panel, `/joint_states` and the wrenches into plots.

| topic | type | content |
|---|---|---|
| /camera/image/compressed | sensor_msgs/CompressedImage | PNG, lossless |
| /camera/camera_info | sensor_msgs/CameraInfo | with each image |
| /imu | sensor_msgs/Imu | chest IMU |
| /ground_truth/pose | geometry_msgs/PoseStamped | true camera pose in the world |
| /plan/pose | geometry_msgs/PoseStamped | planned camera pose |
| /slam/pose | geometry_msgs/PoseWithCovarianceStamped | estimated camera pose, if there was an estimate |
| /tf | tf2_msgs/TFMessage | at each frame, in `world`: `plan_camera`, `slam_camera`; the robot's links in `waist` |
| /tf_static | tf2_msgs/TFMessage | `imu` in `camera`, as calibrated; transient_local |
| /ground_truth/tf | tf2_msgs/TFMessage | at each frame, in `world`: the true `ground_truth/camera`, `ground_truth/waist`, `ground_truth/left_foot` and `ground_truth/right_foot` |
| /ground_truth/tf_static | tf2_msgs/TFMessage | `camera` and `waist` in these, for viewers; `ros2 bag play` leaves them out of /tf, so that a SLAM node can publish map, odom and base_link |
| /ground_truth/path, /plan/path, /slam/path | nav_msgs/Path | camera path so far, once a second and at the end |
| /slam/map | sensor_msgs/PointCloud2 | landmarks, once a second: x, y, z and id |
| /robot_description | std_msgs/String | the robot as URDF, at the start, transient_local; if the program that exported has the simulator |
| /joint_states | sensor_msgs/JointState | joint encoders, 200 Hz |
| /left_foot/wrench, /right_foot/wrench | geometry_msgs/WrenchStamped | force and torque of the ground on each sole, 200 Hz |
)";

constexpr const char* kOpenvinsReadme =
    R"(For OpenVINS (2.7 with ROS 2): a bag with raw images, and `estimator_config.yaml` with the two calibration
files that it names. In two terminals:

    ros2 run ov_msckf run_subscribe_msckf FOLDER/estimator_config.yaml
    ros2 bag play FOLDER/bag

Without ROS, `mav0` has the same images and readings in EuRoC's layout.

`groundtruth.csv` is the true motion of the IMU in EuRoC's columns (for `path_gt`), `groundtruth.tum` that of
the camera. OpenVINS writes poses of the IMU. To compare:

    gaitslam score FOLDER/groundtruth.csv ov_estimate.txt --align yaw

Four lines of `estimator_config.yaml` differ from those of OpenVINS' own examples, because the walk begins at rest and shakes:
`init_dyn_use: true`, `init_window_time: 2.0`, `init_imu_thresh: 5.0`, `init_max_disparity: 3.0`. For results that repeat, one thread is
used and no solver stops by the clock (`init_dyn_mle_max_time`); `track_frequency` is above the rate of the camera, so that no
image is left out.
)";

// T_imu_cam maps from the camera to the IMU.
std::string camera_chain(const ExportContext& out) {
  const slam::CameraIntrinsics& camera = out.camera();
  const auto lens = equidistant_lens(camera);
  const auto k = lens.value_or(std::array<double, 4>{});
  const Eigen::Isometry3d X_GC = out.setup.calibration.X_CG.inverse();
  return fmt::format(
      "%YAML:1.0\n\ncam0:\n  T_imu_cam:\n{}\n  cam_overlaps: []\n  camera_model: pinhole\n  "
      "distortion_coeffs: [{}, {}, {}, {}]\n"
      "  distortion_model: {}\n  intrinsics: [{}, {}, {}, {}]\n  resolution: [{}, {}]\n"
      "  rostopic: /cam0/image_raw\n  timeshift_cam_imu: {}\n",
      matrix_text(X_GC, "    - [", "]", "\n"), real(k[0]), real(k[1]), real(k[2]), real(k[3]),
      lens ? "equidistant" : "radtan", real(camera.fu_px), real(camera.fv_px), real(camera.u0_px),
      real(camera.v0_px), camera.width_px, camera.height_px, real(out.run.errors.motion.time_offset_s));
}

std::string square(const char* key, double diagonal) {
  const std::string d = real(diagonal);
  return fmt::format("  {0}:\n    - [{1}, 0.0, 0.0]\n    - [0.0, {1}, 0.0]\n    - [0.0, 0.0, {1}]\n", key, d);
}

std::string imu_chain(const ExportContext& out) {
  return "%YAML:1.0\n\nimu0:\n  T_i_b:\n" + matrix_text(Eigen::Isometry3d::Identity(), "    - [", "]", "\n") +
         fmt::format(
             "\n  accelerometer_noise_density: {}\n  accelerometer_random_walk: {}\n"
             "  gyroscope_noise_density: {}\n  gyroscope_random_walk: {}\n  rostopic: /imu0\n  update_rate: "
             "{}\n",
             real(out.noise.accelerometer_density), real(out.noise.accelerometer_walk),
             real(out.noise.gyro_density), real(out.noise.gyro_walk), real(out.setup.imu_rate_hz)) +
         "  time_offset: 0.0\n  model: \"kalibr\"\n" + square("Tw", 1) + square("R_IMUtoGYRO", 1) +
         square("Ta", 1) + square("R_IMUtoACC", 1) + square("Tg", 0);
}

const std::string kEstimator = R"(%YAML:1.0

verbosity: "INFO"
use_fej: true
integration: "rk4"
use_imuavg: true
use_rk4int: true
use_stereo: false
max_cameras: 1
calib_cam_extrinsics: false
calib_cam_intrinsics: false
calib_cam_timeoffset: false
calib_imu_intrinsics: false
calib_imu_g_sensitivity: false
max_clones: 11
max_slam: 50
max_slam_in_update: 25
max_msckf_in_update: 40
dt_slam_delay: 1
gravity_mag: 9.81
feat_rep_msckf: "GLOBAL_3D"
feat_rep_slam: "ANCHORED_MSCKF_INVERSE_DEPTH"
feat_rep_aruco: "ANCHORED_MSCKF_INVERSE_DEPTH"
try_zupt: false
zupt_chi2_multipler: 0
zupt_max_velocity: 0.1
zupt_noise_multiplier: 10
zupt_max_disparity: 0.5
zupt_only_at_beginning: false
init_window_time: 2.0
init_imu_thresh: 5.0
init_max_disparity: 3.0
init_max_features: 75
init_dyn_use: true
init_dyn_mle_opt_calib: false
init_dyn_mle_max_iter: 50
init_dyn_mle_max_time: 1000.0
init_dyn_mle_max_threads: 1
init_dyn_num_pose: 6
init_dyn_min_deg: 10.0
init_dyn_inflation_ori: 10
init_dyn_inflation_vel: 100
init_dyn_inflation_bg: 10
init_dyn_inflation_ba: 100
init_dyn_min_rec_cond: 1e-12
init_dyn_bias_g: [0.0, 0.0, 0.0]
init_dyn_bias_a: [0.0, 0.0, 0.0]
record_timing_information: false
record_timing_filepath: "ov_timing.txt"
save_total_state: false
filepath_est: "ov_estimate.txt"
filepath_std: "ov_estimate_std.txt"
filepath_gt: "ov_groundtruth.txt"
use_klt: true
num_pts: 200
fast_threshold: 20
grid_x: 5
grid_y: 5
min_px_dist: 10
knn_ratio: 0.70
downsample_cameras: false
num_opencv_threads: 1
use_multi_threading_subs: false
use_multi_threading_pubs: false
histogram_method: "HISTOGRAM"
use_aruco: false
num_aruco: 1024
downsize_aruco: true
up_msckf_sigma_px: 1
up_msckf_chi2_multipler: 1
up_slam_sigma_px: 1
up_slam_chi2_multipler: 1
up_aruco_sigma_px: 1
up_aruco_chi2_multipler: 1
use_mask: false
relative_config_imu: "kalibr_imu_chain.yaml"
relative_config_imucam: "kalibr_imucam_chain.yaml"
)";

}  // namespace

void export_tum(const ExportContext& out) {
  const char* poses = "timestamp tx ty tz qx qy qz qw";
  std::string images = header("color images", out, "timestamp filename"),
              accelerations = header("accelerometer data, chest IMU", out, "timestamp ax ay az"),
              plan = header("planned camera poses", out, poses);
  ImuMerger imu_merger(out.setup.imu_rate_hz);
  for (recording::FilterInput input = out.filter_input(); auto o = out.next(input);) {
    for (const ImuReading& reading : imu_merger.merge(*o))
      if (const auto& a = reading.accelerometer)
        accelerations += fmt::format("{} {} {} {}\n", written_seconds(reading.t), a->x(), a->y(), a->z());
    if (o->plan) plan += files::tum_row(recording::kEpoch + o->t, o->plan->X_PC);
    if (o->image.empty()) continue;
    const std::string name = fmt::format("rgb/{}.png", written_seconds(o->t));
    out.write_png(name, o->image);
    images += fmt::format("{} {}\n", written_seconds(o->t), name);
  }
  out.write("rgb.txt", images);
  out.write("accelerometer.txt", accelerations);
  out.write("plan.txt", plan);
  out.write_truth("groundtruth.txt",
                  header("ground truth trajectory", out, poses) + tum_text(out.truth().camera));
  if (const auto rows = out.estimate(); !rows.empty())
    out.write("estimate.txt",
              header("estimated trajectory", out, poses) + tum_text({rows.begin(), rows.end()}));
  out.write("settings.yaml", orbslam3_settings(out, false));
  out.write_readme(kTumReadme);
}

void export_mcap(const ExportContext& out) {
  write_ros_bag(out, {"", "/camera/image/compressed", "/camera/camera_info", "/imu", true, true});
  out.write_readme(kMcapReadme);
}

void export_openvins(const ExportContext& out) {
  write_mav0(out);
  write_ros_bag(out, {"bag/", "/cam0/image_raw", "/cam0/camera_info", "/imu0", false});
  out.write("estimator_config.yaml",
            kEstimator + fmt::format("track_frequency: {:.1f}\n", std::ceil(out.setup.camera_rate_hz) + 1));
  out.write("kalibr_imu_chain.yaml", imu_chain(out));
  out.write("kalibr_imucam_chain.yaml", camera_chain(out));
  out.write_truth(
      "groundtruth.csv",
      recording::Manifest(out.run.result / "recording").read(recording::recording_format::kMotionRows));
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme(kOpenvinsReadme);
}

}  // namespace sim::exports
