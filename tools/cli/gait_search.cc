#include "tools/cli/gait_search.h"

#include <stdlib.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <thread>

#include "sim/files/atomic_file.h"
#include "sim/live/short_walks.h"
#include "sim/scenario/robot.h"
#include "sim/score/trajectory.h"
#include "sim/trials/values.h"

namespace cli {
namespace {

using physics::Gait;
using trials::Range;
using Point = std::vector<double>;

constexpr std::size_t kFinalists = 3;
constexpr std::uint64_t kPlant = 101, kLastPlant = 103,
                        kLastStart = 112;  // apart from the seeds of ordinary runs
constexpr double kFirstStep = 0.15;
// The search ends if walks cost no more than this: a tenth of their paths in slip and errors of their ends.
constexpr double kGoodWalk = 1;

/// The searched values and where they are in a gait.
struct Axis {
  double Gait::*value;
  Range range;
};
const std::vector<Axis>& axes() {
  const auto axis = [](double Gait::*value, double low, double high, bool logarithmic) {
    return Axis{value, {.low = low, .high = high, .logarithmic = logarithmic}};
  };
  static const std::vector<Axis> all{axis(&Gait::single_support_s, 0.3, 0.8, true),
                                     axis(&Gait::double_support_s, 0.02, 0.2, false),
                                     axis(&Gait::step_height_m, 0.02, 0.06, true),
                                     axis(&Gait::step_length_m, 0.03, 0.15, true),
                                     axis(&Gait::zmp_inwards_m, 0, 0.04, false),
                                     axis(&Gait::ankle_kp, 0.5, 4, true),
                                     axis(&Gait::ankle_kd, 0.5, 5, true)};
  return all;
}
Point point_of(const Gait& gait) {
  Point point;
  for (const Axis& axis : axes()) point.push_back(axis.range.coordinate_of(gait.*axis.value));
  return point;
}
/// Three digits, as robot.yaml has them.
Gait gait_at(const Point& point) {
  Gait gait;
  for (std::size_t i = 0; i < point.size(); ++i)
    gait.*axes()[i].value = std::stod(fmt::format("{:.3g}", axes()[i].range.value_at(point[i])));
  return gait;
}

/// Timings, heights and gains with which many public robots walk whose first guess fell.
std::vector<Gait> first_gaits(const Gait& guess) {
  const double length = std::min(0.08, guess.step_length_m);
  return {guess,
          {.single_support_s = 0.45, .step_length_m = length, .zmp_inwards_m = 0, .ankle_kd = 3},
          {.single_support_s = 0.35, .step_length_m = length, .zmp_inwards_m = 0.02, .ankle_kp = 2},
          {.single_support_s = 0.35, .step_length_m = std::min(0.06, length)}};
}

constexpr int kWalks = 6;

/// How a gait does over short walks.
struct Rating {
  int walks = 0, arrived = 0;
  double cost = 0;  ///< sum over the walks; each fall counts more than any completed walk
  double limited = 0, yaw_rad = 0, slip = 0;  ///< of completed walks: largest share; largest; largest share
  live::LegNoises noises;                     ///< of completed walks

