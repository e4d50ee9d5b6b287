#include <tenon/plants/robots/internal/urdf_file.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/framework/types/errors.h>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <cctype>
#include <fstream>
#include <mutex>
#include <regex>

namespace tenon::internal {
namespace {

/// Keeps the parser's first error, which would otherwise be written to stderr.
class ParserLog : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (text_.empty()) text_ = text;  // later errors are consequences
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace

std::string UrdfFile::PlaceOf(const std::string& what) const {
  static const std::regex kName(R"((link|joint) ['\[]([^'\]]{1,80})['\]])", std::regex::icase);
  for (auto at = std::sregex_iterator(what.begin(), what.end(), kName); at != std::sregex_iterator(); ++at) {
    const bool is_link = std::tolower(at->str(1).front()) == 'l';
    const auto line = lines.find(fmt::format("{} {}", is_link ? "link" : "joint", at->str(2)));
    if (line != lines.end()) return fmt::format("{}:{}", name, line->second);
  }
  return name;
}

void UrdfFile::Fail(const std::string& what) const {
  throw ParameterError(fmt::format("{}: {}", PlaceOf(what), what));
}

UrdfFile ParseUrdf(const std::filesystem::path& path) {
  UrdfFile file{path.string(), {}, {}};
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) file.Fail("this is a directory; give the path of a URDF");
  std::ifstream in = OpenInput(path);
  if (!in.is_open())
    file.Fail(
        fmt::format("the file cannot be read: {}; give the path of a URDF, relative to the robot's YAML file",
                    std::filesystem::exists(path, error) ? "not a readable file" : "no such file"));
  std::string text;
  for (char part[1 << 16]; text.size() <= kMaxUrdfBytes && in;
       text.append(part, static_cast<std::size_t>(in.gcount())))
    in.read(part, sizeof(part));
  CheckedUrdf checked = CheckUrdf(text, file.name);
  file.lines = std::move(checked.lines);
  static std::mutex mutex;  // the parser's log is global
  const std::lock_guard lock(mutex);
  ParserLog log;
  console_bridge::useOutputHandler(&log);
  file.model = urdf::parseURDF(checked.text);
  console_bridge::restorePreviousOutputHandler();
  if (file.model == nullptr || file.model->getRoot() == nullptr)
    file.Fail(fmt::format("not a valid URDF: {}; correct the XML",
                          log.text().empty() ? "it has no links" : log.text()));
  return file;
}

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

urdf::LinkConstSharedPtr FloatingLink(const urdf::ModelInterface& model) {
  urdf::LinkConstSharedPtr link = model.getRoot();
  while (link->inertial == nullptr && link->child_joints.size() == 1 &&
         link->child_joints[0]->type == urdf::Joint::FLOATING)
    link = model.getLink(link->child_joints[0]->child_link_name);
  return link;
}

bool Turns(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
}

}  // namespace tenon::internal
