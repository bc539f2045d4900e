#include "sim/recording/map_file.h"

#include <Eigen/Cholesky>
#include <cstring>
#include <nlohmann/json.hpp>

#include "sim/files/hash.h"
#include "sim/files/json.h"

namespace sim::recording {
namespace {

constexpr int kVersion = 1;
constexpr std::size_t kHash = 32, kMostLandmarks = 1000;
constexpr double kRounding = 1e-9;  // relative to variances

/// The numbers of a landmark besides its parameters and its patch.
struct Fixed {
  double X_WC_first[12], pixel_first[2], tilt[2], p_WC_inflated[3];
  std::int32_t id, is_point, attempts, successes, last_session, reserved;
};
static_assert(sizeof(Fixed) == 19 * 8 + 6 * 4);

template <class T>
std::string_view bytes_of(const T* values, std::size_t count) {
  return {reinterpret_cast<const char*>(values), count * sizeof(T)};
}

/// Takes values from the front of the bytes. Throws FileError if there are too few.
template <class T>
void take(const fs::path& file, std::string_view& bytes, T* values, std::size_t count) {
  if (bytes.size() < count * sizeof(T)) throw files::FileError(file, "truncated: it ends within a landmark");
  std::memcpy(values, bytes.data(), count * sizeof(T));
  bytes.remove_prefix(count * sizeof(T));
}

std::string text_of(const slam::CameraIntrinsics& c) {
  struct Lens {
    std::string operator()(const slam::OneParameterRadial& l) const {
      return fmt::format("one-parameter-radial {}", l.k1_px2);
    }
    std::string operator()(const slam::RadialTangential& l) const {
      return fmt::format("radial-tangential {} {} {} {}", l.k1, l.k2, l.p1, l.p2);
    }
    std::string operator()(const slam::Equidistant& l) const {
      return fmt::format("equidistant {} {} {} {}", l.k1, l.k2, l.k3, l.k4);
    }
  };
  return fmt::format("{}x{} px, focal length {} {} px, center {} {} px, {}", c.width_px, c.height_px, c.fu_px,
                     c.fv_px, c.u0_px, c.v0_px, std::visit(Lens{}, c.lens));
}

using Rows34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

Fixed fixed_of(const slam::Landmark& l) {
  Fixed fixed{};
  Eigen::Map<Rows34>(fixed.X_WC_first) = l.X_WC_first.matrix().topRows<3>();
  Eigen::Map<Eigen::Vector2d>(fixed.pixel_first) = l.pixel_first;
  Eigen::Map<Eigen::Vector2d>(fixed.tilt) = l.tilt;
  Eigen::Map<Eigen::Vector3d>(fixed.p_WC_inflated) = l.p_WC_inflated;
  fixed.id = l.id, fixed.is_point = std::holds_alternative<slam::Point>(l.kind);
  fixed.attempts = l.attempts, fixed.successes = l.successes, fixed.last_session = l.last_session;
  return fixed;
}

slam::Landmark landmark_of(const Fixed& fixed, int last_id, int sessions,
                           const slam::CameraIntrinsics& camera, const auto& require) {
  slam::Landmark l;
  const Eigen::Map<const Eigen::Array<double, 19, 1>> numbers(fixed.X_WC_first);
  const Rows34 X = Eigen::Map<const Rows34>(fixed.X_WC_first);
  require(numbers.allFinite() && numbers.abs().maxCoeff() < 1e6, "has a number that is not finite");
  require((X.leftCols<3>() * X.leftCols<3>().transpose()).isIdentity(1e-6),
          "has a first view without a pose");
  l.X_WC_first.matrix().topRows<3>() = X;
  l.pixel_first = Eigen::Map<const Eigen::Vector2d>(fixed.pixel_first);
  require((l.pixel_first.array() >= 0).all() && l.pixel_first.x() < camera.width_px &&
              l.pixel_first.y() < camera.height_px,
          "has a first pixel outside the image");
  l.tilt = Eigen::Map<const Eigen::Vector2d>(fixed.tilt);
  l.p_WC_inflated = Eigen::Map<const Eigen::Vector3d>(fixed.p_WC_inflated);
  require(fixed.id > last_id && fixed.id < 1 << 30 && (fixed.is_point & ~1) == 0 && fixed.successes >= 0 &&
              fixed.attempts >= 0 && fixed.last_session >= 1 && fixed.last_session <= sessions,
          "has an invalid count");
  if (fixed.is_point == 1) l.kind = slam::Point{};
  l.id = fixed.id, l.attempts = fixed.attempts, l.successes = fixed.successes;
  l.last_session = fixed.last_session;
  return l;
}

/// Returns whether a covariance is finite and positive semidefinite.
bool is_covariance(Eigen::MatrixXd P) {
  const Eigen::VectorXd variances = P.diagonal();
  if (!P.allFinite() || !(variances.minCoeff() > 0)) return false;
  const Eigen::VectorXd scales = variances.cwiseSqrt().cwiseInverse();
  P = scales.asDiagonal() * P * scales.asDiagonal();
  P.diagonal().array() += kRounding;
  return P.llt().info() == Eigen::Success;
}

}  // namespace

std::string map_bytes(const slam::SavedMap& map) {
  const nlohmann::ordered_json header{
      {"format", "gaitslam map"},
      {"version", kVersion},
      {"frame", "world at the start of the first session, z up, gravity along -z"},
      {"sessions", map.sessions},
      {"camera", text_of(map.camera)},
      {"landmarks", map.landmarks.size()},
      {"parameters", map.x.size()}};
  std::string text = files::json_text(header) + "\n";
  for (const slam::Landmark& landmark : map.landmarks) {
    const Fixed fixed = fixed_of(landmark);
    text += bytes_of(&fixed, 1);
    text += bytes_of(landmark.patch.gray.data(), landmark.patch.gray.size());
    text += bytes_of(map.x.data() + landmark.at, std::size_t(landmark.size()));
  }
  for (Eigen::Index column = 0; column < map.P.cols(); ++column)
    text += bytes_of(&map.P(column, column), std::size_t(map.P.rows() - column));
  files::Hash hash;
  hash.add(text);
  return text + hash.hex();
}

slam::SavedMap read_map(const fs::path& file, const slam::CameraIntrinsics& camera) {
  const std::string text = files::read_text(file, files::kMostOfImage);
  const auto require = [&](bool holds, const std::string& problem) {
    if (!holds) throw files::FileError(file, problem);
  };
  require(text.starts_with("{\"format\":\"gaitslam map\"") && text.size() > kHash,
          "is not a map, expected the file map.bin of a result");
  const std::string_view content = std::string_view(text).substr(0, text.size() - kHash);
  files::Hash hash;
  hash.add(content);
  require(text.ends_with(hash.hex()), "edited or truncated: its content differs from the hash at its end");

  const std::size_t line = std::min(content.find('\n'), content.size());
  const files::Json header(file, content.substr(0, line));
  require(header.at("version").whole() == kVersion,
          fmt::format("has another version, expected {}", kVersion));
  require(header.at("camera").text() == text_of(camera),
          fmt::format("was made with another calibration: {}; expected {}", header.at("camera").text(),
                      text_of(camera)));
  const std::uint64_t sessions = header.at("sessions").whole(), landmarks = header.at("landmarks").whole(),
                      parameters = header.at("parameters").whole();
  require(sessions >= 1 && sessions < 1'000'000, "has an invalid number of sessions");
  require(landmarks <= kMostLandmarks && parameters <= 6 * landmarks, "has an invalid number of landmarks");

  slam::SavedMap map{int(sessions), camera, {}, Eigen::VectorXd(parameters), {}};
  std::string_view rest = content.substr(line);
  rest.remove_prefix(std::min<std::size_t>(1, rest.size()));
  Eigen::Index at = 0;
  for (std::uint64_t i = 0; i < landmarks; ++i) {
    const auto require_in = [&](bool holds, const char* problem) {
      require(holds, fmt::format("landmark {} of {} {}", i + 1, landmarks, problem));
    };
    Fixed fixed;
    take(file, rest, &fixed, 1);
    slam::Landmark& l = map.landmarks.emplace_back(
        landmark_of(fixed, i == 0 ? -1 : map.landmarks.back().id, int(sessions), camera, require_in));
    take(file, rest, l.patch.gray.data(), l.patch.gray.size());
    for (const float gray : l.patch.gray) require_in(gray >= 0 && gray <= 255, "has an invalid patch");
    l.at = int(at);
    require_in(at + l.size() <= map.x.size(), "has too many parameters");
    take(file, rest, map.x.data() + at, std::size_t(l.size()));
    const auto y = map.x.segment(at, l.size());
    require_in(y.allFinite() && y.cwiseAbs().maxCoeff() < 1e6, "has a number that is not finite");
    at += l.size();
  }
  const Eigen::Index n = map.x.size();
  require(at == n && rest.size() == std::size_t(n * (n + 1) / 2) * sizeof(double),
          "has a covariance of the wrong size");
  map.P.resize(n, n);
  for (Eigen::Index column = 0; column < n; ++column)
    take(file, rest, &map.P(column, column), std::size_t(n - column));
  map.P = Eigen::MatrixXd(map.P.selfadjointView<Eigen::Lower>());
  require(n == 0 || is_covariance(map.P), "has a covariance that is not positive semidefinite");
  return map;
}

}  // namespace sim::recording
