#include <tenon/apps/quadruped/quadruped_proposal.h>
#include <tenon/plants/legged/quadruped_clearance.h>
#include <tenon/plants/robots/mesh_file.h>
#include <tenon/systems/yaml/internal/yaml_tree.h>
#include <tenon/systems/yaml/mesh_paths.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numbers>
#include <set>

namespace tenon {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using internal::LinkAxis;
using internal::UrdfJoint;
using internal::UrdfLink;
using internal::UrdfShape;
using std::numbers::pi;

constexpr double kFarFoot = 0.4;  // minimum distance of a foot from the knee, relative to the thigh
constexpr double kAlike = 0.05;   // difference of bending up to which the knee points backward [rad]
// Least distance of the hip pitch from the axis of the abduction that counts, relative to the length of the
// leg.
constexpr double kOffAxis = 0.02;
constexpr double kMargin = 0.02;  // distance from the ends of a joint's range [rad]
// Distances from hip to foot in the stance that are tried in turn, relative to the length of the leg.
constexpr double kBending[] = {0.7, 0.65, 0.75, 0.6, 0.8, 0.55, 0.85, 0.5, 0.9};
// A trunk that rolls by this angle over upright legs should not touch them. Otherwise they are turned
// outwards, by at most kMostSplay [rad].
constexpr double kRoll = 0.5, kMostSplay = 0.2;
constexpr double kTip = 0.05;  // the end of a mesh that is fitted by a sphere, over the length of the shank
// Placeholders: a torque limit above this multiple of weight times leg length, and a speed limit below this
// multiple of sqrt(g / leg length), which a trot exceeds.
constexpr double kMostTorque = 5, kLeastSpeed = 1;
constexpr std::array<const char*, kJointsPerLeg> kKinds{"abduction", "hip_pitch", "knee"};

struct Foot {
  std::string link;
  Vector3d centre = Vector3d::Zero();  ///< centre in the link [m]
  double radius = 0;                   ///< 0 if unknown [m]
  Vector3d p_B = Vector3d::Zero();     ///< centre in B with all joints at 0 [m]
};

class Proposal {
 public:
  Proposal(const std::filesystem::path& path, const UrdfLegsOptions& options, bool strict,
           std::optional<double> mass)
      : path_(path),
        file_(internal::ReadUrdfFile(path)),
        strict_(strict),
        mass_(mass),
        found_(FindUrdfLegs(file_, options)),
        notes_(found_.notes) {
    for (std::size_t i = 0; i < kNumLegs; ++i) feet_[i] = FindFoot(legs_[i]);
    Read();
    ReplacePlaceholders();
    NoteTrunk();
    while (stands_ < kNumLegs && Bend(stands_)) ++stands_;
  }

  bool stands() const { return stands_ == kNumLegs; }
  LinkAxis up() const { return found_.up; }

  QuadrupedProposal Make() {
    if (!stands())
      file_.Fail(
          "joint '{}': no angles of the leg's joints within their ranges bring the foot '{}' below the hip, "
          "where '{}' of '{}' points up; correct the ranges, or set another axis by --up",
          legs_[static_cast<std::size_t>(stands_)][1]->name, feet_[static_cast<std::size_t>(stands_)].link,
          EnumName(found_.up), found_.trunk.empty() ? file_.FloatingLink().name : found_.trunk);
    Splay();
    return {Write(), notes_};
  }

