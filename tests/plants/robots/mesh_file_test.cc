#include <tenon/plants/robots/mesh_file.h>
#include <tenon/systems/yaml/mesh_paths.h>
#include <tenon/tests/plants/model/mesh_test_files.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <numbers>
#include <set>

namespace tenon::mesh_file_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre, ::testing::FloatNear;
using Corner = std::array<float, 3>;

class MeshFileTest : public ::testing::Test {
 protected:
  MeshFileTest() { fs::create_directories(home); }
  ~MeshFileTest() override { fs::remove_all(home); }
  const fs::path home = test::TemporaryPath("meshes");
};

/// Six times the volume that the triangles enclose, positive if they are counterclockwise from outside.
double SixVolumes(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Corner &p = mesh.corners.at(a), &q = mesh.corners.at(b), &r = mesh.corners.at(c);
    sum += p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
           p[2] * (q[0] * r[1] - q[1] * r[0]);
  }
  return sum;
}

/// A sphere of radius 1 with 2 n (n - 1) triangles.
TriangleMesh Sphere(std::uint32_t n) {
  TriangleMesh mesh{{{0, 0, 1}, {0, 0, -1}}, {}};
  const auto at = [n](std::uint32_t ring, std::uint32_t i) { return 2 + (ring - 1) * n + i % n; };
  for (std::uint32_t ring = 1; ring < n; ++ring) {
    const double polar = std::numbers::pi * ring / n;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double turn = 2 * std::numbers::pi * i / n;
      mesh.corners.push_back({static_cast<float>(std::sin(polar) * std::cos(turn)),
                              static_cast<float>(std::sin(polar) * std::sin(turn)),
                              static_cast<float>(std::cos(polar))});
      if (ring == 1) mesh.triangles.push_back({0, at(1, i), at(1, i + 1)});
      if (ring == n - 1) mesh.triangles.push_back({1, at(ring, i + 1), at(ring, i)});
      if (ring == 1) continue;
      mesh.triangles.push_back({at(ring - 1, i), at(ring, i), at(ring, i + 1)});
      mesh.triangles.push_back({at(ring - 1, i), at(ring, i + 1), at(ring - 1, i + 1)});
    }
  }
  return mesh;
}

/// A COLLADA file of the four triangles of a tetrahedron, one red, three blue.
void WriteColoured(const fs::path& file) {
  test::WriteTetrahedron(file);
  std::string text = ReadText(file);
  const auto replace = [&](std::string_view part, const std::string& by) {
    const std::size_t at = text.find(part);
    ASSERT_NE(at, text.npos) << part;
    text.replace(at, part.size(), by);
  };
  std::string effects = "<library_effects>", materials = "<library_materials>", bindings;
  for (const auto& [name, colour] :
       std::map<std::string, std::string>{{"red", "1 0 0 1"}, {"blue", "0 0 0.5 1"}}) {
    effects += "<effect id=\"e-" + name +
               "\"><profile_COMMON><technique sid=\"t\"><lambert><diffuse><color>" + colour +
               "</color></diffuse></lambert></technique></profile_COMMON></effect>";
    materials += "<material id=\"m-" + name + "\"><instance_effect url=\"#e-" + name + "\"/></material>";
    bindings += "<instance_material symbol=\"" + name + "\" target=\"#m-" + name + "\"/>";
  }
  const auto part = [](const std::string& material, int count, const std::string& corners) {
    return "<triangles count=\"" + std::to_string(count) + "\"" + material +
           "><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" + corners + "</p></triangles>";
  };
  replace("<library_geometries>",
          effects + "</library_effects>" + materials + "</library_materials><library_geometries>");
  const std::size_t begin = text.find("<triangles"), end = text.find("</triangles>") + 12;
  text.replace(begin, end - begin,
               part(" material=\"red\"", 1, "0 2 1") + part(" material=\"blue\"", 3, "0 1 3 0 3 2 1 2 3"));
  replace("<instance_geometry url=\"#t\"/>",
          "<instance_geometry url=\"#t\"><bind_material><technique_common>" + bindings +
              "</technique_common></bind_material></instance_geometry>");
  std::ofstream(file) << text;
}

