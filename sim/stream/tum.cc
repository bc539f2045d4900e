#include "sim/stream/tum.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string_view>

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

struct Field {
  std::string_view text;
  std::size_t column;  // from 1
};

std::vector<Field> split(std::string_view line) {
  std::vector<Field> fields;
  for (std::size_t at = 0; (at = line.find_first_not_of(" \t\r", at)) != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
    fields.push_back({line.substr(at, end - at), at + 1});
    at = end;
  }
  return fields;
}

// A line being read: its fields, and where it is for complaints.
struct Line {
  const std::filesystem::path& file;
  std::size_t number;
  std::vector<Field> fields;

  [[noreturn]] void fail(std::size_t field, const std::string& why) const {
    throw FileError(file, number, fields[field].column, why);
  }

  double value(std::size_t field) const {
    const std::string_view text = fields[field].text;
    double x = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(x))
      fail(field, fmt::format("expected a finite number, found \"{}\"", text));
    return x;
  }

  // Decimal seconds to nanoseconds without going through a double, which holds today's date to 100 ns only.
  nanoseconds stamp(std::size_t field) const {
    const std::string_view text = fields[field].text;
    const double approximately = value(field);
    if (std::abs(approximately) > 9e9) fail(field, "a time of more than 9e9 s: is it in nanoseconds?");
    const std::size_t dot = text.find('.');
    if (text.find_first_of("eE") != text.npos) return nanoseconds(std::llround(approximately * 1e9));
    std::int64_t whole = 0, digit = kSecond / 10, fraction = 0;
    std::from_chars(text.data(), text.data() + std::min(dot, text.size()), whole);
    for (std::size_t i = dot == text.npos ? text.size() : dot + 1; i < text.size(); ++i, digit /= 10)
      fraction += (text[i] - '0') * digit;
    return nanoseconds(whole * kSecond + (text.front() == '-' ? -fraction : fraction));
  }

  Eigen::Isometry3d pose() const {
    const Eigen::Quaterniond q(value(7), value(4), value(5), value(6));
    if (std::abs(q.norm() - 1) > 1e-2) fail(4, "the quaternion is not of length 1");
    Eigen::Isometry3d X(q.normalized());
    X.translation() = Eigen::Vector3d(value(1), value(2), value(3));
    return X;
  }

  Matrix6d covariance() const {
    Matrix6d P = Matrix6d::Zero();
    std::size_t field = 8;
    for (const int first : {0, 3})
      for (int row = first; row < first + 3; ++row)
        for (int column = row; column < first + 3; ++column) P(row, column) = P(column, row) = value(field++);
    return P;
  }
};

TumRow parse(const Line& line) {
  const std::size_t n = line.fields.size();
  if (n != 8 && n != 20)
    throw FileError(line.file, line.number, fmt::format("expected 8 or 20 numbers, found {}", n));
  TumRow row;
  row.t = line.stamp(0);
  row.X = line.pose();
  if (n == 20) row.covariance = line.covariance();
  return row;
}

}  // namespace

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
    const Line line{file, number, split(text)};
    if (line.fields.empty() || line.fields[0].text.front() == '#') continue;
    rows.push_back(parse(line));
    if (rows.size() > 1 && rows.back().t <= rows[rows.size() - 2].t)
      line.fail(0, "the stamp is not after the one before");
  }
  if (input.bad()) throw FileError(file, "cannot be read");
  return rows;
}

}  // namespace sim::stream