 private:
  template <class... Args>
  void Note(fmt::format_string<Args...> format, Args&&... args) {
    notes_.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  /// Whether a cylinder turns about its axis.
  bool IsWheel(const UrdfLink& link, const UrdfShape& cylinder) const {
    for (const UrdfLink* at = &link; at->parent_joint != nullptr; at = at->parent) {
      const UrdfJoint& joint = *at->parent_joint;
      if (!joint.turns()) continue;
      const Vector3d axis = found_.poses.at(joint.child).linear() * joint.axis.normalized();
      return found_.locked.contains(joint.name) &&
             std::abs(axis.dot(found_.poses.at(link.name).linear() * cylinder.pose.linear().col(2))) > 0.99;
    }
    return false;
  }

  /// Searches the collision shapes and frames of a link and of all links below it.
  void Search(const UrdfLink& link, const Vector3d& knee, Foot* sphere, Foot* frame) const {
    const Isometry3d& T_BL = found_.poses.at(link.name);
    const auto consider = [&](Foot* best, const Vector3d& centre, double radius) {
      const Vector3d p = T_BL * centre;
      if (best->link.empty() || (p - knee).norm() > (best->p_B - knee).norm() + 1e-9)
        *best = {link.name, centre, radius, p};
    };
    double round = 0;
    for (const UrdfShape& collision : link.collisions) {
      const Vector3d centre = collision.pose.translation();
      if (collision.kind == UrdfShape::Kind::kSphere) consider(sphere, centre, collision.radius);
      if (collision.kind != UrdfShape::Kind::kCylinder) continue;
      if (centre.isZero(1e-9)) round = collision.radius;
      if (IsWheel(link, collision)) consider(sphere, centre, collision.radius);
    }
    consider(frame, Vector3d::Zero(), round);
    for (const UrdfJoint* joint : link.joints) Search(file_.ChildOf(*joint), knee, sphere, frame);
  }

  Foot FindFoot(const UrdfChain& leg) {
    const UrdfLink& shank = file_.ChildOf(*leg.back());
    const Vector3d knee = found_.poses.at(shank.name).translation();
    const double thigh = (knee - found_.poses.at(leg[1]->child).translation()).norm();
    Foot sphere, frame;
    Search(shank, knee, &sphere, &frame);
    const auto far = [&](const Foot& foot) {
      return !foot.link.empty() && (foot.p_B - knee).norm() > kFarFoot * thigh;
    };
    if (far(sphere) && (sphere.p_B - knee).norm() > 0.9 * (frame.p_B - knee).norm()) return sphere;
    if (far(frame)) return frame;
    if (const std::optional<Foot> tip = TipOfMeshes(shank)) return *tip;
    if (!shank.inertia || !(shank.inertia->mass > 0))
      file_.Fail(
          "link '{}', below the knee '{}', has no foot: no frame on a fixed joint, no sphere among its "
          "collision shapes, no mesh that can be read, no mass; add a link by a fixed joint at the centre of "
          "the foot",
          shank.name, leg.back()->name);
    const Vector3d centre = thigh * shank.inertia->com.normalized();
    if (feet_[0].link.empty())
      Note(
          "no shape or mesh shows the feet: each is guessed as far from the knee as the knee from the hip, "
          "{:.3g} m; correct foot_centres_m",
          thigh);
    return {shank.name, centre, 0, found_.poses.at(shank.name) * centre};
  }

  /// Returns a sphere at the end of a shank's meshes that is farthest from the knee; empty without meshes.
  std::optional<Foot> TipOfMeshes(const UrdfLink& shank) {
    std::vector<Vector3d> corners;  // in the shank
    const auto add = [&](const auto& shapes) {
      for (const UrdfShape& shape : shapes) {
        if (shape.kind != UrdfShape::Kind::kMesh) continue;
        const auto file = FindMesh(shape.mesh, file_.name);
        if (!file) continue;
        for (const auto& [x, y, z] : ReadMesh(*file)->corners)
          corners.push_back(shape.pose *
                            Vector3d(x * shape.scale.x(), y * shape.scale.y(), z * shape.scale.z()));
      }
    };
    add(shank.collisions);
    if (corners.empty()) add(shank.visuals);
    if (corners.empty()) return {};
    const Vector3d tip = *std::ranges::max_element(corners, {}, [](const Vector3d& p) { return p.norm(); });
    const Vector3d along = tip.normalized();
    double radius = 0;
    for (const Vector3d& p : corners)
      if ((tip - p).dot(along) < kTip * tip.norm())
        radius = std::max(radius, (p - tip - (p - tip).dot(along) * along).norm() / 2);
    radius = std::clamp(radius, 0.03 * tip.norm(), 0.12 * tip.norm());
    const Vector3d centre = tip - radius * along;
    if (feet_[0].link.empty())
      Note(
          "the feet are the ends of the shanks' meshes: spheres of {:.2g} m; correct foot_centres_m and "
          "foot_radius_m",
          radius);
    return Foot{shank.name, centre, radius, found_.poses.at(shank.name) * centre};
  }

  /// Reads the robot with placeholders for limits that the URDF does not have. Its weight and size determine
  /// the guesses in the file.
  void Read() {
    internal::UrdfReading reading;
    reading.strict = strict_;
    reading.mass = mass_;
    reading.trunk = found_.trunk;
    reading.forward = found_.forward;
    reading.up = found_.up;
    reading.locked = found_.locked;
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      reading.feet[i] = feet_[i].link;
      reading.foot_centres[i] = feet_[i].centre;
      for (std::size_t k = 0; k < kJointsPerLeg; ++k) {
        const UrdfJoint& joint = *legs_[i][k];
        const bool has = joint.limits.has_value();
        if (!has || !(joint.limits->effort > 0)) reading.limits[k].torque = 1;
        if (!has || !(joint.limits->velocity > 0)) reading.limits[k].speed = 1;
        if (joint.type == UrdfJoint::Type::kRevolute && !(has && joint.limits->lower < joint.limits->upper))
          reading.limits[k].range = Eigen::Vector2d(-pi, pi);
      }
    }
    for (const std::string& warning : internal::ReadUrdf(path_, reading, &robot_)) notes_.push_back(warning);
    limits_ = reading.limits;
    length_ = robot_.LegLength(0);
    weight_ = kGravity * robot_.mass();
  }

