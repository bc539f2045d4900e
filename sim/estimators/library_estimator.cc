#include "sim/estimators/library_estimator.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sim/estimators/program_estimator.h"

#define GAITSLAM_ESTIMATOR_SERVE
#include "sim/estimators/gaitslam_estimator.h"

namespace sim::estimators {
namespace {

constexpr std::string_view kHost = "--gaitslam-library-host";             // the first argument of the host
constexpr std::string_view kRefused = "gaitslam: the library is none: ";  // in its log, before the reason

bool main_hosts_libraries = false;

/// A library while it is loaded. All members throw std::invalid_argument.
class Library {
 public:
  explicit Library(const std::string& file)
      : file_(file), handle_(::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) throw std::invalid_argument(fmt::format("cannot be loaded: {}", ::dlerror()));
  }
  ~Library() { ::dlclose(handle_); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  /// function: whose type the named one has.
  template <class Function>
  Function* find(const char* name, Function*) const {
    void* const symbol = ::dlsym(handle_, name);
    if (!symbol)
      throw std::invalid_argument(
          fmt::format("{} has no function {}; see gaitslam_estimator.h", file_, name));
    return reinterpret_cast<Function*>(symbol);
  }

 private:
  std::string file_;
  void* handle_;
};

#define GAITSLAM_FIND(library, function) (library).find(#function, static_cast<decltype(&function)>(nullptr))

gaitslam_functions functions_of(const Library& library, const std::string& file) {
  const std::uint32_t version = GAITSLAM_FIND(library, gaitslam_estimator_version)();
  if (version != GAITSLAM_ESTIMATOR_VERSION)
    throw std::invalid_argument(fmt::format("{} is of version {} of gaitslam_estimator.h, expected {}", file,
                                            version, GAITSLAM_ESTIMATOR_VERSION));
  return {GAITSLAM_FIND(library, gaitslam_estimator_create),
          GAITSLAM_FIND(library, gaitslam_estimator_observe),
          GAITSLAM_FIND(library, gaitslam_estimator_destroy)};
}

#undef GAITSLAM_FIND

}  // namespace

std::optional<int> hosted_library(int argc, char** argv) {
  main_hosts_libraries = true;
  if (argc != 3 || argv[1] != kHost) return std::nullopt;
  std::optional<Library> library;
  gaitslam_functions functions{};
  try {
    library.emplace(argv[2]);
    functions = functions_of(*library, argv[2]);
  } catch (const std::invalid_argument& reason) {
    std::fprintf(stderr, "\n%s%s\n", kRefused.data(), reason.what());
    return 1;
  }
  return gaitslam_serve(&functions);  // what the library throws ends the process
}

Estimator library_estimator(const EstimatorChoice& choice, const Start& start) {
  if (!main_hosts_libraries) throw std::logic_error("main() does not call hosted_library()");
  const std::string& file = choice.words.front();
  try {
    return outside_estimator(
        {"the library " + file,
         {"/proc/self/exe", std::string(kHost), std::filesystem::absolute(file).string()}},
        choice, start);
  } catch (const EstimatorFailed& failure) {
    const std::size_t at = failure.log.rfind(kRefused);
    if (at == std::string::npos) throw;
    std::string_view reason = std::string_view(failure.log).substr(at + kRefused.size());
    throw std::invalid_argument("estimator: " + printable(reason.substr(0, reason.find('\n'))));
  }
}

}  // namespace sim::estimators
