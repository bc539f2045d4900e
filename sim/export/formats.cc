// The TUM RGB-D layout, OpenVINS, and bags for viewers.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numeric>

#include "sim/export/export_context.h"
#include "sim/recording/image_file.h"

namespace sim::exports {
namespace {

constexpr const char* kTumReadme =
    R"(Layout of the TUM RGB-D benchmark (Sturm et al. 2012): `rgb/`, `rgb.txt`, `accelerometer.txt`, and true
camera poses in `groundtruth.txt`; `plan.txt` has the camera poses of the walking plan, `estimate.txt` (if a filter
ran) those of GaitSLAM's filter. The images of `rgb/` are those of the rig's first color camera, else of the gray head camera;
all poses are those of this camera, at the stamps of the head camera. `settings.yaml` is for ORB-SLAM3 (v1.0). In the folder of ORB-SLAM3:

    ./Examples/Monocular/mono_tum Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER
    evo_ape tum FOLDER/groundtruth.txt KeyFrameTrajectory.txt --align --correct_scale
)";

constexpr const char* kTumDepthReadme = R"(
`depth/` has 16-bit depth along the optical axis for each pixel of `rgb/`; 0 is no depth. One unit is 1 mm: divide by 1000.
TUM's own files have 5000 units per m, so that 16 bits end at 13.1 m. `associations.txt` pairs the images that are nearest in time.

    ./Examples/RGB-D/rgbd_tum Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER FOLDER/associations.txt
    evo_ape tum FOLDER/groundtruth.txt CameraTrajectory.txt --align
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
| /rig/NAME/image/compressed, /rig/NAME/camera_info | as above | a further gray or color camera of the rig; `P[3]` is -fx times the baseline for a camera that looks parallel from the right of the head camera |
| /rig/NAME/image_raw, /rig/NAME/camera_info | sensor_msgs/Image | a depth camera: `16UC1`, mm, 0 is no depth; frame and calibration of the camera that it is aligned with |
| /rig/NAME/points | sensor_msgs/PointCloud2 | a sweep of a lidar, stamped at its start, in its frame at the time of each point: x, y, z, intensity (0 to 1) and t (uint32, ns since the stamp), as Ouster's driver; for FAST-LIO: `lidar_type: 3`, `timestamp_unit: 3`, no feature extraction |
| /rig/NAME/imu | sensor_msgs/Imu | a further IMU |
| /ground_truth/pose | geometry_msgs/PoseStamped | true camera pose in the world |
| /plan/pose | geometry_msgs/PoseStamped | planned camera pose |
| /slam/pose | geometry_msgs/PoseWithCovarianceStamped | estimated camera pose, if there was an estimate |
| /tf | tf2_msgs/TFMessage | at each frame, in `world`: `plan_camera`, `slam_camera`; the robot's links in `waist` |
| /tf_static | tf2_msgs/TFMessage | as calibrated, in `cam0_optical_frame` of the head camera (x right, y down, z forward): `imu`; `NAME_optical_frame` of each further camera; `NAME_frame` of lidars and IMUs (x forward, y left, z up); transient_local |
| /ground_truth/tf | tf2_msgs/TFMessage | at each frame, in `world`: the true `ground_truth/camera`, `ground_truth/waist`, `ground_truth/left_foot` and `ground_truth/right_foot` |
| /ground_truth/tf_static | tf2_msgs/TFMessage | `cam0_optical_frame` and `waist` in these, for viewers; `ros2 bag play` leaves them out of /tf, so that a SLAM node can publish map, odom and base_link |
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

With a second gray eye in the rig, OpenVINS uses both (`use_stereo: true`); the bag has `/cam1/image_raw` and, of
further IMUs, `/imu1` and on.

Without ROS, `mav0` has the same images and readings in EuRoC's layout.

`groundtruth.csv` is the true motion of the IMU in EuRoC's columns (for `path_gt`), `groundtruth.tum` that of
the camera. OpenVINS writes poses of the IMU. To compare:

    gaitslam score FOLDER/groundtruth.csv ov_estimate.txt --align yaw

Four lines of `estimator_config.yaml` differ from those of OpenVINS' own examples, because the walk begins at rest and shakes:
`init_dyn_use: true`, `init_window_time: 2.0`, `init_imu_thresh: 5.0`, `init_max_disparity: 3.0`. For results that repeat, one thread is
used and no solver stops by the clock (`init_dyn_mle_max_time`); `track_frequency` is above the rate of the camera, so that no
image is left out.
)";

