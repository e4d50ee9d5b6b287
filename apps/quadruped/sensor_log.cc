#include <tenon/apps/quadruped/log_estimator.h>
#include <tenon/plants/signals/ros2_signals.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon::apps {
namespace {

using namespace ros2;

constexpr double kGap = 2.5;               // periods without a sample
constexpr double kSlowest = 20;            // rate of sensors [Hz]
constexpr double kAlign = 5e-7;            // samples so short behind a tick belong to it [s]
constexpr std::size_t kMost = 10'000'000;  // messages that a log may have

[[noreturn]] void Refuse(const std::string& reason) {
  throw ParameterError(reason);
}

class Reader {
 public:
  Reader(const QuadrupedDescription& robot, const RobotLinks& links) : links_(links) {
    for (int j = 0; j < kNumJoints; ++j) names_.push_back(robot.joint(j).name);
    for (std::size_t leg = 0; leg < kNumLegs; ++leg)
      foot_topics_[leg] = std::string("/foot_force/") + kLegNames[leg];
  }

  SensorLog Read(const std::filesystem::path& file, bool foot_sensors) {
    if (const std::string told = ReadMcap(file, [&](const McapMessage& message) { Take(message); });
        !told.empty())
      log_.told.push_back(told);
    if (refused_ > 0)
      log_.told.push_back(fmt::format("{} messages were refused, the last one: {}", refused_, why_));
    const std::string where = internal::Excerpt(file.string());
    const auto demand = [&](const auto& samples, const std::string& topic, const char* type,
                            const std::string& remedy) {
      if (samples.size() < 2)
        Refuse(fmt::format("'{}' has {} of the topic {} ({}): {}{}", where,
                           samples.empty() ? "no message" : "one message", topic, type, remedy,
                           log_.told.empty() ? "" : "; " + log_.told.back()));
    };
    demand(log_.joints, "/joint_states", "sensor_msgs/msg/JointState", "record it");
    demand(log_.imu, "/imu", "sensor_msgs/msg/Imu", "record it");
    for (int leg = 0; leg < kNumLegs && foot_sensors; ++leg)
      demand(
          feet(leg), FootTopic(leg), "geometry_msgs/msg/WrenchStamped",
          "record it, or --set sensors.foot_force.mounted=none, which estimates the forces from the torques");
    Align(foot_sensors);
    return std::move(log_);
  }

 private:
  const std::string& FootTopic(int leg) const { return foot_topics_[static_cast<std::size_t>(leg)]; }
  Recording<Vec<3>>& feet(int leg) { return log_.feet[static_cast<std::size_t>(leg)]; }

  void Take(const McapMessage& message) {
    if (++count_ > kMost)
      Refuse(fmt::format("the log has more than {} messages: cut it, such as by ros2 bag convert", kMost));
    std::string reason;
    if (message.topic == "/joint_states") {
      reason = Read(message, joints_, [&](double t) { return TakeJoints(t); });
    } else if (message.topic == "/joint_commands") {
      reason = Read(message, joints_, [&](double t) { return TakeCommands(t); });
    } else if (message.topic == "/imu") {
      reason = Read(message, imu_, [&](double t) { return TakeImu(t); });
    } else if (message.topic == "/odom") {
      reason = Read(message, odometry_, [&](double t) { return TakeOdometry(t, log_.odometry); });
    } else if (message.topic == "/ground_truth") {
      reason = Read(message, odometry_, [&](double t) { return TakeOdometry(t, log_.truth); });
    } else if (const auto topic = std::ranges::find(foot_topics_, message.topic);
               topic != foot_topics_.end()) {
      const auto leg = static_cast<int>(topic - foot_topics_.begin());
      reason = Read(message, wrench_, [&](double t) { return TakeFoot(t, leg); });
    }
    if (reason.empty()) return;
    ++refused_;
    why_ = fmt::format("topic {}, t = {:.3f} s: {}", message.topic, message.time, reason);
  }
  /// Reads a message and takes it at its time. Returns the reason why it is refused.
  template <class M>
  std::string Read(const McapMessage& message, M& to, const auto& take) {
    if (std::string reason = message.Read(to); !reason.empty()) return reason;
    const double stamp = TimeOf(to.header.stamp);
    return take(stamp > 0 ? stamp : message.time);
  }
  template <class T>
  static std::string Append(double time, const T& value, Recording<T>& to) {
    if (!internal::IsFinite(value)) return "a number is not finite";
    if (!to.empty() && time <= to.back().time) return "its time does not go on";
    to.push_back({time, value});
    return {};
  }

  /// Returns the values of a list in the order of the robot's joints; NaN if it has another length.
  Vec<12> InOrder(const std::vector<double>& list) {
    if (joints_.name != known_) {  // in any order
      known_ = joints_.name;
      for (std::size_t j = 0; j < names_.size(); ++j) {
        const auto found = std::ranges::find(known_, names_[j]);
        if (found == known_.end())
          Refuse(
              fmt::format("the log lacks the joint '{}', but has '{}': choose the robot of "
                          "the log by --set robot=NAME",
                          names_[j], fmt::join(known_, "', '")));
        places_[j] = static_cast<std::size_t>(found - known_.begin());
      }
    }
    Vec<12> values = Vec<12>::Constant(std::numeric_limits<double>::quiet_NaN());
    if (list.size() != known_.size()) return values;
    for (int j = 0; j < kNumJoints; ++j) values[j] = list[places_[static_cast<std::size_t>(j)]];
    return values;
  }

