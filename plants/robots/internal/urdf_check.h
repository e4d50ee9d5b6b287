#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

namespace tenon::internal {

/// First lines of links and joints by "link NAME" and "joint NAME".
using UrdfLines = std::map<std::string, std::size_t, std::less<>>;

inline constexpr std::size_t kMaxUrdfBytes = 16 << 20;

struct CheckedUrdf {
  UrdfLines lines;
  std::string text;  ///< with a zero <limit> added to joints that lack the one that urdfdom requires
};

/// Refuses errors that urdfdom does not report: invalid numbers, inertias without a mass, loops of links (in
/// which it does not terminate), unexpanded macros, and files, nesting or numbers of links beyond any robot.
/// Throws ParameterError with `file`, line, and the link or joint.
CheckedUrdf CheckUrdf(const std::string& text, const std::string& file);

}  // namespace tenon::internal
