#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tenon {

/// Finds the file of a mesh that a URDF names: by a path relative to the URDF, by "file://" and an absolute
/// path, or by "package://PACKAGE/PATH". PACKAGE is a directory above the URDF or beside one of these, or is
/// found in the directories of the environment variable ROS_PACKAGE_PATH or in "share" below those of
/// AMENT_PREFIX_PATH. A backslash separates directories like a slash.
std::optional<std::filesystem::path> FindMesh(const std::string& name, const std::filesystem::path& urdf);

/// Replaces the names of all meshes that are found by absolute paths, so that a copy of the URDF finds them.
std::string WithMeshesFound(std::string text, const std::filesystem::path& urdf);

}  // namespace tenon
