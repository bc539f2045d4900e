// The formats: EuRoC/ASL, ORB-SLAM3, TUM RGB-D, OpenVINS, and bags for viewers.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "sim/export/export_context.h"
#include "sim/files/hash.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {
namespace {

using namespace recording::recording_format;

constexpr double kLeastGyroWalk = 1e-6;  // rad/s²/√Hz, m/s³/√Hz: programs divide by these
constexpr double kLeastAccelerometerWalk = 1e-5;

/// The noise of an IMU as densities; no number is 0, because programs divide by them.
// A mean of white noise over dt has the standard deviation density/√dt.
recording::ImuNoise noise_of(const rig::RigSensor& imu) {
  const double root_period = std::sqrt(1 / imu.rate_hz);
  return {std::max(kLeastGyroWalk, imu.gyro_sigma_rad_s * root_period),
          std::max(kLeastGyroWalk, imu.gyro_bias_walk_rad_s2),
          std::max(kLeastAccelerometerWalk, imu.accelerometer_sigma_m_s2 * root_period),
          std::max(kLeastAccelerometerWalk, imu.accelerometer_bias_walk_m_s3)};
}

/// "1000000000.033000000"
std::string written_seconds(slam::Stamp t) {
  return fmt::format("{}.{:09}", recording::file_stamp(t) / 1'000'000'000,
                     recording::file_stamp(t) % 1'000'000'000);
}

/// The fewest digits that round-trip, with a decimal point: some readers reject the integer 1.
std::string real(double x) {
  const std::string text = fmt::format("{}", x);
  return text.find_first_of(".e") == text.npos ? text + ".0" : text;
}

/// Four rows of four numbers, each row between `before` and `after`, `between` them: "[1.0, 0.0, ...]\n[...".
std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                        std::string_view between) {
  std::string text;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{}{}, {}, {}, {}{}", row ? between : "", before, real(X(row, 0)), real(X(row, 1)),
                        real(X(row, 2)), real(X(row, 3)), after);
  return text;
}

/// "t tx ty tz qx qy qz qw" with the stamps of the exports.
std::string tum_text(const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(recording::kEpoch + pose.t, pose.X);
  return text;
}

/// The coefficients of an exported camera's equidistant lens; nothing for a pinhole without distortion.
std::optional<std::array<double, 4>> equidistant_lens(const slam::CameraIntrinsics& camera) {
  const auto* k = std::get_if<slam::Equidistant>(&camera.lens);
  return k ? std::optional(std::array{k->k1, k->k2, k->k3, k->k4}) : std::nullopt;
}

files::HashedFile rows(const ExportContext& out, const std::string& name, const std::string& header) {
  files::HashedFile file(out.new_file(name));
  if (!header.empty()) file.write(header + "\n");
  return file;
}

std::string folder_of(const char* kind, std::size_t number) {
  return fmt::format("mav0/{}{}/", kind, number);
}

/// Images of a camera and their stamps. Some programs read beyond their arrays if an image lacks readings on
/// either side: images_within_imu skips such images.
class ImageWriter {
 public:
  ImageWriter(const ExportContext& out, bool images_within_imu, const std::string& folder)
      : out_(out),
        within_(images_within_imu),
        folder_(folder),
        camera_(rows(out, folder + "data.csv", kCameraHeader)) {}

  void add(const ExportedReading& image) {
    if (within_ && (!first_reading_ || image.t <= *first_reading_)) return;
    waiting_.push_back({image.t, image.image});
    if (!within_) write_until(image.t);
  }
  void note_reading(slam::Stamp t) {
    if (!first_reading_) first_reading_ = t;
    if (within_) write_until(t - slam::Stamp(1));
  }
  /// Returns the stamps of the images.
  std::vector<std::int64_t> close() {
    camera_.close();
    return std::move(times_);
  }

 private:
  void write_until(slam::Stamp t) {
    for (; !waiting_.empty() && waiting_.front().first <= t; waiting_.pop_front()) {
      const std::int64_t stamp = recording::file_stamp(waiting_.front().first);
      const std::string name = fmt::format("{}.png", stamp);
      out_.write(folder_ + "data/" + name, recording::encode_png(waiting_.front().second));
      camera_.write(fmt::format("{},{}\n", stamp, name));
      times_.push_back(stamp);
    }
  }

