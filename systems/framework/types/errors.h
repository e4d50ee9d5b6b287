#pragma once

#include <stdexcept>
#include <string>

namespace tenon {

/// Base of every error that Tenon throws on purpose. The text names the thing, the place and the remedy.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A diagram that cannot be built: unconnected input, algebraic loop, name or port used twice.
class BuildError : public Error {
 public:
  using Error::Error;
};

/// A parameter, or a file of parameters, that makes no sense.
class ParameterError : public Error {
 public:
  using Error::Error;
};

/// A run that cannot go on: a value that is not finite, an integrator that fails, events without end.
class RunError : public Error {
 public:
  using Error::Error;
};

}  // namespace tenon
