#include "sim/score/trajectory_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <utility>

#include "sim/score/consistency.h"
#include "sim/score/statistics.h"

namespace sim::score {
namespace {

namespace fs = std::filesystem;
using std::string_view_literals::operator""sv;

constexpr std::array kAlignments{"none"sv, "origin"sv, "yaw"sv, "se3"sv, "sim3"sv, "scale"sv};

double seconds(Stamp t) { return std::chrono::duration<double>(t).count(); }
Stamp stamp(double s) { return Stamp(std::llround(1e9 * s)); }

Trajectory trajectory(const files::TrajectoryFile& file) {
  Trajectory poses;
  for (const files::TumRow& row : file.rows) poses.push_back({row.t, row.X});
  return poses;
}

std::string describe_file(const fs::path& file, const files::TrajectoryFile& read) {
  return fmt::format("{}: {}, {} poses from {:.3f} to {:.3f} s, stamps in {}{}", file.string(), read.format,
                     read.rows.size(), seconds(read.rows.front().t), seconds(read.rows.back().t), read.stamps,
                     read.warning.empty() ? "" : "; warning: " + read.warning);
}

std::vector<PosePair> pair(const Trajectory& truth, Trajectory estimate, const TrajectoryOptions& options) {
  if (!options.interpolate)
    return pair_by_nearest(truth, estimate, stamp(options.most_apart_s), stamp(options.offset_s));
  for (StampedPose& pose : estimate) pose.t += stamp(options.offset_s);
  return pair_by_interpolation(truth, estimate);
}

// An offset, and how many poses are paired with it.
struct Offset {
  Stamp t{0};
  std::size_t pairs = 0;
};

// The differences that most stamps of the two have, of some of the estimate's.
std::vector<Stamp> likely_offsets(const Trajectory& truth, const Trajectory& estimate, Stamp apart) {
  constexpr std::size_t kSome = 40, kBest = 8;
  std::map<std::int64_t, std::pair<std::size_t, Stamp>> votes;  // by the offset in units of `apart`
  const std::size_t every = std::max<std::size_t>(1, estimate.size() / kSome);
  for (std::size_t i = 0; i < estimate.size(); i += every)
    for (const StampedPose& pose : truth) {
      auto& [count, offset] = votes[(pose.t - estimate[i].t) / apart];
      offset = count++ == 0 ? pose.t - estimate[i].t : offset;
    }
  std::vector<std::pair<std::size_t, Stamp>> all;
  for (const auto& [unit, vote] : votes) all.push_back(vote);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Stamp> best;
  for (std::size_t i = 0; i < std::min(kBest, all.size()); ++i) best.push_back(all[i].second);
  return best;
}

// The offset with which most stamps meet. Of several as good the one of the clocks that are known: results
// begin at 0, their exports at 1e9 s.
Offset best_offset(const Trajectory& truth, const Trajectory& estimate, Stamp apart) {
  constexpr Stamp kEpoch = std::chrono::seconds(1'000'000'000);
  std::vector<Stamp> candidates{Stamp(0), -kEpoch, kEpoch, truth.front().t - estimate.front().t};
  for (const Stamp likely : likely_offsets(truth, estimate, std::max(apart, Stamp(1))))
    candidates.push_back(likely);
  Offset best;
  for (const Stamp candidate : candidates)
    if (const std::size_t pairs = pair_by_nearest(truth, estimate, apart, candidate).size();
        pairs > best.pairs)
      best = {candidate, pairs};
  return best;
}

// Why no poses are paired, or hardly any, and which option may help.
std::string why_unmatched(const Trajectory& truth, const Trajectory& estimate,
                          const std::vector<PosePair>& pairs, const TrajectoryOptions& options) {
  const Offset best = best_offset(truth, estimate, stamp(options.most_apart_s));
  const double a0 = seconds(truth.front().t), a1 = seconds(truth.back().t),
               b0 = seconds(estimate.front().t) + options.offset_s,
               b1 = seconds(estimate.back().t) + options.offset_s;
  const std::string few = fmt::format(
      "{} of {} estimated poses have a true one{}: ", pairs.size(), estimate.size(),
      pairs.empty() ? "" : fmt::format(", over {:.3f} s", seconds(pairs.back().t - pairs.front().t)));
  if (pairs.empty() && b0 <= a1 && b1 >= a0)
    return few + fmt::format("no stamps nearer than {} s (--t-max-diff)", options.most_apart_s);
  return few +
         fmt::format("the truth is from {:.3f} to {:.3f} s, the estimate from {:.3f} to {:.3f} s", a0, a1, b0,
                     b1) +
         (best.pairs > pairs.size() ? fmt::format("; with --t-offset {} {} of its poses have a true one",
                                                  seconds(best.t), best.pairs)
                                    : "");
}

Stamp duration(const Trajectory& poses) { return poses.back().t - poses.front().t; }

// True where the pairs are of an instant only of two trajectories that both last much longer.
bool meet_in_an_instant(const std::vector<PosePair>& pairs, const Trajectory& truth,
                        const Trajectory& estimate) {
  constexpr int kMuchLonger = 100;
  return (pairs.back().t - pairs.front().t) * kMuchLonger < std::min(duration(truth), duration(estimate));
}

// Throws std::invalid_argument where a sum or difference of stamps would not be one.
void require_offset(const Trajectory& truth, const Trajectory& estimate, double offset_s) {
  double furthest_s = std::abs(offset_s);
  for (const Stamp t : {truth.front().t, truth.back().t, estimate.front().t, estimate.back().t})
    furthest_s = std::max(furthest_s, std::abs(offset_s) + std::abs(seconds(t)));
  if (offset_s != 0 && !(furthest_s < 4e9))
    throw std::invalid_argument(fmt::format("--t-offset {}: with it a stamp is beyond 4e9 s", offset_s));
}

bool counts_frames(const files::TrajectoryFile& read) { return read.stamps == "frame numbers"; }

// Stamps that are all whole seconds, as the numbers of frames are that are taken for seconds.
bool are_whole(const files::TrajectoryFile& read) {
  const auto whole = [](const files::TumRow& row) { return row.t % std::chrono::seconds(1) == Stamp(0); };
  return read.rows.size() > 2 && std::all_of(read.rows.begin(), read.rows.end(), whole);
}

double duration_s(const files::TrajectoryFile& read) {
  return seconds(read.rows.back().t - read.rows.front().t);
}

// True where the poses last much shorter than the others, and not because they are fewer.
bool last_much_shorter(const files::TrajectoryFile& read, const files::TrajectoryFile& other) {
  constexpr double kMuch = 50;  // a minute has 60 seconds
  if (read.rows.size() < 2 || other.rows.size() < 2) return false;
  const double spans = static_cast<double>(read.rows.size() - 1),
               other_spans = static_cast<double>(other.rows.size() - 1);
  return kMuch * duration_s(read) <= duration_s(other) &&
         kMuch * duration_s(read) / spans <= duration_s(other) / other_spans;
}

// Throws FileError where the stamps of one file are the numbers of its frames and those of the other are
// times, or where they are not in the same unit. Whole numbers may be times once a second, but not where they
// last much longer than the other file does, though that has about as many poses.
void require_times(const fs::path& file, const files::TrajectoryFile& read, const fs::path& other_file,
                   const files::TrajectoryFile& other, const TrajectoryOptions& options) {
  if (counts_frames(read) && !counts_frames(other))
    throw files::FileError(
        file, fmt::format("its stamps are frame numbers, those of {} are times in {}{}", other_file.string(),
                          other.stamps, read.format == "KITTI" ? "; times.txt beside it has the times" : ""));
  if (!are_whole(read) && !are_whole(other) && last_much_shorter(read, other))
    throw files::FileError(
        file,
        fmt::format(
            "its {} poses last {:.3f} s, the {} of {} last {:.3f} s: their stamps are not in the same unit",
            read.rows.size(), duration_s(read), other.rows.size(), other_file.string(), duration_s(other)));
  if (options.interpolate || !are_whole(read) || are_whole(other)) return;
  const bool longer = duration_s(read) > 1.5 * duration_s(other),
             as_many = 2 * other.rows.size() > read.rows.size();
  if (longer && as_many)
    throw files::FileError(
        file,
        fmt::format("its stamps are whole numbers up to {}, as frame numbers are, those of {} are times over "
                    "{:.3f} s; with --interpolate they are taken for seconds",
                    read.rows.back().t / std::chrono::seconds(1), other_file.string(), duration_s(other)));
}

// Throws FileError where nothing moves: no error of such positions says anything.
void require_motion(const fs::path& file, const std::vector<PosePair>& pairs,
                    Eigen::Isometry3d PosePair::*pose) {
  constexpr double kStill_m = 1e-9;
  const Eigen::Vector3d first = (pairs.front().*pose).translation();
  const auto is_there = [&](const PosePair& pair) {
    return ((pair.*pose).translation() - first).norm() <= kStill_m;
  };
  if (pairs.size() > 1 && std::all_of(pairs.begin(), pairs.end(), is_there))
    throw files::FileError(file, fmt::format("all {} poses that were paired are in one point", pairs.size()));
}

bool is_of_orientation(const TrajectoryOptions& options) {
  const Relation relation = options.relation;
  return !options.alignment && (relation == Relation::angle_deg || relation == Relation::angle_rad ||
                                relation == Relation::rot_part);
}

std::string span_name(const Spans& which) {
  static constexpr std::array kUnits{"frames"sv, "m"sv, "s"sv, "rad"sv, "deg"sv, "footsteps"sv};
  return fmt::format("{} {}{}", which.delta, kUnits[static_cast<std::size_t>(which.unit)],
                     which.all ? " (from each pose)" : "");
}

TrajectoryRow row(const std::string& name, const std::string& unit, const std::vector<double>& errors,
                  const std::string& why_none) {
  if (errors.empty()) return {name, unit, {}, why_none};
  if (!std::all_of(errors.begin(), errors.end(), [](double error) { return std::isfinite(error); }))
    return {name, unit, {}, "a value is not finite"};
  return {name, unit, describe(errors), ""};
}

// All pairs under one alignment, or why there is none.
std::variant<std::vector<PosePair>, std::string> aligned(const std::vector<PosePair>& pairs,
                                                         Alignment alignment, std::size_t count,
                                                         Similarity& similarity) {
  const auto found = align_first(pairs, alignment, count);
  if (const auto* none = std::get_if<Absent>(&found)) return none->reason;
  similarity = std::get<Similarity>(found);
  return transformed(similarity, pairs);
}

TrajectoryRow pose_row(const std::vector<PosePair>& pairs, Alignment alignment,
                       const TrajectoryOptions& options) {
  Similarity similarity;
  const auto moved = aligned(pairs, alignment, options.poses_to_align, similarity);
  const std::string name = "APE " + name_of(alignment), unit_name = unit(options.relation);
  if (const auto* why = std::get_if<std::string>(&moved)) return {name, unit_name, {}, *why};
  return row(name, unit_name, pose_errors(std::get<std::vector<PosePair>>(moved), options.relation), "");
}

TrajectoryRow motion_row(const std::vector<PosePair>& pairs, const Spans& which, Relation relation) {
  return row("RPE " + span_name(which), unit(relation), motion_errors(pairs, spans(pairs, which), relation),
             "the path has no such spans");
}

// NEES without alignment, where every matched estimate has a covariance.
std::vector<TrajectoryRow> nees_rows(const std::vector<PosePair>& pairs,
                                     const files::TrajectoryFile& estimate, Stamp offset) {
  std::vector<double> position, orientation;
  for (const PosePair& pair : pairs) {
    const auto at = std::lower_bound(estimate.rows.begin(), estimate.rows.end(), pair.t - offset,
                                     [](const files::TumRow& r, Stamp t) { return r.t < t; });
    if (at == estimate.rows.end() || !at->covariance) return {};
    const auto nees = pose_nees(pair.X_true, pair.X_estimate, *at->covariance);
    if (!nees) return {{"NEES none", "1", {}, "a covariance is not positive definite"}};
    position.push_back(nees->position);
    orientation.push_back(nees->orientation);
  }
  return {row("NEES none, position", "1", position, ""), row("NEES none, orientation", "1", orientation, "")};
}

// The rows of a report without options: every alignment, and relative errors over the usual spans.
void add_overview(TrajectoryReport& report, const std::vector<PosePair>& pairs,
                  const TrajectoryOptions& options) {
  for (const Alignment alignment :
       {Alignment::origin, Alignment::yaw_position, Alignment::se3, Alignment::sim3, Alignment::scale})
    report.rows.push_back(pose_row(pairs, alignment, options));
  TrajectoryOptions turning = options;
  turning.relation = Relation::angle_deg;
  report.rows.push_back(pose_row(pairs, Alignment::none, turning));
  using Unit = Spans::Unit;
  for (const Spans& which : {Spans{Unit::metres, 0.25, true, 0.1, true},
                             {Unit::metres, 0.5, true, 0.1, true},
                             {Unit::metres, 1, true, 0.1, true},
                             {Unit::metres, 2, true, 0.1, true},
                             {Unit::metres, 4, true, 0.1, true},
                             {Unit::seconds, 1, true}}) {
    report.rows.push_back(motion_row(pairs, which, options.relation));
    report.rows.push_back(motion_row(pairs, which, Relation::angle_deg));
  }
}

void add_errors(TrajectoryReport& report, const std::vector<PosePair>& pairs,
                const TrajectoryOptions& options) {
  std::vector<double> walked{0};
  for (std::size_t i = 1; i < pairs.size(); ++i)
    walked.push_back(walked.back() +
                     (pairs[i].X_true.translation() - pairs[i - 1].X_true.translation()).norm());
  report.path_m = walked.back();
  const auto at = [&](std::size_t i) {
    report.stamps.push_back(seconds(pairs[i].t));
    report.walked.push_back(walked[i]);
  };
  if (!options.relative) {
    report.errors = pose_errors(pairs, options.relation);
    for (std::size_t i = 0; i < pairs.size(); ++i) at(i);
    report.rows.push_back(row("APE " + report.alignment, unit(options.relation), report.errors, ""));
    return;
  }
  const std::vector<Span> over = spans(pairs, *options.relative);
  report.errors = motion_errors(pairs, over, options.relation);
  for (const Span& span : over) at(span.to);
  report.rows.push_back(row("RPE " + span_name(*options.relative), unit(options.relation), report.errors,
                            "the path has no such spans"));
}

}  // namespace

std::optional<Alignment> alignment_of(const std::string& name) {
  const auto found = std::find(kAlignments.begin(), kAlignments.end(), name);
  if (found == kAlignments.end()) return std::nullopt;
  return static_cast<Alignment>(found - kAlignments.begin());
}

std::string name_of(Alignment alignment) {
  return std::string(kAlignments[static_cast<std::size_t>(alignment)]);
}

fs::path trajectory_in(const fs::path& path, bool truth) {
  if (!fs::is_directory(path)) return path;
  for (const char* name :
       truth ? std::array{"truth.tum", ""} : std::array{"estimate_cov.txt", "estimate.tum"})
    if (*name != '\0' && fs::exists(path / name)) return path / name;
  throw files::FileError(path, truth ? "is no result folder: it has no truth.tum"
                                     : "is no result folder with an estimate: it has no estimate.tum");
}

TrajectoryReport report_trajectories(const fs::path& truth, const fs::path& estimate,
                                     const TrajectoryOptions& options) {
  const files::TrajectoryFile a = files::read_trajectory(truth), b = files::read_trajectory(estimate);
  require_times(truth, a, estimate, b, options);
  require_times(estimate, b, truth, a, options);
  TrajectoryReport report;
  report.truth = describe_file(truth, a);
  report.estimate = describe_file(estimate, b);
  const Trajectory of_truth = trajectory(a), of_estimate = trajectory(b);
  require_offset(of_truth, of_estimate, options.offset_s);
  const std::vector<PosePair> pairs = pair(of_truth, of_estimate, options);
  if (pairs.empty() || meet_in_an_instant(pairs, of_truth, of_estimate))
    throw std::invalid_argument(why_unmatched(of_truth, of_estimate, pairs, options));
  if (!is_of_orientation(options)) {
    require_motion(truth, pairs, &PosePair::X_true);
    require_motion(estimate, pairs, &PosePair::X_estimate);
  }
  report.matched = pairs.size();
  report.poses = b.rows.size();
  report.pairing = options.interpolate ? "truth interpolated at the estimate's stamps"
                                       : fmt::format("nearest stamp within {} s", options.most_apart_s);
  const Alignment alignment = options.alignment.value_or(Alignment::none);
  report.alignment = name_of(alignment);
  const auto moved = aligned(pairs, alignment, options.poses_to_align, report.similarity);
  if (const auto* why = std::get_if<std::string>(&moved))
    throw std::invalid_argument(fmt::format("--align {}: {}", report.alignment, *why));
  add_errors(report, std::get<std::vector<PosePair>>(moved), options);
  if (options.relative && report.errors.empty())
    throw std::invalid_argument(fmt::format("{}: {}", report.rows.front().name, report.rows.front().reason));
  if (!options.alignment && !options.relative) add_overview(report, pairs, options);
  for (const TrajectoryRow& nees : nees_rows(pairs, b, stamp(options.offset_s))) report.rows.push_back(nees);
  return report;
}

}  // namespace sim::score