  /// Treats limits of torque and speed that no drive of such a robot has as missing.
  void ReplacePlaceholders() {
    for (std::size_t k = 0; k < kJointsPerLeg; ++k)
      missing_[k] = limits_[k].torque || limits_[k].speed || limits_[k].range;
    const double speed_unit = 1 / std::sqrt(length_ / kGravity), torque_unit = weight_ * length_;
    for (std::size_t k = 0; k < kJointsPerLeg; ++k) {
      double torque = 0, speed = std::numeric_limits<double>::infinity();
      for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
        const JointDescription& joint = robot_.legs[leg].joints[k];
        torque = std::max(torque, joint.torque_limit);
        speed = std::min(speed, joint.speed_limit);
      }
      if (!limits_[k].torque && torque > kMostTorque * torque_unit) {
        Note(
            "the URDF's torque limit of the {} joints, {:.4g} N m, is {:.0f} times weight times leg length "
            "and taken as a placeholder: guessed, see joint_limits",
            kKinds[k], torque, torque / torque_unit);
        limits_[k].torque = 1;
      }
      if (!limits_[k].speed && speed < kLeastSpeed * speed_unit) {
        Note(
            "the URDF's speed limit of the {} joints, {:.3g} rad/s, is below the {:.2g} rad/s that a trot "
            "needs and taken as a placeholder: guessed, see joint_limits",
            kKinds[k], speed, 1.5 * speed_unit);
        limits_[k].speed = 1;
      }
    }
  }

  /// Notes the first link of the trunk whose CoM is far below the hips.
  void NoteTrunk() {
    double hips = 0;
    for (const LegDescription& leg : robot_.legs) hips += leg.joints[0].p_PJ.z() / kNumLegs;
    const auto visit = [&](const auto& self, const UrdfLink& link) -> bool {
      if (link.inertia && link.inertia->mass > 0) {
        const double below = hips - (found_.poses.at(link.name) * link.inertia->com).z();
        if (below > length_ / 2) {
          Note(
              "the CoM of link '{}' of the trunk is {:.2g} m below the hips; check the <origin> of its "
              "<inertial>",
              link.name, below);
          return true;
        }
      }
      return std::ranges::any_of(link.joints, [&](const UrdfJoint* joint) {
        const bool is_leg = std::ranges::any_of(legs_, [&](const UrdfChain& leg) { return leg[0] == joint; });
        return !is_leg && self(self, file_.ChildOf(*joint));
      });
    };
    visit(visit, file_.FloatingLink());
  }

