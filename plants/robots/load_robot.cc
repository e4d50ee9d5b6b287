#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/robots/internal/quadruped_urdf.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <fmt/format.h>

#include <numbers>

namespace tenon {
namespace {

/// One value for each leg.
template <class T>
struct PerLeg {
  T front_left = internal::Zeroed<T>(), front_right = front_left, rear_left = front_left,
    rear_right = front_left;
  std::array<T, kNumLegs> InOrder() const { return {front_left, front_right, rear_left, rear_right}; }
  static FieldList Fields() {
    return {Required(kLegNames[0], &PerLeg::front_left), Required(kLegNames[1], &PerLeg::front_right),
            Required(kLegNames[2], &PerLeg::rear_left), Required(kLegNames[3], &PerLeg::rear_right)};
  }
};

/// A movable joint that does not belong to a leg, or an additional joint in a leg, with its fixed position.
struct LockedJoint {
  std::string joint;
  std::optional<double> angle;     ///< of a joint that turns [rad]
  std::optional<double> position;  ///< of a joint that slides [m]
  static FieldList Fields() {
    return {Required("joint", &LockedJoint::joint),
            {"angle_rad", &LockedJoint::angle},
            {"position_m", &LockedJoint::position}};
  }
  void Validate() const {
    if (angle.has_value() == position.has_value())
      throw ParameterError(
          fmt::format("give angle_rad of '{}' if it turns, or position_m if it slides", joint));
  }
};

/// A joint outside the legs that moves under PD control.
struct ActuatedJoint {
  std::string joint;
  double angle = 0;              ///< reference, at t = 0 if it moves [rad]
  double amplitude = 0;          ///< amplitude of the reference [rad]
  std::optional<double> period;  ///< period of the reference [s]
  double phase = 0;              ///< phase of the reference at t = 0 [rad]
  double stiffness = 0;          ///< [N m/rad]
  double damping = 0;            ///< [N m s/rad]

  static FieldList Fields() {
    return {Required("joint", &ActuatedJoint::joint),
            {"angle_rad", &ActuatedJoint::angle},
            Field("amplitude_rad", &ActuatedJoint::amplitude).AtLeast(0),
            Field("period_s", &ActuatedJoint::period).Positive(),
            {"phase_rad", &ActuatedJoint::phase},
            Required("stiffness_N_m_per_rad", &ActuatedJoint::stiffness).AtLeast(0),
            Required("damping_N_m_s_per_rad", &ActuatedJoint::damping).AtLeast(0)};
  }
  void Validate() const {
    if (amplitude > 0 && !period)
      throw ParameterError(
          fmt::format("amplitude_rad is {}, but period_s is missing: add it for '{}'", amplitude, joint));
  }
  AttachedBody Drive() const {
    AttachedBody drive;
    drive.name = joint;
    drive.stiffness = stiffness;
    drive.damping = damping;
    drive.rest = angle;
    drive.amplitude = amplitude;
    drive.phase = phase;
    drive.frequency = period ? 2 * std::numbers::pi / *period : 0;
    return drive;
  }
};

/// Limits of the joints of all legs, which replace those in the URDF.
struct LimitsOfJoints {
  internal::JointLimits abduction, hip_pitch, knee;
  static FieldList Fields() {
    return {{"abduction", &LimitsOfJoints::abduction},
            {"hip_pitch", &LimitsOfJoints::hip_pitch},
            {"knee", &LimitsOfJoints::knee}};
  }
};

/// The place of the real robot, as apps name it.
struct RobotPlace {
  std::string unitree;
  static FieldList Fields() { return {Required("unitree", &RobotPlace::unitree)}; }
};

/// The contents of a robot's YAML file.
struct RobotFile {
  std::string name;
  std::string urdf;
  std::optional<double> mass;
  std::string trunk_link;
  internal::LinkAxis forward = internal::LinkAxis::kX, up = internal::LinkAxis::kZ;
  PerLeg<std::string> feet;
  std::optional<PerLeg<Eigen::Vector3d>> foot_centres;
  double foot_radius = 0;
  LimitsOfJoints limits;
  std::vector<LockedJoint> locked;
  std::vector<ActuatedJoint> actuated;
  Eigen::Vector3d imu = Eigen::Vector3d::Zero();
  PerLeg<Eigen::Vector3d> stance;
  DriveProperties drive;
  ContactProperties contact;
  std::optional<RobotPlace> link;

