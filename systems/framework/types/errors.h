#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace tenon {

/// Base of every error that Tenon throws deliberately. The text says what is wrong, where, and what to do.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& what) : std::runtime_error(what) {}
  Error(const std::string& what, std::string block) : std::runtime_error(what), block_(std::move(block)) {}
  /// The path of the block that the error is about; empty if it is about none or not known.
  const std::string& block() const { return block_; }

 private:
  std::string block_;
};

/// A diagram that cannot be built: unconnected input, algebraic loop, duplicate name or connection.
class BuildError : public Error {
 public:
  using Error::Error;
};

/// An invalid parameter or parameter file.
class ParameterError : public Error {
 public:
  using Error::Error;
};

/// A run that cannot continue: non-finite value, failure of the integrator, accumulation of events.
class RunError : public Error {
 public:
  using Error::Error;
};

}  // namespace tenon
