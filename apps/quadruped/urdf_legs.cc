#include <tenon/apps/quadruped/quadruped_proposal.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <set>

namespace tenon {

namespace {

/// Splits a name at everything that is no letter and before capitals that follow small letters, in small
/// letters.
std::vector<std::string> Words(const std::string& name) {
  std::vector<std::string> words(1);
  char before = 0;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalpha(letter) == 0 || (std::isupper(letter) != 0 && std::islower(before) != 0))
      words.emplace_back();
    if (std::isalpha(letter) != 0) words.back() += static_cast<char>(std::tolower(letter));
    before = c;
  }
  return words;
}

}  // namespace

LegPlace PlaceInName(const std::string& name) {
  LegPlace place;
  for (const std::string& word : Words(name)) {
    const auto has = [&](std::string_view part) { return word.find(part) != word.npos; };
    if (has("front") || has("fore")) place.front = 1;
    if (has("rear") || has("back") || has("hind")) place.front = -1;
    if (has("left")) place.left = 1;
    if (has("right")) place.left = -1;
    if (word.size() != 2) continue;  // two letters, such as fl or hr, in either order
    for (std::string pair : {word, std::string(word.rbegin(), word.rend())}) {
      if (std::string_view("fbh").find(pair[0]) == std::string_view::npos && pair[0] != 'r') continue;
      if (pair[1] != 'l' && pair[1] != 'r') continue;
      place.front = pair[0] == 'f' ? 1 : -1;
      place.left = pair[1] == 'l' ? 1 : -1;
      break;
    }
  }
  return place;
}

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using internal::LinkAxis;
using internal::UrdfJoint;
using internal::UrdfLink;

constexpr double kAlong = 0.8;   // least cosine of the angle between axes that count as parallel
constexpr double kAcross = 0.6;  // largest cosine of the angle between axes that count as perpendicular
constexpr double kLow = 0.4;     // a chain of this part of the longest one's length is a leg
constexpr double kOff = 0.3;  // largest distance of the origin from the hips' centre, over the leg's length
constexpr double kBehind =
    0.25;  // least distance of front and rear hips, relative to the hips' largest extent
// Distance of left and right hips below which they count as one, relative to the length of the leg.
constexpr double kBeside = 0.05;

LinkAxis AxisAt(Eigen::Index index, double sign) {
  return static_cast<LinkAxis>(index + (sign < 0 ? 3 : 0));
}
Eigen::Index IndexOf(LinkAxis axis) {
  return static_cast<Eigen::Index>(axis) % 3;
}

/// Finds the legs in the frame T of the trunk.
class LegFinder {
 public:
  LegFinder(const internal::UrdfFile& file, const UrdfLegsOptions& options)
      : file_(file), base_(file.FloatingLink()), options_(options) {
    found_.locked = options.locked;
  }

  UrdfLegs Find() {
    Place(Isometry3d::Identity());
    std::vector<UrdfChain> legs = FindLegs();
    if (legs.size() < kNumLegs && LockSpine()) legs = FindLegs();
    if (legs.size() != kNumLegs) Refuse();
    Vector3d centre = Vector3d::Zero();
    for (const UrdfChain& leg : legs) centre += HipOf(leg) / kNumLegs;
    ChooseTrunk(legs, centre);
    Place(poses().at(TrunkName()).inverse());
    FindAxes(legs);
    Place(Isometry3d(internal::RotationOf(found_.forward, found_.up).transpose()) * poses().at(base_.name));
    LockOthers(legs);
    Sort(std::move(legs));
    return std::move(found_);
  }

