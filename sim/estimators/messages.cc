#include "sim/estimators/messages.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace sim::estimators {
namespace {

static_assert(std::endian::native == std::endian::little, "structures in memory are messages");
static_assert(sizeof(slam::LidarPoint) == sizeof(gaitslam_point) &&
              offsetof(slam::LidarPoint, intensity) == offsetof(gaitslam_point, intensity) &&
              offsetof(slam::LidarPoint, offset_ns) == offsetof(gaitslam_point, offset_ns));
static_assert(GAITSLAM_CAMERA_GRAY == int(rig::Kind::gray) &&
              GAITSLAM_CAMERA_COLOR == int(rig::Kind::color) &&
              GAITSLAM_CAMERA_DEPTH == int(rig::Kind::depth));
static_assert(slam::Lens(slam::RadialTangential()).index() == GAITSLAM_LENS_RADIAL_TANGENTIAL &&
              slam::Lens(slam::Equidistant()).index() == GAITSLAM_LENS_EQUIDISTANT);
static_assert(GAITSLAM_SUPPORT_LEFT == int(slam::Support::left) &&
              GAITSLAM_SUPPORT_RIGHT == int(slam::Support::right));
static_assert(GAITSLAM_LOST == int(slam::Health::lost) && GAITSLAM_DIVERGED == int(slam::Health::diverged));

static_assert(sizeof(programs::Header) == sizeof(gaitslam_header) &&
              offsetof(programs::Header, bytes) == offsetof(gaitslam_header, bytes) &&
              int(programs::Message::end) == GAITSLAM_MESSAGE_END);

using programs::bytes_of, programs::message, programs::pop, programs::flag, programs::InvalidMessage;
using programs::copy, programs::isometry_of, programs::kHeaderBytes, programs::Message, programs::RowMajor3d;

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

std::uint32_t word(auto number) { return std::uint32_t(number); }

gaitslam_pose pose_of(const Eigen::Isometry3d& X) { return programs::pose_of<gaitslam_pose>(X); }

gaitslam_lens lens_of(const slam::CameraIntrinsics& camera) {
  gaitslam_lens lens{};
  lens.model = word(camera.lens.index());
  lens.focal_px[0] = camera.fu_px, lens.focal_px[1] = camera.fv_px;
  lens.center_px[0] = camera.u0_px, lens.center_px[1] = camera.v0_px;
  std::ranges::copy(rig::coefficients(camera.lens), lens.parameters);
  return lens;
}

/// The name and the pose of a camera, an IMU or a lidar.
template <class Words>
Words words_of(const rig::RigSensor& sensor) {
  Words words{};
  sensor.name.copy(words.name, sizeof words.name - 1);
  words.X_CK = pose_of(sensor.X_CS);
  words.rate_hz = sensor.rate_hz;
  words.time_offset_s = sensor.time_offset_s;
  return words;
}

gaitslam_camera camera_of(const rig::RigSensor& sensor) {
  auto camera = words_of<gaitslam_camera>(sensor);
  const rig::FittedCamera fitted = rig::fit_equidistant(sensor.camera);
  camera.kind = word(sensor.kind);
  camera.width_px = word(sensor.camera.width_px);
  camera.height_px = word(sensor.camera.height_px);
  camera.lens = lens_of(sensor.camera);
  camera.equidistant = lens_of(fitted.camera);
  camera.equidistant_rms_px = fitted.rms_px, camera.equidistant_largest_px = fitted.largest_px;
  camera.readout_s = sensor.readout_s;
  camera.nearest_m = sensor.nearest_m, camera.furthest_m = sensor.furthest_m;
  return camera;
}

// A mean of white noise over dt has the standard deviation density/√dt.
gaitslam_imu imu_of(const rig::RigSensor& sensor) {
  auto imu = words_of<gaitslam_imu>(sensor);
  imu.gyro_density = sensor.gyro_sigma_rad_s / std::sqrt(sensor.rate_hz);
  imu.accelerometer_density = sensor.accelerometer_sigma_m_s2 / std::sqrt(sensor.rate_hz);
  imu.gyro_walk = sensor.gyro_bias_walk_rad_s2;
  imu.accelerometer_walk = sensor.accelerometer_bias_walk_m_s3;
  imu.gravity_m_s2 = slam::kGravity;
  return imu;
}

gaitslam_lidar lidar_of(const rig::RigSensor& sensor) {
  auto lidar = words_of<gaitslam_lidar>(sensor);
  lidar.nearest_m = sensor.nearest_m, lidar.furthest_m = sensor.furthest_m;
  lidar.lowest_rad = sensor.lowest_rad, lidar.highest_rad = sensor.highest_rad;
  return lidar;
}

/// The encoders and the force sensors of both feet.
std::vector<gaitslam_body_sensor> body_sensors_of(const Start& start) {
  std::vector<gaitslam_body_sensor> sensors;
  const auto add = [&](std::string_view name, std::uint32_t kind, std::uint32_t value_count) {
    gaitslam_body_sensor& sensor = sensors.emplace_back();
    name.copy(sensor.name, sizeof sensor.name - 1);
    sensor.kind = kind, sensor.value_count = value_count, sensor.rate_hz = start.body_rate_hz;
  };
  for (const std::string& joint : start.joints) add(joint, GAITSLAM_ENCODER, 1);
  for (const char* foot : {"left", "right"})
    if (!start.joints.empty()) add(foot, GAITSLAM_FORCE_SENSOR, 6);
  return sensors;
}

/// The list of START that a sensor is in: cameras, IMUs or lidars.
rig::Kind list_of(const rig::RigSensor& sensor) {
  return rig::is_camera(sensor) ? rig::Kind::gray : sensor.kind;
}

/// The number of a sensor of the rig in its list. The head's camera and the chest's IMU are number 0.
std::uint32_t number_of(const std::vector<rig::RigSensor>& rig, int sensor) {
  const rig::Kind list = list_of(rig.at(std::size_t(sensor)));
  const auto before = std::count_if(rig.begin(), rig.begin() + sensor,
                                    [&](const rig::RigSensor& other) { return list_of(other) == list; });
  return word(before) + (list == rig::Kind::lidar ? 0 : 1);
}

std::vector<gaitslam_reading> readings_of(const std::vector<slam::InertialSample>& samples) {
  std::vector<gaitslam_reading> readings;
  for (const slam::InertialSample& sample : samples) {
    gaitslam_reading& reading = readings.emplace_back();
    reading.begin_ns = sample.begin.count();
    reading.end_ns = sample.end.count();
    copy(sample.value, reading.value);
  }
  return readings;
}

gaitslam_plan plan_of(const slam::PlannedMotion& planned) {
  gaitslam_plan plan{};
  plan.X_PC = pose_of(planned.X_PC);
  copy(planned.v_PC_C, plan.v_PC_C);
  copy(planned.w_PC_C, plan.w_PC_C);
  copy(planned.p_CF, plan.p_CF);
  plan.support = word(planned.support);
  return plan;
}

std::string_view pixels_of(const cv::Mat& continuous) {
  return {reinterpret_cast<const char*>(continuous.data), continuous.total() * continuous.elemSize()};
}

/// Appends 0 to 7 zero bytes up to a multiple of 8.
void pad(std::string& bytes) { bytes.resize((bytes.size() + 7) / 8 * 8); }

/// The lists of OBSERVATION after the image of camera 0. at_byte counts from `data`, except for that image.
struct RigLists {
  std::vector<gaitslam_image> images;
  std::vector<gaitslam_sweep> sweeps;
  std::vector<gaitslam_imu_reading> imu_readings;
  std::vector<std::int64_t> body_stamps;
  std::vector<double> body_values;
  std::string data;
};

void add(const slam::BodyReading& reading, RigLists& lists) {
  if (reading.q.size() == 0) return;  // START lists no encoders
  lists.body_stamps.push_back(reading.t.count());
  std::ranges::copy(reading.q, std::back_inserter(lists.body_values));
  for (const slam::BodyReading::Wrench& foot : {reading.left, reading.right})
    for (const Eigen::Vector3d& part : {foot.force, foot.torque})
      std::ranges::copy(part, std::back_inserter(lists.body_values));
}

gaitslam_image image_of(std::uint32_t camera, slam::Stamp t, const cv::Mat& image, std::uint64_t at_byte) {
  const std::uint32_t pixels = image.type() == CV_16UC1  ? GAITSLAM_PIXELS_DEPTH16
                               : image.type() == CV_8UC3 ? GAITSLAM_PIXELS_RGB8
                                                         : GAITSLAM_PIXELS_GRAY8;
  const std::uint64_t row_bytes = image.elemSize() * word(image.cols);
  return {camera, pixels, word(image.cols), word(image.rows), row_bytes, t.count(), at_byte};
}

RigLists rig_lists(const std::vector<slam::RigReading>& readings, const std::vector<rig::RigSensor>& rig) {
  RigLists lists;
  for (const slam::RigReading& reading : readings) {
    const std::uint32_t number = number_of(rig, reading.sensor);
    const rig::RigSensor& sensor = rig[std::size_t(reading.sensor)];
    if (sensor.kind == rig::Kind::imu) {
      gaitslam_imu_reading& words = lists.imu_readings.emplace_back();
      words.imu = number;
      words.begin_ns = reading.begin.count(), words.end_ns = reading.t.count();
      copy(reading.gyro, words.gyro);
      copy(reading.accelerometer, words.accelerometer);
    } else if (sensor.kind == rig::Kind::lidar) {
      lists.sweeps.push_back({number, word(reading.points.size()), reading.t.count(), lists.data.size()});
      lists.data += bytes_of(reading.points);
    } else if (!reading.image.empty()) {
      lists.images.push_back(image_of(number, reading.t, reading.image, lists.data.size()));
      lists.data += pixels_of(reading.image.isContinuous() ? reading.image : reading.image.clone());
    }
    pad(lists.data);
  }
  return lists;
}

/// Appends the lists to a message that ends with the image of camera 0, if it has one.
void append(std::string& message, RigLists lists, const std::optional<gaitslam_image>& head) {
  pad(message);
  const std::size_t images = lists.images.size() + (head ? 1 : 0);
  const gaitslam_rig_counts counts{word(images), word(lists.sweeps.size()), word(lists.imu_readings.size()),
                                   word(lists.body_stamps.size())};
  const std::size_t data_at = message.size() - kHeaderBytes + sizeof counts +
                              images * sizeof(gaitslam_image) + bytes_of(lists.sweeps).size() +
                              bytes_of(lists.imu_readings).size() + bytes_of(lists.body_stamps).size() +
                              bytes_of(lists.body_values).size();
  for (gaitslam_image& image : lists.images) image.at_byte += data_at;
  for (gaitslam_sweep& sweep : lists.sweeps) sweep.at_byte += data_at;
  if (head) lists.images.insert(lists.images.begin(), *head);
  for (const std::string_view part :
       {bytes_of(counts), bytes_of(lists.images), bytes_of(lists.sweeps), bytes_of(lists.imu_readings),
        bytes_of(lists.body_stamps), bytes_of(lists.body_values), std::string_view(lists.data)})
    message += part;
  const std::uint64_t payload = message.size() - kHeaderBytes;
  std::memcpy(message.data() + offsetof(gaitslam_header, bytes), &payload, sizeof payload);
}

std::vector<slam::MapPoint> pop_map(std::string_view& bytes, std::uint32_t landmarks) {
  std::vector<slam::MapPoint> map(landmarks);
  for (slam::MapPoint& point : map) {
    const auto landmark = pop<gaitslam_landmark>(bytes, "landmark");
    point.id = int(landmark.id);
    point.kind = "point";
    point.p_W = Eigen::Map<const Eigen::Vector3d>(landmark.p_W_m);
    if (flag(landmark.has_covariance, "landmark's has_covariance"))
      point.covariance = Eigen::Map<const RowMajor3d>(landmark.covariance);
  }
  return map;
}

/// The lines of START about sessions; none if there is only one.
std::string session_text(const Session& session, slam::MapStart start) {
  if (session.count == 1) return "";
  return fmt::format("session.index={}\nsession.count={}\nsession.start={}\nsession.memory={}\n",
                     session.index, session.count, slam::kMapStarts[std::size_t(start)],
                     session.memory.string());
}

}  // namespace