  /// The angle plus a whole number of turns that lies within a joint's range.
  static std::optional<double> Inside(const JointDescription& joint, double angle) {
    for (const double turn : {0.0, -2 * pi, 2 * pi}) {
      if (angle + turn > joint.lower + kMargin && angle + turn < joint.upper - kMargin) return angle + turn;
    }
    return {};
  }

  /// Finds joint angles with the foot below the hip: the leg's plane upright, and the knee bent. Returns
  /// whether there are some.
  bool Bend(int leg) {
    const auto& joints = robot_.legs[static_cast<std::size_t>(leg)].joints;
    const Vector3d &a0 = joints[0].axis, &a1 = joints[1].axis;
    // Two angles of the abduction bring the axis of the hip pitch across: that with the hip outside first.
    const double level = -std::atan2(a1.z(), a1.y()) * (a0.x() > 0 ? 1 : -1);
    std::vector<double> angles{level, level > 0 ? level - pi : level + pi};
    const auto inwards = [&](double q0) {
      const double y = (Eigen::AngleAxisd(q0, a0) * joints[1].p_PJ).y();
      return std::abs(y) < kOffAxis * length_ ? 0 : (y > 0) == IsLeft(leg) ? -1 : 1;
    };
    std::ranges::sort(angles, {}, [&](double q0) { return std::pair(inwards(q0), std::abs(q0)); });
    if (std::ranges::none_of(angles, [&](double q0) { return Inside(joints[0], q0).has_value(); }) &&
        joints[0].lower + 2 * kMargin < joints[0].upper) {
      std::ranges::sort(angles, {}, [](double q0) { return std::abs(q0); });
      angles = {std::clamp(angles[0], joints[0].lower + kMargin, joints[0].upper - kMargin)};
    }
    return std::ranges::any_of(angles, [&](double q0) {
      const std::optional<double> inside = Inside(joints[0], q0);
      return BendAt(leg, inside.value_or(q0));
    });
  }

  bool BendAt(int leg, double q0) {
    const auto& joints = robot_.legs[static_cast<std::size_t>(leg)].joints;
    const Vector3d &a0 = joints[0].axis, &a1 = joints[1].axis,
                   &foot = robot_.legs[static_cast<std::size_t>(leg)].foot_J;
    const Eigen::Matrix3d R0 = Eigen::AngleAxisd(q0, a0).toRotationMatrix();
    const Vector3d down = R0.transpose() * -Vector3d::UnitZ();
    const auto in_plane = [&](const Vector3d& p) -> Vector3d { return p - p.dot(a1) * a1; };
    const auto from_hip = [&](double knee) -> Vector3d {
      return in_plane(joints[2].p_PJ + Eigen::AngleAxisd(knee, joints[2].axis) * foot);
    };
    const double length = in_plane(joints[2].p_PJ).norm() + in_plane(foot).norm();
    double least = std::numeric_limits<double>::infinity();  // least bending so far
    const auto consider = [&](double knee) {
      const Vector3d e = from_hip(knee);
      const std::optional<double> hip = Inside(joints[1], std::atan2(a1.dot(e.cross(down)), e.dot(down)));
      const std::optional<double> bent = Inside(joints[2], knee);
      if (!hip || !bent) return;
      const Vector3d thigh_B = R0 * in_plane(Eigen::AngleAxisd(*hip, a1) * joints[2].p_PJ);
      const bool backward = thigh_B.x() < 0;
      const double bend = std::abs(knee) - (backward ? kAlike : 0);
      if (bend >= least) return;
      least = bend;
      robot_.stance.segment<3>(kJointsPerLeg * leg) << q0, *hip, *bent;
      backward_[static_cast<std::size_t>(leg)] = backward;
    };
    for (const double part : kBending) {
      constexpr int kSteps = 720;
      for (int i = 0; i < kSteps; ++i) {  // find a knee angle with this distance by bisection
        double low = -pi + 2 * pi * i / kSteps, high = low + 2 * pi / kSteps;
        const auto beyond = [&](double knee) { return from_hip(knee).norm() - part * length; };
        if ((beyond(low) > 0) == (beyond(high) > 0)) continue;
        for (int halving = 0; halving < 40; ++halving)
          ((beyond((low + high) / 2) > 0) == (beyond(low) > 0) ? low : high) = (low + high) / 2;
        consider(low);
      }
      bending_[static_cast<std::size_t>(leg)] = part;
      if (std::isfinite(least)) return true;
    }
    return false;
  }