  static FieldList Fields() {
    return {Required("name", &RobotFile::name),
            Required("urdf", &RobotFile::urdf),
            Field("mass_kg", &RobotFile::mass).Positive(),
            {"trunk_link", &RobotFile::trunk_link},
            {"forward", &RobotFile::forward},
            {"up", &RobotFile::up},
            Required("feet", &RobotFile::feet),
            Required("foot_radius_m", &RobotFile::foot_radius)
                .Above(0)
                .AtMost(0.5)
                .Because("the radius of the sphere that touches the ground"),
            {"foot_centres_m", &RobotFile::foot_centres},
            {"joint_limits", &RobotFile::limits},
            {"locked_joints", &RobotFile::locked},
            {"actuated_joints", &RobotFile::actuated},
            {"imu_position_m", &RobotFile::imu},
            Required("nominal_stance", &RobotFile::stance),
            Required("drive", &RobotFile::drive),
            Required("contact", &RobotFile::contact),
            {"link", &RobotFile::link}};
  }
  void Validate() const {
    if (internal::Along(forward).dot(internal::Along(up)) != 0)
      throw ParameterError("forward and up must be at right angles: choose another axis");
  }
};

/// Checks the order of the legs and the angles of the nominal stance. Throws ParameterError.
void CheckStance(const QuadrupedDescription& robot, const PerLeg<std::string>& feet,
                 const YamlDocument& document) {
  for (int leg = 0; leg < kNumLegs; ++leg) {
    for (int i = 0; i < kJointsPerLeg; ++i) {
      const JointDescription& joint = robot.legs[leg].joints[i];
      const double q = robot.stance[kJointsPerLeg * leg + i];
      if (q < joint.lower || q > joint.upper)
        throw ParameterError(fmt::format(
            "{}: the angle {} rad is outside the range {} to {} rad of the joint '{}' in the URDF; "
            "change one of them",
            document.PlaceOf(fmt::format("nominal_stance.{}.{}", kLegNames[leg], i)), q, joint.lower,
            joint.upper, joint.name));
    }
    const Eigen::Vector3d p = robot.FootPosition(leg, robot.stance);
    if ((p[0] > 0) != IsFront(leg) || (p[1] > 0) != IsLeft(leg))
      throw ParameterError(fmt::format(
          "{}: '{}' is at ({:.3g}, {:.3g}, {:.3g}) m from the root link in the nominal stance, which is {} "
          "{} (x points forward, y to the left); swap the names of the feet, or turn the URDF's root link",
          document.PlaceOf(fmt::format("feet.{}", kLegNames[leg])), feet.InOrder()[leg], p[0], p[1], p[2],
          p[0] > 0 ? "front" : "rear", p[1] > 0 ? "left" : "right"));
  }
  try {
    StandingOn(robot, {});
  } catch (const ParameterError& error) {
    throw ParameterError(document.Placed("nominal_stance", error.what()));
  }
}

QuadrupedDescription ReadRobot(const YamlDocument& document, std::vector<std::string>* warnings = nullptr,
                               MovingParts* moving = nullptr, RobotLinks* links = nullptr) {
  const auto file = document.Read<RobotFile>();
  QuadrupedDescription robot;
  robot.name = file.name;
  robot.foot_radius = file.foot_radius;
  robot.imu_B = file.imu;
  robot.drive = file.drive;
  robot.contact = file.contact;
  for (int leg = 0; leg < kNumLegs; ++leg)
    robot.stance.segment<kJointsPerLeg>(kJointsPerLeg * leg) = file.stance.InOrder()[leg];
  internal::UrdfReading reading;
  reading.mass = file.mass;
  reading.trunk = file.trunk_link;
  reading.forward = file.forward;
  reading.up = file.up;
  reading.feet = file.feet.InOrder();
  if (file.foot_centres) reading.foot_centres = file.foot_centres->InOrder();
  for (const LockedJoint& each : file.locked)
    reading.locked[each.joint] = each.angle ? *each.angle : *each.position;
  for (std::size_t i = 0; i < file.actuated.size(); ++i) {
    reading.actuated.push_back(file.actuated[i].Drive());
    if (!reading.locked.emplace(file.actuated[i].joint, file.actuated[i].angle).second)
      throw ParameterError(
          fmt::format("{}: '{}' is listed twice under 'locked_joints' and 'actuated_joints'; remove one",
                      document.PlaceOf(fmt::format("actuated_joints.{}.joint", i)), file.actuated[i].joint));
  }
  reading.limits = {file.limits.abduction, file.limits.hip_pitch, file.limits.knee};
  try {
    const std::vector<std::string> mended =
        internal::ReadUrdf(document.Path("urdf"), reading, &robot, moving);
    if (warnings != nullptr) *warnings = mended;
    if (links != nullptr) *links = internal::ReadLinks(document.Path("urdf"), reading, robot);
  } catch (const ParameterError& error) {
    throw ParameterError(document.Placed("urdf", error.what()));
  }
  CheckStance(robot, file.feet, document);
  return robot;
}

}  // namespace

QuadrupedDescription LoadQuadruped(const std::string& path) {
  return ReadRobot(YamlDocument::Load(path));
}

static YamlDocument LoadRobot(const YamlFile& what) {
  if (const std::string file = ResourceMap(what).Text("file"); file.ends_with(".urdf"))
    throw ParameterError(
        fmt::format("'{0}' is a URDF, but a robot needs a YAML file: make one by tenon-robot {0}",
                    internal::Excerpt(file)));
  return LoadResource("robots", what, "urdf");
}

QuadrupedDescription LoadQuadruped(const YamlFile& what) {
  return ReadRobot(LoadRobot(what));
}

std::string LoadPlace(const YamlFile& what) {
  const auto link = LoadRobot(what).Read<RobotFile>().link;
  return link ? link->unitree : "";
}

MovingParts LoadMovingParts(const YamlFile& what) {
  const YamlDocument document = LoadRobot(what);
  MovingParts moving;
  if (!document.Value("actuated_joints").empty()) ReadRobot(document, nullptr, &moving);
  return moving;
}

RobotLinks LoadRobotLinks(const YamlFile& what) {
  RobotLinks links;
  ReadRobot(LoadRobot(what), nullptr, nullptr, &links);
  return links;
}

std::vector<std::string> QuadrupedWarnings(const YamlFile& what) {
  std::vector<std::string> warnings;
  ReadRobot(LoadRobot(what), &warnings);
  return warnings;
}

CdprDescription LoadCdpr(const std::string& path) {
  return YamlDocument::Load(path).Read<CdprDescription>();
}

CdprDescription LoadCdpr(const YamlFile& what) {
  return LoadResource("robots", what, "cables").Read<CdprDescription>();
}

}  // namespace tenon
