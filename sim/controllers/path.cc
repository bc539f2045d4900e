#include "sim/controllers/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sim::controllers {
namespace {

using walking::FootPose;

constexpr double kFeedForward = 0.8;                        // fraction of the largest speeds
constexpr double kGain_s = 1.0, kIntegral_s2 = 0.1;         // gains for errors of place and heading
constexpr double kFaster_m_s2 = 0.5, kFaster_rad_s2 = 1.0;  // how fast the speeds of a steered walk change
constexpr double kTurnToPath = 2.0;  // rad/s per m aside, for robots that do not walk sideways
constexpr double kWaitBeyond_m = 0.3, kWaitBeyond_rad = 0.5;  // errors at which the path waits
constexpr double kMostIntegral = 1.0;                         // m s and rad s
constexpr double kOverdue = 2, kOverdue_s = 2;                // limit: 2 x the command's duration + 2 s

/// The place reached by moving at a constant velocity for some time.
FootPose moved(const Velocity& v, double t_s) {
  const double angle = v.turn * t_s;
  const double along = std::abs(angle) < 1e-9 ? t_s : std::sin(angle) / v.turn,
               aside = std::abs(angle) < 1e-9 ? 0 : (1 - std::cos(angle)) / v.turn;
  return {{v.ahead * along - v.left * aside, v.ahead * aside + v.left * along}, angle};
}

/// Returns the factor by which a velocity exceeds the largest speeds.
double excess(const Velocity& v, const Velocity& largest) {
  const auto over = [](double speed, double limit) { return speed == 0 ? 0 : std::abs(speed) / limit; };
  return std::max({over(v.ahead, largest.ahead), over(v.left, largest.left), over(v.turn, largest.turn)});
}

}  // namespace

Path::Path(const std::vector<walking::Command>& commands, const Velocity& largest) : largest_(largest) {
  std::vector<std::pair<std::size_t, walking::Command>> all;  // repetitions carried out
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const auto* repeat = std::get_if<walking::Repeat>(&commands[i]);
    if (!repeat) {
      all.emplace_back(i, commands[i]);
      continue;
    }
    const auto last =
        static_cast<std::ptrdiff_t>(std::min<std::size_t>(all.size(), std::size_t(repeat->last)));
    const std::vector again(all.end() - last, all.end());
    for (int time = 0; time < repeat->times; ++time) all.insert(all.end(), again.begin(), again.end());
  }
  for (const auto& [index, command] : all) add(index, command);
  if (pieces_.empty()) pieces_.push_back({});
}

void Path::add(std::size_t command, const Velocity& direction, double length) {
  if (length <= 0) return;
  const double faster = excess(direction, largest_);
  if (std::isinf(faster))
    throw std::invalid_argument(
        fmt::format("walk.commands[{}] needs a motion that the walking controller cannot do: its largest "
                    "speeds are {} m/s ahead, {} m/s aside and {} rad/s",
                    command, largest_.ahead, largest_.left, largest_.turn));
  const double scale = kFeedForward / faster;
  const Velocity v{scale * direction.ahead, scale * direction.left, scale * direction.turn};
  last_move_s_ = duration_s();
  pieces_.push_back({command, end_, v, length / scale, last_move_s_});
  end_ = end_ * moved(v, length / scale);
}

void Path::add(std::size_t command, const walking::Command& what) {
  const auto turn = [&](double angle) { add(command, {0, 0, std::copysign(1.0, angle)}, std::abs(angle)); };
  if (const auto* stand = std::get_if<walking::Stand>(&what)) {
    pieces_.push_back({command, end_, {}, stand->duration_s, duration_s()});
  } else if (const auto* straight = std::get_if<walking::Straight>(&what)) {
    add(command, {straight->forward_m, straight->left_m, 0}, straight->forward_m || straight->left_m ? 1 : 0);
  } else if (const auto* arc = std::get_if<walking::TangentArc>(&what)) {
    add(command, {arc->radius_m, 0, std::copysign(1.0, arc->angle_rad)}, std::abs(arc->angle_rad));
  } else if (const auto* around = std::get_if<walking::PerpendicularArc>(&what)) {
    const double way = std::copysign(1.0, around->angle_rad);
    add(command, {0, -way * around->radius_m, way}, std::abs(around->angle_rad));
  } else if (const auto* on_spot = std::get_if<walking::Turn>(&what)) {
    turn(on_spot->angle_rad);
  } else if (const auto* goal = std::get_if<walking::GoTo>(&what)) {
    go(command, *goal);
  } else {
    throw std::invalid_argument(fmt::format(
        "walk.commands[{}]: steps need the built-in walking controller, expected another command", command));
  }
}

void Path::go(std::size_t command, const walking::GoTo& goal) {
  const Eigen::Vector2d way = Eigen::Vector2d(goal.x_m, goal.y_m) - end_.position;
  const auto turn_to = [&](double heading) {
    add(command, walking::Turn{.angle_rad = std::remainder(heading - end_.yaw, 2 * std::numbers::pi)});
  };
  if (way.norm() > 1e-9) {
    turn_to(std::atan2(way.y(), way.x()));
    add(command, walking::Straight{way.norm(), 0});
  }
  turn_to(goal.heading_rad);
}

void Path::start_at(const FootPose& start) {
  for (Piece& piece : pieces_) piece.start = start * piece.start;
}

const Path::Piece& Path::piece(double t_s) const {
  const auto after = std::ranges::upper_bound(pieces_, t_s, {}, &Piece::start_s);
  return after == pieces_.begin() ? pieces_.front() : *(after - 1);
}

