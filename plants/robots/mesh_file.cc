#include <tenon/plants/robots/mesh_file.h>
#include <tenon/systems/framework/types/errors.h>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace tenon {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestFile = 200'000'000;  // [bytes]
constexpr float kNicely = 0.02F;  // error up to which the topology is kept, relative to the mesh's extent

TriangleMesh Import(const fs::path& file) {
  const auto fail = [&](const std::string& why) {
    throw ParameterError(fmt::format("the mesh '{}' cannot be read: {}; export it as STL, OBJ or COLLADA",
                                     file.string(), why));
  };
  std::error_code error;
  if (!fs::is_regular_file(file, error)) fail("there is no such file");
  if (fs::file_size(file, error) > kLargestFile) fail("it is larger than 200 MB");
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(
      file.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (scene == nullptr) fail(importer.GetErrorString());
  TriangleMesh mesh;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto first = static_cast<std::uint32_t>(mesh.corners.size());
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& p = part.mVertices[i];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) fail("a corner is not finite");
      mesh.corners.push_back({p.x, p.y, p.z});
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      mesh.triangles.push_back(
          {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
  }
  if (mesh.triangles.empty()) fail("it has no triangles");
  return mesh;
}

/// Merges equal corners and removes unused ones.
TriangleMesh Joined(const TriangleMesh& mesh) {
  const std::size_t indices = 3 * mesh.triangles.size(), corners = mesh.corners.size();
  std::vector<std::uint32_t> remap(corners);
  const std::size_t left = meshopt_generateVertexRemap(remap.data(), mesh.triangles.front().data(), indices,
                                                       mesh.corners.data(), corners, sizeof(float[3]));
  TriangleMesh joined{std::vector<std::array<float, 3>>(left), mesh.triangles};
  meshopt_remapVertexBuffer(joined.corners.data(), mesh.corners.data(), corners, sizeof(float[3]),
                            remap.data());
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
  static std::mutex mutex;
  static std::map<std::string, Entry> read;
  std::error_code error;
  const fs::file_time_type written = fs::last_write_time(file, error);
  const std::lock_guard lock(mutex);
  Entry& entry = read[fs::weakly_canonical(file).string()];
  if (entry.mesh == nullptr || entry.written != written) {
    entry.mesh = nullptr;
    entry = {written, std::make_shared<const TriangleMesh>(Simplified(Joined(Import(file))))};
  }
  return entry.mesh;
}

}  // namespace tenon