  const ExportContext& out_;
  bool within_;
  const std::string folder_;
  files::HashedFile camera_;
  std::vector<std::int64_t> times_;
  std::optional<slam::Stamp> first_reading_;
  std::deque<std::pair<slam::Stamp, cv::Mat>> waiting_;  // for a later reading
};

std::string lines(const std::vector<std::int64_t>& stamps) {
  return fmt::format("{}{}", fmt::join(stamps, "\n"), stamps.empty() ? "" : "\n");
}

// The keys of one camera: Camera1 or Camera2.
std::string intrinsics(const std::string& name, const slam::CameraIntrinsics& camera) {
  std::string text =
      fmt::format("{0}.fx: {1}\n{0}.fy: {2}\n{0}.cx: {3}\n{0}.cy: {4}\n", name, real(camera.fu_px),
                  real(camera.fv_px), real(camera.u0_px), real(camera.v0_px));
  const auto k = equidistant_lens(camera);
  for (std::size_t i = 0; k && i < k->size(); ++i)
    text += fmt::format("{}.k{}: {}\n", name, i + 1, real((*k)[i]));
  return text;
}

constexpr double kCloseBaselines = 40;  // nearer points count as close: as in ORB-SLAM3's own files

// Both images overlap over their whole width.
std::string stereo_section(const slam::CameraIntrinsics& left, const rig::RigSensor& right) {
  std::string overlaps;
  if (equidistant_lens(left))
    overlaps = fmt::format(
        "Camera1.overlappingBegin: 0\nCamera1.overlappingEnd: {}\n"
        "Camera2.overlappingBegin: 0\nCamera2.overlappingEnd: {}\n",
        left.width_px - 1, right.camera.width_px - 1);
  return fmt::format(fmt::runtime(text_of("orbslam3_right.yaml")), intrinsics("Camera2", right.camera),
                     overlaps, matrix_text(right.X_CS, "", "", ", "), real(kCloseBaselines));
}

std::string imu_section(const ExportContext& out) {
  const recording::ImuNoise noise = noise_of(out.sensor(out.chest()));
  return fmt::format(fmt::runtime(text_of("orbslam3_imu.yaml")),
                     matrix_text(out.X_GS(out.head()), "", "", ", "), real(noise.gyro_density),
                     real(noise.accelerometer_density), real(noise.gyro_walk), real(noise.accelerometer_walk),
                     real(out.setup.imu_rate_hz));
}

// Three lines before the first row: readers skip that many.
std::string header(const char* what, const ExportContext& out, const char* columns) {
  return fmt::format("# {}\n# file: {}, seed {}\n# {}\n", what, out.run.name, out.run.seed, columns);
}

std::string rows_text(const Eigen::Isometry3d& X) { return matrix_text(X, "    - [", "]", "\n"); }

// T_imu_cam maps from the camera to the IMU, T_cn_cnm1 from the previous camera. timeshift_cam_imu: stamps of
// the IMU minus those of the camera, whose clock may be ahead of the head camera's.
std::string camera_chain(const ExportContext& out) {
  const std::vector<int> eyes = out.all(rig::Kind::gray);
  std::string text = "%YAML:1.0\n\n";
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const rig::RigSensor& eye = out.sensor(eyes[i]);
    const slam::CameraIntrinsics& camera = eye.camera;
    const auto lens = equidistant_lens(camera);
    const auto k = lens.value_or(std::array<double, 4>{});
    std::vector<std::size_t> others(eyes.size());
    std::iota(others.begin(), others.end(), 0u);
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const std::string from_previous =
        i == 0
            ? ""
            : fmt::format("  T_cn_cnm1:\n{}\n", rows_text(eye.X_CS.inverse() * out.sensor(eyes[i - 1]).X_CS));
    text += fmt::format(fmt::runtime(text_of("openvins_camera.yaml")), i, rows_text(out.X_GS(eyes[i])),
                        from_previous, fmt::join(others, ", "), real(k[0]), real(k[1]), real(k[2]),
                        real(k[3]), lens ? "equidistant" : "radtan", real(camera.fu_px), real(camera.fv_px),
                        real(camera.u0_px), real(camera.v0_px), camera.width_px, camera.height_px,
                        real(out.run.errors.motion_time_offset_s - eye.time_offset_s));
  }
  return text;
}

