#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace tenon::test {

/// A tetrahedron with corners at the origin, at 1 on x, 2 on y and 3 on z, in three formats. COLLADA declares
/// millimetres and y upwards, which the reader ignores.
inline void WriteTetrahedron(const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  if (file.extension() == ".stl") {
    out << "solid t\n";
    for (const char* corners :
         {"0 0 0,0 2 0,1 0 0", "0 0 0,1 0 0,0 0 3", "0 0 0,0 0 3,0 2 0", "1 0 0,0 2 0,0 0 3"}) {
      std::string text = corners;
      out << "facet normal 0 0 0\nouter loop\n";
      for (std::size_t at = 0; at != std::string::npos;) {
        const std::size_t comma = text.find(',', at);
        out << "vertex " << text.substr(at, comma - at) << '\n';
        at = comma == std::string::npos ? comma : comma + 1;
      }
      out << "endloop\nendfacet\n";
    }
    out << "endsolid t\n";
  } else if (file.extension() == ".obj") {
    out << "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  } else {
    out << R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="0.001" name="millimeter"/><up_axis>Y_UP</up_axis></asset>
  <library_geometries><geometry id="t"><mesh>
    <source id="p"><float_array id="a" count="12">0 0 0 1000 0 0 0 2000 0 0 0 3000</float_array>
      <technique_common><accessor source="#a" count="4" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
      <p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#t"/></node></visual_scene>
  </library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";
  }
}

}  // namespace tenon::test
