#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon {

CdprDescription LoadCdpr(const std::string& path) {
  return YamlDocument::Load(path).Read<CdprDescription>();
}

CdprDescription LoadCdpr(const YamlFile& what) {
  return LoadResource("robots", what, "cables").Read<CdprDescription>();
}

}  // namespace tenon