// T_i_b maps from the chest IMU to this one.
std::string imu_chain(const ExportContext& out) {
  std::string text = "%YAML:1.0\n\n";
  for (int number = 0; const int i : out.all(rig::Kind::imu)) {
    const recording::ImuNoise noise = noise_of(out.sensor(i));
    text +=
        fmt::format(fmt::runtime(text_of("openvins_imu.yaml")), number++, rows_text(out.X_GS(i).inverse()),
                    real(noise.accelerometer_density), real(noise.accelerometer_walk),
                    real(noise.gyro_density), real(noise.gyro_walk), real(out.sensor(i).rate_hz));
  }
  return text;
}

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

/// Writes mav0/ in the EuRoC/ASL layout, times.txt, and for two gray eyes times_stereo.txt: the stamps that
/// both have. images_within_imu: without the images before the first reading and after the last one.
void write_mav0(const ExportContext& out, bool images_within_imu = false) {
  files::HashedFile plan = rows(out, sensor_rows("plan0"), "");
  bool plan_begun = false;
  const std::vector<int> eyes = out.all(rig::Kind::gray), imus = out.all(rig::Kind::imu);
  std::map<int, ImageWriter> images;  // by sensor
  for (std::size_t i = 0; i < eyes.size(); ++i)
    images.emplace(eyes[i], ImageWriter(out, images_within_imu, folder_of("cam", i)));
  std::map<int, files::HashedFile> readings;
  for (std::size_t i = 0; i < imus.size(); ++i)
    readings.emplace(imus[i], rows(out, folder_of("imu", i) + "data.csv", kImuHeader));
  for (Frames frames(out); const auto frame = frames.next();) {
    for (const ExportedReading& reading : frame->readings)
      if (const auto eye = images.find(reading.sensor); eye != images.end()) {
        eye->second.add(reading);
      } else if (const auto imu = readings.find(reading.sensor); imu != readings.end()) {
        if (!reading.has_acceleration) continue;
        imu->second.write(fmt::format("{},{},{}\n", recording::file_stamp(reading.t),
                                      files::csv_fields(reading.gyro),
                                      files::csv_fields(reading.accelerometer)));
        if (reading.sensor == out.chest())
          for (auto& [sensor, writer] : images) writer.note_reading(reading.t);
      }
    if (!frame->plan) continue;
    if (!std::exchange(plan_begun, true)) plan.write(recording::plan_header(*frame->plan) + "\n");
    plan.write(fmt::format("{},{}\n", recording::file_stamp(frame->t), recording::plan_fields(*frame->plan)));
  }
  if (!plan_begun) plan.write(kPlanHeader + "\n");
  plan.close();
  std::vector<std::vector<std::int64_t>> times;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const rig::RigSensor& eye = out.sensor(eyes[i]);
    times.push_back(images.at(eyes[i]).close());
    out.write(
        folder_of("cam", i) + "sensor.yaml",
        recording::camera_yaml({eye.camera, eye.X_CS.inverse() * out.setup.calibration.X_CG}, eye.rate_hz));
  }
  out.write("times.txt", lines(times[0]));
  if (std::vector<std::int64_t> both; times.size() > 1) {
    std::ranges::set_intersection(times[0], times[1], std::back_inserter(both));
    out.write("times_stereo.txt", lines(both));
  }
  for (std::size_t i = 0; i < imus.size(); ++i) {
    const rig::RigSensor& imu = out.sensor(imus[i]);
    readings.at(imus[i]).close();
    out.write(
        folder_of("imu", i) + "sensor.yaml",
        recording::imu_yaml(imu.name + "; +g up at rest", out.X_GS(imus[i]), imu.rate_hz, noise_of(imu)));
  }
  out.write(kBody, recording::body_yaml());
  out.write(sensor_file("plan0"), recording::plan_yaml(out.setup));
  out.write_truth(sensor_file(kMotion), recording::motion_yaml());
  if (out.run.with_truth) out.write(sensor_rows(kMotion), out.motion());
}

