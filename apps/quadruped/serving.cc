#include <tenon/apps/common/progress.h>
#include <tenon/apps/quadruped/serving.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/text/parse_number.h>
#ifdef TENON_WITH_UNITREE
#include <tenon/diagrams/unitree/unitree_server.h>
#endif

#include <fmt/core.h>

namespace tenon::apps {

#ifdef TENON_WITH_UNITREE

static DdsLink LinkOf(const std::string& where) {
  const std::size_t colon = where.find(':'), comma = where.find(',', colon);
  const std::string robot = where.substr(0, colon);
  const std::string interface = colon == where.npos ? "lo" : where.substr(colon + 1, comma - colon - 1);
  const auto domain = comma == where.npos ? std::optional(interface == "lo" ? 1 : 0)
                                          : internal::NumberIn<int>(where.substr(comma + 1));
  if (robot != "unitree" || interface.empty() || !domain)
    throw ParameterError(fmt::format(
        "--serve {}: give unitree, unitree:INTERFACE or unitree:INTERFACE,DOMAIN, such as unitree:eth0,0",
        where));
  return {.domain = *domain, .interface = interface};
}

std::function<void(Summary&, const Simulator&)> Serve(const std::string& where, DiagramBuilder& builder,
                                                      QuadrupedStand& loop) {
  const DdsLink link = LinkOf(where);
  const UnitreeServerParams params{.link = link, .initial = HoldStance(loop.pd.params)};
  auto& server = builder.Replace<UnitreeServer>(loop.pd, params);
  server.ConnectSensors(builder, loop.world);
  Say(fmt::format(
      "serving rt/lowcmd and rt/lowstate in domain {} at {}; the robot stands until a client commands\n",
      link.domain, link.interface));
  return [&command = server.command](Summary& summary, const Simulator& simulator) {
    const RefusedMessages& refused = simulator.context().Eval(command.refused);
    summary.Set("commands", static_cast<double>(simulator.context().Eval(command.taken).number));
    summary.Set("commands_refused", static_cast<double>(refused.count));
    if (refused.count > 0) summary.Note("the last refused command: " + refused.reason);
    summary.Set("ticks_missed", static_cast<double>(simulator.real_time().missed));
    summary.Set("tick_late_max_s", simulator.real_time().worst_lateness);
  };
}

#else

std::function<void(Summary&, const Simulator&)> Serve(const std::string& where, DiagramBuilder&,
                                                      QuadrupedStand&) {
  throw ParameterError(
      fmt::format("--serve {}: this build has no Cyclone DDS: install cyclonedds-dev and "
                  "cyclonedds-tools, and build Tenon again",
                  where));
}

#endif

}  // namespace tenon::apps
