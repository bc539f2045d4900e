#include "sim/trajectory_score/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "sim/files/json.h"
#include "sim/score/consistency.h"

namespace sim::trajectory_score {
namespace {

namespace fs = std::filesystem;
using files::TimedPose, score::PosePair, score::Stamp, score::Trajectory;
using nlohmann::ordered_json, score::Absent, score::Alignment, score::OrAbsent, score::Similarity,
    score::Spans;

double seconds(Stamp t) { return std::chrono::duration<double>(t).count(); }
Stamp stamp(double seconds) { return Stamp(std::llround(1e9 * seconds)); }

struct NamedFile {
  std::string path;
  files::TrajectoryFile read;

  std::size_t poses() const { return read.rows.size(); }
  double begin_s() const { return seconds(read.rows.front().t); }
  double end_s() const { return seconds(read.rows.back().t); }
  double duration_s() const { return seconds(read.rows.back().t - read.rows.front().t); }
  bool counts_frames() const { return read.stamps == "frame numbers"; }
  // Returns whether all stamps are whole seconds, like frame numbers that were read as seconds.
  bool is_whole() const {
    const auto whole = [](const files::TumRow& row) { return row.t % std::chrono::seconds(1) == Stamp(0); };
    return poses() > 2 && std::ranges::all_of(read.rows, whole);
  }
  Trajectory trajectory() const { return {read.rows.begin(), read.rows.end()}; }
  std::string line() const {
    return fmt::format("{}: {}, {} poses from {:.3f} to {:.3f} s, stamps in {}{}{}", path, read.format,
                       poses(), begin_s(), end_s(), read.stamps,
                       read.has_orientation ? "" : ", positions only",
                       read.warning.empty() ? "" : "; warning: " + read.warning);
  }
  template <class... Arguments>
  [[noreturn]] void fail(fmt::format_string<Arguments...> text, Arguments&&... arguments) const {
    throw files::FileError(path, fmt::format(text, std::forward<Arguments>(arguments)...));
  }
};

// The median time from one pose to the next; 0 for fewer than two.
template <class Poses>
Stamp median_interval(const Poses& poses) {
  std::vector<Stamp> intervals;
  for (std::size_t i = 1; i < poses.size(); ++i) intervals.push_back(poses[i].t - poses[i - 1].t);
  if (intervals.empty()) return Stamp(0);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

constexpr int kGap = 3;  // median intervals
constexpr Stamp kLeastGap = std::chrono::milliseconds(100);

Stamp most_gap(const Trajectory& truth, const PairingOptions& options) {
  return options.most_gap_s ? stamp(*options.most_gap_s) : std::max(kGap * median_interval(truth), kLeastGap);
}

Coverage coverage_of(const Trajectory& truth, const std::vector<PosePair>& pairs) {
  const Stamp of_truth = median_interval(truth), of_pairs = std::max(median_interval(pairs), of_truth),
              gap = std::max(kGap * of_pairs, kLeastGap), whole = truth.back().t - truth.front().t + of_truth;
  Stamp covered = of_pairs;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const Stamp interval = pairs[i].t - pairs[i - 1].t;
    covered += interval <= gap ? interval : of_pairs;
  }
  Trajectory walked;
  for (const TimedPose& pose : truth)
    if (pose.t >= pairs.front().t - of_truth / 2 && pose.t <= pairs.back().t + of_truth / 2)
      walked.push_back(pose);
  const double fraction = whole.count() == 0 ? 1 : seconds(covered) / seconds(whole);
  return {truth.size(), std::min(1.0, fraction), score::path_length(walked)};
}

// "; with --t-offset ..." if the offset of a known clock pairs more poses: results start at 0, their exports
// at 1e9 s, other trajectories perhaps both at their first pose.
std::string offset_hint(const Trajectory& truth, const Trajectory& estimate, Stamp apart,
                        std::size_t most_pairs) {
  constexpr Stamp kEpoch = std::chrono::seconds(1'000'000'000);
  std::string hint;
  for (const Stamp offset : {Stamp(0), -kEpoch, kEpoch, truth.front().t - estimate.front().t}) {
    const std::size_t pairs = score::pair_by_nearest(truth, estimate, apart, offset).size();
    if (pairs <= most_pairs) continue;
    most_pairs = pairs;
    hint = fmt::format("; with --t-offset {} {} of its poses have a true one", seconds(offset), pairs);
  }
  return hint;
}

// Throws std::invalid_argument with the reason and the option that may help if no poses are paired, or only
// an instant of two trajectories that both last much longer.
void require_pairs(const NamedFile& truth, const NamedFile& estimate, const std::vector<PosePair>& pairs,
                   const PairingOptions& options) {
  constexpr double kMuchLonger = 100;
  const double paired_s = pairs.empty() ? 0 : seconds(pairs.back().t - pairs.front().t),
               begin_s = estimate.begin_s() + options.offset_s, end_s = estimate.end_s() + options.offset_s;
  if (!pairs.empty() && paired_s * kMuchLonger >= std::min(truth.duration_s(), estimate.duration_s())) return;
  std::string why = fmt::format("{} of {} estimated poses have a true one", pairs.size(), estimate.poses());
  if (!pairs.empty()) why += fmt::format(", over {:.3f} s", paired_s);
  const Trajectory of_truth = truth.trajectory();
  if (!pairs.empty() || begin_s > truth.end_s() || end_s < truth.begin_s())
    why +=
        fmt::format(": the truth is from {:.3f} to {:.3f} s, the estimate from {:.3f} to {:.3f} s{}",
                    truth.begin_s(), truth.end_s(), begin_s, end_s,
                    offset_hint(of_truth, estimate.trajectory(), stamp(options.most_apart_s), pairs.size()));
  else if (options.interpolate)
    why += fmt::format(": true poses around them are more than {} s apart (--max-gap)",
                       seconds(most_gap(of_truth, options)));
  else
    why += fmt::format(": no stamps nearer than {} s (--t-max-diff)", options.most_apart_s);
  throw std::invalid_argument(why);
}

// Returns whether the poses last much shorter than the others, and not because they are fewer.
bool lasts_much_shorter(const NamedFile& file, const NamedFile& other) {
  constexpr double kMuch = 50;  // a minute has 60 seconds
  if (file.poses() < 2 || other.poses() < 2) return false;
  const auto interval_s = [](const NamedFile& f) {
    return f.duration_s() / static_cast<double>(f.poses() - 1);
  };
  return kMuch * file.duration_s() <= other.duration_s() && kMuch * interval_s(file) <= interval_s(other);
}

// Throws FileError if the stamps of only one file are frame numbers, or if the units differ. Whole numbers
// may be times once a second, unless they last much longer than the other file with about as many poses.
void require_times(const NamedFile& file, const NamedFile& other, const PairingOptions& options) {
  if (file.counts_frames() && !other.counts_frames())
    file.fail("its stamps are frame numbers, those of {} are times in {}{}", other.path, other.read.stamps,
              file.read.format == "KITTI" ? "; times.txt beside it has the times" : "");
  if (!file.is_whole() && !other.is_whole() && lasts_much_shorter(file, other))
    file.fail("its {} poses last {:.3f} s, the {} of {} last {:.3f} s: their stamps are not in the same unit",
              file.poses(), file.duration_s(), other.poses(), other.path, other.duration_s());
  if (!options.interpolate && file.is_whole() && !other.is_whole() &&
      file.duration_s() > 1.5 * other.duration_s() && 2 * other.poses() > file.poses())
    file.fail(
        "its stamps are whole numbers up to {}, as frame numbers are, those of {} are times over {:.3f} s; "
        "with --interpolate they are taken for seconds",
        file.read.rows.back().t / std::chrono::seconds(1), other.path, other.duration_s());
}

// Throws FileError if nothing moves: errors of such positions are meaningless.
void require_motion(const NamedFile& file, const std::vector<PosePair>& pairs,
                    Eigen::Isometry3d PosePair::*pose) {
  constexpr double kStill_m = 1e-9;
  const Eigen::Vector3d first = (pairs.front().*pose).translation();
  const auto is_there = [&](const PosePair& pair) {
    return ((pair.*pose).translation() - first).norm() <= kStill_m;
  };
  if (pairs.size() > 1 && std::ranges::all_of(pairs, is_there))
    file.fail("all {} matched poses coincide", pairs.size());
}

// need_motion: positions are compared.
PairedFiles pair_files(const fs::path& truth, const fs::path& estimate, const PairingOptions& options,
                       bool need_motion) {
  const NamedFile a{truth.string(), files::read_trajectory(truth)},
      b{estimate.string(), files::read_trajectory(estimate)};
  require_times(a, b, options);
  require_times(b, a, options);
  const bool by_row =
      a.counts_frames() && b.counts_frames() && (a.read.format == "KITTI" || b.read.format == "KITTI");
  if (by_row && a.poses() != b.poses())
    b.fail(
        "has {} poses and {} has {}, all without times: they cannot be paired by their row; times.txt beside "
        "a KITTI file has the times",
        b.poses(), a.path, a.poses());
  for (const double t : {a.begin_s(), a.end_s(), b.begin_s(), b.end_s()})  // their sum must not overflow
    if (options.offset_s != 0 && !(std::abs(options.offset_s) + std::abs(t) < 4e9))
      throw std::invalid_argument(
          fmt::format("--t-offset {}: with it a stamp is beyond 4e9 s", options.offset_s));
  const Trajectory of_truth = a.trajectory();
  Trajectory of_estimate = b.trajectory();
  for (TimedPose& pose : of_estimate) pose.t += stamp(options.offset_s);
  const std::vector<PosePair> pairs =
      options.interpolate ? score::pair_by_interpolation(of_truth, of_estimate, most_gap(of_truth, options))
                          : score::pair_by_nearest(of_truth, of_estimate, stamp(options.most_apart_s));
  require_pairs(a, b, pairs, options);
  if (need_motion) {
    require_motion(a, pairs, &PosePair::X_true);
    require_motion(b, pairs, &PosePair::X_estimate);
  }
  const std::string pairing =
      !options.interpolate ? fmt::format("nearest stamp within {} s", options.most_apart_s)
                           : fmt::format("truth interpolated at the estimate's stamps, across at most {} s",
                                         seconds(most_gap(of_truth, options)));
  return {a.line(),
          b.line(),
          pairing,
          pairs,
          coverage_of(of_truth, pairs),
          b.read,
          a.read.has_orientation && b.read.has_orientation};
}

double of_difference(const Eigen::Isometry3d& E, Relation relation) {
  switch (relation) {
    case Relation::trans_part:
    case Relation::point_distance:
      return E.translation().norm();
    case Relation::angle_deg:
      return score::rotation_vector(E.linear()).norm() * 180 / std::numbers::pi;
    case Relation::angle_rad:
      return score::rotation_vector(E.linear()).norm();
    case Relation::rot_part:
      return (E.linear() - Eigen::Matrix3d::Identity()).norm();
    case Relation::full:
      return (E.matrix() - Eigen::Matrix4d::Identity()).norm();
  }
  return 0;
}

ErrorStatistics describe(const std::vector<double>& errors) {
  const double m = score::mean(errors), rmse = score::root_mean_square(errors);
  std::vector<double> deviations;
  for (const double error : errors) deviations.push_back(error - m);
  const auto quantile = [&](double p) { return score::quantile(errors, p); };
  const double std = score::root_mean_square(deviations), n = static_cast<double>(errors.size());
  return {errors.size(),  rmse,           m, quantile(0.5), std, quantile(0), quantile(1), quantile(0.95),
          quantile(0.99), rmse * rmse * n};
}

std::string unit(Relation relation) {
  static constexpr std::array<const char*, 6> kUnits{"m", "deg", "rad", "1", "1", "m"};
  return kUnits[static_cast<std::size_t>(relation)];
}

Row row(const std::string& name, const std::string& unit, const std::vector<double>& errors,
        const std::string& why_none = "") {
  if (errors.empty()) return {name, unit, Absent{why_none}};
  if (!std::ranges::all_of(errors, [](double error) { return std::isfinite(error); }))
    return {name, unit, Absent{"a value is not finite"}};
  return {name, unit, describe(errors)};
}

// The alignment of the first poses_to_align pairs.
OrAbsent<Similarity> align_first(const std::vector<PosePair>& pairs, Alignment alignment,
                                 const Options& options) {
  const std::size_t count = options.poses_to_align;
  if (count == 0 || count >= pairs.size()) return score::align(pairs, alignment);
  return score::align({pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(count)}, alignment);
}

// The errors of poses that are aligned already.
Row aligned_row(const std::vector<PosePair>& pairs, Alignment alignment, Relation relation) {
  std::vector<double> errors;
  for (const PosePair& pair : pairs)
    errors.push_back(of_difference(pair.X_true.inverse() * pair.X_estimate, relation));
  return row("APE " + name_of(alignment), unit(relation), errors);
}

Row pose_row(const std::vector<PosePair>& pairs, Alignment alignment, const Options& options) {
  const auto found = align_first(pairs, alignment, options);
  if (const auto* const absent = std::get_if<Absent>(&found))
    return {"APE " + name_of(alignment), unit(options.relation), *absent};
  return aligned_row(transformed(std::get<Similarity>(found), pairs), alignment, options.relation);
}

Row motion_row(const std::vector<PosePair>& pairs, const Spans& which, Relation relation) {
  static constexpr std::array<std::string_view, 5> kUnits{"frames", "m", "s", "rad", "deg"};
  const std::string name =
      fmt::format("RPE {} {}{}", which.delta, kUnits[static_cast<std::size_t>(which.unit)],
                  which.all ? " (from each pose)" : "");
  std::vector<double> errors;
  for (const score::Span& span : score::spans(pairs, which)) {
    const PosePair &a = pairs[span.from], &b = pairs[span.to];
    const auto distance = [&](Eigen::Isometry3d PosePair::*pose) {
      return ((b.*pose).translation() - (a.*pose).translation()).norm();
    };
    errors.push_back(relation == Relation::point_distance
                         ? std::abs(distance(&PosePair::X_true) - distance(&PosePair::X_estimate))
                         : of_difference(score::relative_difference(pairs, span), relation));
  }
  return row(name, unit(relation), errors, "the path has no such spans");
}

// NEES without alignment, of the matched estimates that have a covariance.
std::vector<Row> nees_rows(const std::vector<PosePair>& pairs, const files::TrajectoryFile& estimate,
                           score::Stamp offset) {
  std::vector<double> position, orientation;
  for (const PosePair& pair : pairs) {
    const auto at = std::ranges::lower_bound(estimate.rows, pair.t - offset, {}, &files::TumRow::t);
    if (at == estimate.rows.end() || !at->covariance) continue;
    const auto nees = score::pose_nees(pair.X_true, pair.X_estimate, *at->covariance);
    if (!nees) return {{"NEES none", "1", Absent{"a covariance is not positive definite"}}};
    position.push_back(nees->position);
    orientation.push_back(nees->orientation);
  }
  if (position.empty()) return {};
  return {row("NEES none, position", "1", position), row("NEES none, orientation", "1", orientation)};
}

// The rows of a report without options: every alignment, and relative errors over the usual spans.
void add_overview(Report& report, const std::vector<PosePair>& pairs, const Options& options) {
  for (const Alignment alignment :
       {Alignment::origin, Alignment::yaw_position, Alignment::se3, Alignment::sim3, Alignment::scale})
    report.rows.push_back(pose_row(pairs, alignment, options));
  Options turning = options;
  turning.relation = Relation::angle_deg;
  report.rows.push_back(pose_row(pairs, Alignment::none, turning));
  std::vector<Spans> usual{{Spans::Unit::seconds, 1, true}};
  for (const double length : {4.0, 2.0, 1.0, 0.5, 0.25})
    usual.insert(usual.begin(), {Spans::Unit::meters, length, true, 0.1, true});
  for (const Spans& which : usual)
    for (const Relation relation : {options.relation, Relation::angle_deg})
      report.rows.push_back(motion_row(pairs, which, relation));
}

std::string line(const Row& row) {
  const std::string name = fmt::format("{} [{}]", row.name, row.unit);
  if (const auto* const absent = std::get_if<Absent>(&row.statistics))
    return fmt::format("{:<33} {}\n", name, absent->reason);
  const auto& s = std::get<ErrorStatistics>(row.statistics);
  return fmt::format("{:<33} {:>5} {:>9.5g} {:>9.5g} {:>9.5g} {:>9.5g}\n", name, s.n, s.rmse, s.median, s.p95,
                     s.max);
}

}  // namespace

fs::path trajectory_in(const fs::path& path, bool truth) {
  if (!fs::is_directory(path)) return path;
  for (const char* name : {"truth.tum", "estimate_cov.txt", "estimate.tum"})
    if (truth == (name[0] == 't') && fs::exists(path / name)) return path / name;
  throw files::FileError(path, truth ? "is not a result folder: it has no truth.tum"
                                     : "is not a result folder with an estimate: it has no estimate.tum");
}

// Marks the errors that positions do not determine. Throws std::invalid_argument for the requested.
void require_orientation(std::vector<Row>& rows, Relation relation) {
  for (Row& row : rows) {
    const bool motion = row.name.starts_with("RPE") && relation != Relation::point_distance;
    if (row.unit == "m" && !motion && row.name != "APE origin") continue;
    row.statistics = Absent{"a file has positions only"};
    if (&row == &rows.front())
      throw std::invalid_argument(
          fmt::format("{}: it needs orientations, but a file has positions only", row.name));
  }
}

Report score_files(const fs::path& truth, const fs::path& estimate, const Options& options) {
  const Relation relation = options.relation;
  const bool of_orientation =
      !options.alignment &&
      (relation == Relation::angle_deg || relation == Relation::angle_rad || relation == Relation::rot_part);
  Report report{pair_files(truth, estimate, options.pairing, !of_orientation), {}, {}, {}};
  const std::vector<PosePair>& paired = report.files.pairs;
  const Alignment alignment = options.alignment.value_or(Alignment::none);
  const auto found = align_first(paired, alignment, options);
  if (const auto* const absent = std::get_if<Absent>(&found))
    throw std::invalid_argument(fmt::format("--align {}: {}", name_of(alignment), absent->reason));
  report.similarity = std::get<Similarity>(found), report.alignment = name_of(alignment);
  const auto pairs = transformed(report.similarity, paired);
  if (options.relative) {
    report.rows = {motion_row(pairs, *options.relative, relation)};
    if (score::spans(pairs, *options.relative).empty())
      throw std::invalid_argument(report.rows.front().name + ": the path has no such spans");
  } else {
    report.rows = {aligned_row(pairs, alignment, relation)};
    if (!options.alignment) add_overview(report, paired, options);
  }
  if (!report.files.has_orientation)
    require_orientation(report.rows, relation);
  else
    for (const Row& nees : nees_rows(paired, report.files.estimate_file, stamp(options.pairing.offset_s)))
      report.rows.push_back(nees);
  return report;
}

std::string table(const Report& r) {
  const auto& [truth, estimate, pairing, pairs, coverage, file, has_orientation] = r.files;
  std::string text = fmt::format(
      "truth     {}\nestimate  {}\nmatched   {} of {} poses ({})\n"
      "covered   {} of {} true poses, {:.1f} % of the time; {:.3f} m walked between the first and the last\n"
      "alignment {}",
      truth, estimate, pairs.size(), file.rows.size(), pairing, std::min(pairs.size(), coverage.true_poses),
      coverage.true_poses, 100 * coverage.time_fraction, coverage.walked_m, r.alignment);
  text += r.similarity.scale == 1 ? "\n\n" : fmt::format(", scale {:.6f}\n\n", r.similarity.scale);
  text += fmt::format("{:<33} {:>5} {:>9} {:>9} {:>9} {:>9}\n", "error", "n", "rmse", "median", "p95", "max");
  for (const Row& row : r.rows) text += line(row);
  return text;
}

std::string json_text(const Report& r) {
  ordered_json json{{"truth", r.files.truth},
                    {"estimate", r.files.estimate},
                    {"poses_matched", r.files.pairs.size()},
                    {"poses", r.files.estimate_file.rows.size()},
                    {"true_poses", r.files.coverage.true_poses},
                    {"time_fraction", r.files.coverage.time_fraction},
                    {"pairing", r.files.pairing},
                    {"path_length_m", r.files.coverage.walked_m},
                    {"alignment", r.alignment},
                    {"scale", r.similarity.scale}};
  json["errors"] = ordered_json::array();
  for (const Row& row : r.rows) {
    ordered_json entry{{"error", row.name}, {"unit", row.unit}, {"n", 0}};
    if (const auto* const s = std::get_if<ErrorStatistics>(&row.statistics)) {
      using S = ErrorStatistics;
      entry["n"] = s->n;
      for (const auto& [name, member] : {std::pair{"rmse", &S::rmse},
                                         {"mean", &S::mean},
                                         {"median", &S::median},
                                         {"std", &S::std},
                                         {"min", &S::min},
                                         {"max", &S::max},
                                         {"p95", &S::p95},
                                         {"p99", &S::p99},
                                         {"sse", &S::sse}})
        entry[name] = s->*member;
    } else {
      entry["reason"] = std::get<Absent>(row.statistics).reason;
    }
    json["errors"].push_back(entry);
  }
  return files::json_text(json, 2) + "\n";
}

}  // namespace sim::trajectory_score
