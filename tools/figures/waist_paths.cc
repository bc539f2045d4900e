// Planned and executed path of the waist, as in Fig. 1 of Stasse et al. 2006: waist_paths OUT.svg
// NAME=RESULT... (the plan is the first result's; NAME is what the legend calls a result).
#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "sim/files/atomic_file.h"
#include "sim/files/trajectory_file.h"
#include "sim/report/figure.h"

namespace {

using namespace sim;

report::Line path(const std::string& name, report::Role role, const std::filesystem::path& tum) {
  report::Line line{name, role};
  for (const files::TumRow& row : files::read_tum(tum)) {
    line.x.push_back(row.X.translation().x());
    line.y.push_back(row.X.translation().y());
  }
  return line;
}

report::Figure figure(int count, char** arguments) {
  report::Figure figure{"waist_paths", "Waist, planned and executed", "x, m", "y, m"};
  figure.equal_axes = true;
  constexpr std::array kRoles{report::Role::first, report::Role::second, report::Role::third};
  if (count > static_cast<int>(kRoles.size())) throw std::runtime_error("at most three results");
  for (int i = 0; i < count; ++i) {
    const std::string argument = arguments[i];
    const auto equals = argument.find('=');
    if (equals == std::string::npos) throw std::runtime_error(argument + ": expected NAME=RESULT");
    const std::filesystem::path result = argument.substr(equals + 1);
    if (i == 0) figure.lines.push_back(path("plan", report::Role::plan, result / "waist_plan.tum"));
    figure.lines.push_back(path(argument.substr(0, equals), kRoles[i], result / "waist_truth.tum"));
  }
  return figure;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 3) return std::fputs("usage: waist_paths OUT.svg NAME=RESULT...\n", stderr), 2;
  files::write_atomically(arguments[1], report::to_svg(figure(count - 2, arguments + 2), 760, 620));
} catch (const std::exception& error) {
  std::fprintf(stderr, "waist_paths: %s\n", error.what());
  return 2;
}
