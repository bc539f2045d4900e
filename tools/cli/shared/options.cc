#include "tools/cli/shared/options.h"

#include <fmt/ranges.h>

#include <cstdlib>
#include <iostream>
#include <set>

#include "sim/files/json.h"
#include "tools/cli/jobs/jobs.h"

namespace cli {

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

void add_backend_options(CLI::App& command, Backend& backend, const char* jobs) {
  command.add_option("--jobs", backend.jobs, jobs)->check(CLI::Range(1, 100000));
  command
      .add_option("--backend", backend.name,
                  "local: processes on this machine; slurm: a job array on a cluster")
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
  command
      .add_flag("--wait", request.wait,
                "wait for a browser, start in real time, and show the result until Ctrl-C")
      ->needs(view);
  add_view_place(command, request);
  for (const char* option : {"--port", "--address", "--public"}) command.get_option(option)->needs(view);
  if (!std::getenv("GAITSLAM_VIEW_TOKEN")) command.get_option("--token")->needs(view);
  request.opened = print_view;
}

// With --json, standard output is reserved for the document.
void print_view(const std::string& url) {
  (output() == Output::text ? std::cout : std::cerr) << "view at " << url << std::endl;
}

void print_warnings(const scenario::ReadScenario& read) {
  for (const std::string& warning : read.warnings)
    std::cerr << files::sanitize("warning: " + warning) << '\n';
}

void require_models(const scenario::ReadScenario& read, const fs::path& models) {
  std::error_code fault;
  const auto require = [&](const char* key, const physics::NameOrPath& named, const fs::path& file,
                           const fs::path& beside, const char* extension, const char* cure) {
    if (fs::is_regular_file(file, fault)) return;
    std::set<std::string> known;
    for (const auto& entry : fs::directory_iterator(beside, fault))
      if (entry.path().extension() == extension) known.insert(entry.path().stem());
    const std::vector<std::string> names(known.begin(), known.end());
    const std::string text = named;
    fail(scenario::place_of(read, key), key,
         named.is_path() ? fmt::format("{}{}", text, cure)
                         : fmt::format("is '{}', expected one of {}{}", text, fmt::join(names, ", "),
                                       scenario::did_you_mean(text, names)));
  };
  const physics::WorldOptions& world = read.scenario.world;
  const fs::path robot = scenario::robot_folder(world.robot), room = std::string(world.room);
  require("world.robot", world.robot, robot / "robot.yaml", robot.parent_path(), "",
          " has no robot.yaml; 'gaitslam robot init' writes one");
  require("world.room", world.room, world.room.is_path() ? room : models / (room.string() + ".xml"), models,
          ".xml", " does not exist");
}

}  // namespace cli
