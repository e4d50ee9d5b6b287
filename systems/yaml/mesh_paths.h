#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tenon {

/// The file that a URDF means by the name of a mesh, if it is there: a path from the URDF, "file://" and one
/// from the root, or "package://PACKAGE/PATH", where PACKAGE is a folder that holds the URDF, stands beside
/// it or one of these, or lies in a folder of the environment's ROS_PACKAGE_PATH or in "share" of one of its
/// AMENT_PREFIX_PATH.
std::optional<std::filesystem::path> FindMesh(const std::string& name, const std::filesystem::path& urdf);

/// The text of a URDF with absolute paths for all meshes that are found: a copy elsewhere finds them, too.
std::string WithMeshesFound(std::string text, const std::filesystem::path& urdf);

}  // namespace tenon
