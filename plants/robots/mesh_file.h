#pragma once

#include <tenon/systems/geometry.h>

#include <filesystem>

namespace tenon {

/// Maximal number of triangles of a mesh for display, so that a robot stays small in a report.
inline constexpr std::size_t kMostTriangles = 2000;

/// Reads a mesh in STL, OBJ or COLLADA, which its content determines. A damaged or excessive file is refused,
/// usually within a second and with 200 MB of memory. Equal corners are merged, and meshes of more than
/// kMostTriangles triangles are simplified. Like in ROS, COLLADA's unit is applied and its upward axis is
/// ignored. The diffuse colours of COLLADA and of the MTL file of an OBJ are read, textures are omitted.
/// A process caches each file. Throws ParameterError with the name of the file if it cannot be read or has no
/// triangles.
std::shared_ptr<const TriangleMesh> ReadMesh(const std::filesystem::path& file);

/// Simplifies a mesh to at most `triangles` triangles.
TriangleMesh Simplified(TriangleMesh mesh, std::size_t triangles = kMostTriangles);

}  // namespace tenon
