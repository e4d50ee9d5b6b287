#pragma once

#include <stdexcept>
#include <string>

namespace tenon {

/// Base of every error that Tenon throws deliberately. The text says what is wrong, where, and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
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
