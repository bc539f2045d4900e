#include "sim/export/export_context.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/files/text.h"
#include "sim/recording/image_file.h"
#include "slam/camera.h"
#include "slam/observation.h"

namespace sim::exports {
namespace {

namespace fs = std::filesystem;

struct Format {
  const char* name;
  void (*write)(const ExportContext&);
  bool knows_lenses = true;  ///< else the images are always undistorted
  int passes = 1;            ///< how often the recording is read
};

constexpr Format kFormats[]{{"euroc", export_euroc},
                            {"tum", export_tum, false},
                            {"mcap", export_mcap},
                            {"orbslam3", export_orbslam3},
                            {"openvins", export_openvins, true, 2}};

constexpr double kLeastGyroWalk = 1e-6;  // rad/s²/√Hz, m/s³/√Hz: programs divide by these
constexpr double kLeastAccelerometerWalk = 1e-5;

// A mean of white noise over dt has the standard deviation density/√dt.
recording::ImuNoise noise_of(const sensor_errors::ErrorOptions& errors) {
  const sensor_errors::ErrorOptions::Gyro& gyro = errors.gyro;
  const sensor_errors::ErrorOptions::Accelerometer& accelerometer = errors.accelerometer;
  return {std::max(kLeastGyroWalk, gyro.sigma_rad_s * std::sqrt(slam::kReadingPeriod_s)),
          std::max(kLeastGyroWalk, gyro.bias_walk_sigma_rad_s2),
          std::max(kLeastAccelerometerWalk, accelerometer.sigma_m_s2 * std::sqrt(slam::kReadingPeriod_s)),
          std::max(kLeastAccelerometerWalk, accelerometer.bias_walk_sigma_m_s3)};
}

// Returns whether every pixel of the pinhole lies inside the recorded image.
bool inside_recorded(const slam::Camera& recorded, const slam::CameraIntrinsics& pinhole) {
  const auto is_inside = [&](int column, int row) {
    const auto at = recorded.project(
        {(column - pinhole.u0_px) / pinhole.fu_px, (row - pinhole.v0_px) / pinhole.fv_px, 1});
    return at && recorded.inside(at->pixel, 0);
  };
  const int right = pinhole.width_px - 1, bottom = pinhole.height_px - 1;
  for (int column = 0; column <= right; ++column)
    if (!is_inside(column, 0) || !is_inside(column, bottom)) return false;
  for (int row = 0; row <= bottom; ++row)
    if (!is_inside(0, row) || !is_inside(right, row)) return false;
  return true;
}

// Writes a pixel of 8 bits a channel; `at` lies inside the image.
void bilinear(const cv::Mat& image, const Eigen::Vector2d& at, unsigned char* pixel) {
  const int left = std::min(static_cast<int>(at.x()), image.cols - 2),
            top = std::min(static_cast<int>(at.y()), image.rows - 2), n = image.channels();
  const double a = at.x() - left, b = at.y() - top;
  const unsigned char *upper = image.ptr(top, left), *lower = image.ptr(top + 1, left);
  for (int i = 0; i < n; ++i)
    pixel[i] = static_cast<unsigned char>(std::lround((1 - b) * ((1 - a) * upper[i] + a * upper[n + i]) +
                                                      b * ((1 - a) * lower[i] + a * lower[n + i])));
}

bool is_pinhole(const slam::CameraIntrinsics& camera) {
  const auto* lens = std::get_if<slam::OneParameterRadial>(&camera.lens);
  return lens && lens->k1_px2 == 0;
}

}  // namespace

std::vector<std::string> export_formats() {
  std::vector<std::string> names;
  for (const Format& format : kFormats) names.push_back(format.name);
  return names;
}

void export_run(const ExportedRun& run, const std::string& format, const std::filesystem::path& folder,
                files::Existing existing) {
  const auto found = std::ranges::find_if(kFormats, [&](const Format& f) { return f.name == format; });
  if (found == std::end(kFormats)) throw std::out_of_range("no export format " + format);
  files::AtomicFolder durable(folder, existing);
  found->write(ExportContext(run, durable.path(), run.undistort || !found->knows_lenses, found->passes));
  durable.commit();
}

ExportContext::ExportContext(const ExportedRun& run_, const fs::path& folder_, bool undistort, int passes)
    : run(run_),
      folder(folder_),
      setup(recording::RecordingReader(run.result / "recording").setup()),
      noise(exports::noise_of(run.errors)),
      undistort_(undistort),
      passes_(passes) {
  const auto add = [this](int sensor, slam::CameraIntrinsics& camera) {
    cameras_.emplace_back(sensor, ExportedCamera(camera, undistort_));
    camera = cameras_.back().second.fitted.camera;
  };
  add(kHead, setup.calibration.camera);
  for (std::size_t i = 0; i < setup.rig.size(); ++i)
    if (rig::is_camera(setup.rig[i])) add(static_cast<int>(i), setup.rig[i].camera);
}

std::vector<int> ExportContext::further(rig::Kind kind) const {
  std::vector<int> found;
  for (std::size_t i = 0; i < setup.rig.size(); ++i)
    if (setup.rig[i].kind == kind) found.push_back(static_cast<int>(i));
  return found;
}

cv::Mat ExportContext::exported(const cv::Mat& image, int sensor) const {
  const auto found = std::ranges::find(cameras_, sensor, &std::pair<int, ExportedCamera>::first);
  if (found == cameras_.end()) throw std::out_of_range("an image of a sensor that is not a camera");
  const auto& undistortion = found->second.undistortion;
  return undistortion ? (*undistortion)(image) : image;
}

recording::ImuNoise ExportContext::noise_of(const rig::RigSensor& imu) {
  const double root_period = 1 / std::sqrt(imu.rate_hz);
  return {std::max(kLeastGyroWalk, imu.gyro_sigma_rad_s * root_period),
          std::max(kLeastGyroWalk, imu.gyro_bias_walk_rad_s2),
          std::max(kLeastAccelerometerWalk, imu.accelerometer_sigma_m_s2 * root_period),
          std::max(kLeastAccelerometerWalk, imu.accelerometer_bias_walk_m_s3)};
}

std::vector<files::TumRow> ExportContext::estimate() const {
  const fs::path file = run.result / "estimate_cov.txt";
  return run.with_truth && fs::exists(file) ? files::read_tum(file) : std::vector<files::TumRow>{};
}

fs::path ExportContext::new_file(const std::string& name) const {
  const fs::path file = folder / name;
  fs::create_directories(file.parent_path());
  return file;
}

void ExportContext::write(const std::string& name, std::string_view bytes) const {
  files::write_text(new_file(name), bytes);
}

void ExportContext::write_png(const std::string& name, const cv::Mat& image, int sensor) const {
  write(name, recording::encode_png(exported(image, sensor)));
}

std::string ExportContext::lens_text() const {
  const rig::FittedCamera& fitted = cameras_.front().second.fitted;
  std::string others;
  for (const auto& [sensor_index, camera] : cameras_)
    if (sensor_index != kHead && !undistort_ && camera.fitted.largest_px > 1e-6)
      others += fmt::format("The fit of `{}`: {:.4f} px root mean square, at most {:.4f} px.\n",
                            sensor(sensor_index).name, camera.fitted.rms_px, camera.fitted.largest_px);
  if (undistort_)
    return fmt::format(
        R"(The lens distortion is removed from the images by bilinear interpolation. They are those of an ideal pinhole
camera with f = {} px and its principal point at ({}, {}); each of their pixels lies inside the recorded image.
)",
        camera().fu_px, camera().u0_px, camera().v0_px);
  if (!equidistant_lens(camera())) return "The head camera has no lens distortion.\n" + others;
  return fmt::format(
             R"(The camera's own lens model has one radial parameter, which few programs know. It is stated here as the
equidistant model of Kannala and Brandt (2006), fitted over the whole image: {:.4f} px root mean square, at most
{:.4f} px. The images are as the camera gave them. `gaitslam export ... --undistort` removes the lens distortion
from the images instead: they are then exactly those of a pinhole camera.
)",
             fitted.rms_px, fitted.largest_px) +
         others;
}