  /// Turns all legs of the stance outwards by the same angle, see kRoll.
  void Splay() {
    QuadrupedDescription shaped = robot_;
    shaped.foot_radius = FootRadius();
    const QuadrupedClearance clearance(shaped, {});
    const auto turned = [&](double outwards) {
      LeggedState x;
      x.q = robot_.stance;
      for (int leg = 0; leg < kNumLegs; ++leg) {
        x.q[kJointsPerLeg * leg] +=
            (robot_.joint(kJointsPerLeg * leg).axis.x() > 0) == IsLeft(leg) ? outwards : -outwards;
      }
      return x;
    };
    const auto possible = [&](double outwards) {
      const LeggedState x = turned(outwards);
      for (int j = 0; j < kNumJoints; j += kJointsPerLeg)
        if (Inside(robot_.joint(j), x.q[j]) != x.q[j]) return false;
      return true;
    };
    constexpr int kSteps = 20;
    for (int i = 1; i <= kSteps && clearance.At(turned(splay_ - kRoll)).trunk.distance < 0; ++i) {
      if (!possible(i * kMostSplay / kSteps)) break;
      splay_ = i * kMostSplay / kSteps;
    }
    robot_.stance = turned(splay_).q;
  }

  /// A number rounded to two digits.
  static std::string Round(double value) {
    const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
    return fmt::format("{:.10g}", std::round(value / unit) * unit);
  }
  template <class F>
  static std::string PerLeg(const F& of) {
    std::string text;
    for (std::size_t i = 0; i < kNumLegs; ++i)
      text += fmt::format("{}{}: {}", i == 0 ? "" : ", ", kLegNames[i], of(i));
    return text;
  }

  std::string WriteLimits() {
    std::string text;
    for (std::size_t k = 0; k < kJointsPerLeg; ++k) {
      const internal::JointLimits& limits = limits_[k];
      std::vector<std::string> own;
      if (limits.torque) own.push_back("torque_N_m: " + Round(0.5 * weight_ * length_));
      if (limits.speed) own.push_back("speed_rad_per_s: " + Round(3 / std::sqrt(length_ / kGravity)));
      if (limits.range) own.push_back("range_rad: [-3.1416, 3.1416]");
      if (own.empty()) continue;
      if (missing_[k]) Note("the URDF has no limits of the {} joints: guessed, see joint_limits", kKinds[k]);
      text += fmt::format("  {}: {{{}}}\n", kKinds[k], fmt::join(own, ", "));
    }
    if (text.empty()) return "";
    return "\n# Limits that the URDF does not give. They are guesses: half the weight times the\n"
           "# length of the leg, and 3 rad in the time sqrt(leg / g). Replace them by the drives' data.\n"
           "joint_limits:\n" +
           text;
  }

  /// Radius of the feet [m]; a guess if the URDF has none.
  double FootRadius() const { return feet_[0].radius > 0 ? feet_[0].radius : 0.05 * length_; }

