#include "sim/sensor_errors/sensor_errors.h"

#include <opencv2/imgproc.hpp>

#include "sim/sensor_errors/random.h"

namespace sim::sensor_errors {
namespace {

using slam::InertialSample, slam::Observation, slam::PlannedMotion, slam::Stamp;

Eigen::Vector3d normal3(Random random) {
  Eigen::Vector3d v;
  for (double& x : v) x = random.normal();
  return v;
}

void append_shifted(std::deque<InertialSample>& queue, std::vector<InertialSample>& readings, Stamp offset) {
  for (const InertialSample& reading : std::exchange(readings, {}))
    queue.push_back({reading.begin + offset, reading.end + offset, reading.value});
}

std::vector<InertialSample> taken_until(Stamp t, std::deque<InertialSample>& queue) {
  std::vector<InertialSample> readings;
  for (; !queue.empty() && queue.front().end <= t; queue.pop_front()) readings.push_back(queue.front());
  if (!queue.empty() && queue.front().begin < t) {
    readings.push_back({queue.front().begin, t, queue.front().value});
    queue.front().begin = t;
  }
  return readings;
}

Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double part) {
  Eigen::Isometry3d X = a;
  const Eigen::Quaterniond q(a.linear());
  X.linear() = q.slerp(part, Eigen::Quaterniond(b.linear())).normalized().toRotationMatrix();
  X.translation() = (1 - part) * a.translation() + part * b.translation();
  return X;
}

PlannedMotion interpolate(const PlannedMotion& a, const PlannedMotion& b, double part) {
  PlannedMotion plan = part < 0.5 ? a : b;
  plan.X_PC = interpolate(a.X_PC, b.X_PC, part);
  plan.v_PC_C = (1 - part) * a.v_PC_C + part * b.v_PC_C;
  plan.w_PC_C = (1 - part) * a.w_PC_C + part * b.w_PC_C;
  return plan;
}

slam::LegMotion interpolate(const slam::LegMotion& a, const slam::LegMotion& b, double part) {
  return {interpolate(a.X_OC, b.X_OC, part), (1 - part) * a.p_CS + part * b.p_CS,
          a.X_CG && b.X_CG ? std::optional(interpolate(*a.X_CG, *b.X_CG, part)) : std::nullopt};
}

template <class Motion>
std::optional<Motion> interpolate(const std::optional<Motion>& a, const std::optional<Motion>& b,
                                  double part) {
  return a && b ? std::optional(interpolate(*a, *b, part)) : std::nullopt;
}

template <class Spike, class Silence>
InertialErrors inertial_errors(const char* sensor, const InertialErrorSizes& sizes, double Spike::*spike_size,
                               const std::vector<Fault>& faults, std::uint64_t seed) {
  std::vector<InertialErrors::Spike> spikes;
  for (const Spike& spike : faults_of<Spike>(faults)) spikes.push_back({spike, spike.*spike_size});
  if constexpr (std::is_same_v<Spike, GyroSpike>)
    for (const GyroScaled& scaled : faults_of<GyroScaled>(faults))
      spikes.push_back({scaled, 0, scaled.factor});
  const auto silent = faults_of<Silence>(faults);
  return {sensor, sizes, seed, std::move(spikes), {silent.begin(), silent.end()}};
}

// InertialErrors takes white noise for 200 Hz readings, so sigma is converted.
InertialErrors inertial(const rig::RigSensor& sensor, const std::string& stream, double sigma,
                        double bias_sigma, std::uint64_t seed) {
  const double sigma_200_hz = sigma / std::sqrt(slam::kReadingPeriod_s * sensor.rate_hz);
  return {stream, {.sigma = sigma_200_hz, .bias_sigma = bias_sigma}, seed, {}, {}};
}

bool is_lost(std::uint64_t seed, const char* stream, Stamp t, double fraction) {
  return fraction > 0 && Random(seed, stream, static_cast<std::uint64_t>(t.count())).uniform() < fraction;
}

// Marks the pixels on both sides of the edges between columns.
void mark_edges(const cv::Mat1w& depth_mm, cv::Mat1b& marks) {
  // 0 if the column has no depth, and beyond both ends.
  std::vector<float> inverse(std::size_t(depth_mm.cols) + 2);
  const auto difference = [](float a, float b) { return a > 0 && b > 0 ? std::abs(a - b) : 0; };
  for (int row = 0; row < depth_mm.rows; ++row) {
    for (int i = 0; i < depth_mm.cols; ++i) {
      const unsigned short z = depth_mm(row, i);
      inverse[std::size_t(i) + 1] = z > 0 ? 1.0f / float(z) : 0;
    }
    for (int i = 0; i + 1 < depth_mm.cols; ++i) {
      const float* w = &inverse[std::size_t(i)];
      const float slant = std::max(difference(w[0], w[1]), difference(w[2], w[3]));
      if (difference(w[1], w[2]) > std::max(3 * slant, 0.02f * std::max(w[1], w[2])))
        marks(row, i) = marks(row, i + 1) = 1;
    }
  }
}

// Noise of unit variance, correlated like means over a matching window: draws on a randomly placed grid,
// interpolated and normalized. With cells of 0.7 windows, it has the correlation of the mean at half a
// window.
cv::Mat1f correlated_noise(const cv::Size& size, double window_px, Random random) {
  const double cell = std::max(1.0, 0.7 * window_px);
  struct Weights {
    int first;
    float here, next;
  };
  const auto along = [&](int count) {
    const double start = std::floor(cell * random.uniform());
    std::vector<Weights> all;
    for (int i = 0; i < count; ++i) {
      const double at = (start + i) / cell, part = at - std::floor(at), root = std::hypot(1 - part, part);
      all.push_back({int(at), float((1 - part) / root), float(part / root)});
    }
    return all;
  };
  const std::vector<Weights> columns = along(size.width), rows = along(size.height);
  cv::Mat1f grid(rows.back().first + 2, columns.back().first + 2), noise(size);
  for (float& draw : grid) draw = float(random.normal());
  for (int v = 0; v < size.height; ++v) {
    const auto [row, a, b] = rows[std::size_t(v)];
    const float *upper = grid[row], *lower = grid[row + 1];
    for (int u = 0; u < size.width; ++u) {
      const auto [i, here, next] = columns[std::size_t(u)];
      noise(v, u) = here * (a * upper[i] + b * lower[i]) + next * (a * upper[i + 1] + b * lower[i + 1]);
    }
  }
  return noise;
}

// According to the data sheet of the D400 series, the error over a plane is at most 2 %, but its change
// between frames at most 1 %, of the depth: a quarter of the variance is new in each frame. The rest depends
// on the content of the matching windows.
cv::Mat1f disparity_noise(const cv::Size& size, const rig::RigSensor& sensor, const std::string& stream,
                          std::uint64_t seed, Stamp t) {
  constexpr Stamp kLasts(250'000'000);
  const Stamp::rep before = t.count() / kLasts.count() - (t < Stamp(0));
  const double part = slam::seconds(t - before * kLasts) / slam::seconds(kLasts),
               root = std::hypot(1 - part, part);
  const auto noise = [&](const std::string& name, Stamp::rep item) {
    return correlated_noise(size, sensor.window_px, Random(seed, name, std::uint64_t(item)));
  };
  const cv::Mat1f lasting = noise(stream + " lasting", before) * ((1 - part) / root) +
                            noise(stream + " lasting", before + 1) * (part / root);
  return 0.5 * noise(stream, t.count()) + std::sqrt(0.75) * lasting;
}

cv::Mat measured_depth(const cv::Mat& ideal, const rig::RigSensor& sensor, const cv::Mat1f& noise) {
  const cv::Mat1b holes = beside_edges(ideal, sensor.edge_px);
  const double scale = rig::inverse_depth_sigma(sensor);
  cv::Mat1w out(ideal.size());
  for (int row = 0; row < out.rows; ++row)
    for (int column = 0; column < out.cols; ++column) {
      const double z_m = 1e-3 * ideal.at<unsigned short>(row, column), error = scale * noise(row, column);
      const bool none =
          z_m == 0 || z_m < sensor.nearest_m || z_m > sensor.furthest_m || holes(row, column) > 0;
      out(row, column) = none ? 0 : cv::saturate_cast<unsigned short>(1e3 * (z_m + z_m * z_m * error));
    }
  return out;
}

// The azimuth error moves a point along the horizontal circle, the elevation error along the vertical one,
// both to first order.
std::vector<slam::LidarPoint> measured_points(const std::vector<slam::LidarPoint>& ideal,
                                              const rig::RigSensor& sensor, Random random) {
  std::vector<slam::LidarPoint> points;
  for (slam::LidarPoint point : ideal) {
    const Eigen::Vector3d p(point.x_m, point.y_m, point.z_m), along = p.normalized();
    const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(along);  // length: cosine of elevation
    const Eigen::Vector3d up = along.cross(left).stableNormalized();
    const double range = p.norm() + sensor.range_sigma_m * random.normal();
    const double azimuth = sensor.angle_sigma_rad * random.normal();
    const double elevation = sensor.angle_sigma_rad * random.normal();
    if (range < sensor.nearest_m || range > sensor.furthest_m) continue;
    const Eigen::Vector3d noisy = range * (along + azimuth * left + elevation * up).normalized();
    point.x_m = float(noisy.x()), point.y_m = float(noisy.y()), point.z_m = float(noisy.z());
    points.push_back(point);
  }
  return points;
}

Eigen::Vector3d measured(InertialErrors& errors, const slam::RigReading& reading,
                         const Eigen::Vector3d& value) {
  std::vector<slam::InertialSample> samples{{reading.begin, reading.t, value}};
  errors.apply(samples);
  return samples[0].value;
}

}  // namespace

