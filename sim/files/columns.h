// Column names, units and units of stamps in external files.
#pragma once

#include <chrono>

#include "sim/files/csv.h"

namespace sim::files {

/// A unit of time: its name and its length in ns.
struct TimeUnit {
  const char* name;
  std::int64_t ns;
};
inline constexpr TimeUnit kTimeUnits[] = {
    {"seconds", 1'000'000'000}, {"milliseconds", 1'000'000}, {"microseconds", 1'000}, {"nanoseconds", 1}};
inline constexpr const TimeUnit &kSeconds = kTimeUnits[0], &kNanoseconds = kTimeUnits[3];

/// Returns a decimal number of this unit, including one such as 1.4e+18, in ns: exactly, unlike a double.
/// Returns nothing if the text is not a number or the time is more than 9e18 ns.
std::optional<std::chrono::nanoseconds> parse_stamp(std::string_view text, const TimeUnit& unit);

/// Returns the median of the positive steps between consecutive stamps, or nothing if there are none.
std::optional<double> median_step(const std::vector<double>& stamps);

/// Returns the unit of a file's stamps, decided from all of them: the stated unit; else the unit that makes
/// them dates from 2001 to 2286; else seconds if they are less than 10 apart; else the unit that brings their
/// step nearest to the expected one. Throws FileError for this file if they cannot have the stated unit.
const TimeUnit& unit_of_stamps(const fs::path& file, const std::vector<double>& stamps,
                               const TimeUnit* stated, double expected_step_s = 0.05);

enum class Quantity { time, position, orientation, angular_rate, acceleration, other };

/// A column of a file: its number, and the factor from its unit to m, rad/s or m/s².
struct Column {
  std::size_t field;
  double factor = 1;
};

/// The columns of a row's stamp.
struct StampColumns {
  std::size_t field = 0;
  const TimeUnit* unit = nullptr;  ///< unit stated in its title, if any
  /// The rest of the stamp in a second column with a finer unit: secs and nsecs, as in ROS.
  std::optional<std::size_t> rest = {};
  const TimeUnit* rest_unit = nullptr;

  /// Returns the stamp of a row in units, rounded to a double.
  double number(const Row& row, const TimeUnit& of) const {
    return row.number(field) +
           (rest ? row.number(*rest) * static_cast<double>(rest_unit->ns) / static_cast<double>(of.ns) : 0);
  }
  /// Returns the stamp of a row, or nothing if parse_stamp() returns nothing. Throws FileError if the second
  /// column is not the rest of a stamp.
  std::optional<std::chrono::nanoseconds> read(const Row& row, const TimeUnit& of) const {
    const auto t = parse_stamp(row.text(field), of);
    if (!t || !rest) return t;
    const auto part = parse_number<std::int64_t>(row.text(*rest));
    if (!part || *part < 0 || *part >= of.ns / rest_unit->ns || t->count() % of.ns != 0)
      row.fail(*rest, "expected whole {} and the rest in whole {} in two columns, as in the header", of.name,
               rest_unit->name);
    return *t + std::chrono::nanoseconds(*part * rest_unit->ns);
  }
};

/// The columns of a pose's covariance, as named in a header: elements of a symmetric matrix in the order
/// orientation, position, with the factor to rad and m. fixed_axes: rotations are about the world's axes (as
/// in ROS messages), not the body's.
struct CovarianceColumns {
  struct Element {
    int row, column;
    Column of;
    bool has_unit;
  };
  std::vector<Element> elements;
  bool fixed_axes = false;
};

/// Returns what is wrong with a stamp that is not later than the previous one.
std::string not_rising(std::chrono::nanoseconds before, std::chrono::nanoseconds stamp);

/// The titles of a file's columns, such as "p_RS_R_x [m]", "tx", "angular_velocity.x" or "gyro_x (deg/s)".
class Header {
 public:
  /// line: its number in the file, for errors.
  Header(fs::path file, std::size_t line, const std::vector<std::string>& titles);
  /// Splits a line at semicolons or commas, or, if it has neither, at whitespace outside brackets.
  Header(fs::path file, std::size_t line, std::string_view text);

  std::size_t size() const { return titles_.size(); }
  /// Returns whether these may be the titles of poses: at least three have an axis.
  bool are_titles() const;
  /// Returns whether these are the titles of rows with that many columns, and not prose. Removes words in
  /// front and adds a missing title of the stamp. Throws FileError if the titles fit neither way.
  bool fit(std::size_t columns, bool commas);
  /// Returns whether a column names this quantity with its axis.
  bool names(Quantity quantity) const;
  /// Returns whether the title of a column is only this axis, such as "x" or "y [mm]".
  bool names_axis(char axis) const;
  /// Returns the columns of a quantity for these axes ("xyz") by their names. If the header does not name
  /// them, they are expected to start at field `first`. Throws FileError if the header names only some of
  /// them, names something else there, or states an unknown unit.
  std::vector<Column> columns(Quantity quantity, std::string_view axes, std::size_t first) const;
  /// Returns the columns of the stamps: a message's header.stamp, else the first with such a title, else 0;
  /// and the rest of that stamp if another column names it. Throws FileError for an unknown unit.
  StampColumns stamp_columns() const;
  /// Returns the columns of the pose's covariance, such as Pr11 (rotation), Pt23 (translation), cov_x_yaw,
  /// position_covariance_8 or pose.covariance[35], or nothing. Throws FileError if one is missing, repeated
  /// or unknown; for rows of twenty columns also if 12 of them are unknown.
  std::optional<CovarianceColumns> covariance_columns(bool twenty) const;

 private:
  struct Title {
    std::string text, unit;
    std::optional<Quantity> quantity;  // absent: unknown name
    char axis = 0;                     // x, y, z, w, or 0
    std::string stem = {};             // its words without unit and axis
    bool of_covariance = false;
    std::optional<std::pair<int, int>> element = {};  // covariance element; absent: an unknown name
    bool fixed_axes = false;
  };
  static Title parse(std::string_view text);
  // Reads the name of a covariance element; returns false if it is not one.
  static bool read_covariance(const std::vector<std::string>& words, Title& title);
  bool fits(std::size_t field, Quantity quantity, char axis, bool named) const;
  double factor(std::size_t field, Quantity quantity) const;
  const TimeUnit* time_unit(std::size_t field) const;
  template <typename... T>
  [[noreturn]] void fail(std::size_t field, fmt::format_string<T...> why, T&&... values) const {
    throw FileError(file_, line_, "column {}, \"{}\": {}", field + 1, titles_[field].text,
                    fmt::format(why, std::forward<T>(values)...));
  }

  fs::path file_;
  std::size_t line_;
  std::vector<Title> titles_;
};

}  // namespace sim::files
