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
    choice<&SteeringOptions::by>(key, kSteeredBy,
                                 "who corrects the footsteps: plan (nobody), truth or estimate");
    number<&SteeringOptions::latency_s>(key, 0, 10, "age of the newest estimate that may correct a footstep");
    number<&SteeringOptions::gain>(key, 0, 1, "part of an error that one footstep corrects");
    number<&SteeringOptions::dead_band_sigma>(
        key, 0, 100, "part of an error that is not corrected, in standard deviations of the estimate");
    number<&SteeringOptions::largest_ahead_m>(key, 0, 0.1, "largest correction of a footstep along the foot");
    number<&SteeringOptions::largest_aside_m>(key, 0, 0.1,
                                              "largest correction of a footstep across the foot");
    degrees<&SteeringOptions::largest_turn_rad>(key, 0, 10, "largest correction of a footstep's heading");
    choice<&SteeringOptions::on_lost>(
        key, kOnLost,
        "what happens when the estimate stays lost: go_on (by the plan) or stop (on both feet)");
    number<&SteeringOptions::lost_s>(key, 0, 1e6, "time without an estimate after which it counts as lost");
    number<&SteeringOptions::tolerance_m>(
        key, 0, 10, "distance from the end of the path at which no more steps are added");
    degrees<&SteeringOptions::tolerance_rad>(
        key, 0, 180, "difference from the heading at the end of the path at which no more steps are added");
    number<&SteeringOptions::final_steps>(
        key, 0, 1000, "most steps that are added at the end of the path to come within the tolerance");
  }
};

}  // namespace walking
