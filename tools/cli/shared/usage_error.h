#pragma once

#include <stdexcept>

namespace cli {

/// The command line is invalid. main prints the message and exits with code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cli
