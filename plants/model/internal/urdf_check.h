#pragma once

#include <string>

namespace tenon::internal {

/// Refuses what urdfdom takes without a word: numbers that it drops, links in a ring, on which it never ends,
/// and elements nested so deep, or files so large, that they are no robot. Throws ParameterError with `file`,
/// line, and the link or joint.
void CheckUrdf(const std::string& text, const std::string& file);

}  // namespace tenon::internal