std::string start_message(const programs::Choice& choice, const Start& start) {
  const std::string options =
      programs::options_text(choice) + session_text(start.session, start.options.map.start);
  rig::RigSensor head{.name = "cam0", .rate_hz = start.camera_rate_hz, .camera = start.calibration.camera};
  head.readout_s = start.camera_readout_s;
  const gaitslam_lens lens = lens_of(head.camera);
  gaitslam_start words{};
  words.version = GAITSLAM_ESTIMATOR_VERSION;
  words.lens = lens.model;
  words.width_px = word(head.camera.width_px);
  words.height_px = word(head.camera.height_px);
  std::ranges::copy(lens.focal_px, words.focal_px);
  std::ranges::copy(lens.center_px, words.center_px);
  std::ranges::copy(lens.parameters, words.lens_parameters);
  words.X_CG = pose_of(start.calibration.X_CG);
  words.X_WC = pose_of(start.X_WC);
  words.seed = start.seed;
  words.options_bytes = options.size();
  std::vector<gaitslam_camera> cameras{camera_of(head)};
  std::vector<gaitslam_imu> imus{imu_of(start.chest_imu)};
  imus[0].X_CK = words.X_CG;
  std::vector<gaitslam_lidar> lidars;
  for (const rig::RigSensor& sensor : start.rig) {
    if (sensor.kind == rig::Kind::imu) imus.push_back(imu_of(sensor));
    if (sensor.kind == rig::Kind::lidar) lidars.push_back(lidar_of(sensor));
    if (!rig::is_camera(sensor)) continue;
    cameras.push_back(camera_of(sensor));
    const int partner =
        sensor.kind == rig::Kind::depth ? rig::partner(start.rig, sensor) : int(&sensor - start.rig.data());
    cameras.back().aligned_with = partner < 0 ? 0 : number_of(start.rig, partner);
  }
  const std::vector<gaitslam_body_sensor> body = body_sensors_of(start);
  const gaitslam_sensor_counts counts{word(cameras.size()), word(imus.size()), word(lidars.size()),
                                      word(body.size())};
  const std::string zeros(8 - options.size() % 8, '\0');
  return message(Message::start, {bytes_of(words), options, zeros, bytes_of(counts), bytes_of(cameras),
                                  bytes_of(imus), bytes_of(lidars), bytes_of(body)});
}