FootPose Path::pose(double t_s) const {
  const Piece& here = piece(t_s);
  return here.start * moved(here.velocity, std::clamp(t_s - here.start_s, 0.0, here.duration_s));
}

PathFollower::PathFollower(Path path, const Velocity& largest, const walking::SteeringOptions& steering,
                           bool marches)
    : path_(std::move(path)), largest_(largest), steering_(steering), marches_(marches) {
  velocity_ = steady_ = path_.piece(0).velocity;
}

void PathFollower::locate(const walking::PlaceEstimate& place) {
  const double turned = std::remainder(place.estimated.yaw - place.planned.yaw, 2 * std::numbers::pi);
  error_ = {Eigen::Rotation2Dd(-desired().yaw - turned) * (place.planned.position - place.estimated.position),
            -turned};
  estimate_s_ = place.t_s;
}

bool PathFollower::may_end() const {
  return !error_ || stands() || path_.goes_on(t_s_) ||
         (error_->position.norm() <= steering_.tolerance_m &&
          std::abs(error_->yaw) <= steering_.tolerance_rad);
}

void PathFollower::advance(double dt_s) {
  if (!is_over()) follow(dt_s);
  if (!is_over() || marches_) correct(dt_s);
}

// Advances on the path, and sets the velocity there.
void PathFollower::follow(double dt_s) {
  now_s_ += dt_s;
  if (steering_.by != walking::SteeredBy::plan && now_s_ - estimate_s_ > steering_.lost_s) {
    stopped_ = fmt::format("steering had no estimate for {} s at t = {:.2f} s", steering_.lost_s, now_s_);
    return;
  }
  const Path::Piece& here = path_.piece(t_s_);
  double end_s = here.start_s + here.duration_s, command_duration_s = here.duration_s;
  const bool lags = error_ && !stands() &&
                    (error_->position.norm() > kWaitBeyond_m || std::abs(error_->yaw) > kWaitBeyond_rad);
  double next_s = lags ? t_s_ : t_s_ + dt_s;
  const bool is_at_end = next_s >= end_s - dt_s / 2;
  waits_for_end_ = is_at_end && !may_end();
  if (waits_for_end_) next_s = std::min(next_s, std::nextafter(end_s, 0));
  command_s_ += dt_s;
  if (command_s_ > kOverdue * command_duration_s + kOverdue_s)
    stopped_ = fmt::format(
        "walk.commands[{}] took more than {} times its {:.1f} s: the base is {:.3f} m and {:.1f} deg off",
        here.command, kOverdue, command_duration_s, error_->position.norm(),
        error_->yaw * 180 / std::numbers::pi);
  t_s_ = next_s;
  ended_ = is_at_end && may_end() && end_s >= path_.duration_s();
  const Path::Piece& now = path_.piece(t_s_);
  if (&now != &here) command_s_ = 0;
  const bool waits = t_s_ >= now.start_s + now.duration_s - dt_s || lags;
  velocity_ = waits && error_ ? Velocity{} : now.velocity;
  if (!error_) steady_ = velocity_;
}

// Adds the feedback of the newest estimate.
void PathFollower::correct(double dt_s) {
  if (!error_) return;
  if (ended_) velocity_ = {};
  // A learned walk can fall if its command jumps, for example from a right arc to a left one.
  const auto toward = [dt_s](double wanted, double from, double most) {
    return std::clamp(wanted, from - most * dt_s, from + most * dt_s);
  };
  steady_ = {toward(velocity_.ahead, steady_.ahead, kFaster_m_s2),
             toward(velocity_.left, steady_.left, kFaster_m_s2),
             toward(velocity_.turn, steady_.turn, kFaster_rad_s2)};
  if (stands() && !marches_) return;
  // In the robot's axes.
  const Eigen::Vector2d ahead =
      Eigen::Rotation2Dd(error_->yaw) * Eigen::Vector2d(steady_.ahead, steady_.left);
  const auto& [place, yaw] = *error_;
  Velocity wanted{ahead.x() + kGain_s * place.x() + kIntegral_s2 * sum_.ahead,
                  ahead.y() + kGain_s * place.y() + kIntegral_s2 * sum_.left,
                  steady_.turn + kGain_s * yaw + kIntegral_s2 * sum_.turn};
  if (largest_.left == 0 && !stands()) wanted.turn += std::copysign(kTurnToPath, velocity_.ahead) * place.y();
  velocity_ = limited(wanted);
  const auto sum = [dt_s](double& value, double error, bool is_limited) {
    if (!is_limited) value = std::clamp(value + dt_s * error, -kMostIntegral, kMostIntegral);
  };
  sum(sum_.ahead, place.x(), velocity_.ahead != wanted.ahead);
  sum(sum_.left, place.y(), velocity_.left != wanted.left);
  sum(sum_.turn, yaw, velocity_.turn != wanted.turn);
}

Velocity PathFollower::limited(Velocity v) const {
  return {std::clamp(v.ahead, -largest_.ahead, largest_.ahead),
          std::clamp(v.left, -largest_.left, largest_.left),
          std::clamp(v.turn, -largest_.turn, largest_.turn)};
}

bool PathFollower::stands() const {
  const Velocity& v = path_.piece(t_s_).velocity;
  return v.ahead == 0 && v.left == 0 && v.turn == 0;
}

FootPose PathFollower::ahead(double s) const {
  const FootPose seen = inverse(desired()) * path_.pose(waits_for_end_ ? t_s_ : t_s_ + s);
  return error_ ? *error_ * seen : seen;
}

double PathFollower::progress() const {
  return path_.duration_s() > 0 ? std::min(1.0, t_s_ / path_.duration_s()) : 1;
}

}  // namespace sim::controllers