void state_errors(const ErrorOptions& errors, rig::RigSensor& chest_imu) {
  chest_imu.time_offset_s = errors.motion_time_offset_s;
  chest_imu.gyro_sigma_rad_s = errors.gyro.sigma;
  chest_imu.gyro_bias_walk_rad_s2 = errors.gyro.bias_walk_sigma;
  chest_imu.accelerometer_sigma_m_s2 = errors.accelerometer.sigma;
  chest_imu.accelerometer_bias_walk_m_s3 = errors.accelerometer.bias_walk_sigma;
}

InertialErrors::InertialErrors(std::string sensor, const InertialErrorSizes& sizes, std::uint64_t seed,
                               std::vector<Spike> spikes, std::vector<Span> silences)
    : sensor_(std::move(sensor)),
      sizes_(sizes),
      seed_(seed),
      spikes_(std::move(spikes)),
      silences_(std::move(silences)),
      bias_(sizes.bias_sigma * normal3(Random(seed, sensor_ + " bias"))) {}

void InertialErrors::apply(std::vector<InertialSample>& readings) {
  for (InertialSample& reading : readings) reading.value = disturbed(reading);
  std::erase_if(readings, [this](const InertialSample& reading) {
    return std::ranges::any_of(silences_, [&](const Span& s) { return s.touches(reading); });
  });
}

