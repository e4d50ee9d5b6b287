#include <tenon/plants/model/internal/quadruped_urdf.h>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <tenon/plants/model/internal/urdf_check.h>
#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/internal/nearest_name.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <regex>
#include <sstream>
#include <utility>
#include <vector>

namespace tenon::internal {
namespace {

/// What the parser has to say; it would write to stderr otherwise.
class ParserLog : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (!text_.empty()) text_ += "; ";
    text_ += text;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

Eigen::Isometry3d ToEigen(const urdf::Pose& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const urdf::Rotation& q = pose.rotation;
  T.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  T.translation() << pose.position.x, pose.position.y, pose.position.z;
  return T;
}

RigidInertia ToRigidInertia(const urdf::Inertial& in) {
  Eigen::Matrix3d inertia;
  inertia << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
  const Eigen::Isometry3d T = ToEigen(in.origin);
  return RigidInertia{in.mass, Eigen::Vector3d::Zero(), inertia}.In(T.linear(), T.translation());
}

bool Turns(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
}

/// Reads one URDF; bodies are numbered 0 for the trunk and 1 + joint for the others.
class Reader {
 public:
  Reader(std::string file, QuadrupedDescription* robot) : file_(std::move(file)), robot_(*robot) {}

  void Read(const std::array<std::string, kNumLegs>& feet) {
    Parse();
    for (int leg = 0; leg < kNumLegs; ++leg) FindLeg(leg, feet[static_cast<std::size_t>(leg)]);
    Add(*model_->getRoot(), 0, Eigen::Isometry3d::Identity());
    for (int leg = 0; leg < kNumLegs; ++leg) FinishLeg(leg, feet[static_cast<std::size_t>(leg)]);
    robot_.trunk = Finished(0, Eigen::Vector3d::Zero());
  }

 private:
  template <class... Args>
  [[noreturn]] void Fail(fmt::format_string<Args...> format, Args&&... args) const {
    const std::string what = fmt::format(format, std::forward<Args>(args)...);
    throw ParameterError(fmt::format("{}: {}", PlaceOf(what), what));
  }

  /// The file, with the line of the first link or joint that a message names: link 'this', or Joint [this].
  std::string PlaceOf(const std::string& what) const {
    static const std::regex kName(R"((link|joint) ['\[](.*?)['\]])", std::regex::icase);
    for (auto at = std::sregex_iterator(what.begin(), what.end(), kName); at != std::sregex_iterator();
         ++at) {
      const bool is_link = std::tolower(at->str(1).front()) == 'l';
      const auto line = lines_.find(fmt::format("{} {}", is_link ? "link" : "joint", at->str(2)));
      if (line != lines_.end()) return fmt::format("{}:{}", file_, line->second);
    }
    return file_;
  }

  void Parse() {
    std::ifstream in(file_);
    if (!in) Fail("the file cannot be read; name a URDF file beside the robot's YAML file");
    std::stringstream text;
    text << in.rdbuf();
    lines_ = CheckUrdf(text.str(), file_);
    static std::mutex mutex;  // the parser's log is the process's
    const std::lock_guard lock(mutex);
    ParserLog log;
    console_bridge::useOutputHandler(&log);
    model_ = urdf::parseURDF(text.str());
    console_bridge::restorePreviousOutputHandler();
    if (model_ == nullptr || model_->getRoot() == nullptr)
      Fail("this is no URDF: {}; correct the XML", log.text().empty() ? "it has no links" : log.text());
  }

  /// Notes which joints are the leg's: the three that turn between its foot and the root.
  void FindLeg(int leg, const std::string& foot) {
    const char* leg_name = kLegNames[static_cast<std::size_t>(leg)];
    urdf::LinkConstSharedPtr link = model_->getLink(foot);
    if (link == nullptr) {
      std::vector<std::string> names;
      for (const auto& entry : model_->links_) names.push_back(entry.first);
      const std::string nearest = NearestName(foot, names);
      Fail("there is no link '{}', the foot of {}{}; give the names of the feet's links under 'feet'", foot,
           leg_name, nearest.empty() ? "" : " (did you mean '" + nearest + "'?)");
    }
    std::vector<urdf::JointConstSharedPtr> chain;
    for (; link->parent_joint != nullptr; link = link->getParent()) {
      if (Turns(*link->parent_joint)) chain.push_back(link->parent_joint);
    }
    if (chain.size() != kJointsPerLeg) {
      std::string names;
      for (auto joint = chain.rbegin(); joint != chain.rend(); ++joint)
        names += (names.empty() ? "'" : ", '") + (*joint)->name + "'";
      Fail(
          "leg {} has {} revolute joints between the root '{}' and its foot '{}' ({}) but must have {}: "
          "abduction, hip pitch and knee pitch; add what is missing, make fixed what is too much",
          leg_name, chain.size(), model_->getRoot()->name, foot, names.empty() ? "none" : names,
          kJointsPerLeg);
    }
    for (int i = 0; i < kJointsPerLeg; ++i) {
      const std::string& name = chain[static_cast<std::size_t>(kJointsPerLeg - 1 - i)]->name;
      const auto [at, is_new] = joints_.emplace(name, kJointsPerLeg * leg + i);
      if (!is_new)
        Fail("the joint '{}' is in the legs {} and {}; give each leg a foot of its own under 'feet'", name,
             kLegNames[static_cast<std::size_t>(at->second / kJointsPerLeg)], leg_name);
    }
  }

