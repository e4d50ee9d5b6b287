#include <tenon/apps/quadruped/leg_names.h>
#include <tenon/apps/quadruped/urdf_legs.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace tenon {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using internal::LinkAxis;
using internal::UrdfJoint;
using internal::UrdfLink;

constexpr double kLow = 0.4;  // a chain that reaches down by this part of the lowest one is a leg
constexpr double kOff = 0.3;  // largest distance of the origin from the hips' centre, over the leg's length

/// Finds the legs in an auxiliary frame F, whose z axis points up.
class LegFinder {
 public:
  LegFinder(const internal::UrdfFile& file, const UrdfLegsOptions& options)
      : file_(file), base_(file.FloatingLink()), options_(options) {
    found_.locked = options.locked;
  }

  UrdfLegs Find() {
    Place(Isometry3d::Identity());
    FindUp();
    std::vector<UrdfChain> legs = FindLegs();
    Vector3d centre = Vector3d::Zero();
    for (const UrdfChain& leg : legs) centre += HipOf(leg) / kNumLegs;
    ChooseTrunk(legs, centre);
    FindForward(legs, centre);
    const Isometry3d T_BF = PoseOfF(found_.forward), T_FR = poses().at(base_.name);
    Place(T_BF * T_FR);
    LockOthers(legs);
    Sort(std::move(legs));
    return std::move(found_);
  }

