#include "sim/stream/tum.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>

#include "sim/stream/text_line.h"
namespace sim::stream {
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

TumRow parse(const TextLine& line) {
  const std::size_t n = line.size();
  if (n != 8 && n != 20) line.fail(fmt::format("expected 8 or 20 numbers, found {}", n));
  TumRow row;
  row.t = line.stamp(0, TextLine::Unit::seconds);
  row.X = tum_pose(line);
  if (n == 20) row.covariance = tum_covariance(line);
  return row;
}

}  // namespace

Eigen::Isometry3d tum_pose(const TextLine& line) {
  const Eigen::Quaterniond q(line.number(7), line.number(4), line.number(5), line.number(6));
  if (std::abs(q.norm() - 1) > 1e-2) line.fail(4, "the quaternion is not of length 1");
  Eigen::Isometry3d X(q.normalized());
  X.translation() = Eigen::Vector3d(line.number(1), line.number(2), line.number(3));
  return X;
}

Matrix6d tum_covariance(const TextLine& line) {
  Matrix6d P = Matrix6d::Zero();
  std::size_t field = 8;
  for (const int first : {0, 3})
    for (int row = first; row < first + 3; ++row)
      for (int column = row; column < first + 3; ++column)
        P(row, column) = P(column, row) = line.number(field++);
  return P;
}

const char* const kTumCovarianceHeader =
    "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11 Pt12 Pt13 Pt22 Pt23 Pt33\n";

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X) { return pose(t, X) + "\n"; }

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X, const Matrix6d& covariance) {
  return pose(t, X) + triangle(covariance, 0) + triangle(covariance, 3) + "\n";
}

std::vector<TumRow> read_tum(const std::filesystem::path& file) {
  std::ifstream input(file);
  if (!input) throw FileError(file, "cannot be opened");
  std::vector<TumRow> rows;
  std::string text;
  for (std::size_t number = 1; std::getline(input, text); ++number) {
    const TextLine line(file, number, text);
    if (line.is_comment()) continue;
    rows.push_back(parse(line));
    if (rows.size() > 1 && rows.back().t <= rows[rows.size() - 2].t)
      line.fail(0, "the stamp is not after the one before");
  }
  if (input.bad()) throw FileError(file, "cannot be read");
  return rows;
}

}  // namespace sim::stream