void ExportContext::write_readme(const std::string& text) const {
  constexpr const char* kReadme = R"(# {}, seed {}

A walk simulated by GaitSLAM: the input of its filter, sensor noise included.

{}
## Conventions

Times begin at {} s. An IMU reading is the mean over 1/{} s, stamped in the middle of that interval. Its noise is
stated as a density: gyro {:.3g} rad/s/sqrt(Hz), accelerometer {:.3g} m/s^2/sqrt(Hz), which is the standard
deviation of a 5 ms reading times the square root of 5 ms. The random walks of the biases are {} rad/s^2/sqrt(Hz)
and {} m/s^3/sqrt(Hz); where the biases are constant, these are {} and {}, because programs divide by them.
Camera axes: x right, y down, z forward. World: z up, origin under the start. The body frame is the chest IMU.
The stamps of the IMU are {} s later than those of the camera.
{}
{})";
  std::string offsets;
  for (const rig::RigSensor& sensor : setup.rig)
    if (sensor.time_offset_s != 0)
      offsets += fmt::format("The stamps of `{}` are {} s ahead of those of the head camera.\n", sensor.name,
                             sensor.time_offset_s);
  write("README.md",
        fmt::format(kReadme, run.name, run.seed, text, recording::kEpoch.count() / 1'000'000'000,
                    setup.imu_rate_hz, noise.gyro_density, noise.accelerometer_density, noise.gyro_walk,
                    noise.accelerometer_walk, kLeastGyroWalk, kLeastAccelerometerWalk,
                    run.errors.motion.time_offset_s, offsets, lens_text()));
}