TEST_F(MeshFileTest, ReadsTheColoursOfCollada) {
  WriteColoured(home / "t.dae");
  const TriangleMesh mesh = *ReadMesh(home / "t.dae");
  ASSERT_EQ(mesh.colours.size(), mesh.corners.size());
  std::multiset<std::array<std::uint8_t, 4>> of_triangles;
  for (const auto& [a, b, c] : mesh.triangles) {
    EXPECT_EQ(mesh.colours[a], mesh.colours[b]);
    EXPECT_EQ(mesh.colours[a], mesh.colours[c]);
    of_triangles.insert(mesh.colours[a]);
  }
  EXPECT_EQ(of_triangles.count({255, 0, 0, 255}), 1u);
  EXPECT_EQ(of_triangles.count({0, 0, 128, 255}), 3u);
  EXPECT_NEAR(SixVolumes(mesh), 6, 1e-6);
  test::WriteTetrahedron(home / "plain.dae");
  for (const auto& colour : ReadMesh(home / "plain.dae")->colours) EXPECT_EQ(colour[3], 0);
  test::WriteTetrahedron(home / "t.stl");
  EXPECT_TRUE(ReadMesh(home / "t.stl")->colours.empty());
}

TEST_F(MeshFileTest, ReadsTheColoursOfTheMaterialsOfAnObj) {
  std::ofstream(home / "paint.mtl") << "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 0.5\n";
  std::ofstream(home / "two.obj") << "# two\nmtllib paint.mtl \nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                     "usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n";
  const TriangleMesh mesh = *ReadMesh(home / "two.obj");
  ASSERT_EQ(mesh.colours.size(), mesh.corners.size());
  std::multiset<std::uint8_t> red;
  for (const auto& [a, b, c] : mesh.triangles) red.insert(mesh.colours[a][0]);
  EXPECT_EQ(red, (std::multiset<std::uint8_t>{0, 255}));
  std::ofstream(home / "bare.obj") << "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
  EXPECT_TRUE(ReadMesh(home / "bare.obj")->colours.empty());
}

// A simplified mesh has the colours of the corners that remain.
TEST_F(MeshFileTest, SimplifyingKeepsColours) {
  TriangleMesh ball = Sphere(60);
  for (const Corner& p : ball.corners)
    ball.colours.push_back(p[2] > 0 ? std::array<std::uint8_t, 4>{200, 10, 10, 255}
                                    : std::array<std::uint8_t, 4>{10, 10, 200, 255});
  const TriangleMesh fewer = Simplified(ball);
  ASSERT_LE(fewer.triangles.size(), kMostTriangles);
  ASSERT_EQ(fewer.colours.size(), fewer.corners.size());
  for (std::size_t i = 0; i < fewer.corners.size(); ++i)
    EXPECT_EQ(fewer.colours[i][0], fewer.corners[i][2] > 0 ? 200 : 10);
}

TEST_F(MeshFileTest, ReadsThreeFormatsAlike) {
  for (const char* name : {"t.stl", "t.obj", "t.dae"}) {
    test::WriteTetrahedron(home / name);
    const TriangleMesh mesh = *ReadMesh(home / name);
    std::vector<Corner> corners = mesh.corners;
    std::ranges::sort(corners);
    const auto is = [](float x, float y, float z) {
      return ElementsAre(FloatNear(x, 1e-6F), FloatNear(y, 1e-6F), FloatNear(z, 1e-6F));
    };
    EXPECT_THAT(corners, ElementsAre(is(0, 0, 0), is(0, 0, 3), is(0, 2, 0), is(1, 0, 0))) << name;
    EXPECT_EQ(mesh.triangles.size(), 4u) << name;
    EXPECT_NEAR(SixVolumes(mesh), 6, 1e-6) << name;
  }
}

TEST_F(MeshFileTest, AFileIsReadOnceUntilItChanges) {
  test::WriteTetrahedron(home / "t.stl");
  const auto first = ReadMesh(home / "t.stl");
  EXPECT_EQ(ReadMesh(home / "." / "t.stl"), first);
  std::ofstream(home / "t.stl") << "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                   "vertex 0 1 0\nendloop\nendfacet\nendsolid t\n";
  fs::last_write_time(home / "t.stl", fs::last_write_time(home / "t.stl") + std::chrono::seconds(2));
  EXPECT_EQ(ReadMesh(home / "t.stl")->triangles.size(), 1u);
  EXPECT_EQ(first->triangles.size(), 4u);
}

