// The built-in controller: pattern generator, landing adjustment, stabilizer and inverse kinematics.
#pragma once

#include "sim/controllers/controller.h"
#include "walking/floor_slope.h"
#include "walking/landing_adjustment.h"
#include "walking/pattern_generator.h"

namespace sim::controllers {

class PlanController : public Controller {
 public:
  PlanController(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer,
                 const walking::SteeringOptions& steering = {});

  const walking::JointVector& start() const override { return start_; }
  /// Plan -> landing adjustment -> stabilizer -> inverse kinematics.
  JointCommands command(const Readings& readings, bool settles) override;
  void advance() override;
  bool walks() const override { return tick_ < plan_.ticks(); }
  double progress() const override { return static_cast<double>(tick_) / static_cast<double>(plan_.ticks()); }
  /// The plan with its adjusted landings.
  const walking::Reference& reference() const override { return adjusted_; }
  walking::Reference following() const override { return adjustment_.shifted(following_); }
  std::optional<Ticks> path() const override;
  bool steers(std::size_t tick) const override { return steered_ && steered_->by.is_due(plan_, tick); }
  void steer(std::size_t tick, const std::optional<walking::PlaceEstimate>& newest) override {
    steered_->by.decide(plan_, tick, newest);
  }
  std::optional<std::vector<walking::StepCorrection>> corrections() const override;
  std::optional<std::string> stopped() const override;
  /// Makes the soles follow the measured slope of the floor from this tick on.
  void adapt_to_slope() { slope_.emplace(plan_.robot()); }
  std::size_t ticks() const { return plan_.ticks(); }
  /// Returns whether this tick is the last one.
  bool is_last() const { return tick_ + 1 >= plan_.ticks(); }

 private:
  walking::PatternGenerator plan_;
  walking::Reference reference_ = plan_.next(), following_ = plan_.next();
  walking::LandingAdjustment adjustment_;
  walking::Reference adjusted_ = reference_;
  walking::Stabilizer stabilizer_;
  std::optional<walking::FloorSlope> slope_;
  walking::JointVector q_, start_;
  std::size_t tick_ = 0;
  struct Steered {
    walking::Steering by;
    double lost_s;
    walking::PatternGenerator path;  // without corrections
    Ticks ticks;                     // two ticks of the path
  };
  std::optional<Steered> steered_;
};

}  // namespace sim::controllers
