#include "sim/trajectory_score/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "sim/files/table.h"

namespace sim::trajectory_score {
namespace {

using files::TimedPose, nlohmann::ordered_json, score::Absent, score::Alignment, score::kDegree,
    score::OrAbsent, score::PosePair, score::Similarity, score::Spans, score::Stamp, score::Trajectory;

constexpr double kDecisive = 5, kLeast_m = 1e-3, kSameUnit = 0.1,
                 kNone = std::numeric_limits<double>::infinity();

/// Two trajectories, their pairs, and how these are aligned.
struct Compared {
  const files::TrajectoryFile& truth;
  const files::TrajectoryFile& estimate;
  const std::vector<score::PosePair>& pairs;
  score::Stamp most_gap, offset;  ///< between two true poses; added to the estimate's stamps
  score::Alignment alignment;     ///< se3 in place of none and origin, sim3 in place of scale
};

/// A change of the estimate with the option that applies it, and the errors before and after it.
struct Change {
  std::string words;
  double before, after;
  const char* unit = "m";
  double cut() const { return before < kNone ? before / std::max(after, 1e-12) : 0; }
};

double error_m(const std::vector<PosePair>& pairs, Alignment alignment) {
  const auto found = score::align(pairs, alignment);
  const auto* const S = std::get_if<Similarity>(&found);
  return S ? score::root_mean_square(score::position_errors(score::transformed(*S, pairs))) : kNone;
}

/// Tries offsets of a few hundred poses, every 0.1 s, then closer ones around the best.
Change clock_offset(const Compared& c, Alignment alignment) {
  const score::Trajectory truth(c.truth.rows.begin(), c.truth.rows.end());
  score::Trajectory estimate;
  for (std::size_t i = 0; i < c.estimate.rows.size(); i += c.estimate.rows.size() / 400 + 1)
    estimate.push_back(c.estimate.rows[i]);
  const auto pairs_at = [&](Stamp offset) {
    score::Trajectory shifted = estimate;
    for (files::TimedPose& pose : shifted) pose.t += offset;
    return score::pair_by_interpolation(truth, shifted, c.most_gap);
  };
  const auto as_stated = pairs_at(c.offset);
  const std::size_t enough = std::max<std::size_t>(as_stated.size() * 4 / 5, 10);
  Change change{"", error_m(as_stated, alignment), kNone};
  Stamp best = c.offset;
  double least = kNone;  // error per pair, since laps repeat themselves
  for (const auto& [step_ms, steps] : {std::pair(100, 400), {10, 10}, {1, 10}}) {
    const Stamp middle = best;
    for (int i = -steps; i <= steps; ++i) {
      const Stamp offset = middle + std::chrono::milliseconds(i * step_ms);
      const auto pairs = pairs_at(offset);
      const double error = pairs.size() < enough ? kNone : error_m(pairs, alignment);
      if (const double each = error / double(pairs.size()); each < least)
        least = each, change.after = error, best = offset;
    }
  }
  change.words = fmt::format("the clocks differ; --t-offset {:.3f}", 1e-9 * double(best.count()));
  return change;
}

/// Returns the option that names the columns of a file with each position's name changed.
std::string columns(const char* option, const files::TrajectoryFile& file, auto changed) {
  std::vector<std::string> names = file.columns;
  if (names.empty()) return "correcting its file";  // KITTI
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::string& name = names[file.position[axis]];
    name = changed(axis, name);
  }
  return fmt::format("{} \"{}\"", option, fmt::join(names, " "));
}

Change scaled(const Compared& c, Alignment alignment, const Eigen::Vector3d& factors,
              const std::string& words) {
  std::vector<PosePair> pairs = c.pairs;
  for (PosePair& pair : pairs) pair.X_estimate.translation().array() *= factors.array();
  return {words, error_m(c.pairs, alignment), error_m(pairs, alignment)};
}

Change mirror(const Compared& c, Alignment alignment) {
  const auto option = columns("--columns", c.estimate, [](std::size_t axis, const std::string& name) {
    return axis != 1 ? name : name[0] == '-' ? name.substr(1) : "-" + name;
  });
  return scaled(c, alignment, {1, -1, 1}, "its y axis is mirrored; " + option);
}

/// factor: from the estimate's unit to the truth's.
Change unit(const Compared& c, Alignment alignment, double factor) {
  const auto in_mm = [](std::size_t, const std::string& name) {
    return name.substr(0, name.find('[')) + "[mm]";
  };
  const std::string option = factor == 1e-3   ? columns("--columns", c.estimate, in_mm)
                             : factor == 1000 ? columns("--truth-columns", c.truth, in_mm)
                                              : "--align sim3";
  return scaled(c, alignment, Eigen::Vector3d::Constant(factor),
                fmt::format("its positions are {:.4g} times the true ones; {}", 1 / factor, option));
}

/// Removes the rotation common to R_true^T R_estimate of all pairs, and returns it.
Eigen::Vector3d take_off_turn(std::vector<PosePair>& pairs) {
  Eigen::Matrix3d turn = pairs[0].X_true.linear().transpose() * pairs[0].X_estimate.linear();
  for (int i = 0; i < 5; ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& [t, X_true, X_estimate] : pairs)
      sum += score::rotation_vector(turn.transpose() * X_true.linear().transpose() * X_estimate.linear());
    turn *= Eigen::AngleAxisd(sum.norm() / double(pairs.size()), sum.stableNormalized()).toRotationMatrix();
  }
  for (PosePair& pair : pairs) pair.X_estimate.linear() *= turn.transpose();
  return score::rotation_vector(turn) / kDegree;
}