/// Settings of ORB-SLAM3 (v1.0) for images of a camera; of the head camera with IMU and, if there are two
/// gray cameras, stereo. depth: a depth camera aligned with it, for settings without IMU.
// OpenCV reads color images as BGR; gray ones have no order.
std::string orbslam3_settings(const ExportContext& out, int camera, std::optional<int> depth, bool inertial) {
  const slam::CameraIntrinsics& lens = out.sensor(camera).camera;
  std::string text = fmt::format(
      fmt::runtime(text_of("orbslam3_head.yaml")), equidistant_lens(lens) ? "KannalaBrandt8" : "PinHole",
      intrinsics("Camera1", lens), lens.width_px, lens.height_px, out.sensor(camera).rate_hz);
  if (depth)
    text += fmt::format("RGBD.DepthMapFactor: 1000.0\nStereo.ThDepth: {}\nStereo.b: {}\n\n",
                        real(kCloseBaselines), real(out.sensor(*depth).baseline_m));
  if (const auto eyes = out.all(rig::Kind::gray); inertial && eyes.size() > 1)
    text += stereo_section(lens, out.sensor(eyes[1]));
  return (text + (inertial ? imu_section(out) : "")).append(text_of("orbslam3_settings.yaml"));
}

}  // namespace

std::string ExportContext::lens_text() const {
  const rig::FittedCamera& fitted = cameras_.at(setup.rig.size())->fitted;
  if (undistort_)
    return fmt::format(fmt::runtime(text_of("lens_pinhole.md")), fitted.camera.fu_px, fitted.camera.u0_px,
                       fitted.camera.v0_px);
  std::string text = "The head camera has no lens distortion.\n";
  if (equidistant_lens(fitted.camera))
    text = fmt::format(fmt::runtime(text_of("lens_equidistant.md")), fitted.rms_px, fitted.largest_px);
  for (std::size_t i = 0; i < setup.rig.size(); ++i)
    if (cameras_[i] && cameras_[i]->fitted.largest_px > 1e-6)
      text += fmt::format("The fit of `{}`: {:.4f} px root mean square, at most {:.4f} px.\n",
                          sensors[i].name, cameras_[i]->fitted.rms_px, cameras_[i]->fitted.largest_px);
  return text;
}

void ExportContext::write_readme(std::initializer_list<std::string> names) const {
  std::string texts;
  for (const std::string& name : names) texts += name.empty() ? "" : text_of(name);
  const recording::ImuNoise noise = noise_of(sensor(chest()));
  std::string offsets;
  for (const rig::RigSensor& sensor : setup.rig)
    if (sensor.time_offset_s != 0)
      offsets += fmt::format("The stamps of `{}` are {} s ahead of those of the head camera.\n", sensor.name,
                             sensor.time_offset_s);
  write("README.md",
        fmt::format(fmt::runtime(text_of("readme.md")), run.name, run.seed, texts,
                    recording::kEpoch.count() / 1'000'000'000, setup.imu_rate_hz, noise.gyro_density,
                    noise.accelerometer_density, noise.gyro_walk, noise.accelerometer_walk, kLeastGyroWalk,
                    kLeastAccelerometerWalk, run.errors.motion_time_offset_s, offsets, lens_text()));
}

void export_euroc(const ExportContext& out) {
  write_mav0(out);
  out.write_readme({"euroc.md"});
}

void export_orbslam3(const ExportContext& out) {
  write_mav0(out, true);
  out.write("settings.yaml", orbslam3_settings(out, out.head(), std::nullopt, true));
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme({"orbslam3.md", out.all(rig::Kind::gray).size() > 1 ? "orbslam3_stereo.md" : "",
                    out.all(rig::Kind::depth).empty() ? "" : "orbslam3_depth.md"});
}

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
  out.write_readme({"tum.md", cameras.depth ? "tum_depth.md" : ""});
}

void export_mcap(const ExportContext& out) {
  write_ros_bag(out, "", true);
  out.write_readme({"mcap.md"});
}

void export_openvins(const ExportContext& out) {
  write_mav0(out);
  write_ros_bag(out, "bag/", false);
  const bool stereo = out.all(rig::Kind::gray).size() > 1;
  out.write("estimator_config.yaml",
            text_of("openvins_estimator.yaml") +
                fmt::format("use_stereo: {}\nmax_cameras: {}\ntrack_frequency: {:.1f}\n", stereo,
                            stereo ? 2 : 1, std::ceil(out.setup.camera_rate_hz) + 1));
  out.write("kalibr_imu_chain.yaml", imu_chain(out));
  out.write("kalibr_imucam_chain.yaml", camera_chain(out));
  if (out.run.with_truth) out.write("groundtruth.csv", out.motion());
  out.write_truth("groundtruth.tum", tum_text(out.truth().camera));
  out.write_readme({"openvins.md"});
}

}  // namespace sim::exports
