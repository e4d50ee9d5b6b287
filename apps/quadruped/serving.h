#pragma once

#include <tenon/apps/common/summary.h>
#include <tenon/diagrams/legged/quadruped_stand.h>

#include <memory>
#include <string>

namespace tenon::apps {

/// The option --serve: a client on DDS commands the joints of a standing robot in place of its PD control.
class Serving {
 public:
  /// `where` is "unitree[:interface[,domain]]"; by default, as in the maker's simulator, domain 1 on "lo".
  /// Another interface has domain 0, as the robots do. Throws ParameterError, also in a build without Cyclone
  /// DDS.
  Serving(const std::string& where, DiagramBuilder& builder, QuadrupedStand& loop);
  ~Serving();
  /// Adds the numbers of commands and of late ticks.
  void AddTo(Summary& summary, const Simulator& simulator) const;

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tenon::apps
