// How long a job will go on, from the part of it that is done.
#pragma once

#include <optional>

namespace cli {

/// Estimates the time left from the rate over the whole job but its first second, in which what was done
/// before is found done. Between two steps it counts down. It does not grow but where the job has become much
/// slower.
class RemainingTime {
 public:
  /// part: done by now, 0 to 1. spent_s: since the job began, never less than at the call before. Nothing
  /// while there is no rate yet.
  std::optional<double> at(double part, double spent_s);

 private:
  struct Point {
    double part = 0, spent_s = 0;
  };
  std::optional<Point> first_, last_;
  std::optional<double> end_s_, shown_s_;  ///< when the job will be done; the time left as last returned
};

}  // namespace cli
