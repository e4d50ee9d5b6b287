#pragma once

#include <tenon/plants/model/quadruped_description.h>

#include <string>

namespace tenon::apps {

/// Draws the robot in its nominal stance as SVG: from the left, from the front and from above, to one scale,
/// with a scale bar of 0.1 m. Trunk, links and feet are plain shapes.
std::string DrawQuadruped(const QuadrupedDescription& robot);

}  // namespace tenon::apps
