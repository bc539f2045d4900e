#include "sim/view/result_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/files/file_error.h"
#include "sim/files/number.h"
#include "sim/files/tum.h"

namespace sim::view {
namespace {

namespace fs = std::filesystem;
using pages::Table;

slam::Stamp stamp_of(const std::string& field, const fs::path& file) {
  const auto ns = files::parse_number<std::int64_t>(field);
  if (!ns) throw files::FileError(file, fmt::format("'{}' is no time stamp", field));
  return slam::Stamp(*ns);
}

/// The frames by their stamps.
class Timeline {
 public:
  explicit Timeline(std::vector<Frame>& frames) : frames_(frames) {}

  Frame* at(slam::Stamp t) {
    const auto found = std::lower_bound(frames_.begin(), frames_.end(), t,
                                        [](const Frame& f, slam::Stamp s) { return f.t < s; });
    return found != frames_.end() && found->t == t ? &*found : nullptr;
  }

 private:
  std::vector<Frame>& frames_;
};

std::vector<Frame> frames_at(const std::vector<files::TumRow>& truth) {
  std::vector<Frame> frames(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) frames[i].t = truth[i].t, frames[i].truth = truth[i].X;
  return frames;
}

void add_plan(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  for (const files::TumRow& row : files::read_tum(file))
    if (Frame* const frame = frames.at(row.t)) frame->plan = row.X;
}

void add_estimate(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  for (const files::TumRow& row : files::read_tum(file))
    if (Frame* const frame = frames.at(row.t)) frame->estimate = row.X, frame->covariance = row.covariance;
}

slam::Health health_of(const std::string& name) {
  return name == "lost" ? slam::Health::lost : name == "diverged" ? slam::Health::diverged : slam::Health::ok;
}

void add_reports(Timeline& frames, const fs::path& folder, const Table& table) {
  const auto &t = table.text("timestamp"), &health = table.text("health"), &cause = table.text("cause"),
             &refused = table.text("refused"), &suspect = table.text("suspect");
  const auto landmarks = table.numbers("landmarks");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(stamp_of(t[i], folder / "frames.csv"));
    if (!frame) continue;
    slam::FrameReport report;
    report.t = frame->t;
    report.landmarks = landmarks[i] >= 0 && landmarks[i] < 1e6 ? static_cast<int>(landmarks[i]) : 0;
    report.health = health_of(health[i]);
    report.cause = cause[i], report.refused = refused[i], report.suspect = suspect[i];
    frame->report = report;
  }
}

// Recordings of earlier versions do not say where a match was refused.
std::vector<double> numbers_if_there(const Table& table, const char* column) {
  return table.has(column) ? table.numbers(column) : std::vector<double>(table.rows(), NAN);
}

void add_searches(Timeline& frames, const fs::path& folder, const Table& table) {
  const auto& t = table.text("timestamp");
  const auto landmark = table.numbers("landmark"), u = table.numbers("u"), v = table.numbers("v"),
             uu = table.numbers("S_uu"), uv = table.numbers("S_uv"), vv = table.numbers("S_vv"),
             found_u = table.numbers("found_u"), found_v = table.numbers("found_v"),
             refused_u = numbers_if_there(table, "refused_u"),
             refused_v = numbers_if_there(table, "refused_v");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(stamp_of(t[i], folder / "searches.csv"));
    if (!frame || !frame->report || !(std::abs(landmark[i]) < 1e9)) continue;
    slam::Search search{static_cast<int>(landmark[i]), {u[i], v[i]}, Eigen::Matrix2d::Zero()};
    search.S << uu[i], uv[i], uv[i], vv[i];
    if (!search.S.allFinite() || !search.pixel.allFinite()) continue;
    search.used = std::isfinite(found_u[i]);
    if (search.used) search.match = {found_u[i], found_v[i]};
    if (std::isfinite(refused_u[i])) search.match = {refused_u[i], refused_v[i]};
    frame->report->searched.push_back(search);
  }
}

void add_begun(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  const Table table(file);
  const auto& begun = table.text("begun");
  const auto u = table.numbers("u"), v = table.numbers("v");
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (Frame* const frame = frames.at(stamp_of(begun[i], file));
        frame && frame->report && std::isfinite(u[i] + v[i]))
      frame->report->initialised.push_back({0, {u[i], v[i]}});
}

void add_maps(Timeline& frames, const fs::path& folder, const Table& table) {
  constexpr std::array kColumns{"p_W_x", "p_W_y", "p_W_z", "P_xx", "P_xy", "P_xz", "P_yy", "P_yz", "P_zz"};
  const auto& t = table.text("timestamp");
  const auto id = table.numbers("id");
  std::vector<std::vector<double>> c;
  for (const char* const column : kColumns) c.push_back(table.numbers(column));
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(stamp_of(t[i], folder / "map_over_time.csv"));
    if (!frame || !(std::abs(id[i]) < 1e9)) continue;
    slam::MapPoint point;
    point.id = static_cast<int>(id[i]);
    point.p_W = {c[0][i], c[1][i], c[2][i]};
    point.covariance << c[3][i], c[4][i], c[5][i], c[4][i], c[6][i], c[7][i], c[5][i], c[7][i], c[8][i];
    if (!point.p_W.allFinite() || !point.covariance.allFinite()) continue;
    if (!frame->map) frame->map.emplace();
    frame->map->push_back(point);
  }
}

}  // namespace

std::vector<Frame> read_result_frames(const fs::path& result, const pages::RunData& data) {
  std::vector<Frame> all = frames_at(files::read_tum(result / "truth.tum"));
  if (all.empty()) throw files::FileError(result / "truth.tum", "has no pose, expected one of each frame");
  Timeline frames(all);
  add_plan(frames, result / "plan.tum");
  add_estimate(frames, result / "estimate_cov.txt");
  if (data.frames) add_reports(frames, result, *data.frames);
  if (data.searches) add_searches(frames, result, *data.searches);
  add_begun(frames, result / "landmarks.csv");
  if (data.maps) add_maps(frames, result, *data.maps);
  return all;
}

}  // namespace sim::view