// A reading split by a frame is a mean over less than 5 ms. Its noise is scaled up, so that the integral over
// the whole 5 ms has the variance of an unsplit reading.
Eigen::Vector3d InertialErrors::disturbed(const InertialSample& reading) {
  const auto item = std::uint64_t(reading.end.count());
  const double duration_s = slam::seconds(reading.end - reading.begin);
  if (sizes_.bias_walk_sigma > 0)
    bias_ +=
        sizes_.bias_walk_sigma * std::sqrt(duration_s) * normal3(Random(seed_, sensor_ + " bias walk", item));
  const double sigma = sizes_.sigma * std::sqrt(slam::kReadingPeriod_s / duration_s);
  Eigen::Vector3d value = reading.value + sigma * normal3(Random(seed_, sensor_ + " noise", item)) + bias_;
  for (const Spike& spike : spikes_)
    if (spike.span.touches(reading)) value = (spike.factor * value).array() + spike.size;
  return value;
}

std::optional<PlannedMotion> PlanErrors::apply(std::optional<PlannedMotion> plan, Stamp t) {
  if (!plan) return plan;
  double factor = 1;
  for (const PlanScaled& scaled : scaled_)
    if (scaled.holds(t)) factor *= scaled.factor;
  const Eigen::Vector3d p_PC = plan->X_PC.translation();
  position_error_P_ += (factor - 1) * (p_PC - last_p_PC_.value_or(p_PC));
  last_p_PC_ = p_PC;
  plan->X_PC.translation() += position_error_P_;
  plan->v_PC_C *= factor;
  if (std::ranges::any_of(missing_, [t](const PlanMissing& m) { return m.holds(t); })) plan.reset();
  return plan;
}

std::vector<Observation> MotionClock::process(Observation observation) {
  append_shifted(gyro_, observation.gyro, offset_);
  append_shifted(accelerometer_, observation.accelerometer, offset_);
  for (slam::BodyReading& reading : std::exchange(observation.body, {})) {
    reading.t += offset_;
    body_.push_back(std::move(reading));
  }
  const Stamp known = observation.t + offset_;
  if (observation.command) observation.command->t += offset_;
  motions_.push_back({known, std::exchange(observation.plan, {}), std::exchange(observation.legs, {}),
                      std::exchange(observation.command, {})});
  waiting_.push_back(std::move(observation));
  std::vector<Observation> complete;
  while (!waiting_.empty() && waiting_.front().t <= known) complete.push_back(assembled());
  return complete;
}

