#pragma once

#include <stdexcept>

namespace cli {

/// What a command line asks for cannot be done. main prints it and ends with exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cli
