#include "tools/cli/shared/options.h"

#include <fmt/ranges.h>

#include <cstdlib>
#include <iostream>
#include <set>

#include "sim/files/json.h"
#include "tools/cli/jobs/jobs.h"

namespace cli {
namespace {

void require_model(const scenario::ReadScenario& read, const std::string& key, const std::string& name,
                   const std::set<std::string>& known) {
  if (known.contains(name)) return;
  const auto set_by = read.origin.find(key);
  const std::vector<std::string_view> candidates(known.begin(), known.end());
  throw scenario::ConfigError(fmt::format("{}: {}: is '{}', expected one of {}{}",
                                          set_by == read.origin.end() ? read.scenario.name : set_by->second,
                                          key, name, fmt::join(known, ", "),
                                          scenario::did_you_mean(name, candidates)));
}

}  // namespace

void add_quiet(CLI::App& command) {
  command.add_flag_callback(
      "-q,--quiet", [] { choose_output(Output::quiet); }, "print only errors");
}

void add_output(CLI::App& command) {
  add_quiet(command);
  const auto choose = [] { choose_output(Output::json); };
  command.add_flag_callback("--json", choose, "print one JSON document (schemas/outcome.schema.json)")
      ->excludes("--quiet");
}

void add_backend_options(CLI::App& command, Backend& backend) {
  command.add_option("--jobs", backend.jobs, "processes at a time (default 1), or array elements on Slurm")
      ->check(CLI::Range(1, 100000));
  add_backend(command, backend.name);
}

void add_backend(CLI::App& command, std::string& name) {
  command.add_option("--backend", name, "local: processes on this machine; slurm: a job array on a cluster")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
}

CLI::Option* add_scenario(CLI::App& command, std::string& file, scenario::Changes& changes) {
  CLI::Option* const option = command.add_option("scenario", file, "the scenario's YAML file");
  add_overrides(command, changes.overrides, "(gaitslam config --keys lists the keys)");
  add_with(command, changes);
  add_without(command, changes);
  return option;
}

void join_batch(const BatchMember& member, scenario::ReadScenario* read) {
  if (member.parent) die_with(*member.parent);
  if (!member.set_by || !read) return;
  read->origin.clear();
  for (const auto& [key, by] : files::read_json(*member.set_by).entries()) read->origin[key] = by.text();
}

void require_one_of(const std::vector<std::string>& names, const std::string& typed,
                    const std::string& option) {
  if (std::ranges::count(names, typed) > 0) return;
  throw UsageError("{}: expected one of {}, not '{}'{}", option, fmt::join(names, ", "), typed,
                   scenario::did_you_mean(typed, names));
}

score::Alignment alignment_named(const std::string& name) {
  if (const auto alignment = score::alignment_of(name)) return *alignment;
  throw UsageError("--align {}: expected none, origin, yaw, se3, sim3 or scale", name);
}

std::vector<std::uint64_t> parse_seeds(const std::string& text) {
  try {
    return scenario::parse_seeds(text);
  } catch (const std::invalid_argument& e) {
    throw UsageError("--seeds {}: {}", text, e.what());
  }
}

void add_view_place(CLI::App& command, Access& place) {
  command.add_option("--port", place.port, "port of the view; 0: any free port")->capture_default_str();
  command
      .add_option("--address", place.address,
                  "listening address; an address that others can reach needs a --token")
      ->capture_default_str();
  command
      .add_option("--public", place.forwarded,
                  "HOST:PORT or https://HOST[/PATH] that browsers on other machines use, through ssh -L or a "
                  "proxy; may be given several times")
      ->allow_extra_args(false);
  command
      .add_option("--token", place.token,
                  "secret in the URL: at least 22 letters, digits, - or _ (default: random)")
      ->envname("GAITSLAM_VIEW_TOKEN");  // other users of the machine cannot read it there
}

void add_view(CLI::App& command, ViewRequest& request) {
  CLI::Option* const view =
      command.add_flag("--view", request.view, "show the walk live in the browser (prints a URL)");
  command.add_flag("--control", request.control, "let viewers pause, step and slow down")->needs(view);
  command.add_flag("--wait", request.wait, "wait until the view is open in a browser")->needs(view);
  add_view_place(command, request);
  for (const char* option : {"--port", "--address", "--public"}) command.get_option(option)->needs(view);
  if (!std::getenv("GAITSLAM_VIEW_TOKEN")) command.get_option("--token")->needs(view);
  request.opened = print_view;
}

// With --json, standard output is reserved for the document.
void print_view(const std::string& url) {
  (output() == Output::text ? std::cout : std::cerr) << "view at " << url << std::endl;
}

// A room file contains shapes; a file included by rooms contains none.
void require_models(const scenario::ReadScenario& read, const fs::path& models) {
  std::set<std::string> robots, rooms;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(models, fault)) {
    if (entry.path().extension() != ".xml") continue;
    const std::string text = files::read_text(entry.path());
    if (text.find("<geom", std::min(text.size(), text.find("<worldbody"))) != text.npos)
      rooms.insert(entry.path().stem());
  }
  if (rooms.empty()) throw files::FileError(models, "has no models");
  const physics::NameOrPath& robot = read.scenario.world.robot;
  const fs::path folder = scenario::robot_folder(robot);
  if (!fs::exists(folder / "robot.yaml", fault)) {
    if (robot.is_path())
      fail(scenario::place_of(read, "world.robot"), "world.robot",
           fmt::format("{} has no robot.yaml; 'gaitslam robot init' writes one", std::string(robot)));
    for (const auto& entry : fs::directory_iterator(folder.parent_path(), fault))
      robots.insert(entry.path().filename());
    require_model(read, "world.robot", robot, robots);
  }
  const physics::NameOrPath& room = read.scenario.world.room;
  if (!room.is_path()) return require_model(read, "world.room", room, rooms);
  if (!fs::is_regular_file(std::string(room), fault))
    fail(scenario::place_of(read, "world.room"), "world.room",
         fmt::format("{} does not exist", std::string(room)));
}

}  // namespace cli