std::string rows_text(const Eigen::Isometry3d& X) { return matrix_text(X, "    - [", "]", "\n"); }

// T_imu_cam maps from the camera to the IMU, T_cn_cnm1 from the previous camera. timeshift_cam_imu: stamps of
// the IMU minus those of the camera, whose clock may be ahead of the head camera's.
std::string camera_chain(const ExportContext& out) {
  const std::vector<int> eyes = out.all(rig::Kind::grey);
  std::string text = "%YAML:1.0\n\n";
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const rig::RigSensor& eye = out.sensor(eyes[i]);
    const slam::CameraIntrinsics& camera = eye.camera;
    const auto lens = equidistant_lens(camera);
    const auto k = lens.value_or(std::array<double, 4>{});
    std::vector<std::size_t> others(eyes.size());
    std::iota(others.begin(), others.end(), 0u);
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    text += fmt::format("cam{}:\n  T_imu_cam:\n{}\n", i, rows_text(out.X_GS(eyes[i])));
    if (i > 0)
      text += fmt::format("  T_cn_cnm1:\n{}\n", rows_text(eye.X_CS.inverse() * out.sensor(eyes[i - 1]).X_CS));
    text += fmt::format(
        "  cam_overlaps: [{}]\n  camera_model: pinhole\n  "
        "distortion_coeffs: [{}, {}, {}, {}]\n"
        "  distortion_model: {}\n  intrinsics: [{}, {}, {}, {}]\n  resolution: [{}, {}]\n"
        "  rostopic: /cam{}/image_raw\n  timeshift_cam_imu: {}\n",
        fmt::join(others, ", "), real(k[0]), real(k[1]), real(k[2]), real(k[3]),
        lens ? "equidistant" : "radtan", real(camera.fu_px), real(camera.fv_px), real(camera.u0_px),
        real(camera.v0_px), camera.width_px, camera.height_px, i,
        real(out.run.errors.motion_time_offset_s - eye.time_offset_s));
  }
  return text;
}

std::string square(const char* key, double diagonal) {
  const std::string d = real(diagonal);
  return fmt::format("  {0}:\n    - [{1}, 0.0, 0.0]\n    - [0.0, {1}, 0.0]\n    - [0.0, 0.0, {1}]\n", key, d);
}

// T_i_b maps from the chest IMU to this one.
std::string imu_chain(const ExportContext& out) {
  std::string text = "%YAML:1.0\n\n";
  for (int number = 0; const int i : out.all(rig::Kind::imu)) {
    const recording::ImuNoise noise = noise_of(out.sensor(i));
    text += fmt::format(
                "imu{0}:\n  T_i_b:\n{1}\n  accelerometer_noise_density: {2}\n"
                "  accelerometer_random_walk: {3}\n  gyroscope_noise_density: {4}\n"
                "  gyroscope_random_walk: {5}\n  rostopic: /imu{0}\n  update_rate: {6}\n",
                number++, rows_text(out.X_GS(i).inverse()), real(noise.accelerometer_density),
                real(noise.accelerometer_walk), real(noise.gyro_density), real(noise.gyro_walk),
                real(out.sensor(i).rate_hz)) +
            "  time_offset: 0.0\n  model: \"kalibr\"\n" + square("Tw", 1) + square("R_IMUtoGYRO", 1) +
            square("Ta", 1) + square("R_IMUtoACC", 1) + square("Tg", 0);
  }
  return text;
}

const std::string kEstimator = R"(%YAML:1.0

verbosity: "INFO"
use_fej: true
integration: "rk4"
use_imuavg: true
use_rk4int: true
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

// The first color camera, else the head camera; the depth camera aligned with it, else the first one.
struct RgbdCameras {
  explicit RgbdCameras(const ExportContext& out) : rgb(out.head()) {
    if (const auto colors = out.all(rig::Kind::color); !colors.empty()) rgb = colors.front();
    for (const int one : out.all(rig::Kind::depth))
      if (!depth || out.sensor(one).aligned_with == out.sensor(rgb).name) depth = one;
  }

  /// The depth image as that of the camera of rgb/.
  cv::Mat aligned(const ExportContext& out, const cv::Mat& image) const {
    const rig::RigSensor &from = out.sensor(*depth), &to = out.sensor(rgb);
    return from.aligned_with == to.name
               ? image
               : registered(image, from.camera, to.camera, to.X_CS.inverse() * from.X_CS);
  }

  int rgb;
  std::optional<int> depth;
};

