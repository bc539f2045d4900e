// The scenario's keys walk.steering.*: whether and how an estimate of the robot's place corrects the
// footsteps.
#pragma once

#include <array>
#include <numbers>
#include <string_view>

namespace walking {

/// Who says where the robot is: nobody (the plan is walked as it is), the truth (what steering alone can do),
/// or the estimate.
enum class SteeredBy { plan, truth, estimate };
inline constexpr std::array<std::string_view, 3> kSteeredBy{"plan", "truth", "estimate"};

enum class OnLost { go_on, stop };
inline constexpr std::array<std::string_view, 2> kOnLost{"go_on", "stop"};

struct SteeringOptions {
  SteeredBy by = SteeredBy::plan;
  double latency_s = 0.1;
  double gain = 0.8;
  double dead_band_sigma = 0.5;
  double largest_ahead_m = 0.03;
  double largest_aside_m = 0.02;
  double largest_turn_rad = 3 * std::numbers::pi / 180;
  OnLost on_lost = OnLost::stop;
  double lost_s = 3.0;
  double tolerance_m = 0.006;
  double tolerance_rad = 0.5 * std::numbers::pi / 180;
  int final_steps = 8;

  static void keys(auto&& key) {
    key.choice("by", &SteeringOptions::by, kSteeredBy,
               "who corrects the footsteps: plan (nobody), truth or estimate");
    key.number("latency_s", &SteeringOptions::latency_s, 0, 10,
               "age of the newest estimate that may correct a footstep");
    key.number("gain", &SteeringOptions::gain, 0, 1, "part of an error that one footstep corrects");
    key.number("dead_band_sigma", &SteeringOptions::dead_band_sigma, 0, 100,
               "part of an error that is not corrected, in standard deviations of the estimate");
    key.number("largest_ahead_m", &SteeringOptions::largest_ahead_m, 0, 0.1,
               "largest correction of a footstep along the foot");
    key.number("largest_aside_m", &SteeringOptions::largest_aside_m, 0, 0.1,
               "largest correction of a footstep across the foot");
    key.degrees("largest_turn_deg", &SteeringOptions::largest_turn_rad, 0, 10,
                "largest correction of a footstep's heading");
    key.choice("on_lost", &SteeringOptions::on_lost, kOnLost,
               "what happens when the estimate stays lost: go_on (by the plan) or stop (on both feet)");
    key.number("lost_s", &SteeringOptions::lost_s, 0, 1e6,
               "time without an estimate after which it counts as lost");
    key.number("tolerance_m", &SteeringOptions::tolerance_m, 0, 10,
               "distance from the end of the path at which no more steps are added");
    key.degrees("tolerance_deg", &SteeringOptions::tolerance_rad, 0, 180,
                "difference from the heading at the end of the path at which no more steps are added");
    key.number("final_steps", &SteeringOptions::final_steps, 0, 1000,
               "most steps that are added at the end of the path to come within the tolerance");
  }
};

}  // namespace walking