TEST_F(MeshFileTest, ManyTrianglesBecomeFewOfTheSameShape) {
  const TriangleMesh sphere = Sphere(100);
  ASSERT_EQ(sphere.triangles.size(), 19800u);
  const TriangleMesh few = Simplified(sphere);
  EXPECT_LE(few.triangles.size(), kMostTriangles);
  EXPECT_GE(few.triangles.size(), kMostTriangles / 2);
  for (const Corner& p : few.corners) EXPECT_NEAR(std::hypot(p[0], p[1], p[2]), 1, 0.02);
  EXPECT_NEAR(SixVolumes(few), 8 * std::numbers::pi, 0.02 * 8 * std::numbers::pi);
  std::set<std::uint32_t> used;
  for (const auto& triangle : few.triangles) used.insert(triangle.begin(), triangle.end());
  EXPECT_EQ(used.size(), few.corners.size());
  EXPECT_LE(Simplified(sphere, 20).triangles.size(), 20u) << "where shape cannot be kept, too";
  EXPECT_EQ(Simplified(Sphere(10)).triangles, Sphere(10).triangles) << "few stay as they are";
}

TEST_F(MeshFileTest, FindsFilesAsUrdfsNameThem) {
  const fs::path urdf = home / "my_robot/urdf/my.urdf";
  fs::create_directories(urdf.parent_path());
  test::WriteTetrahedron(home / "my_robot/meshes/a.stl");
  test::WriteTetrahedron(home / "other_robot/meshes/b.stl");
  test::WriteTetrahedron(home / "elsewhere/share/far_robot/c.stl");
  EXPECT_TRUE(FindMesh("../meshes/a.stl", urdf));
  EXPECT_TRUE(FindMesh("..\\meshes\\a.stl", urdf));
  EXPECT_TRUE(FindMesh("file://" + (home / "my_robot/meshes/a.stl").string(), urdf));
  EXPECT_TRUE(FindMesh("package://my_robot/meshes/a.stl", urdf));
  EXPECT_EQ(FindMesh("package://other_robot/meshes/b.stl", urdf), home / "other_robot/meshes/b.stl");
  EXPECT_FALSE(FindMesh("package://far_robot/c.stl", urdf));
  ::setenv("ROS_PACKAGE_PATH", ("/nowhere:" + (home / "elsewhere/share").string()).c_str(), 1);
  EXPECT_TRUE(FindMesh("package://far_robot/c.stl", urdf));
  ::unsetenv("ROS_PACKAGE_PATH");
  ::setenv("AMENT_PREFIX_PATH", (home / "elsewhere").c_str(), 1);
  EXPECT_TRUE(FindMesh("package://far_robot/c.stl", urdf));
  ::unsetenv("AMENT_PREFIX_PATH");
  for (const char* name : {"", "..", "package://", "package:///etc/passwd", "file://", "../meshes/no.stl"})
    EXPECT_FALSE(FindMesh(name, urdf)) << name;
}

TEST_F(MeshFileTest, ACopyOfAUrdfFindsThemFromAnywhere) {
  test::WriteTetrahedron(home / "my_robot/a.stl");
  const std::string text =
      "<mesh scale=\"1 1 1\" filename=\"package://my_robot/a.stl\"/> <mesh filename='a.stl'/>"
      "<mesh filename=\"no.stl\"/><mesh/><mesh filename=\"a";
  const std::string found = "file://" + fs::canonical(home / "my_robot/a.stl").string();
  const std::string copy = WithMeshesFound(text, home / "my_robot/my.urdf");
  EXPECT_EQ(copy, "<mesh scale=\"1 1 1\" filename=\"" + found + "\"/> <mesh filename='" + found +
                      "'/><mesh filename=\"no.stl\"/><mesh/><mesh filename=\"a");
  EXPECT_EQ(WithMeshesFound(copy, "/elsewhere/my.urdf"), copy);
}

// Folders and files whose names contain special characters of XML.
TEST_F(MeshFileTest, ACopyOfAUrdfIsXmlWhereverTheyStand) {
  const fs::path folder = home / "R&D's <dogs>";
  fs::create_directories(folder);
  test::WriteTetrahedron(folder / "a&b.stl");
  const std::string copy = WithMeshesFound("<mesh filename='a&amp;b.stl'/>", folder / "my.urdf");
  EXPECT_EQ(copy, "<mesh filename='file://" + fs::canonical(home).string() +
                      "/R&amp;D&apos;s &lt;dogs&gt;/a&amp;b.stl'/>");
  EXPECT_EQ(WithMeshesFound(copy, "/elsewhere/my.urdf"), copy);
}