std::string observation_message(const slam::Observation& observation,
                                const std::vector<rig::RigSensor>& rig) {
  const auto gyro = readings_of(observation.gyro), accelerometer = readings_of(observation.accelerometer);
  const cv::Mat image = observation.image.isContinuous() ? observation.image : observation.image.clone();
  gaitslam_observation words{};
  words.t_ns = observation.t.count();
  words.width_px = word(image.cols);
  words.height_px = word(image.rows);
  words.gyro_count = word(gyro.size());
  words.accelerometer_count = word(accelerometer.size());
  words.has_plan = observation.plan ? 1 : 0;
  if (observation.plan) words.plan = plan_of(*observation.plan);
  if (const auto& legs = observation.legs) {
    words.has_legs = 1;
    words.legs.X_OC = pose_of(legs->X_OC);
    copy(legs->p_CS, words.legs.p_CS);
  }
  if (const auto& command = observation.command) {
    words.has_command = 1;
    words.command = {command->t.count(), command->ahead_m_s, command->left_m_s, command->turn_rad_s};
  }
  std::string bytes =
      message(Message::input, {bytes_of(words), bytes_of(gyro), bytes_of(accelerometer), pixels_of(image)});
  std::optional<gaitslam_image> head;
  if (!image.empty()) head = image_of(0, observation.t, image, bytes.size() - kHeaderBytes - image.total());
  RigLists lists = rig_lists(observation.rig, rig);
  for (const slam::BodyReading& reading : observation.body) add(reading, lists);
  append(bytes, std::move(lists), head);
  return bytes;
}