  void add(const live::Walked& walk) {
    constexpr double kFall = 6, kYaw_rad_m = 3 * score::kDegree, kShare = 0.1;
    ++walks;
    if (!walk.problem.empty()) return void(cost += kFall + 2 * kFall * (1 - walk.lasted));
    // Relative errors, so that a short walk in short steps is no better than a longer one.
    const double path = std::max(walk.path_m, 0.3),
                 yaw = walk.yaw_error_rad / (kYaw_rad_m * path + kShare * walk.turn_rad);
    arrived += walk.complaint().empty();
    cost += std::min(kFall, walk.limited + yaw + (walk.error_m + walk.slip_m) / (kShare * path));
    noises.add(walk.noises);
    limited = std::max(limited, walk.limited);
    yaw_rad = std::max(yaw_rad, walk.yaw_error_rad);
    slip = std::max(slip, walk.slip_m / path);
  }
  void add(const Rating& other) {
    walks += other.walks, arrived += other.arrived, cost += other.cost;
    limited = std::max(limited, other.limited), yaw_rad = std::max(yaw_rad, other.yaw_rad);
    slip = std::max(slip, other.slip);
    noises.add(other.noises);
  }
  std::string text() const {
    return fmt::format(
        "arrives at the end of {} of {} short walks (ahead, back, to both sides, both turns; {}); heading at "
        "most {:.0f} deg off, torques of legs at their limits in at most {:.0f} % of a walk, soles slip by "
        "at most {:.0f} % of a path",
        arrived, walks, walks > kWalks ? "plants of three seeds" : "plant of one seed",
        yaw_rad / score::kDegree, 1e2 * limited, 1e2 * slip);
  }
};
bool is_better(const Rating& one, const Rating& other) {
  return std::pair(-one.arrived, one.cost) < std::pair(-other.arrived, other.cost);
}

/// A robot.yaml in a temporary folder, which the destructor removes.
class TemporaryRobot {
 public:
  explicit TemporaryRobot(const std::string& robot_yaml) {
    std::string pattern = (fs::temp_directory_path() / "gaitslam-robot-XXXXXX").string();
    if (!mkdtemp(pattern.data())) files::fail_by_errno(pattern, "cannot be made");
    folder_ = pattern;
    files::write_text(folder_ / "robot.yaml", robot_yaml);
  }
  ~TemporaryRobot() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  TemporaryRobot(const TemporaryRobot&) = delete;
  TemporaryRobot& operator=(const TemporaryRobot&) = delete;
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

class Walker {
 public:
  explicit Walker(const fs::path& model) : model_(fs::absolute(model)), first_(model) {}

  const physics::FirstRobotFile& first() const { return first_; }

  /// A gait on the plant of a seed. The first plant's robot has rigid arms.
  struct Trial {
    Gait gait;
    std::uint64_t plant = kPlant;
  };
  /// Walks all trials, several at a time.
  std::vector<Rating> rate(const std::vector<Trial>& trials, const std::function<void()>& one_done) const {
    std::vector<Rating> ratings(trials.size());
    std::atomic<std::size_t> next = 0;
    std::vector<std::jthread> threads;
    const auto work = [&] {
      for (std::size_t i = next++; i < trials.size(); i = next++) {
        ratings[i] = rate(trials[i]);
        one_done();
      }
    };
    for (unsigned k = 1; k < std::min<std::size_t>(std::thread::hardware_concurrency(), trials.size()); ++k)
      threads.emplace_back(work);
    work();
    return threads.clear(), ratings;
  }

  /// Stands on the plants of further seeds, which also differ in how they start.
  live::LegNoises starts(const Gait& gait) const {
    const auto [scenario, models] = load(first_.yaml(model_.string(), gait, "tried"));
    live::LegNoises noises;
    for (std::uint64_t seed = kLastPlant + 1; seed <= kLastStart; ++seed)
      noises.add(live::walked(scenario, models, {walking::Stand{walking::kPeriod}}, seed).noises);
    return noises;
  }

 private:
  Rating rate(const Trial& trial) const try {
    const auto [scenario, models] =
        load(trial.plant == kPlant ? first_.trial(model_.string(), trial.gait)
                                   : first_.yaml(model_.string(), trial.gait, "tried"));
    Rating rating;
    bool fell = false;
    for (const live::ShortWalk& walk : live::short_walks(scenario.walk)) {
      const live::Walked result = fell ? live::Walked{.problem = "not walked after another fall"}
                                       : live::walked(scenario, models, walk.commands, trial.plant);
      fell |= !result.problem.empty();
      rating.add(result);
    }
    return rating;
  } catch (const std::exception&) {  // a robot that cannot stand with these values
    Rating none;
    for (int i = 0; i < kWalks; ++i) none.add({.problem = "does not load"});
    return none;
  }