TEST_F(MeshFileTest, RefusesBadFiles) {
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home / "no.stl"); }, "no.stl"));
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home); }, home.string()));
  std::ofstream(home / "text.stl") << "this is no mesh";
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home / "text.stl"); }, "text.stl"));
  std::ofstream(home / "points.obj") << "v 0 0 0\nv 1 0 0\n";
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home / "points.obj"); }, "points.obj"));
  std::ofstream(home / "far.obj") << "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n";
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home / "far.obj"); }, "far.obj"));
  for (const char* other : {"ply\nformat ascii 1.0\n", "<svg/>", "#usda 1.0\n", "glTF", ""}) {
    std::ofstream(home / "other.stl") << other;
    EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home / "other.stl"); }, "neither STL")) << other;
    fs::remove(home / "other.stl");
  }
  test::WriteTetrahedron(home / "large.stl");
  fs::resize_file(home / "large.stl", 200'000'001);
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home / "large.stl"); }, "200 MB"));
}

TEST_F(MeshFileTest, TheContentDeterminesTheFormat) {
  for (const char* name : {"t.stl", "t.obj", "t.dae"}) {
    test::WriteTetrahedron(home / name);
    const fs::path misnamed = home / (std::string(name) + ".blend");
    fs::rename(home / name, misnamed);
    EXPECT_EQ(ReadMesh(misnamed)->triangles.size(), 4u) << name;
  }
}

/// Text of a COLLADA file with a tetrahedron, one part of which is replaced.
std::string Collada(const fs::path& home, const std::string& part, const std::string& replacement) {
  test::WriteTetrahedron(home / "whole.dae");
  std::string all = ReadText(home / "whole.dae");
  const std::size_t at = all.find(part);
  EXPECT_NE(at, all.npos) << part;
  return at == all.npos ? all : all.replace(at, part.size(), replacement);
}

std::string Repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

// Each of these makes a reader without limits crash, hang or use all memory.
TEST_F(MeshFileTest, RefusesHostileFilesSoon) {
  std::string polygon, corners = "f";
  for (int i = 0; i < 30'000; ++i) {
    const double turn = 2 * std::numbers::pi * i / 30'000, radius = 1 + 0.5 * (i % 2);
    polygon += fmt::format("v {} {} 0\n", radius * std::cos(turn), radius * std::sin(turn));
    corners += fmt::format(" {}", i + 1);
  }
  std::string entities = "<?xml version=\"1.0\"?><!DOCTYPE COLLADA [<!ENTITY a \"aaaaaaaaaa\">";
  for (char c = 'b'; c < 'l'; ++c)
    entities +=
        fmt::format("<!ENTITY {} \"{}\">", c, Repeated(fmt::format("&{};", static_cast<char>(c - 1)), 10));
  const std::string node = "<node><instance_geometry url=\"#t\"/></node>";
  const std::map<std::string, std::string> files{
      {"polygon.obj", polygon + corners + "\n"},
      {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"},
      {"negative.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9\n"},
      {"index.dae", Collada(home, "1 2 3</p>", "1 2 900000</p>")},
      {"accessor.dae", Collada(home, "count=\"4\" stride=\"3\"", "count=\"400000\" stride=\"3\"")},
      {"short.dae", Collada(home, "1000 0 0 0 2000 0 0 0 3000", "1000")},
      {"itself.dae",
       Collada(home, node,
               "<node id=\"n\"><instance_geometry url=\"#t\"/><instance_node url=\"#n\"/></node>")},
      {"deep.dae", Collada(home, node, Repeated("<node>", 20'000) + node + Repeated("</node>", 20'000))},
      {"bomb.dae", Collada(home, "<?xml version=\"1.0\"?>", entities + "]>")},
      {"count.stl", std::string(80, ' ') + "\xff\xff\xff\x7f" + std::string(50, 'x')}};
  for (const auto& [name, text] : files) {
    std::ofstream(home / name) << text;
    ::rusage before{}, after{};
    ::getrusage(RUSAGE_CHILDREN, &before);
    EXPECT_TRUE(Throws<ParameterError>([&, file = home / name] { ReadMesh(file); }, name));
    ::getrusage(RUSAGE_CHILDREN, &after);
    EXPECT_LE(after.ru_utime.tv_sec - before.ru_utime.tv_sec, 2) << name;
    if (AllocationGuard::Available()) {  // sanitizers take memory of their own
      EXPECT_LE(after.ru_maxrss, 250'000) << name << ": [kB]";
    }
  }
}

TEST_F(MeshFileTest, OpensNoOtherFile) {
  ASSERT_EQ(::mkfifo((home / "pipe.mtl").c_str(), 0600), 0);
  std::ofstream(home / "t.obj") << "mtllib pipe.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
  EXPECT_EQ(ReadMesh(home / "t.obj")->triangles.size(), 1u);
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMesh(home / "pipe.mtl"); }, "pipe.mtl"));
}

}  // namespace tenon::mesh_file_test
