#include "sim/trajectory_score/diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace sim::trajectory_score {
namespace {

using score::Alignment, score::kDegree, score::PosePair, score::Similarity, score::Stamp;

constexpr double kDecisive = 5, kLeast_m = 1e-3, kSameUnit = 0.1,
                 kNone = std::numeric_limits<double>::infinity();

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
      if (const double each = error / static_cast<double>(pairs.size()); each < least)
        least = each, change.after = error, best = offset;
    }
  }
  change.words =
      fmt::format("the clocks differ; --t-offset {:.3f}", 1e-9 * static_cast<double>(best.count()));
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
    turn *= Eigen::AngleAxisd(sum.norm() / static_cast<double>(pairs.size()), sum.stableNormalized())
                .toRotationMatrix();
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

}  // namespace

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

}  // namespace sim::trajectory_score