  /// Adds a link and what hangs on it to `body`; T_BL is its pose with all joints at 0.
  void Add(const urdf::Link& link, int body, const Eigen::Isometry3d& T_BL) {
    poses_[link.name] = T_BL;
    std::string& names = names_[static_cast<std::size_t>(body)];
    names += (names.empty() ? "'" : ", '") + link.name + "'";
    if (link.inertial != nullptr) {
      const RigidInertia inertia = ToRigidInertia(*link.inertial);
      if (inertia.mass < 0)
        Fail("link '{}' has the mass {} kg; give a positive mass, or no <inertial> at all", link.name,
             inertia.mass);
      if (inertia.mass > 0) {
        try {
          CheckInertia(inertia.inertia);
        } catch (const ParameterError& error) {
          Fail("link '{}': {}", link.name, error.what());
        }
      }
      RigidInertia& sum = bodies_[static_cast<std::size_t>(body)];
      sum = sum + inertia.In(T_BL.linear(), T_BL.translation());
    }
    for (const auto& joint : link.child_joints) {
      const Eigen::Isometry3d T_BJ = T_BL * ToEigen(joint->parent_to_joint_origin_transform);
      int child = body;
      if (Turns(*joint)) {
        child = NoteJoint(*joint, T_BJ) + 1;
      } else if (joint->type != urdf::Joint::FIXED) {
        Fail("joint '{}' is neither revolute nor fixed; a quadruped has no others, make it fixed",
             joint->name);
      }
      Add(*model_->getLink(joint->child_link_name), child, T_BJ);
    }
  }

  /// Returns its number.
  int NoteJoint(const urdf::Joint& joint, const Eigen::Isometry3d& T_BJ) {
    const auto at = joints_.find(joint.name);
    if (at == joints_.end()) Fail("joint '{}' turns but belongs to no leg; make it fixed", joint.name);
    if (joint.limits == nullptr || !(joint.limits->effort > 0 && joint.limits->velocity > 0))
      Fail(
          "joint '{}' has no limits of torque and speed; add <limit effort=\"N m\" velocity=\"rad/s\" .../> "
          "with positive values",
          joint.name);
    const bool bounded = joint.type == urdf::Joint::REVOLUTE;
    if (bounded && !(joint.limits->lower < joint.limits->upper))
      Fail("joint '{}' has the range {} to {} rad; the lower limit must be below the upper", joint.name,
           joint.limits->lower, joint.limits->upper);
    JointDescription& out = JointOf(at->second);
    out.name = joint.name;
    out.p_PJ = T_BJ.translation();  // in B so far
    const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
    if (!(axis.norm() > 0)) Fail("joint '{}' has the axis 0 0 0; give its direction", joint.name);
    out.axis = T_BJ.linear() * axis.normalized();
    out.lower = bounded ? joint.limits->lower : -std::numeric_limits<double>::infinity();
    out.upper = bounded ? joint.limits->upper : std::numeric_limits<double>::infinity();
    out.torque_limit = joint.limits->effort;
    out.speed_limit = joint.limits->velocity;
    return at->second;
  }

  /// Moves what is so far in B to the joints' frames.
  void FinishLeg(int leg, const std::string& foot) {
    LegDescription& out = robot_.legs[static_cast<std::size_t>(leg)];
    Eigen::Vector3d parent = Eigen::Vector3d::Zero();
    for (int i = 0; i < kJointsPerLeg; ++i) {
      JointDescription& joint = out.joints[static_cast<std::size_t>(i)];
      const Eigen::Vector3d p_BJ = joint.p_PJ;
      out.bodies[static_cast<std::size_t>(i)] = Finished(1 + kJointsPerLeg * leg + i, p_BJ);
      joint.p_PJ = p_BJ - parent;
      parent = p_BJ;
    }
    out.foot_J = poses_.at(foot).translation() - parent;
  }

  RigidInertia Finished(int body, const Eigen::Vector3d& origin) const {
    const RigidInertia& sum = bodies_[static_cast<std::size_t>(body)];
    if (!(sum.mass > 0))
      Fail("the body of the link(s) {} has no mass; give one of them an <inertial> with a positive mass",
           names_[static_cast<std::size_t>(body)]);
    return sum.In(Eigen::Matrix3d::Identity(), -origin);
  }

  JointDescription& JointOf(int j) {
    return robot_.legs[static_cast<std::size_t>(j / kJointsPerLeg)]
        .joints[static_cast<std::size_t>(j % kJointsPerLeg)];
  }

  const std::string file_;
  UrdfLines lines_;
  QuadrupedDescription& robot_;
  urdf::ModelInterfaceSharedPtr model_;
  std::map<std::string, int> joints_;                // of the legs, by name
  std::map<std::string, Eigen::Isometry3d> poses_;   // of the links in B
  std::array<RigidInertia, 1 + kNumJoints> bodies_;  // in B, with all joints at 0
  std::array<std::string, 1 + kNumJoints> names_;    // of the links that make them up
};

}  // namespace

void ReadUrdf(const std::filesystem::path& path, const std::array<std::string, kNumLegs>& feet,
              QuadrupedDescription* robot) {
  Reader(path.string(), robot).Read(feet);
}

}  // namespace tenon::internal
