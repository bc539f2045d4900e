#include "sim/files/tum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sim::files {
namespace {

using std::chrono::nanoseconds;
constexpr std::int64_t kSecond = 1'000'000'000;

std::string seconds(nanoseconds t) {
  const std::int64_t ns = t.count(), whole = ns / kSecond, rest = std::abs(ns % kSecond);
  return fmt::format("{}{}.{:09}", ns < 0 && whole == 0 ? "-" : "", whole, rest);
}

std::string triangle(const Matrix6d& P, int first) {
  std::string text;
  for (int row = first; row < first + 3; ++row)
    for (int column = row; column < first + 3; ++column) text += fmt::format(" {}", P(row, column));
  return text;
}

std::string pose(nanoseconds t, const Eigen::Isometry3d& X) {
  Eigen::Quaterniond q(X.linear());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d p = X.translation();
  return fmt::format("{} {} {} {} {} {} {} {}", seconds(t), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

Matrix6d covariance(const TextLine& line) {
  Matrix6d P = Matrix6d::Zero();
  std::size_t field = 8;
  for (const int first : {0, 3})
    for (int row = first; row < first + 3; ++row)
      for (int column = row; column < first + 3; ++column)
        P(row, column) = P(column, row) = line.number(field++);
  return P;
}

}  // namespace

const char* const kTumCovarianceHeader =
    "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11 Pt12 Pt13 Pt22 Pt23 Pt33\n";

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X) { return pose(t, X) + "\n"; }

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X, const Matrix6d& covariance) {
  return pose(t, X) + triangle(covariance, 0) + triangle(covariance, 3) + "\n";
}

TumRow parse_tum_row(const TextLine& line, TextLine::Unit unit) {
  const std::size_t n = line.size();
  if (n != 8 && n != 20) line.fail(fmt::format("expected 8 or 20 numbers, found {}", n));
  TumRow row;
  row.t = line.stamp(0, unit);
  row.X = parse_pose(line, 7, 4);
  if (n == 20) row.covariance = covariance(line);
  return row;
}

double coordinate(const TextLine& line, std::size_t field) {
  constexpr double kMost_m = 1e9;
  const double value = line.number(field);
  if (!(std::abs(value) <= kMost_m)) line.fail(field, "a position of more than 1e9 m");
  return value;
}

Eigen::Isometry3d parse_pose(const TextLine& line, std::size_t w, std::size_t x) {
  const Eigen::Quaterniond q(line.number(w), line.number(x), line.number(x + 1), line.number(x + 2));
  if (std::abs(q.norm() - 1) > 1e-2) line.fail(std::min(w, x), "the quaternion is not of length 1");
  Eigen::Isometry3d X(q.normalized());
  X.translation() = Eigen::Vector3d(coordinate(line, 1), coordinate(line, 2), coordinate(line, 3));
  return X;
}

void require_rising_stamps(const std::vector<TumRow>& rows, const std::vector<TextLine>& lines) {
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].t <= rows[i - 1].t) lines[i].fail(0, "the stamp is not after the one before");
}

std::vector<TumRow> read_tum(const std::filesystem::path& file) {
  const TextLines text(file);
  std::vector<TumRow> rows;
  for (const TextLine& line : text.lines()) rows.push_back(parse_tum_row(line, TextLine::Unit::seconds));
  require_rising_stamps(rows, text.lines());
  return rows;
}

}  // namespace sim::files
