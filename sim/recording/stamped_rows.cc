#include "sim/recording/stamped_rows.h"

#include <fmt/format.h>

#include <utility>

namespace sim::recording {
namespace {

constexpr std::int64_t kLastStamp = 9'000'000'000'000'000'000;  // ns: sums and differences stay in range

}  // namespace

StampedRows::StampedRows(files::CsvReader csv, slam::Stamp epoch) : csv_(std::move(csv)), epoch_(epoch) {
  advance();
}

void StampedRows::advance() {
  const std::optional<slam::Stamp> before = stamp_;
  stamp_.reset();
  if (!csv_.next()) return;
  const std::int64_t ns = csv_.integer(0);
  if (ns < 0 || ns > kLastStamp) csv_.fail(0, fmt::format("expected a stamp from 0 to {} ns", kLastStamp));
  stamp_ = slam::Stamp(ns) - epoch_;
  if (before && *stamp_ <= *before) csv_.fail(0, "the stamp is not after the one before");
}

}  // namespace sim::recording
