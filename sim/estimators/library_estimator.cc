#include "sim/estimators/library_estimator.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <string.h>

#include <array>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "sim/estimators/messages.h"

namespace sim::estimators {
namespace {

/// A library while it is loaded. All members throw std::invalid_argument.
class Library {
 public:
  explicit Library(const std::string& file)
      : file_(file), handle_(::dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) throw std::invalid_argument(fmt::format("estimator: cannot be loaded: {}", ::dlerror()));
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
          fmt::format("estimator: {} has no function {}; see gaitslam_estimator.h", file_, name));
    return reinterpret_cast<Function*>(symbol);
  }

  const std::string& file() const { return file_; }

 private:
  std::string file_;
  void* handle_;
};

#define GAITSLAM_FIND(library, function) (library).find(#function, static_cast<decltype(&function)>(nullptr))

void require_version(const Library& library) {
  const std::uint32_t version = GAITSLAM_FIND(library, gaitslam_estimator_version)();
  if (version != GAITSLAM_ESTIMATOR_VERSION)
    throw std::invalid_argument(
        fmt::format("estimator: {} is of version {} of gaitslam_estimator.h, expected {}", library.file(),
                    version, GAITSLAM_ESTIMATOR_VERSION));
}

/// The estimator that a library has made, and the library.
class Loaded {
 public:
  Loaded(const EstimatorChoice& choice, const Start& start) : library_(choice.words.front()) {
    require_version(library_);
    observe_ = GAITSLAM_FIND(library_, gaitslam_estimator_observe);
    destroy_ = GAITSLAM_FIND(library_, gaitslam_estimator_destroy);
    const auto create = GAITSLAM_FIND(library_, gaitslam_estimator_create);
    const std::string options = options_text(choice);
    const gaitslam_start words = start_of(start, options.size());
    std::array<char, GAITSLAM_MOST_TEXT_BYTES> error{};
    estimator_ = create(&words, options.c_str(), error.data(), error.size());
    error.back() = '\0';
    if (!estimator_)
      throw EstimatorFailed(
          fmt::format("the library {} cannot start: {}", library_.file(), printable(error.data())));
  }
  ~Loaded() { destroy_(estimator_); }
  Loaded(const Loaded&) = delete;
  Loaded& operator=(const Loaded&) = delete;

  Answer step(const slam::Observation& observation) {
    const ObservationParts parts = parts_of(observation);
    gaitslam_answer answer{};
    answer.t_ns = parts.observation.t_ns;
    for (const int diagonal : {0, 4, 8}) answer.X_WC.rotation[diagonal] = 1;
    const gaitslam_landmark* landmarks = nullptr;
    const char* cause = nullptr;
    const int failed =
        observe_(estimator_, &parts.observation, parts.gyro.data(), parts.accelerometer.data(),
                 parts.image.empty() ? nullptr : parts.image.data, &answer, &landmarks, &cause);
    const std::string_view text(cause ? cause : "", cause ? ::strnlen(cause, GAITSLAM_MOST_TEXT_BYTES) : 0);
    if (failed)
      throw EstimatorFailed(fmt::format("the library {} failed at t = {:.3f} s: {}", library_.file(),
                                        slam::seconds(observation.t), printable(text)));
    if (answer.landmark_count > GAITSLAM_MOST_LANDMARKS || (answer.landmark_count > 0 && !landmarks))
      throw EstimatorFailed(
          fmt::format("the library {} announces {} landmarks, expected at most {}, and where they are",
                      library_.file(), answer.landmark_count, GAITSLAM_MOST_LANDMARKS));
    return answer_of(answer, {landmarks, answer.landmark_count}, text);
  }

 private:
  Library library_;
  decltype(&gaitslam_estimator_observe) observe_ = nullptr;
  decltype(&gaitslam_estimator_destroy) destroy_ = nullptr;
  void* estimator_ = nullptr;
};

#undef GAITSLAM_FIND

}  // namespace

Estimator library_estimator(const EstimatorChoice& choice, const Start& start) {
  const auto loaded = std::make_shared<Loaded>(choice, start);
  return {.step = [loaded](const slam::Observation& observation) { return loaded->step(observation); }};
}

}  // namespace sim::estimators
