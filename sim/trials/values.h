// Values to try for a scenario's keys: lists, ranges, points spread over ranges, and the search for the best.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/sensor_errors/random.h"

namespace sim::trials {

/// A range of a key, scaled to [0, 1] logarithmically or linearly.
struct Range {
  std::string key;                ///< key of the scenario
  std::vector<std::string> also;  ///< more keys that get the same value
  double low = 0, high = 1;
  double start = 0;  ///< start of a search; NaN if not given
  bool logarithmic = true;
  int points = 0;  ///< number of points of a grid; 0: the range is sampled or searched

  double value_at(double coordinate) const;  ///< coordinate in [0, 1]
  double coordinate_of(double value) const;  ///< clamped to [0, 1]
  /// Returns the values of a grid: `points` values from low to high.
  std::vector<double> grid() const;
};

/// Values to try for a key: YAML nodes, or a range.
using Values = std::variant<std::vector<scenario::Yaml>, Range>;

/// Reads `1`, `[1, 2]` or `{from: 1, to: 2, scale: log, points: 5, start: 1.5, also: [KEY]}`. Throws
/// ConfigError at the node; for a range also if the key's value is not a number or the key does not accept
/// its ends.
Values read_values(const scenario::Yaml& key, const scenario::Yaml& node);

/// Reads a range to be searched. Throws ConfigError as read_values does.
Range read_range(const scenario::Yaml& key, const scenario::Yaml& node);

/// Sets a key of the scenario to exactly that number.
void set(scenario::Scenario& scenario, const std::string& key, double value);

/// Returns a number as a YAML node that reads back to the same bits. shortest: with at most 12 digits (0.1 +
/// 0.2 is 0.3).
scenario::Yaml number_node(double value, const scenario::Origin& origin, bool shortest);

/// Returns the first n points of the Sobol sequence after the origin (direction numbers of Joe and Kuo 2008).
/// With 2^k − 1 points and the origin, the sequence stratifies each dimension into 2^k cells.
std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions);

/// CMA-ES, the covariance matrix adaptation evolution strategy (Hansen 2016, "The CMA Evolution Strategy: A
/// Tutorial"), in its ask-and-tell form. It minimizes a function on the unit cube. It is written here because
/// Debian's pagmo is built without AVX, so that its Eigen matrices are aligned differently.
class CmaEs {
 public:
  /// start: mean of the first generation; step: its standard deviation; count >= 4: size of a generation.
  CmaEs(const std::vector<double>& start, double step, int count, std::uint64_t seed);

  /// Returns the next generation. Points outside the cube are reflected at its faces.
  std::vector<std::vector<double>> ask();
  /// Sets the values of the last generation, in its order.
  void tell(const std::vector<double>& values);

 private:
  Eigen::VectorXd sample();
  void adapt(const Eigen::VectorXd& step);

  struct Rates {
    Eigen::VectorXd weights;  // weights of the better half
    double mu_eff, c_sigma, d_sigma, c_c, c_1, c_mu, expected_length;
  };
  static Rates rates(double n, int count);

  int count_, generation_ = 0;
  Rates rates_;
  double sigma_;
  Eigen::VectorXd mean_, p_sigma_, p_c_, D_;  // C = B D² Bᵀ
  Eigen::MatrixXd C_, B_, asked_;             // asked_: one column per point
  sensor_errors::Random random_;
};

}  // namespace sim::trials
