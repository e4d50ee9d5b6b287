#include <tenon/plants/robots/internal/mesh_import.h>
#include <tenon/plants/robots/mesh_file.h>
#include <tenon/systems/files/input_file.h>

#include <assimp/Importer.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <meshoptimizer.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <mutex>

namespace tenon::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestFile = 200'000'000;  // [bytes]
constexpr rlim_t kMemory = 200 << 20;              // memory of the child beside that of this process [bytes]
constexpr std::size_t kMemoryPerByte = 16;         // further memory for each byte of the file
constexpr std::size_t kBytesPerSecond = 5 << 20;   // bytes of a file for a further second of processor time

/// A file could not be read, for a reason that completes "cannot be read: ".
class Unreadable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

std::string ReadFile(const fs::path& file) {
  std::ifstream in = OpenInput(file, std::ios::binary | std::ios::ate);
  if (!in.is_open()) throw Unreadable("there is no such file");
  const std::streamoff size = in.tellg();
  if (size > static_cast<std::streamoff>(kLargestFile)) throw Unreadable("it is larger than 200 MB");
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!in.seekg(0).read(text.data(), size)) throw Unreadable("it cannot be opened");
  return text;
}

/// Returns the ending that makes assimp choose the reader of this content.
const char* EndingFor(std::string_view text) {
  constexpr std::size_t kHeader = 84, kTriangle = 50;  // sizes in a binary STL file [bytes]
  std::size_t binary = 0;                              // size of a binary STL file with this header
  if (text.size() >= kHeader) {
    std::uint32_t triangles = 0;
    std::memcpy(&triangles, text.data() + kHeader - sizeof(triangles), sizeof(triangles));
    binary = kHeader + kTriangle * static_cast<std::size_t>(triangles);
    if (binary == text.size()) return "stl";
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::string_view head = text.substr(0, 1 << 16);
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  if (first != head.npos && head.substr(first).starts_with("solid")) return "stl";
  if (head.find("<COLLADA") != head.npos) return "dae";
  for (std::size_t line = 0; line != head.npos && line < head.size();) {
    if (head.substr(line).starts_with("v ") || head.substr(line).starts_with("f ")) return "obj";
    const std::size_t end = head.find('\n', line);
    line = end == head.npos ? end : end + 1;
  }
  if (binary > kHeader && binary < text.size()) return "stl";  // with further bytes at the end
  throw Unreadable("it is neither STL nor OBJ nor COLLADA");
}

/// The files that assimp sees: the mesh, and the materials (MTL) that it names, which stand beside it.
class TheseFiles : public Assimp::IOSystem {
 public:
  TheseFiles(std::string name, std::string_view text, fs::path folder)
      : name_(std::move(name)), text_(text), folder_(std::move(folder)) {}
  bool Exists(const char* name) const override { return name_ == name || IsMaterial(name); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char*) override {
    if (!Exists(name)) return nullptr;
    if (name_ != name) materials_ = ReadFile(Beside(name));
    const std::string_view text = name_ == name ? text_ : materials_;
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), false);
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }
  bool has_materials() const { return !materials_.empty(); }

 private:
  fs::path Beside(std::string_view name) const {
    return folder_ / name.substr(0, name.find_last_not_of(" \t") + 1);
  }
  bool IsMaterial(std::string_view name) const {
    std::error_code error;
    return Beside(name).extension() == ".mtl" && fs::is_regular_file(Beside(name), error);
  }

  std::string name_;
  std::string_view text_;
  fs::path folder_;
  std::string materials_;
};

/// The diffuse colour of a part, see TriangleMesh; none if the part has a texture.
MeshColour ColourOf(const aiScene& scene, const aiMesh& part) {
  if (part.mMaterialIndex >= scene.mNumMaterials) return {};
  const aiMaterial& material = *scene.mMaterials[part.mMaterialIndex];
  aiString name;
  aiColor3D diffuse;
  if (material.GetTextureCount(aiTextureType_DIFFUSE) > 0 ||
      material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) != AI_SUCCESS ||
      (material.Get(AI_MATKEY_NAME, name) == AI_SUCCESS && name == aiString(AI_DEFAULT_MATERIAL_NAME)))
    return {};
  return ColourFrom(diffuse.r, diffuse.g, diffuse.b);
}

TriangleMesh Import(std::string_view text, const fs::path& file) {
  const std::string name = std::string("mesh.") + EndingFor(text);
  const bool collada = name.ends_with("dae");
  if (collada) CheckCollada(text);
  Assimp::Importer importer;
  auto* const files = new TheseFiles(name, text, file.parent_path());
  importer.SetIOHandler(files);  // the importer deletes it
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene =
      importer.ReadFile(name, aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (scene == nullptr) throw Unreadable(importer.GetErrorString());
  TriangleMesh mesh;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto first = static_cast<std::uint32_t>(mesh.corners.size());
    if (collada || files->has_materials())
      mesh.colours.resize(first + part.mNumVertices, ColourOf(*scene, part));
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& p = part.mVertices[i];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        throw Unreadable("a corner is not finite");
      mesh.corners.push_back({p.x, p.y, p.z});
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      const std::array corners{face.mIndices[0], face.mIndices[1], face.mIndices[2]};
      if (*std::ranges::max_element(corners) >= part.mNumVertices)
        throw Unreadable("a triangle has a corner that does not exist");
      mesh.triangles.push_back({first + corners[0], first + corners[1], first + corners[2]});
    }
  }
  if (mesh.triangles.empty()) throw Unreadable("it has no triangles");
  return mesh;
}

