#include <algorithm>
#include <cmath>

#include "sim/score/run.h"

namespace sim::score {
namespace {

constexpr double kTouch = 0.01, kCarries = 0.4;   // of the weight
constexpr std::chrono::milliseconds kBounce{30};  // a foot in the air for less has not left the ground

Pose2 operator-(const Pose2& a, const Pose2& b) {
  return {a.x - b.x, a.y - b.y, std::remainder(a.yaw - b.yaw, 2 * std::numbers::pi)};
}
Pose2& operator+=(Pose2& a, const Pose2& b) {
  a = {a.x + b.x, a.y + b.y, a.yaw + b.yaw};
  return a;
}
Pose2 operator*(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.yaw), s = std::sin(a.yaw);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y, a.yaw + b.yaw};
}
Pose2 inverse(const Pose2& a) {
  const double c = std::cos(a.yaw), s = std::sin(a.yaw);
  return {-c * a.x - s * a.y, s * a.x - c * a.y, -a.yaw};
}

/// The samples [begin, end) of a foot on the ground, and its planned place.
struct Stance {
  Foot foot = Foot::left;
  std::size_t begin = 0, end = 0;
  Pose2 plan;
  std::size_t carries = 0, carried = 0;  // first and past the last sample with its share of the weight
};

class DriftDecomposition {
 public:
  DriftDecomposition(const std::vector<FeetSample>& samples, const Pose2& waist_truth,
                     const Pose2& waist_plan)
      : samples_(samples), last_(samples.size() - 1), waist_truth_(waist_truth), waist_plan_(waist_plan) {}

  std::vector<FootRow> rows() {
    std::vector<Stance> all;
    for (const Foot foot : {Foot::left, Foot::right}) add_stances(foot, all);
    std::ranges::stable_sort(all, {}, &Stance::begin);
    find_anchors(all);
    add_jumps();
    for (const Stance& stance : all) {
      add(stance, FootPhase::landing, stance.begin, stance.carries);
      add(stance, FootPhase::support, stance.carries, stance.carried);
      add(stance, FootPhase::lift_off, std::max(stance.carries, stance.carried), stance.end);
    }
    std::ranges::stable_sort(rows_, {}, &FootRow::begin);
    return rows_;
  }

 private:
  // Successive stances carry the motion of the robot, each from sample `from` on.
  struct Anchor {
    Stance stance;
    std::size_t from = 0;
  };

  const FootSample& at(Foot foot, std::size_t i) const {
    return samples_[i].feet[static_cast<std::size_t>(foot)];
  }
  bool touches(Foot foot, std::size_t i) const { return at(foot, i).load > kTouch; }

  /// The final waist if everything follows the plan from sample i on, as seen from the stance foot.
  Pose2 end_seen_from(const Stance& stance, std::size_t i) const {
    return at(stance.foot, i).truth * inverse(stance.plan) * waist_plan_;
  }

  /// Returns the contact as a stance; nothing for a foot that scuffs the ground in mid-swing.
  std::optional<Stance> stance(Foot foot, std::size_t begin, std::size_t end) const {
    Stance found{foot, begin, end, {}, end, end};
    bool planned = false;
    for (std::size_t i = begin; i < end; ++i) {
      const FootSample& sample = at(foot, i);
      if (sample.planned_down && !planned) found.plan = sample.plan;
      planned |= sample.planned_down;
      if (sample.load < kCarries) continue;
      if (found.carries == end) found.carries = i;
      found.carried = i + 1;
    }
    if (begin == 0) found.carries = 0;
    if (!planned) return std::nullopt;
    return found;
  }

  void add_stances(Foot foot, std::vector<Stance>& all) const {
    for (std::size_t i = 0; i <= last_; ++i) {
      if (i != 0 && !touches(foot, i)) continue;
      std::size_t end = i + 1;  // after the last sample of the contact
      for (std::size_t k = end; k <= last_ && samples_[k].t - samples_[end - 1].t <= kBounce; ++k)
        if (touches(foot, k)) end = k + 1;
      if (const auto found = stance(foot, i, end)) all.push_back(*found);
      i = end - 1;
    }
  }

  /// Between two landings the foot that does not land next stands throughout: it carries the motion.
  void find_anchors(const std::vector<Stance>& landings) {
    for (std::size_t k = 0; k < landings.size(); ++k) {
      const bool last = k + 1 == landings.size(), begins = landings[k].begin == 0;
      if (begins && !last && landings[k + 1].begin == 0) continue;
      if (last || landings[k + 1].foot != landings[k].foot) {
        anchors_.push_back({landings[k], landings[k].begin});
      } else if (begins && k > 0) {
        anchors_.push_back({landings[k - 1], 0});
      }
    }
  }

  void add(const Stance& stance, FootPhase phase, std::size_t begin, std::size_t end) {
    if (begin >= end) return;
    const std::size_t last = std::min(end, last_);
    FootRow row{samples_[begin].t, samples_[last].t, stance.foot, phase, {}, {}, {}};
    row.moved = at(stance.foot, last).truth - at(stance.foot, begin).truth;
    for (std::size_t i = begin + 1; i <= last; ++i) row.creep += at(stance.foot, i).creep;
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
      if (anchors_[k].stance.foot != stance.foot || anchors_[k].stance.begin != stance.begin) continue;
      const std::size_t until = k + 1 < anchors_.size() ? anchors_[k + 1].from : last_;
      const std::size_t from = std::max(begin, anchors_[k].from), to = std::min(last, until);
      if (from < to) row.drift += end_seen_from(stance, to) - end_seen_from(stance, from);
    }
    rows_.push_back(row);
  }

  /// Adds the start, each landing error, and the body over the last foot.
  void add_jumps() {
    if (anchors_.empty()) return;
    const auto jump = [&](FootPhase phase, Foot foot, std::size_t i, const Pose2& drift, const Pose2& moved) {
      rows_.push_back({samples_[i].t, samples_[i].t, foot, phase, moved, {}, drift});
    };
    const Stance &first = anchors_.front().stance, &end = anchors_.back().stance;
    const Pose2 start = end_seen_from(first, 0) - waist_plan_,
                body = waist_truth_ - end_seen_from(end, last_);
    jump(FootPhase::start, first.foot, 0, start, start);
    for (std::size_t k = 1; k < anchors_.size(); ++k) {
      const auto& [stance, from] = anchors_[k];
      const Stance& before = anchors_[k - 1].stance;
      const Pose2 wanted = at(before.foot, from).truth * inverse(before.plan) * stance.plan;
      jump(FootPhase::put_down, stance.foot, from, end_seen_from(stance, from) - end_seen_from(before, from),
           at(stance.foot, from).truth - wanted);
    }
    jump(FootPhase::body, end.foot, last_, body, body);
  }

  const std::vector<FeetSample>& samples_;
  std::size_t last_;
  Pose2 waist_truth_, waist_plan_;
  std::vector<Anchor> anchors_;
  std::vector<FootRow> rows_;
};

}  // namespace

Pose2 pose2(const Eigen::Isometry3d& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

std::vector<FootRow> decompose_drift(const std::vector<FeetSample>& samples, const Pose2& waist_truth,
                                     const Pose2& waist_plan) {
  return DriftDecomposition(samples, waist_truth, waist_plan).rows();
}

}  // namespace sim::score
