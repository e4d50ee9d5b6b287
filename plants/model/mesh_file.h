#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <tenon/systems/geometry.h>

namespace tenon {

/// Triangles that a mesh to look at has at most: a whole robot stays small in a report.
inline constexpr std::size_t kMostTriangles = 2000;

/// Reads a mesh: STL, OBJ, COLLADA (.dae), or what else the library assimp reads. Corners at one place become
/// one; more than kMostTriangles triangles are simplified to that. Of COLLADA the unit counts and the upward
/// axis does not, as ROS reads it; colours and textures are left out. The same file is read once a process.
/// Throws ParameterError that names the file if it cannot be read or has no triangles.
std::shared_ptr<const TriangleMesh> ReadMesh(const std::filesystem::path& file);

/// The mesh with at most `triangles` triangles, as like the given one as that allows.
TriangleMesh Simplified(TriangleMesh mesh, std::size_t triangles = kMostTriangles);

/// The file that a URDF means by the name of a mesh, if it is there: a path from the URDF, "file://" and one
/// from the root, or "package://PACKAGE/PATH", where PACKAGE is a folder that holds the URDF, stands beside
/// it or one of these, or lies in a folder of the environment's ROS_PACKAGE_PATH or in "share" of one of its
/// AMENT_PREFIX_PATH.
std::optional<std::filesystem::path> FindMesh(const std::string& name, const std::filesystem::path& urdf);

/// The text of a URDF with absolute paths for all meshes that are found: a copy elsewhere finds them, too.
std::string WithMeshesFound(std::string text, const std::filesystem::path& urdf);

}  // namespace tenon