/// Positions on a line do not determine the alignment's turn about it, so the smallest error of several turns
/// counts.
Change body_turn(const Compared& c) {
  Change change{"", kNone, kNone, "deg"};
  for (const Alignment alignment : {Alignment::none, Alignment::yaw_position, Alignment::se3}) {
    const auto found = score::align(c.pairs, alignment);
    const auto* const S = std::get_if<Similarity>(&found);
    if (!S) continue;
    std::vector<PosePair> pairs = score::transformed(*S, c.pairs);
    const auto error = [&] { return score::root_mean_square(score::orientation_errors(pairs)) / kDegree; };
    change.before = std::min(change.before, error());
    const Eigen::Vector3d turn = take_off_turn(pairs);
    if (error() >= change.after) continue;
    change.after = turn.norm() < 1 ? change.before : error();
    change.words = fmt::format("the bodies are turned by {:.4g} deg; --turn-body {:.2f},{:.2f},{:.2f}",
                               turn.norm(), turn.x(), turn.y(), turn.z());
  }
  return change;
}

/// Returns a sentence on the change that cuts the error of positions (after the alignment) or of
/// orientations most, at least fivefold, and the option that applies it: a clock offset up to 40 s, a
/// constant turn between the two bodies, a mirrored axis, or positions in other units. Nothing if none does.
std::optional<std::string> diagnosis(const Compared& c) {
  Alignment alignment = c.alignment;
  if (alignment <= Alignment::origin) alignment = Alignment::se3;
  if (alignment == Alignment::scale) alignment = Alignment::sim3;
  std::vector<Change> changes;
  if (c.truth.has_orientation && c.estimate.has_orientation) changes.push_back(body_turn(c));
  if (const double error = error_m(c.pairs, alignment); error >= kLeast_m && error < kNone) {
    changes.push_back(clock_offset(c, alignment));
    changes.push_back(mirror(c, alignment));
    const auto found = score::align(c.pairs, Alignment::sim3);
    const auto* const S = std::get_if<Similarity>(&found);
    for (const double factor : {1000., 1e-3, 1 / kDegree, kDegree})
      if (S && std::abs(S->scale / factor - 1) < kSameUnit) changes.push_back(unit(c, alignment, factor));
  }
  const auto best = std::ranges::max_element(changes, {}, &Change::cut);
  if (best == changes.end() || best->cut() < kDecisive) return std::nullopt;
  const auto& [words, before, after, of] = *best;
  return fmt::format("{} cuts the error from {:.3g} to {:.3g} {}", words, before, after, of);
}

double seconds(Stamp t) { return std::chrono::duration<double>(t).count(); }
Stamp stamp(double seconds) { return Stamp(std::llround(1e9 * seconds)); }