std::string written_seconds(slam::Stamp t) {
  return fmt::format("{}.{:09}", recording::file_stamp(t) / 1'000'000'000,
                     recording::file_stamp(t) % 1'000'000'000);
}

std::string real(double x) {
  const std::string text = fmt::format("{}", x);
  return text.find_first_of(".e") == text.npos ? text + ".0" : text;
}

std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                        std::string_view between) {
  std::string text;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{}{}, {}, {}, {}{}", row ? between : "", before, real(X(row, 0)), real(X(row, 1)),
                        real(X(row, 2)), real(X(row, 3)), after);
  return text;
}

std::string tum_text(const std::vector<files::TimedPose>& poses) {
  std::string text;
  for (const files::TimedPose& pose : poses) text += files::tum_row(recording::kEpoch + pose.t, pose.X);
  return text;
}

std::optional<std::array<double, 4>> equidistant_lens(const slam::CameraIntrinsics& camera) {
  const auto* k = std::get_if<slam::Equidistant>(&camera.lens);
  return k ? std::optional(std::array{k->k1, k->k2, k->k3, k->k4}) : std::nullopt;
}

Undistortion::Undistortion(const slam::CameraIntrinsics& camera) : pinhole_(camera) {
  const slam::Camera recorded(camera);
  pinhole_.lens = slam::RadialTangential{};
  for (pinhole_.fu_px = pinhole_.fv_px = 1; !inside_recorded(recorded, pinhole_);
       pinhole_.fv_px = ++pinhole_.fu_px)
    if (pinhole_.fu_px > 1e5) throw std::logic_error("no pinhole looks through this lens");
  const slam::Camera straight(pinhole_);
  for (int row = 0; row < camera.height_px; ++row)
    for (int column = 0; column < camera.width_px; ++column)
      from_.push_back(recorded.project(straight.unproject({column, row})->h)->pixel);
}

cv::Mat Undistortion::operator()(const cv::Mat& image) const {
  cv::Mat straight(image.rows, image.cols, image.type());
  auto from = from_.begin();
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column, ++from)
      if (image.depth() == CV_16U)
        straight.at<std::uint16_t>(row, column) = image.at<std::uint16_t>(
            static_cast<int>(std::lround(from->y())), static_cast<int>(std::lround(from->x())));
      else
        bilinear(image, *from, straight.ptr(row, column));
  return straight;
}

ExportedCamera::ExportedCamera(const slam::CameraIntrinsics& recorded, bool undistort) : fitted{recorded} {
  if (is_pinhole(recorded)) {
    fitted.camera.lens = slam::RadialTangential{};
  } else if (undistort) {
    undistortion.emplace(recorded);
    fitted.camera = undistortion->pinhole();
  } else {
    fitted = rig::fit_equidistant(recorded);
  }
}

cv::Mat registered(const cv::Mat& depth, const slam::CameraIntrinsics& from, const slam::CameraIntrinsics& to,
                   const Eigen::Isometry3d& X_to_from) {
  cv::Mat nearest = cv::Mat::zeros(to.height_px, to.width_px, CV_16UC1);
  for (int row = 0; row < depth.rows; ++row)
    for (int column = 0; column < depth.cols; ++column) {
      const double z = depth.at<std::uint16_t>(row, column);
      if (z == 0) continue;
      const auto seen = [&](double u, double v) -> Eigen::Vector3d {  // pixel and depth, mm
        Eigen::Vector3d p(z * (u - from.u0_px) / from.fu_px, z * (v - from.v0_px) / from.fv_px, z);
        p = X_to_from.linear() * p + 1e3 * X_to_from.translation();
        return {to.u0_px + to.fu_px * p.x() / p.z(), to.v0_px + to.fv_px * p.y() / p.z(), p.z()};
      };
      const Eigen::Vector3d center = seen(column, row), first = seen(column - 0.5, row - 0.5),
                            last = seen(column + 0.5, row + 0.5);
      if (center.z() < 1 || center.z() > 65535 || first.z() <= 0 || last.z() <= 0) continue;
      const auto mm = static_cast<std::uint16_t>(std::lround(center.z()));
      const int bottom = static_cast<int>(std::min<double>(to.height_px, std::ceil(last.y()))),
                right = static_cast<int>(std::min<double>(to.width_px, std::ceil(last.x())));
      for (int v = static_cast<int>(std::max(0.0, std::ceil(first.y()))); v < bottom; ++v)
        for (int u = static_cast<int>(std::max(0.0, std::ceil(first.x()))); u < right; ++u) {
          auto& pixel = nearest.at<std::uint16_t>(v, u);
          if (pixel == 0 || mm < pixel) pixel = mm;
        }
    }
  return nearest;
}

}  // namespace sim::exports
