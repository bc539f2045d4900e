#include "sim/export/export_context.h"

#include <fmt/format.h>

#include <stdexcept>

#include "sim/files/text.h"
#include "sim/recording/manifest.h"

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
  imu.name = rig::kChestImu, imu.kind = rig::Kind::imu;
  imu.rate_hz = setup.imu_rate_hz, imu.X_CS = setup.calibration.X_CG;
  imu.time_offset_s = run.errors.motion_time_offset_s;
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

std::string ExportContext::cameras_text(const std::vector<int>& cameras) const {
  std::string text = undistort_ ? text_of("lens_pinhole.md") : "";
  bool fits = false;
  for (const int i : cameras) {
    const auto& [camera, rms_px, largest_px] = cameras_.at(static_cast<std::size_t>(i))->fitted;
    text +=
        fmt::format("- `{}`, {}: {} x {} px, focal lengths {} and {} px, principal point ({}, {}), ",
                    sensor(i).name, rig::kKinds[static_cast<std::size_t>(sensor(i).kind)], camera.width_px,
                    camera.height_px, camera.fu_px, camera.fv_px, camera.u0_px, camera.v0_px);
    fits = fits || equidistant_lens(camera);
    text +=
        equidistant_lens(camera)
            ? fmt::format("equidistant: {:.4f} px root mean square, at most {:.4f} px\n", rms_px, largest_px)
            : "no distortion\n";
  }
  return text + (fits ? text_of("lens_equidistant.md") : "");
}

void ExportContext::write_readme(std::initializer_list<std::string> names, const std::vector<int>& cameras,
                                 const std::string& more) const {
  std::string texts;
  for (const std::string& name : names) texts += name.empty() ? "" : text_of(name);
  const recording::ImuNoise noise = noise_of(sensor(chest()));
  std::string offsets;
  for (const rig::RigSensor& sensor : setup.rig)
    if (sensor.time_offset_s != 0)
      offsets += fmt::format("The stamps of `{}` are {} s ahead of those of the head camera.\n", sensor.name,
                             sensor.time_offset_s);
  write("README.md", fmt::format(fmt::runtime(text_of("readme.md")), run.name, run.seed, texts + more,
                                 recording::kEpoch.count() / 1'000'000'000, setup.imu_rate_hz,
                                 noise.gyro_density, noise.accelerometer_density, noise.gyro_walk,
                                 noise.accelerometer_walk, kLeastGyroWalk, kLeastAccelerometerWalk,
                                 run.errors.motion_time_offset_s, offsets, cameras_text(cameras)));
}

int image_of_depth(const ExportContext& out, int depth) {
  constexpr double kLeastOverlap = 0.1;
  const rig::RigSensor& from = out.sensor(depth);
  int best = rig::partner(out.sensors, from);
  double most = kLeastOverlap;
  if (out.sensor(best).kind == rig::Kind::color) return best;
  for (const int color : out.all(rig::Kind::color))
    if (const double part = overlap(out.sensor(color), from, 0.5 * (from.nearest_m + from.furthest_m));
        part > most)
      best = color, most = part;
  return best;
}

}  // namespace sim::exports