struct NamedFile {
  std::string path;
  files::TrajectoryFile read;

  std::size_t poses() const { return read.rows.size(); }
  double begin_s() const { return seconds(read.rows.front().t); }
  double end_s() const { return seconds(read.rows.back().t); }
  double duration_s() const { return seconds(read.rows.back().t - read.rows.front().t); }
  Trajectory trajectory() const { return {read.rows.begin(), read.rows.end()}; }
  std::string line() const {
    const std::string format =
        read.columns.empty() ? "KITTI" : fmt::format("{}", fmt::join(read.columns, " "));
    return fmt::format("{}: {}, {} poses from {:.3f} to {:.3f} s{}{}", path, format, poses(), begin_s(),
                       end_s(), read.counts_frames ? ", stamps are frame numbers" : "",
                       read.warning ? "; warning: " + *read.warning : "");
  }
  template <class... Arguments>
  [[noreturn]] void fail(fmt::format_string<Arguments...> text, Arguments&&... arguments) const {
    throw files::FileError(path, text, std::forward<Arguments>(arguments)...);
  }
};

template <class Poses>
Stamp median_step(const Poses& poses) {
  std::vector<Stamp> stamps;
  for (const auto& pose : poses) stamps.push_back(pose.t);
  return files::median_step(stamps);
}

constexpr int kGap = 3;  // median intervals
constexpr Stamp kLeastGap = std::chrono::milliseconds(100);

Stamp most_gap(const Trajectory& truth, const PairingOptions& options) {
  return options.most_gap_s ? stamp(*options.most_gap_s) : std::max(kGap * median_step(truth), kLeastGap);
}

// Adds how much of the truth the pairs cover: each pair covers the time until the next, unless that is a gap.
// Returns the length (m) of the truth from the first to the last pair.
double add_coverage(ordered_json& report, const Trajectory& truth, const std::vector<PosePair>& pairs) {
  const Stamp of_truth = median_step(truth), of_pairs = std::max(median_step(pairs), of_truth),
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
  report["true_poses"] = truth.size();
  report["time_fraction"] = std::min(1.0, fraction);
  return score::path_length(walked);
}

// Returns "; with --t-offset ..." if a clock offset that is common in practice pairs more poses. Results
// start at 0, their exports at 1e9 s; other trajectories may both start at their first pose.
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

// Throws std::invalid_argument, with the reason and an option that may help, if no poses are paired, or only
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
    why += fmt::format(": no stamps within {} s (--t-max-diff)", options.most_apart_s);
  throw std::invalid_argument(why);
}

// Throws FileError if the stamps of only one file are frame numbers, or if one file has about as many
// poses as the other but lasts much longer.
void require_times(const NamedFile& file, const NamedFile& other) {
  constexpr double kMuch = 9;
  if (file.read.counts_frames && !other.read.counts_frames)
    file.fail("its stamps are frame numbers, but {} has times; write times.txt next to it", other.path);
  if (2 * other.poses() > file.poses() && 2 * file.poses() > other.poses() && other.duration_s() > 0 &&
      file.duration_s() > kMuch * other.duration_s())
    file.fail(
        "its {} poses last {:.3f} s, the {} of {} last {:.3f} s: the stamps of one are in another unit or "
        "are "
        "frame numbers; the unit is stated as in --columns \"t[ms] x y z\"",
        file.poses(), file.duration_s(), other.poses(), other.path, other.duration_s());
}

