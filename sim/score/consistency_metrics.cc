#include "sim/score/consistency_metrics.h"

#include <algorithm>

#include "sim/score/scored.h"

namespace sim::score {
namespace {

using enum Worst;
using S = const Scored&;
using Squares = std::vector<double>;

// of(the normalised squares of all frames)
template <typename F>
auto of_nees(double PoseNees::*part, F of) {
  return [part, of](S s) -> Value {
    if (!s.no_nees.empty()) return Value::none(s.no_nees);
    Squares squares;
    for (const PoseNees& nees : s.nees) squares.push_back(nees.*part);
    return of(squares);
  };
}

Value variance(const Squares& squares) {
  if (squares.size() < 2) return Value::none("one frame has no variance");
  const double sd = standard_deviation(squares);
  return sd * sd;
}

double fraction_within_95(const Squares& squares) {
  const double most = chi_square_quantile(0.95, 3);
  const auto within =
      std::count_if(squares.begin(), squares.end(), [most](double square) { return square <= most; });
  return static_cast<double>(within) / static_cast<double>(squares.size());
}

void add_nees(MetricDefinitions& all, const std::string& name, double PoseNees::*part, Needs needs) {
  const std::string of = "normalised estimation error squared (NEES) of the camera's " + name +
                         ", without alignment, from the first planned motion on";
  all.push_back({"nees_" + name + "_mean", "1", "Mean of the " + of + "; 3 is expected.", needs,
                 of_nees(part, mean), Direction::away_from(3), kHeadline});
  all.push_back({"nees_" + name + "_variance", "1", "Variance of the " + of + "; 6 is expected.", needs,
                 of_nees(part, variance), Direction::away_from(6)});
  all.push_back({"nees_" + name + "_within_95", "1",
                 "Fraction of the frames in which the " + of +
                     ", is at most 7.81, the 95 % quantile of a chi-square of 3 degrees of freedom; 0.95 is "
                     "expected.",
                 needs, of_nees(part, fraction_within_95), Direction::away_from(0.95)});
}

// of(the summary of a sensor's innovations)
template <typename F>
auto of_innovations(std::size_t sensor, F of) {
  return [sensor, of](S s) -> Value {
    std::vector<Innovation> all;
    for (const StampedInnovation& innovation : s.run.innovations[sensor])
      if (innovation.t >= *s.begin) all.push_back(innovation.innovation);
    const auto summary = summarise(all);
    if (!summary) return Value::none("the sensor was used in fewer than two frames");
    return of(*summary);
  };
}

void add_nis(MetricDefinitions& all, std::size_t sensor) {
  const std::string name(kSensors[sensor]),
      of = "normalised innovation squared (NIS) of the sensor " + name +
           " by its degrees of freedom, from the first planned motion on";
  const auto add = [&](const std::string& what, const std::string& text, auto part, Direction direction) {
    all.push_back(
        {"nis_" + name + "_" + what, "1", text, Needs::estimate, of_innovations(sensor, part), direction});
  };
  using I = const InnovationSummary&;
  add(
      "mean", "Mean " + of + "; 1 is expected.", [](I i) { return i.ratio; }, Direction::away_from(1));
  add(
      "band_low",
      "Lower end of the 95 % confidence interval of nis_" + name + "_mean for a consistent filter.",
      [](I i) { return i.band.low; }, smallest);
  add(
      "band_high",
      "Upper end of the 95 % confidence interval of nis_" + name + "_mean for a consistent filter.",
      [](I i) { return i.band.high; }, largest);
  add(
      "variance",
      "Variance of the normalised innovation squared (NIS) of the sensor " + name +
          " divided by that of its chi-square distribution; 1 is expected.",
      [](I i) { return i.variance_ratio; }, Direction::away_from(1));
  add(
      "whiteness",
      "Correlation of the normalised innovation squared (NIS) of the sensor " + name +
          " from one frame to the next; 0 is expected.",
      [](I i) { return i.whiteness; }, largest_magnitude);
}

}  // namespace

MetricDefinitions consistency_metrics() {
  MetricDefinitions all;
  add_nees(all, "position", &PoseNees::position, Needs::scale);
  add_nees(all, "orientation", &PoseNees::orientation, Needs::estimate);
  for (std::size_t sensor = 0; sensor < kSensors.size(); ++sensor) add_nis(all, sensor);
  return all;
}

}  // namespace sim::score
