#include "sim/trials/values.h"

#include <Eigen/Eigenvalues>
#include <boost/random/sobol.hpp>
#include <numeric>

#include "sim/scenario/keys.h"

namespace sim::trials {
namespace {

using scenario::fail;
using scenario::Yaml;
using std::string_view_literals::operator""sv;

constexpr std::array kScales{"log"sv, "linear"sv};
constexpr scenario::Domain kAnyNumber{-1e12, 1e12};
constexpr double kMostPoints = 100'000;

void require_number(const Yaml& at, const std::string& name) {
  const auto* const key = scenario::find_key(name);
  if (!key) fail(at, name, scenario::unknown_key(name));
  if (!key->expected.starts_with("a number") && !key->expected.starts_with("a whole number"))
    fail(at, name, "is {}, expected a key whose value is a number", key->expected);
}

// A number that the key itself accepts.
double read_bound(const Yaml& node, const std::string& key) {
  scenario::Scenario scratch = scenario::default_scenario();
  scenario::find_key(key)->read(node, scratch);
  double value = 0;
  read(node, key, kAnyNumber, value);
  return value;
}

void require_rising(const Yaml& node, const Range& range) {
  if (std::isnan(range.low) || std::isnan(range.high)) fail(node, range.key, "expected both from and to");
  if (!(range.low < range.high))
    fail(node, range.key, "from {} to {}: expected an increasing range", range.low, range.high);
  if (range.logarithmic && range.low <= 0)
    fail(node, range.key, "a logarithmic range must start above 0; scale: linear allows 0 and below");
  if (range.start < range.low || range.start > range.high)
    fail(node, range.key, "start {} is outside {} to {}", range.start, range.low, range.high);
}

// Reflects into [0, 1] at both ends.
double reflected(double x) { return std::min(std::abs(std::remainder(x, 2)), 1.0); }

bool is_range(const Yaml& node) {
  return node.is_map() && std::ranges::any_of(node.keys, [](const Yaml& key) {
           return key.text == "from" || key.text == "to";
         });
}

}  // namespace

double Range::value_at(double coordinate) const {
  if (coordinate <= 0) return low;
  if (coordinate >= 1) return high;
  return logarithmic ? low * std::exp(coordinate * std::log(high / low)) : low + coordinate * (high - low);
}

double Range::coordinate_of(double value) const {
  const double coordinate =
      logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return std::clamp(coordinate, 0.0, 1.0);
}

std::vector<double> Range::grid() const {
  std::vector<double> values;
  for (int i = 0; i < points; ++i) values.push_back(value_at(i / std::max(points - 1.0, 1.0)));
  return values;
}

Range read_range(const Yaml& key, const Yaml& node) {
  require_number(key, key.text);
  require_map(node, key.text, "a range, as in {from: 0.001, to: 0.1}");
  Range range{key.text, {}, NAN, NAN, NAN, true, 0};
  const auto bound = [&](double& into) {
    return [&](const Yaml& value) { into = read_bound(value, range.key); };
  };
  read_map(node, {{"from", bound(range.low)},
                  {"to", bound(range.high)},
                  {"start", bound(range.start)},
                  {"scale",
                   [&](const Yaml& value) {
                     range.logarithmic = scenario::read_choice(value, "scale", {0, 0, kScales}) == 0;
                   }},
                  {"points",
                   [&](const Yaml& value) {
                     scenario::read(value, "points", {2, kMostPoints}, range.points);
                   }},
                  {"also", [&](const Yaml& value) {
                     range.also = read_texts(value, "also", "[slam.vision.gate_sigma_px]");
                     for (const Yaml& item : value.items) require_number(item, item.text);
                   }}});
  require_rising(node, range);
  return range;
}

Values read_values(const Yaml& key, const Yaml& node) {
  if (node.is_list() && node.items.size() == 1 && is_range(node.items[0]))
    return read_range(key, node.items[0]);
  if (is_range(node)) return read_range(key, node);
  if (!node.is_list()) return std::vector{node};
  if (node.items.empty()) fail(node, key.text, "has no values");
  for (const Yaml& item : node.items)
    if (item.kind == Yaml::Kind::empty) fail(item, key.text, "a value is missing");
  return node.items;
}

Yaml number_node(double value, const scenario::Origin& origin, bool shortest) {
  Yaml node;
  node.kind = Yaml::Kind::scalar;
  node.text = shortest ? fmt::format("{:.12g}", value) : fmt::format("{}", value);
  node.origin = origin;
  return node;
}

void set(scenario::Scenario& scenario, const std::string& key, double value) {
  scenario::find_key(key)->read(number_node(value, {key}, false), scenario);
}

std::vector<std::vector<double>> sobol_points(std::size_t n, std::size_t dimensions) {
  boost::random::sobol sequence(dimensions);
  std::vector<std::vector<double>> points(n, std::vector<double>(dimensions));
  for (std::vector<double>& point : points)
    for (double& coordinate : point) coordinate = 0x1p-64 * double(sequence());
  return points;
}

// Equations and default values of table 1 of the tutorial, without negative weights.
CmaEs::Rates CmaEs::rates(double n, int count) {
  Rates r;
  r.weights = Eigen::VectorXd::NullaryExpr(
      count / 2, [&](Eigen::Index i) { return std::log((count + 1) / 2.0) - std::log(1.0 + double(i)); });
  r.weights /= r.weights.sum();
  r.mu_eff = 1 / r.weights.squaredNorm();
  r.c_sigma = (r.mu_eff + 2) / (n + r.mu_eff + 5);
  r.d_sigma = 1 + 2 * std::max(0.0, std::sqrt((r.mu_eff - 1) / (n + 1)) - 1) + r.c_sigma;
  r.c_c = (4 + r.mu_eff / n) / (n + 4 + 2 * r.mu_eff / n);
  r.c_1 = 2 / ((n + 1.3) * (n + 1.3) + r.mu_eff);
  r.c_mu = std::min(1 - r.c_1, 2 * (0.25 + r.mu_eff + 1 / r.mu_eff - 2) / ((n + 2) * (n + 2) + r.mu_eff));
  r.expected_length = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
  return r;
}

CmaEs::CmaEs(const std::vector<double>& start, double step, int count, std::uint64_t seed)
    : count_(count), rates_(rates(double(start.size()), count)), sigma_(step), random_(seed, "cma-es") {
  const auto n = Eigen::Index(start.size());
  mean_ = Eigen::Map<const Eigen::VectorXd>(start.data(), n);
  p_sigma_ = p_c_ = Eigen::VectorXd::Zero(n);
  D_ = Eigen::VectorXd::Ones(n);
  C_ = B_ = Eigen::MatrixXd::Identity(n, n);
  asked_.resize(n, count_);
}

Eigen::VectorXd CmaEs::sample() {
  Eigen::VectorXd z(mean_.size());
  for (double& value : z) value = random_.normal();
  const Eigen::VectorXd x = mean_ + sigma_ * (B_ * D_.cwiseProduct(z));
  return x.unaryExpr([](double value) { return reflected(value); });
}

std::vector<std::vector<double>> CmaEs::ask() {
  std::vector<std::vector<double>> all;
  for (int k = 0; k < count_; ++k) {
    asked_.col(k) = sample();
    all.emplace_back(asked_.col(k).begin(), asked_.col(k).end());
  }
  return all;
}

void CmaEs::tell(const std::vector<double>& values) {
  std::vector<Eigen::Index> order(values.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::stable_sort(
      order, [&](Eigen::Index a, Eigen::Index b) { return values[std::size_t(a)] < values[std::size_t(b)]; });
  order.resize(std::size_t(rates_.weights.size()));
  const Eigen::MatrixXd Y = (asked_(Eigen::all, order).colwise() - mean_) / sigma_;
  const Eigen::VectorXd step = Y * rates_.weights;  // eq. (41)
  mean_ += sigma_ * step;
  adapt(step);
  C_ += rates_.c_mu * (Y * rates_.weights.asDiagonal() * Y.transpose());  // the rest of eq. (47)
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen((C_ + C_.transpose()) / 2);
  B_ = eigen.eigenvectors();
  D_ = eigen.eigenvalues().cwiseMax(1e-20).cwiseSqrt();
  ++generation_;
}

// Updates paths, step size, and the terms of eq. (47) except the rank-mu update.
void CmaEs::adapt(const Eigen::VectorXd& step) {
  const Eigen::VectorXd white = B_ * (B_.transpose() * step).cwiseQuotient(D_);  // C^(−1/2) y
  p_sigma_ = (1 - rates_.c_sigma) * p_sigma_ +
             std::sqrt(rates_.c_sigma * (2 - rates_.c_sigma) * rates_.mu_eff) * white;  // eq. (43)
  const double length = p_sigma_.norm();
  const double settled = std::sqrt(1 - std::pow(1 - rates_.c_sigma, 2 * (generation_ + 1)));
  const bool straight = length / settled < (1.4 + 2 / (double(mean_.size()) + 1)) * rates_.expected_length;
  p_c_ *= 1 - rates_.c_c;
  if (straight) p_c_ += std::sqrt(rates_.c_c * (2 - rates_.c_c) * rates_.mu_eff) * step;  // eq. (45)
  const double kept =
      1 - rates_.c_1 - rates_.c_mu + (straight ? 0 : rates_.c_1 * rates_.c_c * (2 - rates_.c_c));
  C_ = kept * C_ + rates_.c_1 * p_c_ * p_c_.transpose();
  sigma_ *= std::exp(
      std::min(1.0, rates_.c_sigma / rates_.d_sigma * (length / rates_.expected_length - 1)));  // eq. (44)
}

}  // namespace sim::trials