std::vector<Observation> MotionClock::flush() {
  std::vector<Observation> incomplete;
  while (!waiting_.empty()) incomplete.push_back(assembled());
  return incomplete;
}

Observation MotionClock::assembled() {
  Observation frame = std::move(waiting_.front());
  waiting_.pop_front();
  frame.gyro = taken_until(frame.t, gyro_);
  frame.accelerometer = taken_until(frame.t, accelerometer_);
  for (; !body_.empty() && body_.front().t < frame.t; body_.pop_front())
    frame.body.push_back(std::move(body_.front()));
  add_motion(frame);
  return frame;
}

// Frames come in chronological order, so earlier motions are not needed again.
void MotionClock::add_motion(Observation& frame) {
  while (motions_.size() > 1 && motions_[1].t <= frame.t) motions_.pop_front();
  if (motions_.empty() || motions_[0].t > frame.t) return;
  const StampedMotion& before = motions_[0];
  frame.command = before.command;
  if (before.t == frame.t) {
    frame.plan = before.plan, frame.legs = before.legs;
  } else if (motions_.size() > 1) {
    const StampedMotion& after = motions_[1];
    const double part = slam::seconds(frame.t - before.t) / slam::seconds(after.t - before.t);
    frame.plan = interpolate(before.plan, after.plan, part);
    frame.legs = interpolate(before.legs, after.legs, part);
  }
}

cv::Mat1b beside_edges(const cv::Mat1w& depth_mm, int reach) {
  cv::Mat1b marks(depth_mm.size(), 0), turned(cv::Size(depth_mm.rows, depth_mm.cols), 0);
  if (reach == 0) return marks;
  mark_edges(depth_mm, marks);
  mark_edges(depth_mm.t(), turned);
  cv::bitwise_or(marks, turned.t(), marks);
  if (reach > 1) cv::dilate(marks, marks, cv::Mat(), cv::Point(-1, -1), reach - 1);
  return marks;
}

RigErrors::RigErrors(const std::vector<rig::RigSensor>& rig, std::uint64_t seed) : seed_(seed) {
  for (const rig::RigSensor& sensor : rig) {
    const std::string stream = "rig " + sensor.name;
    const ImageOptions sizes{.read_sigma_gray = sensor.read_sigma_gray,
                             .shot_sigma_gray = sensor.shot_sigma_gray};
    sensors_.push_back(
        {sensor, stream + " noise", ImageErrors(sizes, seed, {}, stream + " noise"),
         inertial(sensor, stream + " gyro", sensor.gyro_sigma_rad_s, sensor.gyro_bias_sigma_rad_s, seed),
         inertial(sensor, stream + " accelerometer", sensor.accelerometer_sigma_m_s2,
                  sensor.accelerometer_bias_sigma_m_s2, seed)});
  }
}

void RigErrors::apply(std::vector<slam::RigReading>& readings) {
  for (slam::RigReading& reading : readings) {
    Sensor& sensor = sensors_.at(std::size_t(reading.sensor));
    const Random random(seed_, sensor.stream, std::uint64_t(reading.t.count()));
    const slam::Stamp offset = stamp(sensor.is.time_offset_s);
    cv::Mat& image = reading.image;
    if (sensor.is.kind == rig::Kind::lidar) {
      reading.points = measured_points(reading.points, sensor.is, random);
    } else if (sensor.is.kind == rig::Kind::imu) {
      reading.gyro = measured(sensor.gyro, reading, reading.gyro);
      reading.accelerometer = measured(sensor.accelerometer, reading, reading.accelerometer);
      reading.begin += offset;
    } else if (!image.empty()) {
      image = sensor.is.kind == rig::Kind::depth
                  ? measured_depth(image, sensor.is,
                                   disparity_noise(image.size(), sensor.is, sensor.stream, seed_, reading.t))
                  : sensor.image.apply(image.reshape(1), reading.t).reshape(image.channels());
    }
    reading.t += offset;
  }
}

