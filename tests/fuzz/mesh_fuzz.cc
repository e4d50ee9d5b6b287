// Bytes as the file of a mesh.

#include <tenon/plants/robots/mesh_file.h>
#include <tenon/tests/fuzz/refusals.h>
#include <tenon/tests/fuzz/scratch.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tenon::fuzz::Scratch kScratch;
  const std::string file = kScratch.Write("mesh", {reinterpret_cast<const char*>(data), size});
  return tenon::fuzz::Try(file, [&] { tenon::ReadMesh(file); });
}
