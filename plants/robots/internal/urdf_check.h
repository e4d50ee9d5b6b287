#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

namespace tenon::internal {

/// The lines in which links and joints begin, by "link NAME" and "joint NAME".
using UrdfLines = std::map<std::string, std::size_t, std::less<>>;

inline constexpr std::size_t kMaxUrdfBytes = 16 << 20;

struct CheckedUrdf {
  UrdfLines lines;
  std::string text;  ///< with a <limit> of zeros where a joint has none, for urdfdom refuses it
};

/// Refuses what urdfdom takes without a word: numbers that it drops, inertias without a mass, links in a
/// ring, on which it never ends, elements nested so deep, so many links, or files so large, that they are no
/// robot, and macros that nobody expanded. Throws ParameterError with `file`, line, and the link or joint.
CheckedUrdf CheckUrdf(const std::string& text, const std::string& file);

}  // namespace tenon::internal
