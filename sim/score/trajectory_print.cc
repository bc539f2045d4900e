#include "sim/score/trajectory_print.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "sim/files/json.h"

namespace sim::score {
namespace {

using nlohmann::ordered_json;

// The numbers of a row under their names, as the field quotes them.
std::vector<std::pair<std::string, double>> numbers(const ErrorStatistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std}, {"min", s.min},
          {"max", s.max},   {"p95", s.p95},   {"p99", s.p99},       {"sse", s.sse}};
}

std::string line(const TrajectoryRow& row) {
  const std::string name = fmt::format("{} [{}]", row.name, row.unit);
  if (!row.statistics) return fmt::format("{:<33} {}\n", name, row.reason);
  const ErrorStatistics& s = *row.statistics;
  return fmt::format("{:<33} {:>5} {:>9.5g} {:>9.5g} {:>9.5g} {:>9.5g}\n", name, s.n, s.rmse, s.median, s.p95,
                     s.max);
}

}  // namespace

std::string trajectory_table(const TrajectoryReport& r) {
  std::string text =
      fmt::format("truth     {}\nestimate  {}\nmatched   {} of {} poses ({}); {:.3f} m walked\n", r.truth,
                  r.estimate, r.matched, r.poses, r.pairing, r.path_m);
  text += fmt::format("alignment {}", r.alignment);
  text += r.similarity.scale == 1 ? "\n\n" : fmt::format(", scale {:.6f}\n\n", r.similarity.scale);
  text += fmt::format("{:<33} {:>5} {:>9} {:>9} {:>9} {:>9}\n", "error", "n", "rmse", "median", "p95", "max");
  for (const TrajectoryRow& row : r.rows) text += line(row);
  return text;
}

std::string trajectory_json(const TrajectoryReport& r) {
  ordered_json json{{"truth", r.truth},         {"estimate", r.estimate},     {"poses_matched", r.matched},
                    {"poses", r.poses},         {"pairing", r.pairing},       {"path_length_m", r.path_m},
                    {"alignment", r.alignment}, {"scale", r.similarity.scale}};
  json["errors"] = ordered_json::array();
  for (const TrajectoryRow& row : r.rows) {
    ordered_json entry{{"error", row.name}, {"unit", row.unit}};
    if (row.statistics) {
      entry["n"] = row.statistics->n;
      for (const auto& [name, value] : numbers(*row.statistics)) entry[name] = value;
    } else {
      entry["n"] = 0;
      entry["reason"] = row.reason;
    }
    json["errors"].push_back(entry);
  }
  return files::json_text(json, 2) + "\n";
}

std::string trajectory_csv(const TrajectoryReport& r) {
  std::string text = "error,unit,n,rmse,mean,median,std,min,max,p95,p99,sse\n";
  for (const TrajectoryRow& row : r.rows) {
    text += fmt::format("\"{}\",{},{}", row.name, row.unit, row.statistics ? row.statistics->n : 0);
    for (const auto& [name, value] : numbers(row.statistics.value_or(ErrorStatistics{})))
      text += row.statistics ? fmt::format(",{}", value) : ",";
    text += '\n';
  }
  return text;
}

std::string trajectory_latex(const TrajectoryReport& r) {
  std::string text =
      "\\begin{tabular}{lrrrrrr}\n\\hline\nerror & $n$ & RMSE & mean & median & std & max \\\\\n\\hline\n";
  for (const TrajectoryRow& row : r.rows) {
    if (!row.statistics) continue;
    const ErrorStatistics& s = *row.statistics;
    const std::string unit = row.unit == "%" ? "\\%" : row.unit;
    text += fmt::format("{} [{}] & {} & {:.4g} & {:.4g} & {:.4g} & {:.4g} & {:.4g} \\\\\n", row.name, unit,
                        s.n, s.rmse, s.mean, s.median, s.std, s.max);
  }
  return text + "\\hline\n\\end{tabular}\n";
}

}  // namespace sim::score
