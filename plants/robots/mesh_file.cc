#include <tenon/plants/robots/internal/mesh_import.h>
#include <tenon/plants/robots/mesh_file.h>

#include <meshoptimizer.h>

#include <mutex>

namespace tenon {
namespace {

namespace fs = std::filesystem;

constexpr float kNicely = 0.02F;  // error up to which the topology is kept, relative to the mesh's extent

/// Merges corners of equal place and colour, and removes unused ones.
TriangleMesh Joined(const TriangleMesh& mesh) {
  constexpr std::size_t kPlace = sizeof(mesh.corners[0]), kColour = sizeof(mesh.colours[0]);
  const std::size_t indices = 3 * mesh.triangles.size(), corners = mesh.corners.size();
  const bool coloured = !mesh.colours.empty();
  const std::array<meshopt_Stream, 2> streams{meshopt_Stream{mesh.corners.data(), kPlace, kPlace},
                                              meshopt_Stream{mesh.colours.data(), kColour, kColour}};
  std::vector<std::uint32_t> remap(corners);
  const std::size_t left = meshopt_generateVertexRemapMulti(
      remap.data(), mesh.triangles.front().data(), indices, corners, streams.data(), coloured ? 2 : 1);
  TriangleMesh joined{std::vector<std::array<float, 3>>(left), mesh.triangles};
  meshopt_remapVertexBuffer(joined.corners.data(), mesh.corners.data(), corners, kPlace, remap.data());
  if (coloured) {
    joined.colours.resize(left);
    meshopt_remapVertexBuffer(joined.colours.data(), mesh.colours.data(), corners, kColour, remap.data());
  }
  meshopt_remapIndexBuffer(joined.triangles.front().data(), mesh.triangles.front().data(), indices,
                           remap.data());
  return joined;
}

}  // namespace

TriangleMesh Simplified(TriangleMesh mesh, std::size_t triangles) {
  if (mesh.triangles.size() <= triangles) return mesh;
  const auto reduce = [&](auto simplify) {
    std::vector<std::array<std::uint32_t, 3>> fewer(mesh.triangles.size());
    const std::size_t count =
        simplify(fewer.front().data(), mesh.triangles.front().data(), 3 * mesh.triangles.size(),
                 mesh.corners.front().data(), mesh.corners.size(), sizeof(float[3]), 3 * triangles);
    fewer.resize(count / 3);
    if (!fewer.empty()) mesh.triangles = std::move(fewer);
  };
  reduce([](auto... what) { return meshopt_simplify(what..., kNicely, 0U, nullptr); });
  if (mesh.triangles.size() > triangles)
    reduce([](auto... what) { return meshopt_simplifySloppy(what..., 1.0F, nullptr); });
  return Joined(mesh);
}

std::shared_ptr<const TriangleMesh> ReadMesh(const fs::path& file) {
  struct Entry {
    fs::file_time_type written;
    std::shared_ptr<const TriangleMesh> mesh;
  };
  const auto reduce = [](const TriangleMesh& mesh) { return Simplified(Joined(mesh)); };
  static std::mutex mutex;
  static std::map<std::string, Entry> read;
  std::error_code error;
  const fs::file_time_type written = fs::last_write_time(file, error);
  const std::lock_guard lock(mutex);
  Entry& entry = read[fs::weakly_canonical(file).string()];
  if (entry.mesh == nullptr || entry.written != written) {
    entry.mesh = nullptr;
    entry = {written, std::make_shared<const TriangleMesh>(internal::ImportMesh(file, reduce))};
  }
  return entry.mesh;
}

}  // namespace tenon
