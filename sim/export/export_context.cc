#include "sim/export/export_context.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/files/text.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"
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
      sensors(setup.rig),
      undistort_(undistort),
      passes_(passes) {
  sensors.push_back(recording::head_camera(setup));
  rig::RigSensor& imu = sensors.emplace_back();
  imu.name = "imu0", imu.kind = rig::Kind::imu;
  imu.rate_hz = setup.imu_rate_hz, imu.X_CS = setup.calibration.X_CG;
  imu.gyro_sigma_rad_s = run.errors.gyro.sigma;
  imu.gyro_bias_walk_rad_s2 = run.errors.gyro.bias_walk_sigma;
  imu.accelerometer_sigma_m_s2 = run.errors.accelerometer.sigma;
  imu.accelerometer_bias_walk_m_s3 = run.errors.accelerometer.bias_walk_sigma;
  for (rig::RigSensor& one : sensors) {
    cameras_.emplace_back();
    if (rig::is_camera(one)) one.camera = cameras_.back().emplace(one.camera, undistort_).fitted.camera;
  }
}

std::vector<int> ExportContext::all(rig::Kind kind) const {
  std::vector<int> found;
  for (int i = 0; i <= chest(); ++i)
    if (sensor(i).kind == kind) found.insert(i < head() ? found.end() : found.begin(), i);
  return found;
}

Eigen::Isometry3d ExportContext::X_GS(int index) const {
  return index == chest() ? Eigen::Isometry3d::Identity()
                          : setup.calibration.X_CG.inverse() * sensor(index).X_CS;
}

std::string ExportContext::motion() const {
  using namespace recording::recording_format;
  return recording::Manifest(run.result / "recording").read(sensor_rows(kMotion));
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

std::optional<ExportedFrame> Frames::next() {
  out_.run.progress((out_.passed_ + input_.part()) / out_.passes_);
  std::optional<slam::Observation> observation = input_.next_in_order();
  if (!observation) {
    ++out_.passed_;
    return std::nullopt;
  }
  ExportedFrame frame{observation->t, std::move(observation->plan), {}};
  for (ExportedReading& reading : imu_.merge(*observation)) {
    reading.sensor = out_.chest();
    frame.readings.push_back(std::move(reading));
  }
  slam::RigReading head;
  head.sensor = out_.head(), head.t = observation->t, head.image = std::move(observation->image);
  observation->rig.insert(observation->rig.begin(), std::move(head));
  for (slam::RigReading& reading : observation->rig) {
    const auto index = static_cast<std::size_t>(reading.sensor);
    if (out_.sensor(reading.sensor).kind == rig::Kind::imu)
      reading.t = reading.begin + (reading.t - reading.begin) / 2;
    else if (rig::is_camera(out_.sensors[index]) && reading.image.empty())
      continue;
    if (const auto& camera = out_.cameras_[index]; camera && camera->undistortion)
      reading.image = (*camera->undistortion)(reading.image);
    frame.readings.push_back({std::move(reading)});
  }
  return frame;
}

Undistortion::Undistortion(const slam::CameraIntrinsics& camera) : pinhole_(camera) {
  const slam::Camera recorded(camera);
  const int pixels = camera.width_px * camera.height_px;
  pinhole_.lens = slam::RadialTangential{};
  pinhole_.fu_px = 0;
  while (from_.size() < static_cast<std::size_t>(pixels)) {
    pinhole_.fv_px = ++pinhole_.fu_px;
    if (pinhole_.fu_px > 1e5) throw std::logic_error("no pinhole looks through this lens");
    from_.clear();
    for (int i = 0; i < pixels; ++i) {
      const auto at = recorded.project({(i % camera.width_px - pinhole_.u0_px) / pinhole_.fu_px,
                                        (i / camera.width_px - pinhole_.v0_px) / pinhole_.fv_px, 1});
      if (!at || !recorded.inside(at->pixel, 0)) break;
      from_.push_back(at->pixel);
    }
  }
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
