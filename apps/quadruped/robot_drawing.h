#pragma once

#include <tenon/plants/model/quadruped_description.h>

#include <string>

namespace tenon::apps {

/// The robot in its nominal stance as an SVG picture: from the left, from the front and from above, all to
/// one scale, with a bar of 0.1 m. Trunk, links and feet are plain shapes, as in a report.
std::string DrawQuadruped(const QuadrupedDescription& robot);

}  // namespace tenon::apps
