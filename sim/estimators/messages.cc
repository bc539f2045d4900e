#include "sim/estimators/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <variant>
#include <vector>

namespace sim::estimators {
namespace {

static_assert(std::endian::native == std::endian::little, "structures in memory are messages");
static_assert(sizeof(gaitslam_pose) == 96 && sizeof(gaitslam_start) == 288 &&
              sizeof(gaitslam_reading) == 40 && sizeof(gaitslam_plan) == 296 &&
              sizeof(gaitslam_observation) == 328 && sizeof(gaitslam_answer) == 408 &&
              sizeof(gaitslam_landmark) == 104 && sizeof(gaitslam_header) == 16 &&
              sizeof(gaitslam_ready) == 8);
static_assert(GAITSLAM_SUPPORT_LEFT == static_cast<int>(slam::Support::left) &&
              GAITSLAM_SUPPORT_RIGHT == static_cast<int>(slam::Support::right));
static_assert(GAITSLAM_LOST == static_cast<int>(slam::Health::lost) &&
              GAITSLAM_DIVERGED == static_cast<int>(slam::Health::diverged));

constexpr std::string_view kMagic = "GSLM";

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

void copy(const Eigen::Vector3d& from, double* to) { std::copy_n(from.data(), 3, to); }

gaitslam_pose pose_of(const Eigen::Isometry3d& X) {
  gaitslam_pose pose{};
  const RowMajor3d R = X.linear();
  std::copy_n(R.data(), 9, pose.rotation);
  copy(X.translation(), pose.translation_m);
  return pose;
}

Eigen::Isometry3d isometry_of(const gaitslam_pose& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Map<const RowMajor3d>(pose.rotation);
  X.translation() = Eigen::Map<const Eigen::Vector3d>(pose.translation_m);
  return X;
}

template <class Lens>
void set_lens(gaitslam_start& start, std::uint32_t kind, const Lens& parameters) {
  start.lens = kind;
  std::ranges::copy(parameters, start.lens_parameters);
}

void set_lens(gaitslam_start& start, const slam::Lens& lens) {
  if (const auto* one = std::get_if<slam::OneParameterRadial>(&lens))
    set_lens(start, GAITSLAM_LENS_ONE_PARAMETER_RADIAL, std::array{one->k1_px2});
  if (const auto* k = std::get_if<slam::RadialTangential>(&lens))
    set_lens(start, GAITSLAM_LENS_RADIAL_TANGENTIAL, std::array{k->k1, k->k2, k->p1, k->p2});
  if (const auto* k = std::get_if<slam::Equidistant>(&lens))
    set_lens(start, GAITSLAM_LENS_EQUIDISTANT, std::array{k->k1, k->k2, k->k3, k->k4});
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
  plan.support = static_cast<std::uint32_t>(planned.support);
  if (!planned.legs) return plan;
  plan.has_legs = 1;
  plan.X_OC = pose_of(planned.legs->X_OC);
  copy(planned.legs->p_CS, plan.p_CS);
  return plan;
}

template <class Bytes>
std::string_view bytes_of(const Bytes& structure) {
  return {reinterpret_cast<const char*>(&structure), sizeof structure};
}
template <class Item>
std::string_view bytes_of(const std::vector<Item>& items) {
  return {reinterpret_cast<const char*>(items.data()), items.size() * sizeof(Item)};
}

std::string message(std::uint32_t type, std::initializer_list<std::string_view> parts) {
  gaitslam_header header{};
  std::ranges::copy(kMagic, header.magic);
  header.type = type;
  for (const std::string_view part : parts) header.bytes += part.size();
  std::string bytes;
  bytes.reserve(sizeof header + header.bytes);
  bytes += bytes_of(header);
  for (const std::string_view part : parts) bytes += part;
  return bytes;
}

/// Removes a structure from the front of the bytes. Throws EstimatorFailed if there are too few.
template <class Structure>
Structure pop(std::string_view& bytes, const char* of) {
  if (bytes.size() < sizeof(Structure))
    throw EstimatorFailed(
        fmt::format("its {} has {} bytes, expected at least {}", of, bytes.size(), sizeof(Structure)));
  Structure structure;
  std::memcpy(&structure, bytes.data(), sizeof structure);
  bytes.remove_prefix(sizeof structure);
  return structure;
}

/// Throws EstimatorFailed unless the word is 0 or 1.
bool flag(std::uint32_t word, const char* of) {
  if (word > 1) throw EstimatorFailed(fmt::format("its {} is {}, expected 0 or 1", of, word));
  return word == 1;
}

std::vector<slam::MapPoint> pop_map(std::string_view& bytes, std::uint32_t landmarks) {
  std::vector<slam::MapPoint> map(landmarks);
  for (slam::MapPoint& point : map) {
    const auto landmark = pop<gaitslam_landmark>(bytes, "landmark");
    point.id = static_cast<int>(landmark.id);
    point.kind = "point";
    point.p_W = Eigen::Map<const Eigen::Vector3d>(landmark.p_W_m);
    if (flag(landmark.has_covariance, "landmark's has_covariance"))
      point.covariance = Eigen::Map<const RowMajor3d>(landmark.covariance);
  }
  return map;
}

}  // namespace

std::string options_text(const EstimatorChoice& choice) {
  std::string text;
  for (const auto& [key, value] : choice.options) text += fmt::format("{}={}\n", key, value);
  return text;
}

std::string start_message(const EstimatorChoice& choice, const Start& start) {
  const std::string options = options_text(choice);
  const slam::CameraIntrinsics& camera = start.calibration.camera;
  gaitslam_start words{};
  words.version = GAITSLAM_ESTIMATOR_VERSION;
  words.width_px = static_cast<std::uint32_t>(camera.width_px);
  words.height_px = static_cast<std::uint32_t>(camera.height_px);
  words.focal_px[0] = camera.fu_px, words.focal_px[1] = camera.fv_px;
  words.center_px[0] = camera.u0_px, words.center_px[1] = camera.v0_px;
  set_lens(words, camera.lens);
  words.X_CG = pose_of(start.calibration.X_CG);
  words.X_WC = pose_of(start.X_WC);
  words.seed = start.seed;
  words.options_bytes = options.size();
  return message(GAITSLAM_MESSAGE_START, {bytes_of(words), options});
}

std::string observation_message(const slam::Observation& observation) {
  const auto gyro = readings_of(observation.gyro), accelerometer = readings_of(observation.accelerometer);
  const cv::Mat image = observation.image.isContinuous() ? observation.image : observation.image.clone();
  gaitslam_observation words{};
  words.t_ns = observation.t.count();
  words.width_px = static_cast<std::uint32_t>(image.cols);
  words.height_px = static_cast<std::uint32_t>(image.rows);
  words.gyro_count = static_cast<std::uint32_t>(gyro.size());
  words.accelerometer_count = static_cast<std::uint32_t>(accelerometer.size());
  words.has_plan = observation.plan ? 1 : 0;
  if (observation.plan) words.plan = plan_of(*observation.plan);
  return message(GAITSLAM_MESSAGE_OBSERVATION, {bytes_of(words),
                                                bytes_of(gyro),
                                                bytes_of(accelerometer),
                                                {reinterpret_cast<const char*>(image.data), image.total()}});
}

std::string end_message() { return message(GAITSLAM_MESSAGE_END, {}); }

std::size_t payload_bytes(std::string_view header, std::uint32_t type) {
  const auto words = pop<gaitslam_header>(header, "header");
  if (std::string_view(words.magic, sizeof words.magic) != kMagic)
    throw EstimatorFailed(
        fmt::format("its standard output is not a message: it starts with '{}'", printable(bytes_of(words))));
  if (words.type != type)
    throw EstimatorFailed(fmt::format("its message is of type {}, expected {}", words.type, type));
  constexpr std::uint64_t kMost = sizeof(gaitslam_answer) + GAITSLAM_MOST_TEXT_BYTES +
                                  std::uint64_t{GAITSLAM_MOST_LANDMARKS} * sizeof(gaitslam_landmark);
  if (words.bytes > kMost)
    throw EstimatorFailed(
        fmt::format("its message announces {} bytes, expected at most {}", words.bytes, kMost));
  return static_cast<std::size_t>(words.bytes);
}

void read_ready(std::string_view payload) {
  const auto ready = pop<gaitslam_ready>(payload, "READY");
  if (ready.version != GAITSLAM_ESTIMATOR_VERSION)
    throw EstimatorFailed(fmt::format("it speaks version {} of gaitslam_estimator.h, expected {}",
                                      ready.version, GAITSLAM_ESTIMATOR_VERSION));
  if (ready.error_bytes != payload.size() || ready.error_bytes > GAITSLAM_MOST_TEXT_BYTES)
    throw EstimatorFailed(fmt::format("its READY announces a text of {} bytes, and {} follow",
                                      ready.error_bytes, payload.size()));
  if (!payload.empty()) throw EstimatorFailed("it cannot start: " + printable(payload));
}

Answer read_answer(std::string_view payload) {
  const auto words = pop<gaitslam_answer>(payload, "ANSWER");
  const std::uint64_t landmark_bytes = std::uint64_t{words.landmark_count} * sizeof(gaitslam_landmark);
  if (words.landmark_count > GAITSLAM_MOST_LANDMARKS || words.cause_bytes > GAITSLAM_MOST_TEXT_BYTES ||
      landmark_bytes + words.cause_bytes != payload.size())
    throw EstimatorFailed(
        fmt::format("its ANSWER announces {} landmarks (at most {}) and a cause of {} bytes (at most {}), "
                    "and {} bytes follow",
                    words.landmark_count, GAITSLAM_MOST_LANDMARKS, words.cause_bytes,
                    GAITSLAM_MOST_TEXT_BYTES, payload.size()));
  if (words.status > GAITSLAM_NOT_READY)
    throw EstimatorFailed(fmt::format(
        "its status is {}, expected 0 (ok), 1 (lost), 2 (diverged) or 3 (not ready)", words.status));
  Answer answer;
  answer.estimate.t = slam::Stamp(words.t_ns);
  answer.has_pose = words.status == GAITSLAM_OK || words.status == GAITSLAM_DIVERGED;
  if (answer.has_pose) answer.estimate.X_WC = isometry_of(words.X_WC);
  if (flag(words.has_covariance, "has_covariance") && answer.has_pose)
    answer.estimate.covariance = Eigen::Map<const RowMajor6d>(words.covariance);
  if (words.landmark_count > 0) answer.map = pop_map(payload, words.landmark_count);
  const bool ready = words.status != GAITSLAM_NOT_READY;
  answer.report.health = ready ? static_cast<slam::Health>(words.status) : slam::Health::lost;
  answer.report.cause = printable(payload);
  if (words.status != GAITSLAM_OK && payload.empty())
    answer.report.cause = ready ? "the estimator gave no cause" : "the estimator is not ready";
  return answer;
}

}  // namespace sim::estimators
