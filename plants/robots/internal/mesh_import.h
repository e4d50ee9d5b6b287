#pragma once

#include <tenon/systems/geometry.h>

#include <algorithm>
#include <filesystem>
#include <functional>

namespace tenon::internal {

using MeshColour = decltype(TriangleMesh::colours)::value_type;

/// A colour of TriangleMesh from its parts, 0 to 1.
inline MeshColour ColourFrom(float red, float green, float blue) {
  const auto byte = [](float part) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(part, 0.0F, 1.0F)));
  };
  return {byte(red), byte(green), byte(blue), 255};
}

/// Reads a mesh in STL, OBJ or COLLADA, which its content determines, not its name. The library assimp reads
/// it in a child process, because a damaged file may let it crash or use all time and memory: the child has
/// 1 s of processor time and 200 MB of memory, and more for files of more than a few megabytes. It opens no
/// other file but the MTL file that an OBJ names. `reduce` is called in the child. Throws ParameterError with
/// the name of the file.
TriangleMesh ImportMesh(const std::filesystem::path& file,
                        const std::function<TriangleMesh(TriangleMesh)>& reduce);

/// Checks the text of a COLLADA file: elements are nested at most 100 deep, there are no entities, and the
/// accessors stay within their arrays. Throws std::runtime_error with the reason.
void CheckCollada(std::string_view text);

}  // namespace tenon::internal
