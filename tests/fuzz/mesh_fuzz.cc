// Bytes as the file of a mesh.

#include <tenon/plants/robots/mesh_file.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return tenon::fuzz::TryFile("mesh", data, size, [](const std::string& file) { tenon::ReadMesh(file); });
}