 private:
  template <class... Args>
  [[noreturn]] void Fail(fmt::format_string<Args...> format, Args&&... args) const {
    file_.Fail(fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void Note(fmt::format_string<Args...> format, Args&&... args) {
    found_.notes.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
  const std::map<std::string, Isometry3d>& poses() const { return found_.poses; }

  /// Computes the poses of all links from that of the link that floats, and the chains.
  void Place(const Isometry3d& T_FR) {
    found_.poses.clear();
    chains_.clear();
    Walk(base_, T_FR, {});
  }

  /// Collects the poses of all links, and the chains that end in a body without further revolute joints.
  bool Walk(const UrdfLink& link, const Isometry3d& T_FL, const UrdfChain& chain) {
    found_.poses[link.name] = T_FL;
    bool turns = false;
    for (const UrdfJoint* joint : link.joints) {
      Isometry3d T_FJ = T_FL * joint->pose;
      const auto angle = found_.locked.find(joint->name);
      UrdfChain below = chain;
      const bool is_free = joint->turns() && angle == found_.locked.end();
      if (is_free) below.push_back(joint);
      if (angle != found_.locked.end())
        T_FJ.rotate(Eigen::AngleAxisd(angle->second, joint->axis.normalized()));
      const bool more = Walk(file_.ChildOf(*joint), T_FJ, below);
      if (is_free && !more) chains_.push_back(below);
      turns = turns || is_free || more;
    }
    return turns;
  }

  const UrdfLink& LinkOf(const UrdfJoint& joint) const { return file_.ChildOf(joint); }
  Vector3d HipOf(const UrdfChain& leg) const { return poses().at(leg[1]->child).translation(); }
  double Lowest(const UrdfLink& link) const {
    double z = poses().at(link.name).translation().z();
    for (const UrdfJoint* joint : link.joints) z = std::min(z, Lowest(LinkOf(*joint)));
    return z;
  }
  /// The height by which a chain reaches down from its first joint.
  double DropOf(const UrdfChain& chain) const {
    return poses().at(chain[0]->child).translation().z() - Lowest(LinkOf(*chain.back()));
  }

  /// Turns F such that the chains of three joints reach down, if they all point along another axis.
  void FindUp() {
    Vector3d down = Vector3d::Zero();
    for (const UrdfChain& chain : chains_)
      if (chain.size() == kJointsPerLeg) down += poses().at(chain[2]->child).translation() - HipOf(chain);
    Eigen::Index axis = 0;
    if (!(down.cwiseAbs().maxCoeff(&axis) > kAlong * down.norm()) || axis == 2) return;
    constexpr LinkAxis kUp[][2] = {{LinkAxis::kX, LinkAxis::kMinusX}, {LinkAxis::kY, LinkAxis::kMinusY}};
    found_.up = kUp[axis][down[axis] > 0 ? 1 : 0];
    Note("the legs reach along the root link's axis against '{}': written as `up`", EnumName(found_.up));
    const LinkAxis across = axis == 0 ? LinkAxis::kY : LinkAxis::kX;
    Place(Isometry3d(internal::RotationOf(across, found_.up).transpose()));
  }

  /// Returns the legs: the chains of three joints that reach lowest.
  std::vector<UrdfChain> FindLegs() const {
    double largest = 0;
    for (const UrdfChain& chain : chains_) largest = std::max(largest, DropOf(chain));
    std::vector<UrdfChain> legs, others;
    for (const UrdfChain& chain : chains_)
      if (DropOf(chain) > kLow * largest) (chain.size() == kJointsPerLeg ? legs : others).push_back(chain);
    if (legs.size() != kNumLegs) Refuse(legs, others);
    return legs;
  }

  /// Throws ParameterError that says which kind of robot it is.
  [[noreturn]] void Refuse(const std::vector<UrdfChain>& legs, const std::vector<UrdfChain>& others) const {
    if (chains_.empty()) Fail("no joint turns, but a quadruped has four legs of three joints");
    const auto of_three = std::ranges::count(chains_, std::size_t{kJointsPerLeg}, &UrdfChain::size);
    if (of_three > kNumLegs && of_three == std::ssize(chains_))
      Fail("the robot has {} legs of three joints, the first '{}', but a quadruped has four", of_three,
           NamesOf(chains_[0]));
    const bool alike = legs.empty() && !others.empty() && std::ranges::all_of(others, [&](const auto& chain) {
                         return chain.size() == others[0].size();
                       });
    const std::size_t joints = alike ? others[0].size() : 0;
    if (alike && others.size() == kNumLegs && joints == 2)
      Fail(
          "the robot has four legs of two joints, the first '{}', but the legs of Tenon's quadrupeds have "
          "abduction, hip pitch and knee",
          NamesOf(others[0]));
    if (alike && others.size() == kNumLegs && joints == kJointsPerLeg + 1) {
      std::string options;
      for (const UrdfChain& chain : others) options += fmt::format(" --lock {}=0", chain.back()->name);
      Fail(
          "the robot has four legs of four joints, the first '{}'; if their last joints turn wheels or can "
          "be "
          "fixed, add{}",
          NamesOf(others[0]), options);
    }
    if (alike && others.size() <= 2)
      Fail("the robot has {} of {} joints ('{}'), but a quadruped has four legs of three joints",
           others.size() == 2 ? "two legs or arms" : "one leg or arm", joints, NamesOf(others[0]));
    std::string found;
    for (const UrdfChain& chain : chains_) found += fmt::format("; {} ({})", NamesOf(chain), chain.size());
    Fail(
        "found {} chains of three joints that turn and reach down, but a quadruped has four legs of "
        "abduction, "
        "hip pitch and knee; fix other joints by --lock JOINT=ANGLE. Chains{}",
        legs.size(), found);
  }

  /// Takes the heaviest link of the trunk as its frame, if the origin of the root link is far from the hips.
  void ChooseTrunk(const std::vector<UrdfChain>& legs, const Vector3d& centre) {
    const auto off = [&](const std::string& link) {
      return (poses().at(link).translation() - centre).norm() > kOff * DropOf(legs[0]);
    };
    if (!off(base_.name)) return;
    double mass = 0;
    const auto visit = [&](const auto& self, const UrdfLink& link) -> void {
      if (link.inertia && link.inertia->mass > mass && !off(link.name)) {
        mass = link.inertia->mass;
        found_.trunk = link.name;
      }
      for (const UrdfJoint* joint : link.joints)
        if (!joint->turns()) self(self, LinkOf(*joint));
    };
    visit(visit, base_);
    if (!found_.trunk.empty())
      Note("the origin of the root link is far from the hips: '{}' is the trunk, written as `trunk_link`",
           found_.trunk);
  }

  /// The pose of F in the frame of a robot that faces along an axis of its trunk.
  Isometry3d PoseOfF(LinkAxis forward) const {
    const Isometry3d T_TF = poses().at(found_.trunk.empty() ? base_.name : found_.trunk).inverse();
    return Isometry3d(internal::RotationOf(forward, found_.up).transpose()) * T_TF;
  }

  /// The place of a leg as the names of its joints and links give it.
  static LegPlace PlaceOf(const UrdfChain& leg) {
    LegPlace place;
    for (const auto& joint : leg) {
      for (const std::string& name : {joint->name, joint->child}) {
        const LegPlace said = PlaceInName(name);
        if (place.front == 0) place.front = said.front;
        if (place.left == 0) place.left = said.left;
      }
    }
    return place;
  }

  /// The number of names that agree with the places of the legs, minus those that contradict them.
  int Agreement(const std::vector<UrdfChain>& legs, const Vector3d& centre, LinkAxis forward) const {
    int count = 0;
    for (const UrdfChain& leg : legs) {
      const Vector3d p = PoseOfF(forward).linear() * (HipOf(leg) - centre);
      const LegPlace place = PlaceOf(leg);
      count += place.front * (p.x() > 0 ? 1 : -1) + place.left * (p.y() > 0 ? 1 : -1);
    }
    return count;
  }

  void FindForward(const std::vector<UrdfChain>& legs, const Vector3d& centre) {
    const Vector3d up = internal::Along(found_.up);
    if (options_.forward) {
      found_.forward = *options_.forward;
      if (std::abs(internal::Along(found_.forward).dot(up)) > 0.5)
        Fail("--forward {}: the robot's vertical is along this axis; give another one",
             EnumName(found_.forward));
    } else {
      int most = std::numeric_limits<int>::min();
      for (const LinkAxis forward : {LinkAxis::kX, LinkAxis::kY, LinkAxis::kMinusX, LinkAxis::kMinusY,
                                     LinkAxis::kZ, LinkAxis::kMinusZ}) {
        if (std::abs(internal::Along(forward).dot(up)) > 0.5) continue;
        const Eigen::Matrix3d R_BF = PoseOfF(forward).linear();
        const bool fits = std::ranges::all_of(legs, [&](const UrdfChain& leg) {
          return std::abs((R_BF * poses().at(leg[0]->child).linear() * leg[0]->axis.normalized()).x()) >
                 kAlong;
        });
        const int agreement = Agreement(legs, centre, forward);
        if (!fits || agreement <= most) continue;
        most = agreement;
        found_.forward = forward;
      }
      if (found_.forward != LinkAxis::kX)
        Note(
            "the robot faces along the axis '{}' of '{}', by the axes of its joints and the names of its "
            "legs: "
            "written as `forward`; --forward sets another axis",
            EnumName(found_.forward), found_.trunk.empty() ? base_.name : found_.trunk);
    }
    int named = 0;
    for (const UrdfChain& leg : legs) named += std::abs(PlaceOf(leg).front) + std::abs(PlaceOf(leg).left);
    const Vector3d first = PoseOfF(found_.forward).linear() * (HipOf(legs[0]) - centre);
    if (Agreement(legs, centre, found_.forward) < named)
      Note("the names of the legs contradict their places, which decide: '{}' is {} {}", legs[0][0]->name,
           first.x() > 0 ? "front" : "rear", first.y() > 0 ? "left" : "right");
  }

  void LockOthers(const std::vector<UrdfChain>& legs) {
    std::set<std::string> used;
    for (const UrdfChain& leg : legs)
      for (const auto& joint : leg) used.insert(joint->name);
    for (const UrdfChain& chain : chains_) {
      for (const auto& joint : chain) {
        if (!used.insert(joint->name).second) continue;
        const double angle =
            joint->type == UrdfJoint::Type::kRevolute && joint->limits->lower < joint->limits->upper
                ? std::clamp(0.0, joint->limits->lower, joint->limits->upper)
                : 0;
        found_.locked[joint->name] = angle;
        Note("joint '{}' belongs to no leg: locked at {:.3g} rad", joint->name, angle);
      }
    }
  }

  void Sort(std::vector<UrdfChain> legs) {
    std::ranges::stable_sort(legs, [&](const auto& a, const auto& b) { return HipOf(a).x() > HipOf(b).x(); });
    for (const std::size_t first : {0, 2})
      if (HipOf(legs[first]).y() < HipOf(legs[first + 1]).y()) std::swap(legs[first], legs[first + 1]);
    std::ranges::move(legs, found_.legs.begin());
  }

  const internal::UrdfFile& file_;
  const UrdfLink& base_;
  const UrdfLegsOptions& options_;
  UrdfLegs found_;  ///< the poses are those in F until the robot's frame is known
  std::vector<UrdfChain> chains_;
};

}  // namespace

std::string NamesOf(const UrdfChain& chain) {
  std::vector<std::string> names;
  for (const auto& joint : chain) names.push_back(joint->name);
  return fmt::format("{}", fmt::join(names, " - "));
}

UrdfLegs FindUrdfLegs(const internal::UrdfFile& file, const UrdfLegsOptions& options) {
  return LegFinder(file, options).Find();
}

}  // namespace tenon
