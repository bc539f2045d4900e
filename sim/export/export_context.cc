#include "sim/export/export_context.h"

#include "sim/files/text.h"

GAITSLAM_EMBED(gaitslam_export_texts, GAITSLAM_EXPORT_TEXTS)

namespace sim::exports {
namespace {

struct Format {
  const char* name;
  void (*write)(const ExportContext&);
  bool knows_lenses = true;  ///< otherwise the images are always undistorted
  int passes = 1;            ///< how many times the recording is read
};

constexpr Format kFormats[]{{"euroc", export_euroc},
                            {"tum", export_tum, false},
                            {"mcap", export_mcap},
                            {"orbslam3", export_orbslam3},
                            {"openvins", export_openvins, true, 2}};

// Writes a pixel with 8 bits per channel; `at` lies inside the image.
void bilinear(const cv::Mat& image, const Eigen::Vector2d& at, unsigned char* pixel) {
  const int left = std::min(int(at.x()), image.cols - 2), top = std::min(int(at.y()), image.rows - 2),
            n = image.channels();
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

/// Returns whether two depths on either side of a pixel can belong to one surface.
bool is_same_surface(int a_mm, int b_mm) {
  return a_mm > 0 && b_mm > 0 && std::abs(a_mm - b_mm) < 0.05 * std::min(a_mm, b_mm);
}

cv::Mat1w filled(const cv::Mat1w& depth_mm) {
  cv::Mat1w full = depth_mm.clone();
  for (int v = 0; v < depth_mm.rows; ++v)
    for (int u = 0; u < depth_mm.cols; ++u)
      for (const cv::Point step : {cv::Point(1, 0), cv::Point(0, 1)}) {
        const cv::Point before = cv::Point(u, v) - step, after = cv::Point(u, v) + step;
        if (full(v, u) > 0 || before.x < 0 || before.y < 0 || after.x >= full.cols || after.y >= full.rows)
          continue;
        const int a = depth_mm(before), b = depth_mm(after);
        if (is_same_surface(a, b)) full(v, u) = std::uint16_t((a + b) / 2);
      }
  return full;
}

}  // namespace

std::vector<std::string> export_formats() {
  std::vector<std::string> names;
  for (const Format& format : kFormats) names.push_back(format.name);
  return names;
}

void export_run(const ExportedRun& run, const std::string& format, const fs::path& folder) {
  const auto found = std::ranges::find_if(kFormats, [&](const Format& f) { return f.name == format; });
  if (found == std::end(kFormats)) throw std::out_of_range("no export format " + format);
  files::AtomicFolder durable(folder);
  found->write(ExportContext(run, durable.path(), run.undistort || !found->knows_lenses, found->passes));
  durable.commit();
}

std::string text_of(std::string_view name) {
  if (const auto found = files::titled_lines(gaitslam_export_texts(), name)) return *found;
  throw std::logic_error(fmt::format("no text is named {}", name));
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
  sensor_errors::state_errors(run.errors, imu);
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
  ExportedFrame frame{observation->t, {}, {}};
  frame.motion.t = observation->t;
  frame.motion.plan = observation->plan, frame.motion.legs = observation->legs;
  frame.motion.command = observation->command;
  for (ExportedReading& reading : imu_.merge(*observation)) {
    reading.sensor = out_.chest();
    frame.readings.push_back(std::move(reading));
  }
  slam::RigReading head;
  head.sensor = out_.head(), head.t = observation->t, head.image = std::move(observation->image);
  observation->rig.insert(observation->rig.begin(), std::move(head));
  for (slam::RigReading& reading : observation->rig) {
    const auto index = std::size_t(reading.sensor);
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
    const auto& [camera, rms_px, largest_px] = cameras_.at(std::size_t(i))->fitted;
    text += fmt::format("- `{}`, {}: {} x {} px, focal lengths {} and {} px, principal point ({}, {}), ",
                        sensor(i).name, rig::kKinds[std::size_t(sensor(i).kind)], camera.width_px,
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
      offsets += fmt::format("The stamps of `{}` are {} s ahead of the head camera's.\n", sensor.name,
                             sensor.time_offset_s);
  write("README.md",
        filled_text("readme.md", run.name, run.seed, texts + more, recording::kEpoch.count() / 1'000'000'000,
                    setup.imu_rate_hz, noise.gyro_density, noise.accelerometer_density, noise.gyro_walk,
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

Undistortion::Undistortion(const slam::CameraIntrinsics& camera) : pinhole_(camera) {
  const slam::Camera recorded(camera);
  const int pixels = camera.width_px * camera.height_px;
  pinhole_.lens = slam::RadialTangential{};
  pinhole_.fu_px = 0;
  while (from_.size() < std::size_t(pixels)) {
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
        straight.at<std::uint16_t>(row, column) =
            image.at<std::uint16_t>(int(std::lround(from->y())), int(std::lround(from->x())));
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

DepthRegistration::DepthRegistration(const slam::CameraIntrinsics& from, const slam::CameraIntrinsics& to,
                                     const Eigen::Isometry3d& X_to_from)
    : to_(to), size_(to.width_px, to.height_px), X_to_from_(X_to_from) {
  const slam::Camera camera(from);
  for (int v = 0; v < from.height_px; ++v)
    for (int u = 0; u < from.width_px; ++u) {
      const auto center = camera.unproject({u, v}), first = camera.unproject({u - 0.5, v - 0.5}),
                 last = camera.unproject({u + 0.5, v + 0.5});
      squares_.emplace_back();
      if (center && first && last) squares_.back() = {center->h, first->h, last->h};
    }
}

cv::Mat1w DepthRegistration::operator()(const cv::Mat1w& depth_mm) const {
  cv::Mat1w nearest(size_, 0);
  auto square = squares_.begin();
  for (const std::uint16_t mm : depth_mm) {
    const auto& sight = *square++;
    if (mm == 0 || !sight) continue;
    const auto moved = [&](const Eigen::Vector3d& line) { return X_to_from_ * (1e-3 * mm * line); };
    const auto first = to_.project(moved(sight->first)), last = to_.project(moved(sight->last));
    const double z_mm = std::round(1e3 * moved(sight->center).z());
    if (!first || !last || z_mm < 1 || z_mm > 65535) continue;
    const auto range = [](double from, double to, int size) {
      return cv::Range(int(std::clamp<double>(std::ceil(from), 0, size)),
                       int(std::clamp<double>(std::ceil(to), 0, size)));
    };
    const cv::Range rows = range(first->pixel.y(), last->pixel.y(), size_.height),
                    columns = range(first->pixel.x(), last->pixel.x(), size_.width);
    for (int v = rows.start; v < rows.end; ++v)
      for (int u = columns.start; u < columns.end; ++u)
        if (nearest(v, u) == 0 || z_mm < nearest(v, u)) nearest(v, u) = std::uint16_t(z_mm);
  }
  return filled(nearest);
}

double overlap(const rig::RigSensor& camera, const rig::RigSensor& other, double distance_m) {
  constexpr int kGrid = 20;
  const slam::Camera from(camera.camera), to(other.camera);
  int seen = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Eigen::Vector2d pixel((i % kGrid + 0.5) / kGrid * camera.camera.width_px - 0.5,
                                (i / kGrid + 0.5) / kGrid * camera.camera.height_px - 0.5);
    const auto ray = from.unproject(pixel);
    if (!ray) continue;
    const auto at = to.project(other.X_CS.inverse() * camera.X_CS * (distance_m * ray->h));
    seen += at && to.inside(at->pixel, 0);
  }
  return double(seen) / (kGrid * kGrid);
}

}  // namespace sim::exports