  std::string WriteFeet() {
    std::string text = fmt::format(
        "\n# Links of the feet, spheres: the farthest from the knee below it. A leg is the chain of\n"
        "# three joints above its foot: abduction, hip pitch, knee. The hips tell front from rear.\n"
        "feet: {{{}}}\n",
        PerLeg([&](std::size_t i) { return internal::YamlScalar(feet_[i].link); }));
    const bool centred =
        std::all_of(feet_.begin(), feet_.end(), [](const Foot& f) { return f.centre.isZero(1e-9); });
    if (!centred)
      text += fmt::format(
          "# Centres of the spheres in these links, from the collision shapes.\nfoot_centres_m: {{{}}}\n",
          PerLeg([&](std::size_t i) {
            const Vector3d& c = feet_[i].centre;
            return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", c[0], c[1], c[2]);
          }));
    const double radius = FootRadius();
    const bool known = feet_[0].radius > 0;
    if (!known) Note("the URDF has no radius of the feet: foot_radius_m is guessed as {} m", Round(radius));
    text += known
                ? fmt::format("foot_radius_m: {:.6g}         # from the collision shape\n", radius)
                : fmt::format("foot_radius_m: {}         # a guess: 5 % of the leg; the URDF has no radius\n",
                              Round(radius));
    return text;
  }

  std::string WriteDrive() {
    double damping = 0, friction = 0;
    for (const UrdfChain& leg : legs_) {
      for (const auto& joint : leg) {
        damping += joint->damping / kNumJoints;
        friction += joint->friction / kNumJoints;
      }
    }
    return fmt::format(
        "\n# One drive for all joints. Damping and friction are means of the URDF; it has no rotor inertia.\n"
        "drive:\n"
        "  rotor_inertia_kg_m2: 0               # at the joint: times the gear ratio squared\n"
        "  damping_N_m_s_per_rad: {:.4g}\n"
        "  friction_N_m: {:.4g}\n"
        "  full_torque_speed_ratio: 0.5         # full torque up to this part of the limit, a choice\n"
        "  stop_stiffness_N_m_per_rad: {}      # end stops: 4 times weight times leg length, a choice\n"
        "  stop_dissipation_s_per_rad: 0.5\n",
        damping, friction, Round(4 * weight_ * length_));
  }

  std::string WriteContact() const {
    const double depth = length_ / 600, time = std::sqrt(length_ / kGravity);
    return fmt::format(
        "\n# Contact: a foot that carries a quarter of the weight, {:.0f} N, sinks in by 1/600 of the\n"
        "# leg, {:.2g} mm. The other values are those of DogBot, scaled to this weight and size.\n"
        "contact:\n"
        "  stiffness_N_per_m: {}\n"
        "  dissipation_s_per_m: {}\n"
        "  blend_m: {}\n"
        "  bristle_stiffness_per_m: {}\n"
        "  bristle_damping_s_per_m: {}\n"
        "  bristle_friction: 0.2\n"
        "  full_friction_N: {}\n"
        "  release_time_s: {}\n",
        weight_ / 4, 1e3 * depth, Round(weight_ / 4 / depth), Round(12.4 * time / length_), Round(depth / 5),
        Round(600 / length_), Round(2.5 * time / length_), Round(weight_ / 40), Round(0.02 * time));
  }