SensorErrors::SensorErrors(const ErrorOptions& options, std::uint64_t seed,
                           const std::vector<rig::RigSensor>& rig)
    : options_(options),
      seed_(seed),
      rig_(rig, seed),
      gyro_(inertial_errors<GyroSpike, GyroSilent>("gyro", options.gyro, &GyroSpike::size_rad_s,
                                                   options.faults, seed)),
      accelerometer_(inertial_errors<AccelerometerSpike, AccelerometerSilent>(
          "accelerometer", options.accelerometer, &AccelerometerSpike::size_m_s2, options.faults, seed)),
      image_(options.image, seed, options.faults),
      sources_(options, seed),
      plan_(options.faults),
      motion_clock_(stamp(options.motion_time_offset_s)) {}

template <class Kind>
bool SensorErrors::strikes(const char* stream, slam::Stamp t) const {
  const auto faults = faults_of<Kind>(options_.faults);
  return std::ranges::any_of(
      faults, [&](const Kind& fault) { return fault.holds(t) && is_lost(seed_, stream, t, fault.fraction); });
}

void SensorErrors::arrive(slam::Observation observation, std::vector<slam::Observation>& arrived) {
  if (!late_ && strikes<FramesReordered>("frame reordered", observation.t)) {
    late_ = std::move(observation);
    return;
  }
  arrived.insert(arrived.end(), strikes<FramesDoubled>("frame doubled", observation.t) ? 2 : 1, observation);
  if (late_) arrived.push_back(*std::exchange(late_, {}));
}

std::vector<slam::Observation> SensorErrors::process(slam::Observation o) {
  gyro_.apply(o.gyro);
  accelerometer_.apply(o.accelerometer);
  rig_.apply(o.rig);
  o.image = received_image(o.image, o.t);
  if (o.legs) disturb(*o.legs, o.t);
  o.plan = plan_.apply(std::move(o.plan), o.t);
  if (is_lost(seed_, "plan loss", o.t, options_.plan_loss_fraction)) o.plan.reset();
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.process(std::move(o)))
    arrive(std::move(assembled), arrived);
  return arrived;
}

std::vector<slam::Observation> SensorErrors::flush() {
  std::vector<slam::Observation> arrived;
  for (slam::Observation& assembled : motion_clock_.flush()) arrive(std::move(assembled), arrived);
  if (late_) arrived.push_back(*std::exchange(late_, {}));
  return arrived;
}

void SensorErrors::disturb(slam::LegMotion& legs, slam::Stamp t) {
  const ErrorOptions::LegOdometry& sizes = options_.leg_odometry;
  auto p_OC = legs.X_OC.translation();
  if (!first_p_OC_) first_p_OC_ = p_OC;
  if (sizes.scale_fraction != 0) p_OC.head<2>() += sizes.scale_fraction * (p_OC - *first_p_OC_).head<2>();
  if (sizes.sigma_m == 0) return;
  Random random(seed_, "leg odometry", std::uint64_t(t.count()));
  for (int axis = 0; axis < 3; ++axis) p_OC(axis) += sizes.sigma_m * random.normal();
}

ImageSources::ImageSources(const ErrorOptions& options, std::uint64_t seed)
    : seed_(seed),
      loss_fraction_(options.image.loss_fraction),
      latency_(stamp(options.image.latency_s)),
      losses_(faults_of<FramesLost>(options.faults)),
      freezes_(faults_of<FramesFrozen>(options.faults)) {}

std::optional<slam::Stamp> ImageSources::at(slam::Stamp t, bool has_image) {
  double lost_fraction = loss_fraction_;
  for (const FramesLost& fault : losses_)
    if (fault.holds(t)) lost_fraction = std::max(lost_fraction, fault.fraction);
  if (has_image && !is_lost(seed_, "image loss", t, lost_fraction)) {
    const bool frozen = std::ranges::any_of(freezes_, [t](const Span& s) { return s.holds(t); });
    if (!frozen || !last_unfrozen_) last_unfrozen_ = t;
    delayed_.emplace_back(t, *last_unfrozen_);
  }
  std::optional<slam::Stamp> newest;
  for (; !delayed_.empty() && delayed_.front().first + latency_ <= t; delayed_.pop_front())
    newest = delayed_.front().second;
  return newest;
}

cv::Mat SensorErrors::received_image(const cv::Mat& ideal, slam::Stamp t) {
  const std::optional<slam::Stamp> source = sources_.at(t, !ideal.empty());
  if (sources_.is_source(t)) images_.push_back({t, image_.apply(ideal, t)});
  if (!source) return {};
  while (images_.front().t < *source) images_.pop_front();
  return images_.front().image;
}

}  // namespace sim::sensor_errors
