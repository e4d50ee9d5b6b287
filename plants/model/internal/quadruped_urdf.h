#pragma once

#include <tenon/plants/model/quadruped_description.h>

#include <array>
#include <filesystem>
#include <string>

namespace tenon::internal {

/// Reads trunk and legs from a URDF file, the legs from the names of their feet's links. Links that fixed
/// joints connect become one body. Throws ParameterError, beginning with the file's name.
void ReadUrdf(const std::filesystem::path& path, const std::array<std::string, kNumLegs>& feet,
              QuadrupedDescription* robot);

}  // namespace tenon::internal
