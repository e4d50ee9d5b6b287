#include <tenon/apps/common/ros2_outputs.h>
#include <tenon/systems/text/text.h>
#ifdef TENON_WITH_DDS
#include <tenon/systems/dds/ros2.h>
#endif

#include <fmt/core.h>

namespace tenon::apps {

std::pair<std::string, std::optional<int>> SplitLink(const std::string& option, const std::string& where) {
  const std::size_t comma = where.find(',');
  std::pair<std::string, std::optional<int>> link{where.substr(0, comma), {}};
  if (comma != where.npos) link.second = internal::NumberIn<int>(where.substr(comma + 1));
  if (link.first.empty() || (comma != where.npos && !link.second))
    throw ParameterError(fmt::format("{} '{}': give INTERFACE or INTERFACE,DOMAIN, such as eth0,0", option,
                                     internal::Excerpt(where)));
  return link;
}

#ifdef TENON_WITH_DDS

Ros2Outputs::Ros2Outputs(DiagramBuilder& builder, const RunOptions& options) : builder_(builder) {
  Open(options);
  if (!options.ros2) return;
  const auto [interface, domain] = SplitLink("--ros2", *options.ros2);
  DdsLink link = Ros2Link(interface == kAnyInterface ? "" : interface);
  if (domain) link.domain = *domain;
  sends_ = true;
  interface_ = link.interface;
  domain_ = link.domain;
  Say(fmt::format("publishing in ROS 2, domain {}{}\n", domain_,
                  interface_.empty() ? "" : " at " + interface_));
}

template <class M>
void Ros2Outputs::AddSender(const std::string& name, const std::string& topic, const OutputPort<M>& message,
                            Rate rate, bool once) {
  auto& publisher = builder_.Add<DdsPublisher<M>>(name, {.topic = "rt/" + topic,
                                                         .link = {.domain = domain_, .interface = interface_},
                                                         .rate = rate,
                                                         .depth = once ? 1 : 0,
                                                         .transient_local = once});
  builder_.Connect(message, publisher.u);
  unsent_.push_back(
      [&publisher](const Context& context) { return static_cast<double>(context.Eval(publisher.unsent)); });
}

const OutputPort<VelocityCommand>* Ros2Outputs::VelocityIn(const Vec<3>& lowest, const Vec<3>& highest) {
  if (!sends_) return nullptr;
  auto& velocity = builder_.Add<Ros2Velocity>(
      "ros2_cmd_vel",
      {.link = {.domain = domain_, .interface = interface_}, .lowest = lowest, .highest = highest});
  heard_ = [&velocity](Summary& summary, const Context& context) {
    const RefusedMessages& refused = context.Eval(velocity.refused);
    summary.Set("velocities_taken", static_cast<double>(context.Eval(velocity.taken).number));
    summary.Set("velocities_refused", static_cast<double>(refused.count));
    if (refused.count > 0) summary.Note("the last refused velocity: " + refused.reason);
  };
  return &velocity.y;
}

#else

Ros2Outputs::Ros2Outputs(DiagramBuilder& builder, const RunOptions& options) : builder_(builder) {
  if (options.ros2)
    throw ParameterError(
        "--ros2: this build has no Cyclone DDS: install cyclonedds-dev and cyclonedds-tools, and build Tenon "
        "again");
  Open(options);
}
template <class M>
void Ros2Outputs::AddSender(const std::string&, const std::string&, const OutputPort<M>&, Rate, bool) {}
const OutputPort<VelocityCommand>* Ros2Outputs::VelocityIn(const Vec<3>&, const Vec<3>&) {
  return nullptr;
}

#endif

void Ros2Outputs::Open(const RunOptions& options) {
  if (!options.mcap || options.out.empty()) return;
  std::error_code ignored;
  std::filesystem::create_directories(options.out, ignored);
  file_ = std::make_shared<McapFile>(options.out / "run.mcap");
}

template <class M>
void Ros2Outputs::Add(const std::string& topic, const OutputPort<M>& message, Rate sent, Rate recorded,
                      bool once) {
  std::string name = topic;
  std::ranges::replace(name, '/', '_');
  if (sends_) AddSender("ros2_" + name, topic, message, sent, once);
  if (file_ == nullptr) return;
  auto& recorder =
      builder_.Add<McapPublisher<M>>("mcap_" + name, {.file = file_, .topic = "/" + topic, .rate = recorded});
  builder_.Connect(message, recorder.u);
}

template <ros2::Message M>
void Ros2Outputs::Send(const std::string& topic, const OutputPort<M>& message, Rate recorded) {
  Add(topic, message, Hz(100), recorded, false);
}

template <ros2::Message M>
void Ros2Outputs::SendOnce(const std::string& topic, const OutputPort<M>& message) {
  const Rate once = Hz(1e-4);  // the only tick of a run is its first
  Add(topic, message, once, once, true);
}

void Ros2Outputs::SendDescription(const std::string& urdf) {
  if (!any()) return;
  SendOnce("robot_description", builder_.AddFunction("robot_description", Uses(),
                                                     [urdf] { return ros2::std_msgs::String{urdf}; }));
}

void Ros2Outputs::SendClock() {
  if (!any()) return;
  Send("clock", builder_.AddFunction("clock", Uses(builder_.time),
                                     [](double t) { return ros2::rosgraph_msgs::Clock{ros2::StampOf(t)}; }));
}

void Ros2Outputs::AddTo(Summary& summary, const Simulator& simulator) const {
  if (file_ != nullptr)
    if (const int code = TryToWrite([&] { file_->Close(); }); code != kRan) summary.set_exit_code(code);
  if (!sends_) return;
  double unsent = 0;
  for (const auto& count : unsent_) unsent += count(simulator.context());
  summary.Set("messages_unsent", unsent);
  if (heard_) heard_(summary, simulator.context());
}

template void Ros2Outputs::Send(const std::string&, const OutputPort<ros2::sensor_msgs::JointState>&, Rate);
template void Ros2Outputs::Send(const std::string&, const OutputPort<ros2::sensor_msgs::Imu>&, Rate);
template void Ros2Outputs::Send(const std::string&, const OutputPort<ros2::nav_msgs::Odometry>&, Rate);
template void Ros2Outputs::Send(const std::string&, const OutputPort<ros2::geometry_msgs::WrenchStamped>&,
                                Rate);
template void Ros2Outputs::Send(const std::string&, const OutputPort<ros2::tf2_msgs::TFMessage>&, Rate);
template void Ros2Outputs::SendOnce(const std::string&, const OutputPort<ros2::tf2_msgs::TFMessage>&);

}  // namespace tenon::apps
