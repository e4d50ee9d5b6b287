#pragma once

#include <tenon/systems/geometry.h>

#include <cstddef>
#include <filesystem>
#include <memory>

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

}  // namespace tenon