 private:
  template <class... Args>
  void Note(fmt::format_string<Args...> format, Args&&... args) {
    found_.notes.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
  const std::map<std::string, Isometry3d>& poses() const { return found_.poses; }

  const std::string& TrunkName() const { return found_.trunk.empty() ? base_.name : found_.trunk; }

  /// Computes the poses of all links from that of the link that floats, and the chains.
  void Place(const Isometry3d& pose) {
    found_.poses.clear();
    chains_.clear();
    Walk(base_, pose, {});
  }

  /// Collects the poses of all links, and the chains that end in a body without further revolute joints.
  bool Walk(const UrdfLink& link, const Isometry3d& pose, const UrdfChain& chain) {
    found_.poses[link.name] = pose;
    bool turns = false;
    for (const UrdfJoint* joint : link.joints) {
      const std::optional<double> position = LockedAt(*joint, found_.locked);
      UrdfChain below = chain;
      const bool is_free = joint->turns() && !position;
      if (is_free) below.push_back(joint);
      const double at = position.value_or(joint->slides() ? joint->Neutral() : 0);
      const bool more = Walk(file_.ChildOf(*joint), pose * joint->pose * joint->Moved(at), below);
      if (is_free && !more) chains_.push_back(below);
      turns = turns || is_free || more;
    }
    return turns;
  }

  Vector3d OriginOf(const UrdfJoint& joint) const { return poses().at(joint.child).translation(); }
  Vector3d AxisOf(const UrdfJoint& joint) const {
    return poses().at(joint.child).linear() * joint.axis.normalized();
  }
  /// The point of the axis of the abduction beside the hip pitch joint, which no zero pose moves. If left and
  /// right legs share this axis, the origin of the hip pitch joint.
  Vector3d HipOf(const UrdfChain& leg) const {
    const Vector3d start = OriginOf(*leg[0]), along = AxisOf(*leg[0]), hip = OriginOf(*leg[1]);
    return share_axes_ ? hip : Vector3d(start + along * along.dot(hip - start));
  }
  /// The distance of the farthest frame from a point.
  double Farthest(const UrdfLink& link, const Vector3d& from) const {
    double distance = (poses().at(link.name).translation() - from).norm();
    for (const UrdfJoint* joint : link.joints)
      distance = std::max(distance, Farthest(file_.ChildOf(*joint), from));
    return distance;
  }
  double LengthOf(const UrdfChain& leg) const {
    const Vector3d knee = OriginOf(*leg[2]);
    return (knee - OriginOf(*leg[1])).norm() + Farthest(file_.ChildOf(*leg[2]), knee);
  }

  /// Whether three joints can be abduction, hip pitch and knee. The angles between their axes do not depend
  /// on the angles of the joints.
  bool IsLeg(const UrdfChain& chain) const {
    return chain.size() == kJointsPerLeg &&
           std::ranges::none_of(chain, [](auto* j) { return j->mimic.has_value(); }) &&
           std::abs(AxisOf(*chain[0]).dot(AxisOf(*chain[1]))) < kAcross &&
           std::abs(AxisOf(*chain[1]).dot(AxisOf(*chain[2]))) > kAlong;
  }
  static UrdfChain LastOf(const UrdfChain& chain) {
    return {chain.end() - std::min<std::ptrdiff_t>(kJointsPerLeg, std::ssize(chain)), chain.end()};
  }

  /// Returns the legs; other numbers than four if it is no quadruped.
  std::vector<UrdfChain> FindLegs() const {
    double longest = 0;
    std::vector<UrdfChain> legs;
    std::ranges::copy_if(chains_, std::back_inserter(legs), [&](const auto& leg) { return IsLeg(leg); });
    for (const UrdfChain& leg : legs) longest = std::max(longest, LengthOf(leg));
    std::erase_if(legs, [&](const UrdfChain& leg) { return LengthOf(leg) <= kLow * longest; });
    for (const UrdfChain& first : legs) {  // arms of three joints turn about other axes
      std::vector<UrdfChain> alike;
      std::ranges::copy_if(legs, std::back_inserter(alike), [&](const UrdfChain& leg) {
        return std::abs(AxisOf(*leg[0]).dot(AxisOf(*first[0]))) > kAlong;
      });
      if (alike.size() == kNumLegs) return alike;
    }
    return legs;
  }

  /// Locks the joints that carry several legs; returns whether there are some.
  bool LockSpine() {
    std::map<const UrdfJoint*, int> carried;
    for (const UrdfChain& chain : chains_)
      if (IsLeg(LastOf(chain)))
        for (std::size_t i = 0; i + kJointsPerLeg < chain.size(); ++i) ++carried[chain[i]];
    std::erase_if(carried, [](const auto& each) { return each.second < 2; });
    for (const auto& each : carried)
      Lock(*each.first, "carries legs, as a spine does (--lock {}=ANGLE sets another angle)");
    if (!carried.empty()) Place(Isometry3d::Identity());
    return !carried.empty();
  }

  /// Locks a joint at 0, or as near to it as its range allows.
  void Lock(const UrdfJoint& joint, fmt::format_string<const std::string&> why) {
    const double at = joint.Neutral();
    found_.locked[joint.name] = at;
    Note("joint '{}' {}: locked at {:.3g} {}", joint.name, fmt::format(why, joint.name), at,
         joint.slides() ? "m" : "rad");
  }

  /// Throws ParameterError that says which kind of robot it is.
  [[noreturn]] void Refuse() const {
    // The limbs are the chains without the joints that they share, most of equal length.
    std::map<const UrdfJoint*, int> uses;
    for (const UrdfChain& chain : chains_)
      for (const UrdfJoint* joint : chain) ++uses[joint];
    std::map<std::size_t, std::vector<UrdfChain>> by_size;
    for (UrdfChain chain : chains_) {
      std::erase_if(chain, [&](const UrdfJoint* joint) { return uses[joint] > 1; });
      by_size[chain.size()].push_back(chain);
    }
    if (by_size.empty()) file_.Fail("no joint turns, but a quadruped has four legs of three joints");
    const auto& [joints, limbs] = *std::ranges::max_element(
        by_size, {}, [](const auto& each) { return std::pair(each.second.size(), each.first); });
    constexpr std::array kWords{"no", "one", "two", "three", "four", "five", "six", "seven", "eight"};
    const auto word = [&](std::size_t n) { return n < kWords.size() ? kWords[n] : "many"; };
    const std::string kind =
        fmt::format("the robot has {} leg{} of {} joint{}, the first '{}'", word(limbs.size()),
                    limbs.size() == 1 ? "" : "s", word(joints), joints == 1 ? "" : "s", NamesOf(limbs[0]));
    if (limbs.size() != kNumLegs) {
      std::string others;
      for (const UrdfChain& chain : chains_) others += fmt::format("; {} ({})", NamesOf(chain), chain.size());
      if (limbs.size() == chains_.size())
        file_.Fail("{}, but a quadruped has four legs of three joints; give another robot", kind);
      file_.Fail(
          "{}, but a quadruped has four legs of three joints; fix other joints by --lock JOINT=ANGLE. "
          "Chains{}",
          kind, others);
    }
    const auto slides = [&](const auto& self, const UrdfLink& link) -> const UrdfJoint* {
      for (const UrdfJoint* joint : link.joints) {
        if (joint->slides()) return joint;
        if (const UrdfJoint* below = self(self, file_.ChildOf(*joint))) return below;
      }
      return nullptr;
    };
    if (const UrdfJoint* knee = joints == 2 ? slides(slides, file_.ChildOf(*limbs[0][0])) : nullptr)
      file_.Fail(
          "{}, and a prismatic knee, joint '{}', but the knees of Tenon's quadrupeds turn: make it revolute, "
          "or give another robot",
          kind, knee->name);
    const std::string locks = LocksOf(limbs);
    if (!locks.empty())
      file_.Fail("{}; if the other joints turn wheels or ankles, or can be fixed, add{}", kind, locks);
    const auto follower =
        std::ranges::find_if(limbs[0], [](const auto* joint) { return joint->mimic.has_value(); });
    const UrdfJoint &first = *limbs[0][0], &second = *limbs[0][std::min<std::size_t>(1, joints - 1)];
    const Vector3d a = AxisOf(first), b = AxisOf(second);
    file_.Fail(
        "{}{}, but the legs of Tenon's quadrupeds have abduction, hip pitch and knee, the first at right "
        "angles to the others: joint '{}' turns about ({:.2g}, {:.2g}, {:.2g}) of '{}', joint '{}' about "
        "({:.2g}, {:.2g}, {:.2g}); give another robot",
        kind,
        follower == limbs[0].end() ? ""
                                   : fmt::format(", where '{}' moves with '{}' (<mimic>)", (*follower)->name,
                                                 (*follower)->mimic->joint),
        first.name, a[0], a[1], a[2], base_.name, second.name, b[0], b[1], b[2]);
  }

  /// The options that lock all joints of the legs except abduction, hip pitch and knee; empty if none makes a
  /// quadruped of it.
  std::string LocksOf(const std::vector<UrdfChain>& legs) const {
    const std::size_t n = legs[0].size();
    if (n <= kJointsPerLeg) return "";
    std::vector<bool> locked(n, true);  // which joints of each leg, in all combinations
    std::fill_n(locked.begin(), kJointsPerLeg, false);
    do {
      UrdfLegsOptions options = options_;
      std::string text;
      for (const UrdfChain& leg : legs) {
        for (std::size_t i = 0; i < n; ++i) {
          if (!locked[i]) continue;
          options.locked[leg[i]->name] = leg[i]->Neutral();
          text += fmt::format(" --lock {}={:.4g}", leg[i]->name, leg[i]->Neutral());
        }
      }
      try {
        LegFinder(file_, options).Find();
        return text;
      } catch (const ParameterError&) {  // another combination
      }
    } while (std::next_permutation(locked.begin(), locked.end()));
    return "";
  }

  /// Takes the heaviest link of the trunk as its frame, if the origin of the root link is far from the hips.
  void ChooseTrunk(const std::vector<UrdfChain>& legs, const Vector3d& centre) {
    const auto off = [&](const std::string& link) {
      return (poses().at(link).translation() - centre).norm() > kOff * LengthOf(legs[0]);
    };
    if (!off(base_.name)) return;
    double mass = 0;
    const auto visit = [&](const auto& self, const UrdfLink& link) -> void {
      if (link.inertia && link.inertia->mass > mass && !off(link.name)) {
        mass = link.inertia->mass;
        found_.trunk = link.name;
      }
      for (const UrdfJoint* joint : link.joints)
        if (!joint->turns()) self(self, file_.ChildOf(*joint));
    };
    visit(visit, base_);
    if (!found_.trunk.empty())
      Note("the origin of the root link is far from the hips: '{}' is the trunk, written as `trunk_link`",
           found_.trunk);
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
  int Agreement(const std::vector<UrdfChain>& legs, LinkAxis forward, LinkAxis up) const {
    Vector3d centre = Vector3d::Zero();
    for (const UrdfChain& leg : legs) centre += HipOf(leg) / kNumLegs;
    int count = 0;
    for (const UrdfChain& leg : legs) {
      const Vector3d p = internal::RotationOf(forward, up).transpose() * (HipOf(leg) - centre);
      const LegPlace place = PlaceOf(leg);
      count += place.front * (p.x() > 0 ? 1 : -1) + place.left * (p.y() > 0 ? 1 : -1);
    }
    return count;
  }

  /// Returns the axis of T along which the axes of the abduction joints are.
  Eigen::Index FindAlong(const std::vector<UrdfChain>& legs) const {
    const Vector3d first = AxisOf(*legs[0][0]);
    Eigen::Index along = 0;
    first.cwiseAbs().maxCoeff(&along);
    for (const UrdfChain& leg : legs) {
      const Vector3d a = AxisOf(*leg[0]);
      if (std::abs(a[along]) < kAlong)
        file_.Fail(
            "joint '{}' turns about ({:.2g}, {:.2g}, {:.2g}) of '{}' and joint '{}' about ({:.2g}, {:.2g}, "
            "{:.2g}), but the abduction joints of all legs must turn about the same of its axes, along which "
            "the robot faces; if only the link is turned, fix it to a new root link that is not",
            legs[0][0]->name, first[0], first[1], first[2], TrunkName(), leg[0]->name, a[0], a[1], a[2]);
    }
    return along;
  }

  /// Finds `up` and `forward`, among the axes of T.
  void FindAxes(const std::vector<UrdfChain>& legs) {
    const Eigen::Index along = FindAlong(legs);
    const auto check = [&](const char* option, const std::optional<LinkAxis>& axis, bool must) {
      if (axis && (IndexOf(*axis) == along) != must)
        file_.Fail(
            "{} {}: the abduction joints turn about '{}' of '{}', so that the robot faces along this axis: "
            "write {}, or leave the option out",
            option, EnumName(*axis), EnumName(AxisAt(along, 1)), TrunkName(),
            must ? fmt::format("{} or {}", EnumName(AxisAt(along, 1)), EnumName(AxisAt(along, -1)))
                 : "another axis");
    };
    check("--forward", options_.forward, true);
    check("--up", options_.up, false);

    Vector3d low = HipOf(legs[0]), high = low, crossing = Vector3d::Zero(), down = Vector3d::Zero();
    for (const UrdfChain& leg : legs) {
      low = low.cwiseMin(HipOf(leg)), high = high.cwiseMax(HipOf(leg));
      crossing += AxisOf(*leg[1]).cwiseAbs() / kNumLegs;
      down += (OriginOf(*leg[2]) - OriginOf(*leg[1])).normalized() / kNumLegs;
    }
    const Vector3d spread = high - low;
    const double length = LengthOf(legs[0]);
    const auto is_up = [&](Eigen::Index axis) {
      const Eigen::Index across = 3 - along - axis;
      const double beside =
          (spread[across] - spread[axis]) / (spread[across] + spread[axis] + kBeside * length);
      return 2 * beside + crossing[across] - crossing[axis] + (axis == 2 ? 0.25 : 0);
    };
    const Eigen::Index a = (along + 1) % 3, b = (along + 2) % 3;
    if (spread[along] < kBehind * spread.maxCoeff())
      file_.Fail(
          "joint '{}' and the first joints of the other legs turn about '{}' of '{}', along which no hips "
          "are behind each other, like those of a spider, but the first joint of a leg must be its "
          "abduction, about the axis along which the robot faces; give another robot",
          legs[0][0]->name, EnumName(AxisAt(along, 1)), TrunkName());
    const Eigen::Index vertical = options_.up ? IndexOf(*options_.up) : is_up(a) > is_up(b) ? a : b;
    share_axes_ = spread[3 - along - vertical] < kBeside * length;

    const auto best = [&](LinkAxis up) {  // the number of names that agree, and the direction
      const LinkAxis one = AxisAt(along, 1), other = AxisAt(along, -1);
      const int agree = Agreement(legs, one, up), contrary = Agreement(legs, other, up);
      return contrary > agree ? std::pair(contrary, other) : std::pair(agree, one);
    };
    found_.up = AxisAt(vertical, 1);
    constexpr double kDown = 0.3;
    const bool by_names = std::abs(down[vertical]) < kDown &&
                          best(AxisAt(vertical, -1)).first > best(AxisAt(vertical, 1)).first;
    if (vertical != 2 && (by_names || down[vertical] > kDown)) found_.up = AxisAt(vertical, -1);
    if (options_.up) found_.up = *options_.up;
    found_.forward = options_.forward.value_or(best(found_.up).second);
    const auto note = [&](const char* what, LinkAxis axis, const char* key) {
      Note(
          "the {} is the axis '{}' of '{}', by the axes of its joints and the places and names of its legs: "
          "written as `{}`; --{} sets another axis",
          what, EnumName(axis), TrunkName(), key, key);
    };
    if (found_.up != LinkAxis::kZ && !options_.up) note("robot's vertical", found_.up, "up");
    if (found_.forward != LinkAxis::kX && !options_.forward)
      note("direction that the robot faces", found_.forward, "forward");
    int named = 0;
    for (const UrdfChain& leg : legs) named += std::abs(PlaceOf(leg).front) + std::abs(PlaceOf(leg).left);
    names_agree_ = Agreement(legs, found_.forward, found_.up) == named;
  }

  /// Locks the joints outside the legs, followers after the joints that they follow.
  void LockOthers(const std::vector<UrdfChain>& legs) {
    std::set<const UrdfJoint*> used;
    for (const UrdfChain& leg : legs) used.insert(leg.begin(), leg.end());
    for (const bool follows : {false, true})
      for (const auto& [name, joint] : file_.joints)
        if ((joint.turns() || joint.slides()) && joint.mimic.has_value() == follows &&
            !used.contains(&joint) && !LockedAt(joint, found_.locked))
          Lock(joint, "belongs to no leg");
  }

  void Sort(std::vector<UrdfChain> legs) {
    std::ranges::stable_sort(legs, [&](const auto& a, const auto& b) { return HipOf(a).x() > HipOf(b).x(); });
    for (const std::size_t first : {0, 2})
      if (HipOf(legs[first]).y() < HipOf(legs[first + 1]).y()) std::swap(legs[first], legs[first + 1]);
    if (!names_agree_)
      Note("the names of the legs contradict their places, which decide: '{}' is front left",
           legs[0][0]->name);
    std::ranges::move(legs, found_.legs.begin());
  }

  const internal::UrdfFile& file_;
  const UrdfLink& base_;
  const UrdfLegsOptions& options_;
  UrdfLegs found_;
  std::vector<UrdfChain> chains_;
  bool share_axes_ = false;  ///< whether left and right legs have the same axis of abduction
  bool names_agree_ = true;  ///< whether the names of all legs agree with their places
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