// Pairs each image with the depth image nearest in time, at most half a period apart; none is used twice.
std::string associations(const std::vector<slam::Stamp>& images, const std::vector<slam::Stamp>& depths,
                         double depth_rate_hz) {
  const double most_s = 0.5 / depth_rate_hz;
  const auto apart = [](slam::Stamp a, slam::Stamp b) { return std::abs(slam::seconds(a - b)); };
  std::string text;
  auto depth = depths.begin();
  for (auto image = images.begin(); image != images.end() && depth != depths.end(); ++image) {
    while (depth + 1 != depths.end() && apart(*image, depth[1]) <= apart(*image, *depth)) ++depth;
    const bool next_is_nearer = image + 1 != images.end() && apart(image[1], *depth) < apart(*image, *depth);
    if (next_is_nearer || apart(*image, *depth) > most_s) continue;
    text +=
        fmt::format("{0} rgb/{0}.png {1} depth/{1}.png\n", written_seconds(*image), written_seconds(*depth));
    ++depth;
  }
  return text;
}

}  // namespace

void export_tum(const ExportContext& out) {
  const RgbdCameras cameras(out);
  const Eigen::Isometry3d& X_CS = out.sensor(cameras.rgb).X_CS;
  const char* poses = "timestamp tx ty tz qx qy qz qw";
  std::string images = header("color images", out, "timestamp filename"),
              depths = header("depth maps, 1000 per m", out, "timestamp filename"),
              accelerations = header("accelerometer data, chest IMU", out, "timestamp ax ay az"),
              plan = header("planned camera poses", out, poses);
  std::vector<slam::Stamp> with_image, with_depth;
  const auto add = [&](const char* folder, slam::Stamp t, const cv::Mat& image, std::string& list,
                       std::vector<slam::Stamp>& stamps) {
    const std::string name = fmt::format("{}/{}.png", folder, written_seconds(t));
    list += fmt::format("{} {}\n", written_seconds(t), name);
    stamps.push_back(t);
    out.write(name, recording::encode_png(image));
  };
  for (Frames frames(out); const auto frame = frames.next();) {
    if (frame->plan) plan += files::tum_row(recording::kEpoch + frame->t, frame->plan->X_PC * X_CS);
    for (const ExportedReading& reading : frame->readings)
      if (const auto& a = reading.accelerometer; reading.sensor == out.chest() && reading.has_acceleration)
        accelerations += fmt::format("{} {} {} {}\n", written_seconds(reading.t), a.x(), a.y(), a.z());
      else if (reading.sensor == cameras.rgb)
        add("rgb", reading.t, reading.image, images, with_image);
      else if (reading.sensor == cameras.depth)
        add("depth", reading.t, cameras.aligned(out, reading.image), depths, with_depth);
  }
  out.write("rgb.txt", images);
  if (cameras.depth) {
    out.write("depth.txt", depths);
    out.write("associations.txt", associations(with_image, with_depth, out.sensor(*cameras.depth).rate_hz));
  }
  out.write("accelerometer.txt", accelerations);
  out.write("plan.txt", plan);
  const auto of_camera = [&](std::vector<files::TimedPose> all) {
    for (files::TimedPose& pose : all) pose.X = pose.X * X_CS;
    return tum_text(all);
  };
  out.write_truth("groundtruth.txt",
                  header("ground truth trajectory", out, poses) + of_camera(out.truth().camera));
  if (const auto rows = out.estimate(); !rows.empty())
    out.write("estimate.txt",
              header("estimated trajectory", out, poses) + of_camera({rows.begin(), rows.end()}));
  out.write("settings.yaml", orbslam3_settings(out, cameras.rgb, cameras.depth, false));
  out.write_readme(std::string(kTumReadme) + (cameras.depth ? kTumDepthReadme : ""));
}

void export_mcap(const ExportContext& out) {
  write_ros_bag(out, "", true);
  out.write_readme(kMcapReadme);
}

void export_openvins(const ExportContext& out) {
  write_mav0(out);
  write_ros_bag(out, "bag/", false);
  const bool stereo = out.all(rig::Kind::grey).size() > 1;
  out.write("estimator_config.yaml",
            kEstimator + fmt::format("use_stereo: {}\nmax_cameras: {}\ntrack_frequency: {:.1f}\n", stereo,
                                     stereo ? 2 : 1, std::ceil(out.setup.camera_rate_hz) + 1));
  out.write("kalibr_imu_chain.yaml", imu_chain(out));
  out.write("kalibr_imucam_chain.yaml", camera_chain(out));
  if (out.run.with_truth) out.write("groundtruth.csv", out.motion());
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme(kOpenvinsReadme);
}

}  // namespace sim::exports
