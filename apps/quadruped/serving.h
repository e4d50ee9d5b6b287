#pragma once

#include <tenon/apps/common/summary.h>
#include <tenon/diagrams/legged/quadruped_stand.h>

#include <functional>
#include <string>

namespace tenon::apps {

/// The option --serve: a client on DDS commands the joints of a standing robot in place of its PD control.
/// `where` is "unitree[:interface[,domain]]"; by default, as in the maker's simulator, domain 1 on "lo".
/// Another interface has domain 0, as the robots do. Returns a function that adds the numbers of commands and
/// of late ticks to the figures. Throws ParameterError, also in a build without Cyclone DDS.
std::function<void(Summary&, const Simulator&)> Serve(const std::string& where, DiagramBuilder& builder,
                                                      QuadrupedStand& loop);

}  // namespace tenon::apps
