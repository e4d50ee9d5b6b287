#pragma once

#include <tenon/apps/common/run_scenario.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/systems/ros2/velocity_command.h>

namespace tenon::apps {

/// Splits INTERFACE[,DOMAIN]. Throws ParameterError that names the option.
std::pair<std::string, std::optional<int>> SplitLink(const std::string& option, const std::string& where);

/// The messages of a run, which the option --ros2 sends and --mcap records. Without these options it adds
/// nothing to the diagram.
class Ros2Outputs {
 public:
  /// Throws ParameterError for --ros2 in a build without Cyclone DDS or in an invalid domain, and OutputError
  /// if run.mcap cannot be opened in the output directory.
  Ros2Outputs(DiagramBuilder& builder, const RunOptions& options);

  /// Whether anybody wants the messages.
  bool any() const { return sends_ || file_ != nullptr; }

  /// Sends a message at 100 Hz, such as to the topic /joint_states, and records it at a rate of its own.
  template <ros2::Message M>
  void Send(const std::string& topic, const OutputPort<M>& message, Rate recorded = Hz(100));
  /// Sends a message once, also to programs that join later.
  template <ros2::Message M>
  void SendOnce(const std::string& topic, const OutputPort<M>& message);
  /// Sends the text of a URDF as the topic /robot_description.
  void SendDescription(const std::string& urdf);
  /// Sends the time of the run as the topic /clock.
  void SendClock();

  /// Returns the velocity that is commanded by /cmd_vel or /joy, within bounds; null without --ros2.
  const OutputPort<VelocityCommand>* VelocityIn(const Vec<3>& lowest, const Vec<3>& highest);

  /// Adds the numbers of messages that were not sent and that were refused to the figures, and completes
  /// run.mcap. If that fails, the error is printed on stderr and becomes the summary's exit code.
  void AddTo(Summary& summary, const Simulator& simulator) const;

 private:
  void Open(const RunOptions& options);
  template <class M>
  void Add(const std::string& topic, const OutputPort<M>& message, Rate sent, Rate recorded, bool once);
  template <class M>
  void AddSender(const std::string& name, const std::string& topic, const OutputPort<M>& message, Rate rate,
                 bool once);

  DiagramBuilder& builder_;
  bool sends_ = false;
  std::shared_ptr<McapFile> file_;
  std::string interface_;
  int domain_ = 0;
  std::vector<std::function<double(const Context&)>> unsent_;
  std::function<void(Summary&, const Context&)> heard_;
};

}  // namespace tenon::apps