void read_ready(std::string_view payload) {
  programs::check_ready(payload, GAITSLAM_ESTIMATOR_VERSION, "gaitslam_estimator.h");
  if (!payload.empty())
    throw InvalidMessage(fmt::format("its READY announces no text, and {} bytes follow", payload.size()));
}

Answer read_answer(std::string_view payload) {
  const auto words = pop<gaitslam_answer>(payload, "ANSWER");
  const std::uint64_t landmark_bytes = std::uint64_t{words.landmark_count} * sizeof(gaitslam_landmark);
  if (words.landmark_count > GAITSLAM_MOST_LANDMARKS || words.cause_bytes > GAITSLAM_MOST_TEXT_BYTES ||
      landmark_bytes + words.cause_bytes != payload.size())
    throw InvalidMessage(
        fmt::format("its ANSWER announces {} landmarks (at most {}) and a cause of {} bytes (at most {}), "
                    "and {} bytes follow",
                    words.landmark_count, GAITSLAM_MOST_LANDMARKS, words.cause_bytes,
                    GAITSLAM_MOST_TEXT_BYTES, payload.size()));
  if (words.status > GAITSLAM_NOT_READY)
    throw InvalidMessage(fmt::format(
        "its status is {}, expected 0 (ok), 1 (lost), 2 (diverged) or 3 (not ready)", words.status));
  Answer answer;
  if (words.status == GAITSLAM_OK || words.status == GAITSLAM_DIVERGED) {
    PoseEstimate& estimate = answer.estimate.emplace();
    estimate.t = slam::Stamp(words.t_ns);
    estimate.X_WC = isometry_of(words.X_WC);
    if (flag(words.has_covariance, "has_covariance"))
      estimate.covariance = Eigen::Map<const RowMajor6d>(words.covariance);
  }
  if (words.landmark_count > 0) answer.map = pop_map(payload, words.landmark_count);
  const bool ready = words.status != GAITSLAM_NOT_READY;
  answer.report.health = ready ? static_cast<slam::Health>(words.status) : slam::Health::lost;
  if (!payload.empty())
    answer.report.cause = programs::printable(payload);
  else if (words.status != GAITSLAM_OK)
    answer.report.cause = ready ? "the estimator gave no cause" : "the estimator is not ready";
  return answer;
}

}  // namespace sim::estimators
