#include "sim/bench/scenario_faults.h"

#include "sim/bench/kind_list.h"

namespace sim::bench {
namespace {

using namespace stream;

constexpr Domain kTime{0, 1e6}, kFraction{0, 1}, kFactor{-100, 100}, kLight{0, 100}, kSpike{-1e6, 1e6};

template <class Kind>
Grammar<Kind> fault(std::string_view word, std::vector<Key<Kind>> more = {}) {
  Grammar<Kind> grammar{word,
                        {make_key<Kind>(GAITSLAM_FIELD(from_s), kTime, "when it begins, on the run's clock"),
                         make_key<Kind>(GAITSLAM_FIELD(duration_s), kTime, "how long it lasts")}};
  grammar.fields.insert(grammar.fields.end(), more.begin(), more.end());
  return grammar;
}

template <class Kind>
Grammar<Kind> fault_of_some(std::string_view word, const std::string& doc) {
  return fault<Kind>(word, {make_key<Kind>(GAITSLAM_FIELD(fraction), kFraction, doc)});
}

template <class Kind>
Grammar<Kind> fault_by_a_factor(std::string_view word, const Domain& domain, const std::string& doc) {
  return fault<Kind>(word, {make_key<Kind>(GAITSLAM_FIELD(factor), domain, doc)});
}

const auto& faults_list() {
  static const KindList list(
      "fault", "frames_lost: {from_s: 20, duration_s: 2}",
      fault_of_some<FramesLost>("frames_lost", "of the frames meanwhile whose picture is lost"),
      fault<FramesFrozen>("frames_frozen"),
      fault_by_a_factor<FramesDimmed>("frames_dimmed", kLight, "light that is left; more than 1: too much"),
      fault_of_some<FramesCovered>("frames_covered", "of the picture that a poster fixed to the head covers"),
      fault_of_some<FramesDoubled>("frames_doubled", "of the frames meanwhile that arrive twice"),
      fault_of_some<FramesReordered>("frames_reordered",
                                     "of the frames meanwhile that arrive after the next"),
      fault<GyroSilent>("gyro_silent"),
      fault<GyroSpike>("gyro_spike",
                       {make_key<GyroSpike>(GAITSLAM_FIELD(size_rad_s), kSpike, "on each axis")}),
      fault<AccelerometerSilent>("accelerometer_silent"),
      fault<AccelerometerSpike>(
          "accelerometer_spike",
          {make_key<AccelerometerSpike>(GAITSLAM_FIELD(size_m_s2), kSpike, "on each axis")}),
      fault<PlanMissing>("plan_missing"),
      fault_by_a_factor<PlanScaled>("plan_scaled", kFactor, "planned way and velocity over those walked"));
  return list;
}

}  // namespace

void read_faults(const Yaml& node, std::string_view key, std::vector<Fault>& faults) {
  faults_list().read(node, key, faults);
}

std::string print_faults(const std::vector<Fault>& faults) { return faults_list().print(faults); }

std::string describe_faults() { return faults_list().describe(); }

}  // namespace sim::bench