  std::string Write() {
    std::string name = path_.stem().string();
    std::string text = fmt::format(
        "# {}: data that its URDF does not hold; made by tenon-robot. {:.4g} kg, legs of {:.3g} m.\n\n"
        "name: {}\nurdf: {}\n",
        file_.robot, robot_.mass(), length_, internal::YamlScalar(name),
        internal::YamlScalar(path_.filename().string()));
    if (mass_)
      text += fmt::format("mass_kg: {}     # shared by the bodies without mass in the URDF\n", *mass_);
    if (!found_.trunk.empty())
      text += fmt::format("trunk_link: {}     # its origin is that of the robot's frame\n",
                          internal::YamlScalar(found_.trunk));
    if (found_.forward != LinkAxis::kX)
      text += fmt::format("forward: \"{}\"     # axis of the trunk link along which the robot faces\n",
                          EnumName(found_.forward));
    if (found_.up != LinkAxis::kZ)
      text +=
          fmt::format("up: \"{}\"          # axis of the trunk link that points up\n", EnumName(found_.up));
    text += WriteFeet();
    text += "imu_position_m: [0, 0, 0]     # inertial unit on the trunk, in the root link's axes; a guess\n";
    text += fmt::format(
        "\n# Joint angles of the stance: feet below the hips at {} of the leg's length. The knees point\n"
        "# to the side with less bending, within the joints' ranges: {}.\n{}"
        "nominal_stance:\n",
        std::ranges::count(bending_, bending_[0]) == kNumLegs
            ? fmt::format("{:.2g}", bending_[0])
            : fmt::format("{{{}}}",
                          PerLeg([&](std::size_t i) { return fmt::format("{:.2g}", bending_[i]); })),
        PerLeg([&](std::size_t i) { return backward_[i] ? "backward" : "forward"; }),
        splay_ == 0
            ? ""
            : fmt::format(
                  "# The legs are turned outwards by {:.2g} rad, so that they touch the trunk less when "
                  "it rolls.\n",
                  splay_));
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Vector3d q = robot_.stance.segment<3>(kJointsPerLeg * leg);
      text += fmt::format("  {}: [{:.10g}, {:.10g}, {:.10g}]\n", kLegNames[static_cast<std::size_t>(leg)],
                          std::abs(q[0]) < 1e-9 ? 0.0 : q[0], q[1], q[2]);
    }
    if (!found_.locked.empty()) {
      text +=
          "\n# Joints outside the legs, and the angles at which they are fixed. Joints that move are under\n"
          "# actuated_joints instead, see docs/robots.md.\n"
          "locked_joints:\n";
      for (const auto& [joint, at] : found_.locked)
        text += fmt::format("  - {{joint: {}, {}: {:.6g}}}\n", internal::YamlScalar(joint),
                            file_.joints.at(joint).slides() ? "position_m" : "angle_rad", at);
    }
    text += WriteLimits();
    text += WriteDrive();
    text += WriteContact();
    return text;
  }

  const std::filesystem::path path_;
  const internal::UrdfFile file_;
  const bool strict_;
  const std::optional<double> mass_;  ///< [kg]
  const UrdfLegs found_;
  const std::array<UrdfChain, kNumLegs>& legs_ = found_.legs;
  std::array<Foot, kNumLegs> feet_;
  std::array<internal::JointLimits, kJointsPerLeg> limits_;  ///< limits that are guessed
  std::array<bool, kJointsPerLeg> missing_{};                ///< whether the URDF lacks a limit
  QuadrupedDescription robot_;
  std::array<bool, kNumLegs> backward_{};
  std::array<double, kNumLegs> bending_{};
  int stands_ = 0;    ///< number of legs with a stance
  double splay_ = 0;  ///< turn of the legs outwards in the stance [rad]
  double length_ = 0, weight_ = 0;
  std::vector<std::string> notes_;
};

}  // namespace

QuadrupedProposal ProposeQuadruped(const std::filesystem::path& urdf, const UrdfLegsOptions& options,
                                   bool strict, std::optional<double> mass) {
  Proposal proposal(urdf, options, strict, mass);
  if (proposal.stands() || options.up) return proposal.Make();
  UrdfLegsOptions upside_down = options;
  const int up = static_cast<int>(proposal.up());
  upside_down.up = static_cast<LinkAxis>((up + 3) % 6);
  Proposal other(urdf, upside_down, strict, mass);
  return (other.stands() ? other : proposal).Make();
}

}  // namespace tenon