  std::string TakeJoints(double time) {
    const JointMotion motion{InOrder(joints_.position), InOrder(joints_.velocity)};
    const Vec<12> torque = InOrder(joints_.effort);
    if (!internal::IsFinite(motion) || !torque.allFinite())
      return "position, velocity and effort, the measured torque, need a finite number for each joint";
    std::string reason = Append(time, motion, log_.joints);
    if (reason.empty()) log_.torque.push_back({time, torque});
    return reason;
  }
  std::string TakeCommands(double time) { return Append(time, InOrder(joints_.effort), log_.commands); }

  std::string TakeImu(double time) {
    if (imu_.header.frame_id != frame_) {
      frame_ = imu_.header.frame_id;
      R_BI_.setIdentity();
      for (std::string name = frame_; !name.empty() && name != links_.base;) {
        const auto link = std::ranges::find(links_.links, name, &RobotLinks::Link::name);
        if (link == links_.links.end() || link->joint >= 0)
          Refuse(
              fmt::format("the topic /imu has the frame '{}', which is no link at rest in the trunk: give "
                          "it in '{}'",
                          internal::Excerpt(frame_), links_.base));
        R_BI_ = link->rotation * R_BI_;
        name = link->parent;
      }
    }
    ImuMeasurement measured = ImuOf(imu_);
    measured.angular_velocity_B = R_BI_ * measured.angular_velocity_B;
    measured.specific_force_B = R_BI_ * measured.specific_force_B;
    return Append(time, measured, log_.imu);
  }

  std::string TakeFoot(double time, int leg) {
    const std::string& frame = wrench_.header.frame_id;
    if (frame != links_.base && frame != std::string("contact_") + kLegNames[static_cast<std::size_t>(leg)])
      return fmt::format("the frame '{}' is not contact_{}, which has the axes of the trunk",
                         internal::Excerpt(frame), kLegNames[static_cast<std::size_t>(leg)]);
    return Append(time, VectorOf(wrench_.wrench.force), feet(leg));
  }

  std::string TakeOdometry(double time, Recording<LeggedState>& to) {
    const geometry_msgs::Pose& pose = odometry_.pose.pose;
    LeggedState x;
    x.p_WB = {pose.position.x, pose.position.y, pose.position.z};
    x.q_WB = {pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z};
    if (!(std::abs(x.q_WB.norm() - 1) < 0.01)) return "the orientation is no unit quaternion";
    x.v_W = x.R_WB() * VectorOf(odometry_.twist.twist.linear);
    x.w_W = x.R_WB() * VectorOf(odometry_.twist.twist.angular);
    return Append(time, x, to);
  }

  /// Sets the times relative to the common start of the topics, and finds their rates and gaps.
  void Align(bool foot_sensors) {
    double end = std::min(log_.joints.back().time, log_.imu.back().time);
    log_.start = std::max(log_.joints.front().time, log_.imu.front().time);
    for (int leg = 0; leg < kNumLegs && foot_sensors; ++leg) {
      log_.start = std::max(log_.start, feet(leg).front().time);
      end = std::min(end, feet(leg).back().time);
    }
    const double period = std::max(Examine("/joint_states", log_.joints), Examine("/imu", log_.imu));
    for (int leg = 0; leg < kNumLegs && foot_sensors; ++leg) Examine(FootTopic(leg), feet(leg));
    if (end <= log_.start) Refuse("the topics have no common time: record them in one log");
    if (period * kSlowest > 1)
      Refuse(
          fmt::format("/joint_states or /imu has {:.3g} Hz: record at {} Hz or more", 1 / period, kSlowest));
    log_.rate = Hz(std::round(1 / period));
    log_.end = end - log_.start;
    const auto shift = [&](auto& samples) {
      for (auto& sample : samples) sample.time -= log_.start + kAlign;
    };
    shift(log_.joints), shift(log_.torque), shift(log_.commands), shift(log_.imu), shift(log_.odometry),
        shift(log_.truth);
    for (auto& samples : log_.feet) shift(samples);
  }
  /// Tells the gaps of a topic and returns its median period [s].
  double Examine(const std::string& topic, const auto& samples) {
    std::vector<double> periods;
    for (std::size_t i = 1; i < samples.size(); ++i) periods.push_back(samples[i].time - samples[i - 1].time);
    const auto longest = std::ranges::max_element(periods);
    const double at = samples[static_cast<std::size_t>(longest - periods.begin())].time, gap = *longest;
    std::ranges::nth_element(periods, periods.begin() + std::ssize(periods) / 2);
    const double period = periods[periods.size() / 2];
    const long gaps = std::ranges::count_if(periods, [&](double each) { return each > kGap * period; });
    if (gaps == 0) return period;
    log_.told.push_back(fmt::format("topic {}: {} gaps, the longest of {:.3g} s from t = {:.3f} s on", topic,
                                    gaps, gap, at - log_.start));
    log_.gaps += gaps;
    log_.longest_gap = std::max(log_.longest_gap, gap);
    return period;
  }

  const RobotLinks& links_;
  std::vector<std::string> names_, known_;        // joints of the robot, and of the log
  std::array<std::size_t, kNumJoints> places_{};  // in the log
  std::array<std::string, kNumLegs> foot_topics_;
  std::string frame_, why_;
  Eigen::Matrix3d R_BI_ = Eigen::Matrix3d::Identity();
  sensor_msgs::JointState joints_;
  sensor_msgs::Imu imu_;
  geometry_msgs::WrenchStamped wrench_;
  nav_msgs::Odometry odometry_;
  SensorLog log_;
  std::size_t count_ = 0;
  long refused_ = 0;
};

}  // namespace

SensorLog ReadSensorLog(const std::filesystem::path& file, const QuadrupedDescription& robot,
                        const RobotLinks& links, bool foot_sensors) {
  return Reader(robot, links).Read(file, foot_sensors);
}

}  // namespace tenon::apps