/// Limits the time and the memory of this process.
void LimitSelf(std::size_t file_size) {
  const auto limit = [](auto resource, rlim_t value) {
    const ::rlimit both{value, value};
    ::setrlimit(resource, &both);
  };
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, 1 + file_size / kBytesPerSecond);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these reserve terabytes
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  limit(RLIMIT_AS,
        pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + kMemory + kMemoryPerByte * file_size);
#endif
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGXCPU}) std::signal(signal, SIG_DFL);
}

void WriteAll(int descriptor, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ::ssize_t written = ::write(descriptor, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    at += written;
    size -= static_cast<std::size_t>(written);
  }
}

struct Header {
  std::uint32_t corners = 0, triangles = 0, colours = 0;  // all 0 before the text of an error
};

[[noreturn]] void ReadInChild(std::string_view text, const fs::path& file,
                              const std::function<TriangleMesh(TriangleMesh)>& reduce, int to) {
  LimitSelf(text.size());
  std::string failure;
  try {
    const TriangleMesh mesh = reduce(Import(text, file));
    const Header header{static_cast<std::uint32_t>(mesh.corners.size()),
                        static_cast<std::uint32_t>(mesh.triangles.size()),
                        static_cast<std::uint32_t>(mesh.colours.size())};
    WriteAll(to, &header, sizeof(header));
    WriteAll(to, mesh.corners.data(), mesh.corners.size() * sizeof(mesh.corners[0]));
    WriteAll(to, mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0]));
    WriteAll(to, mesh.colours.data(), mesh.colours.size() * sizeof(mesh.colours[0]));
    ::_exit(0);
  } catch (const std::bad_alloc&) {
    failure = "it needs too much memory";
  } catch (const std::exception& error) {
    failure = error.what();
  } catch (...) {
    failure = "the reader failed";
  }
  const Header header;
  WriteAll(to, &header, sizeof(header));
  WriteAll(to, failure.data(), failure.size());
  ::_exit(0);
}

/// Reads until the other end is closed, at most for a time. Returns false after that time.
bool ReadToEnd(int descriptor, std::chrono::seconds within, std::string& all) {
  const auto end = std::chrono::steady_clock::now() + within;
  for (std::array<char, 1 << 16> buffer;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    ::pollfd wanted{descriptor, POLLIN, 0};
    const int ready = left.count() <= 0 ? 0 : ::poll(&wanted, 1, static_cast<int>(left.count()));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ::ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    all.append(buffer.data(), static_cast<std::size_t>(got));
  }
}

TriangleMesh MeshFrom(std::string_view all) {
  Header header;
  if (all.size() < sizeof(header)) throw Unreadable("its content makes the reader fail");
  std::memcpy(&header, all.data(), sizeof(header));
  all.remove_prefix(sizeof(header));
  if (header.triangles == 0) throw Unreadable(std::string(all));
  TriangleMesh mesh{decltype(TriangleMesh::corners)(header.corners),
                    decltype(TriangleMesh::triangles)(header.triangles),
                    decltype(TriangleMesh::colours)(header.colours)};
  const std::size_t corners = header.corners * sizeof(mesh.corners[0]);
  const std::size_t triangles = header.triangles * sizeof(mesh.triangles[0]);
  const std::size_t colours = header.colours * sizeof(mesh.colours[0]);
  if (all.size() != corners + triangles + colours) throw Unreadable("its content makes the reader fail");
  std::memcpy(mesh.corners.data(), all.data(), corners);
  std::memcpy(mesh.triangles.data(), all.data() + corners, triangles);
  if (colours > 0) std::memcpy(mesh.colours.data(), all.data() + corners + triangles, colours);
  return mesh;
}

TriangleMesh ReadInLimits(std::string_view text, const fs::path& file,
                          const std::function<TriangleMesh(TriangleMesh)>& reduce) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw Unreadable(std::strerror(errno));
  const ::pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::close(ends[0]);
    ReadInChild(text, file, reduce, ends[1]);
  }
  ::close(ends[1]);
  std::string all;
  // On a busy machine, the limit of processor time takes longer.
  const std::chrono::seconds patience(20 + 10 * text.size() / kBytesPerSecond);
  const bool in_time = child > 0 && ReadToEnd(ends[0], patience, all);
  ::close(ends[0]);
  if (child < 0) throw Unreadable(std::strerror(errno));
  if (!in_time) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!in_time || (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)))
    throw Unreadable("reading it takes too long");
  if (WIFSIGNALED(status)) throw Unreadable("it is damaged or nested too deeply");
  return MeshFrom(all);
}

}  // namespace

TriangleMesh ImportMesh(const fs::path& file, const std::function<TriangleMesh(TriangleMesh)>& reduce) {
  try {
    return ReadInLimits(ReadFile(file), file, reduce);
  } catch (const Unreadable& error) {
    throw ParameterError(fmt::format("the mesh '{}' cannot be read: {}; export it as STL, OBJ or COLLADA",
                                     file.string(), error.what()));
  }
}

}  // namespace tenon::internal

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