// Throws FileError if nothing moves, because errors of such positions are meaningless.
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
std::vector<PosePair> paired(const NamedFile& a, const NamedFile& b, const PairingOptions& options,
                             bool need_motion) {
  require_times(a, b);
  require_times(b, a);
  if (a.read.counts_frames && b.read.counts_frames && a.poses() != b.poses())
    b.fail(
        "has {} poses and {} has {}, all without times, so they cannot be paired by row; write times.txt "
        "next to a KITTI file",
        b.poses(), a.path, a.poses());
  for (const double t : {a.begin_s(), a.end_s(), b.begin_s(), b.end_s()})  // their sum must not overflow
    if (options.offset_s != 0 && !(std::abs(options.offset_s) + std::abs(t) < 4e9))
      throw std::invalid_argument(
          fmt::format("--t-offset {}: this moves a stamp beyond 4e9 s", options.offset_s));
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
  return pairs;
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

std::string unit(Relation relation) {
  static constexpr std::array<const char*, 6> kUnits{"m", "deg", "rad", "1", "1", "m"};
  return kUnits[std::size_t(relation)];
}

// One entry of the report: statistics of the errors, or why they are absent.
ordered_json row(const std::string& name, const std::string& unit, const std::vector<double>& errors,
                 const std::string& why_none = "") {
  ordered_json row{{"error", name}, {"unit", unit}, {"n", 0}};
  const bool finite = std::ranges::all_of(errors, [](double error) { return std::isfinite(error); });
  if (errors.empty() || !finite) {
    row["reason"] = finite ? why_none : "a value is not finite";
    return row;
  }
  const double mean = score::mean(errors), rmse = score::root_mean_square(errors);
  std::vector<double> deviations;
  for (const double error : errors) deviations.push_back(error - mean);
  row["n"] = errors.size(), row["rmse"] = rmse, row["mean"] = mean;
  row["median"] = score::median(errors), row["std"] = score::root_mean_square(deviations);
  for (const auto& [of, p] : {std::pair{"min", 0.0}, {"max", 1.0}, {"p95", 0.95}, {"p99", 0.99}})
    row[of] = score::quantile(errors, p);
  row["sse"] = rmse * rmse * double(errors.size());
  return row;
}

// Aligns the first poses_to_align pairs.
OrAbsent<Similarity> align_first(const std::vector<PosePair>& pairs, Alignment alignment,
                                 const Options& options) {
  const std::size_t count = options.poses_to_align;
  if (count == 0 || count >= pairs.size()) return score::align(pairs, alignment);
  return score::align({pairs.begin(), pairs.begin() + std::ptrdiff_t(count)}, alignment);
}

bool has_scale(Alignment alignment) { return alignment == Alignment::sim3 || alignment == Alignment::scale; }

ordered_json pose_row(const std::vector<PosePair>& pairs, Alignment alignment, const Options& options) {
  const std::string name = "APE " + name_of(alignment);
  const auto found = align_first(pairs, alignment, options);
  if (const auto* const absent = std::get_if<Absent>(&found))
    return row(name, unit(options.relation), {}, absent->reason);
  const auto& S = std::get<Similarity>(found);
  std::vector<double> errors;
  for (const PosePair& pair : transformed(S, pairs))
    errors.push_back(of_difference(pair.X_true.inverse() * pair.X_estimate, options.relation));
  ordered_json scored = row(name, unit(options.relation), errors);
  if (has_scale(alignment)) scored["scale"] = S.scale;
  return scored;
}

ordered_json motion_row(const std::vector<PosePair>& pairs, const Spans& which, Relation relation) {
  static constexpr std::array<std::string_view, 5> kUnits{"frames", "m", "s", "rad", "deg"};
  const std::string name = fmt::format("RPE {} {}{}", which.delta, kUnits[std::size_t(which.unit)],
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

// Returns why the errors may mislead: the one change that explains them, or else a meaningless scale.
std::optional<std::string> warning(const NamedFile& truth, const NamedFile& estimate,
                                   const std::vector<PosePair>& pairs, const Options& options) {
  const Alignment alignment = options.alignment.value_or(Alignment::none);
  const Trajectory of_truth = truth.trajectory();
  if (auto found = diagnosis({truth.read, estimate.read, pairs, most_gap(of_truth, options.pairing),
                              stamp(options.pairing.offset_s), alignment}))
    return found;
  if (options.alignment && !has_scale(alignment)) return std::nullopt;
  const auto found = align_first(pairs, Alignment::sim3, options);
  const auto* const S = std::get_if<Similarity>(&found);
  const auto doubt = S ? score::doubt_of_scale(*S, pairs) : std::nullopt;
  return doubt ? std::optional("sim3: " + *doubt) : std::nullopt;
}

// Turns the estimate's body, and its covariance, to the truth's.
void turn_body(files::TrajectoryFile& estimate, const Eigen::Vector3d& turn) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix();
  files::Matrix6d J = files::Matrix6d::Identity();
  J.topLeftCorner<3, 3>() = R;
  for (files::TumRow& row : estimate.rows) {
    row.X.linear() *= R.transpose();
    if (row.covariance) *row.covariance = J * *row.covariance * J.transpose();
  }
}

// Adds the NEES without alignment for the matched estimates that have a covariance.
void add_nees(ordered_json& rows, const std::vector<PosePair>& pairs, const files::TrajectoryFile& estimate,
              score::Stamp offset) {
  std::vector<double> position, orientation;
  for (const PosePair& pair : pairs) {
    const auto at = std::ranges::lower_bound(estimate.rows, pair.t - offset, {}, &files::TumRow::t);
    if (at == estimate.rows.end() || !at->covariance) continue;
    const auto nees = score::pose_nees(pair.X_true, pair.X_estimate, *at->covariance);
    if (!nees) return rows.push_back(row("NEES none", "1", {}, "a covariance is not positive definite"));
    position.push_back(nees->position);
    orientation.push_back(nees->orientation);
  }
  if (position.empty()) return;
  for (const auto& [name, squares] :
       {std::pair("NEES none, position", &position), {"NEES none, orientation", &orientation}}) {
    rows.push_back(row(name, "1", *squares));
    rows.back()["expected_mean"] = 3;
  }
}

// The rows of a report without options: every alignment, and relative errors over the usual spans.
void add_overview(ordered_json& rows, const std::vector<PosePair>& pairs, const Options& options) {
  for (const Alignment alignment :
       {Alignment::origin, Alignment::yaw_position, Alignment::se3, Alignment::sim3, Alignment::scale})
    rows.push_back(pose_row(pairs, alignment, options));
  Options turning = options;
  turning.relation = Relation::angle_deg;
  rows.push_back(pose_row(pairs, Alignment::none, turning));
  std::vector<Spans> usual{{Spans::Unit::seconds, 1, true}};
  for (const double length : {4.0, 2.0, 1.0, 0.5, 0.25})
    usual.insert(usual.begin(), {Spans::Unit::meters, length, true, 0.1, true});
  for (const Spans& which : usual)
    for (const Relation relation : {options.relation, Relation::angle_deg})
      rows.push_back(motion_row(pairs, which, relation));
}

// Marks the errors that positions do not determine. Throws std::invalid_argument for a requested error.
void require_orientation(ordered_json& rows, Relation relation) {
  for (ordered_json& one : rows) {
    const std::string name = one["error"], unit = one["unit"];
    const bool motion = name.starts_with("RPE") && relation != Relation::point_distance;
    if (unit == "m" && !motion && name != "APE origin") continue;
    one = row(name, unit, {}, "a file has only positions");
    if (&one == &rows.front())
      throw std::invalid_argument(
          fmt::format("{}: it needs orientations, but a file has only positions", name));
  }
}

}  // namespace

fs::path trajectory_in(const fs::path& path, bool truth) {
  if (!fs::is_directory(path)) return path;
  for (const char* name : {"truth.tum", "estimate_cov.txt", "estimate.tum"})
    if (truth == (name[0] == 't') && fs::exists(path / name)) return path / name;
  throw files::FileError(path, truth ? "is not a result folder: it has no truth.tum"
                                     : "is not a result folder with an estimate: it has no estimate.tum");
}

ordered_json score_files(const fs::path& truth, const fs::path& estimate, const Options& options) {
  const Relation relation = options.relation;
  const bool of_orientation =
      !options.alignment &&
      (relation == Relation::angle_deg || relation == Relation::angle_rad || relation == Relation::rot_part);
  const NamedFile a{truth.string(), files::read_trajectory(truth, options.truth_columns)};
  NamedFile b{estimate.string(), files::read_trajectory(estimate, options.columns)};
  if (!options.body_turn.isZero()) turn_body(b.read, options.body_turn);
  const std::vector<PosePair> given = paired(a, b, options.pairing, !of_orientation);
  const Alignment alignment = options.alignment.value_or(Alignment::none);
  const auto found = align_first(given, alignment, options);
  if (const auto* const absent = std::get_if<Absent>(&found))
    throw std::invalid_argument(fmt::format("--align {}: {}", name_of(alignment), absent->reason));
  const Similarity& similarity = std::get<Similarity>(found);
  const auto pairs = transformed(similarity, given);
  ordered_json rows = ordered_json::array();
  if (options.relative) {
    rows.push_back(motion_row(pairs, *options.relative, relation));
    if (score::spans(pairs, *options.relative).empty())
      throw std::invalid_argument(rows[0]["error"].get<std::string>() + ": the path has no such spans");
  } else {
    rows.push_back(pose_row(given, alignment, options));
    if (!options.alignment) add_overview(rows, given, options);
  }
  if (a.read.has_orientation && b.read.has_orientation)
    add_nees(rows, given, b.read, stamp(options.pairing.offset_s));
  else
    require_orientation(rows, relation);
  const Trajectory of_truth = a.trajectory();
  ordered_json report{{"truth", a.line()}, {"estimate", b.line()}};
  report["poses_matched"] = given.size(), report["poses"] = b.poses();
  const double walked_m = add_coverage(report, of_truth, given);
  report["pairing"] = options.pairing.interpolate
                          ? fmt::format("truth interpolated at the estimate's stamps, across at most {} s",
                                        seconds(most_gap(of_truth, options.pairing)))
                          : fmt::format("nearest stamp within {} s", options.pairing.most_apart_s);
  report["path_length_m"] = walked_m;
  report["alignment"] = name_of(alignment), report["scale"] = similarity.scale;
  report["warnings"] = ordered_json::array();
  if (const auto why = warning(a, b, given, options)) report["warnings"].push_back(*why);
  for (ordered_json& one : rows) one["time_fraction"] = report["time_fraction"];
  report["errors"] = rows;
  return report;
}

std::string table(const ordered_json& r) {
  const auto text_of = [&](const char* key) { return r[key].get<std::string>(); };
  const auto number = [](const ordered_json& json) { return json.get<double>(); };
  const double scale = number(r["scale"]);
  std::string text = fmt::format(
      "truth     {}\nestimate  {}\nmatched   {} of {} poses ({})\n"
      "covered   {} of {} true poses, {:.1f} % of the time; {:.3f} m walked between the first and the last\n"
      "alignment {}",
      text_of("truth"), text_of("estimate"), number(r["poses_matched"]), number(r["poses"]),
      text_of("pairing"), std::min(number(r["poses_matched"]), number(r["true_poses"])),
      number(r["true_poses"]), 100 * number(r["time_fraction"]), number(r["path_length_m"]),
      text_of("alignment"));
  text += scale == 1 ? "\n" : fmt::format(", scale {:.4g}\n", scale);
  for (const ordered_json& warning : r["warnings"]) text += "warning   " + warning.get<std::string>() + "\n";
  text += fmt::format("\n{:<33} {:>5} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "error", "n", "covered", "rmse",
                      "mean", "median", "p95", "max");
  bool nees = false;
  for (const ordered_json& row : r["errors"]) {
    const std::string name = row["error"], scaled = row.contains("scale")
                                                        ? fmt::format(", scale {:.4g}", number(row["scale"]))
                                                        : "";
    text += fmt::format("{:<33} ", fmt::format("{}{} [{}]", name, scaled, row["unit"].get<std::string>()));
    if (row.contains("reason")) {
      text += row["reason"].get<std::string>() + "\n";
      continue;
    }
    nees |= row.contains("expected_mean");
    text += fmt::format("{:>5} {:>5.1f} % {:>9} {:>9.5g} {:>9.5g} {:>9.5g} {:>9.5g}\n", number(row["n"]),
                        100 * number(row["time_fraction"]),
                        row.contains("expected_mean") ? "-" : fmt::format("{:.5g}", number(row["rmse"])),
                        number(row["mean"]), number(row["median"]), number(row["p95"]), number(row["max"]));
  }
  return text + (nees ? "A mean NEES of 3 is expected.\n" : "");
}

}  // namespace sim::trajectory_score
