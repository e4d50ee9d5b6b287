#include <tenon/plants/model/rope.h>
#include <tenon/systems/block.h>

#include <fmt/core.h>

namespace tenon {

void Rope::Validate() const {
  const bool fits = std::ranges::all_of(
      name, [](unsigned char c) { return c > ' ' && c != 0x7F && c != ',' && c != '.' && c != ';'; });
  Demand(!name.empty() && fits,
         fmt::format("the name '{}' cannot be that of a column: use letters, digits and underscores", name));
  Demand(tension_min <= tension_max,
         fmt::format("tension_min_N = {} must not exceed tension_max_N = {}", tension_min, tension_max));
}

void CheckRopes(const std::vector<Rope>& ropes) {
  Demand(!ropes.empty() && ropes.size() <= kMaxRopes,
         fmt::format("ropes: {} are given, but a quadruped takes 1 to {}", ropes.size(), kMaxRopes));
  for (auto rope = ropes.begin(); rope != ropes.end(); ++rope) {
    CheckRanges(*rope);
    rope->Validate();
    Demand(std::find_if(ropes.begin(), rope, [&](const Rope& other) { return other.name == rope->name; }) ==
               rope,
           fmt::format("ropes: two have the name '{}': rename one", rope->name));
  }
}

std::string RopeElements(const std::vector<Rope>& ropes) {
  std::string elements;
  for (const Rope& rope : ropes) elements += (elements.empty() ? "" : ",") + rope.name;
  return elements;
}

RopeLine LineOf(const Rope& rope, const LeggedState& robot) {
  RopeLine line;
  line.arm_W = robot.R_WB() * rope.attachment_B;
  line.direction_W = rope.anchor_W - robot.p_WB - line.arm_W;
  line.length = line.direction_W.norm();
  constexpr double kShortest = 1e-6;  // m
  if (line.length <= kShortest)
    throw RunError(fmt::format(
        "the rope '{}' has no direction because its anchor and its attachment coincide: move the anchor",
        rope.name));
  line.direction_W /= line.length;
  return line;
}

}  // namespace tenon