  /// MuJoCo's reader is not safe for threads.
  static std::pair<scenario::Scenario, physics::Models> load(const std::string& robot_yaml) {
    static std::mutex mutex;
    const std::scoped_lock lock(mutex);
    const TemporaryRobot robot(robot_yaml);  // removed before the walks, which take most of the time
    const fs::path& folder = robot.folder();
    const physics::RobotFile file = scenario::read_robot(folder);
    const std::string text =
        fmt::format("world: {{robot: {}, room: floor}}\nwalk: {{commands: [{{stand: {{}}}}]}}\n",
                    files::quote_if_needed((folder / "").string()));
    return {scenario::read_scenario_text(text, "gait").scenario,
            physics::Models(adapt(file).root, file, physics::kPhysicalRoom, scenario::standard_models())};
  }

  fs::path model_;
  physics::FirstRobotFile first_;
};

struct Rated {
  Gait gait;
  Rating rating;
};

}  // namespace

void search_gait(const fs::path& model, const std::string& model_written, const GaitSearch& search,
                 const std::function<void(const std::string&)>& better,
                 const std::function<void(double, const std::string&)>& show) {
  const Walker walker(model);
  std::vector<Rated> all;  // the best first
  const auto write = [&](const Rated& rated, const std::string& noises) {
    better(
        walker.first().yaml(model_written, rated.gait, "found by walking: " + rated.rating.text(), noises));
  };
  better(walker.first().yaml(model_written, walker.first().guessed_gait(), "guess: not walked yet"));

  const std::vector<Gait> first = first_gaits(walker.first().guessed_gait());
  const double total = double(first.size()) + search.generations * search.population +
                       double((kLastPlant - kPlant) * kFinalists);
  std::mutex mutex;
  int done = 0;
  const auto rate = [&](const std::vector<Walker::Trial>& trials) {
    return walker.rate(trials, [&] {
      const std::scoped_lock lock(mutex);
      show(++done / total, all.empty() ? ""
                                       : fmt::format("best gait arrives {} of {} times",
                                                     all[0].rating.arrived, all[0].rating.walks));
    });
  };
  const auto try_gaits = [&](const std::vector<Gait>& some) {
    std::vector<Walker::Trial> trials;
    for (const Gait& gait : some) trials.push_back({gait});
    const std::vector<Rating> ratings = rate(trials);
    std::vector<double> costs;
    for (std::size_t i = 0; i < some.size(); ++i) {
      costs.push_back(ratings[i].cost);
      const bool best = all.empty() || is_better(ratings[i], all[0].rating);
      all.insert(std::ranges::upper_bound(all, ratings[i], is_better, &Rated::rating), {some[i], ratings[i]});
      if (best) write(all[0], "");
    }
    return costs;
  };

  try_gaits(first);
  trials::CmaEs cma_es(point_of(all[0].gait), kFirstStep, search.population, search.seed);
  const auto is_good = [&] {
    const Rating& best = all[0].rating;
    return best.arrived == best.walks && best.cost <= kGoodWalk * best.walks;
  };
  for (int generation = 0; generation < search.generations && !is_good(); ++generation) {
    std::vector<Gait> gaits;
    for (const Point& point : cma_es.ask()) gaits.push_back(gait_at(point));
    cma_es.tell(try_gaits(gaits));
  }
  all.resize(kFinalists);
  const auto found = [&]() -> Rated& {
    for (Rated& finalist : all) {
      std::vector<Walker::Trial> trials;
      for (std::uint64_t plant = kPlant + 1; plant <= kLastPlant; ++plant)
        trials.push_back({finalist.gait, plant});
      for (const Rating& rating : rate(trials)) finalist.rating.add(rating);
      if (finalist.rating.arrived == finalist.rating.walks) return finalist;
    }
    return *std::ranges::min_element(all, is_better, &Rated::rating);
  };
  Rated& chosen = found();
  if (chosen.rating.arrived > 0) chosen.rating.noises.add(walker.starts(chosen.gait));
  write(chosen, chosen.rating.arrived > 0 ? chosen.rating.noises.yaml() : "");
}

}  // namespace cli
