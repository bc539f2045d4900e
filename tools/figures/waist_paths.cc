// Planned and executed path of the waist, as in Fig. 1 of Stasse et al. 2006: waist_paths OUT.svg
// NAME=RESULT... (the plan is the first result's; NAME is what the legend calls a result).
#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "sim/files/durable_file.h"
#include "sim/files/tum.h"
#include "sim/pages/figure.h"

namespace {

using namespace sim;

pages::Line path(const std::string& name, pages::Role role, const std::filesystem::path& tum) {
  pages::Line line{name, role};
  for (const files::TumRow& row : files::read_tum(tum)) {
    line.x.push_back(row.X.translation().x());
    line.y.push_back(row.X.translation().y());
  }
  return line;
}

pages::Figure figure(int count, char** arguments) {
  pages::Figure figure{"waist_paths", "Waist, planned and executed", "x, m", "y, m"};
  figure.equal_axes = true;
  constexpr std::array kRoles{pages::Role::first, pages::Role::second, pages::Role::third};
  if (count > static_cast<int>(kRoles.size())) throw std::runtime_error("at most three results");
  for (int i = 0; i < count; ++i) {
    const std::string argument = arguments[i];
    const auto equals = argument.find('=');
    if (equals == std::string::npos) throw std::runtime_error(argument + ": expected NAME=RESULT");
    const std::filesystem::path result = argument.substr(equals + 1);
    if (i == 0) figure.lines.push_back(path("plan", pages::Role::plan, result / "waist_plan.tum"));
    figure.lines.push_back(path(argument.substr(0, equals), kRoles[i], result / "waist_truth.tum"));
  }
  return figure;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 3) return std::fputs("usage: waist_paths OUT.svg NAME=RESULT...\n", stderr), 2;
  files::write_durably(arguments[1], pages::to_svg(figure(count - 2, arguments + 2), 760, 620));
} catch (const std::exception& error) {
  std::fprintf(stderr, "waist_paths: %s\n", error.what());
  return 2;
}
