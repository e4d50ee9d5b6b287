#include <tenon/plants/robots/internal/quadruped_urdf.h>
#include <tenon/plants/robots/internal/xml_elements.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <regex>

namespace tenon::internal {
namespace {

constexpr std::size_t kMaxBytes = 16 << 20;
constexpr std::size_t kMaxLinks = 1000;

/// Attributes that hold numbers, the count of numbers, and their largest plausible absolute value.
struct Numbers {
  std::string_view element, attribute;
  std::size_t count;
  double largest = HUGE_VAL;
};
constexpr Numbers kNumbers[] = {
    {"mass", "value", 1, 1e6},  {"inertia", "ixx", 1, 1e9}, {"inertia", "ixy", 1, 1e9},
    {"inertia", "ixz", 1, 1e9}, {"inertia", "iyy", 1, 1e9}, {"inertia", "iyz", 1, 1e9},
    {"inertia", "izz", 1, 1e9}, {"origin", "xyz", 3, 100},  {"origin", "rpy", 3, 1e3},
    {"axis", "xyz", 3, 1e3},    {"limit", "lower", 1},      {"limit", "upper", 1},
    {"limit", "effort", 1},     {"limit", "velocity", 1},   {"sphere", "radius", 1},
    {"cylinder", "radius", 1},  {"cylinder", "length", 1},  {"box", "size", 3},
    {"mesh", "scale", 3},       {"color", "rgba", 4},       {"mimic", "multiplier", 1},
    {"mimic", "offset", 1},     {"dynamics", "damping", 1}, {"dynamics", "friction", 1},
};

/// The elements that are read, or known and not needed, each with its parent.
constexpr std::string_view kRead[] = {
    "robot/link",         "robot/joint",     "robot/material",    "robot/gazebo",
    "robot/transmission", "link/inertial",   "link/visual",       "link/collision",
    "inertial/origin",    "inertial/mass",   "inertial/inertia",  "visual/origin",
    "visual/geometry",    "visual/material", "collision/origin",  "collision/geometry",
    "collision/material", "geometry/mesh",   "geometry/sphere",   "geometry/cylinder",
    "geometry/box",       "material/color",  "material/texture",  "joint/origin",
    "joint/parent",       "joint/child",     "joint/axis",        "joint/limit",
    "joint/mimic",        "joint/dynamics",  "joint/calibration", "joint/safety_controller",
};

/// Makes links and joints of the elements.
class UrdfReader {
 public:
  UrdfReader(const Element& robot, UrdfFile& file) : file_(file) {
    NoteUnread(robot);
    for (const Element& each : robot.children) {
      owner_ = fmt::format("{} '{}'", Excerpt(each.name), Excerpt(each["name"]));
      if (each.name == "material" && !each["name"].empty())
        Add(materials_, each["name"], ColourOf(each), each);
    }
    for (const Element& each : robot.children) {
      owner_ = fmt::format("{} '{}'", Excerpt(each.name), Excerpt(each["name"]));
      if (each.name != "link" && each.name != "joint" && each.name != "material") continue;
      CheckNumbers(each);
      if (each.name == "material") continue;
      if (each["name"].empty()) Fail(each, "a {} has no name; give each one a unique name", each.name);
      if (each.name == "link") {
        Add(file_.links, each["name"], ReadLink(each), each);
        if (file_.links.size() > kMaxLinks)
          Fail(each, "there are more than {} links; check the file", kMaxLinks);
      } else {
        Add(file_.joints, each["name"], ReadJoint(each), each);
      }
    }
    Connect();
    for (const auto& [path, lines] : unread_)
      file_.unread.push_back(fmt::format(
          "{}:{}: the element {} is not read{}", file_.name, lines[0], Excerpt(path),
          lines.size() == 1
              ? ""
              : fmt::format(", nor in lines {}", fmt::join(lines.begin() + 1, lines.end(), ", "))));
  }

 private:
  template <class... Args>
  [[noreturn]] void Fail(const Element& at, fmt::format_string<Args...> format, Args&&... args) const {
    FailAt(file_.name, at.line, format, std::forward<Args>(args)...);
  }

  void Add(auto& map, const std::string& name, auto&& value, const Element& at) const {
    if (!map.emplace(name, std::move(value)).second)
      Fail(at, "there are two of {}; give each one a unique name", owner_);
  }

  /// Notes the elements that are not read, unless their parent is not read either, and those after the first
  /// where one is read.
  void NoteUnread(const Element& parent) {
    for (const Element& child : parent.children) {
      const std::string path = parent.name + "/" + child.name;
      const auto in_parent = [&](std::string_view each) { return each.starts_with(parent.name + "/"); };
      const bool is_one = parent.name != "robot" && child.name != "visual" && child.name != "collision";
      if (std::ranges::any_of(kRead, in_parent) && (std::ranges::find(kRead, path) == std::end(kRead) ||
                                                    (is_one && parent.Child(child.name) != &child)))
        unread_[path].push_back(child.line);
    }
  }

  /// The numbers of an attribute, or `standard` without it.
  std::vector<double> Read(const Element& element, std::string_view attribute,
                           std::vector<double> standard) const {
    for (const auto& [name, text] : element.attributes)
      if (name == attribute) return *Parse(text);
    return standard;
  }
  double Read(const Element* element, std::string_view attribute, double standard = 0) const {
    return element == nullptr ? standard : Read(*element, attribute, std::vector{standard})[0];
  }

  /// Parses finite numbers separated by blanks; empty if the text holds anything else.
  static std::optional<std::vector<double>> Parse(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\n";
    std::vector<double> numbers;
    for (std::size_t at; (at = text.find_first_not_of(kBlanks)) != text.npos;) {
      text.remove_prefix(at);
      const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
      text.remove_prefix(word.size());
      const auto value = NumberIn<double>(WithoutPlus(word));
      if (!value || !std::isfinite(*value)) return {};
      numbers.push_back(*value);
    }
    return numbers;
  }

  /// Checks the numbers of an element and of all elements in it.
  void CheckNumbers(const Element& element) {
    NoteUnread(element);
    for (const auto& each_attribute : element.attributes) {
      const std::string &attribute = each_attribute.first, &text = each_attribute.second;
      const auto numbers = std::ranges::find_if(kNumbers, [&](const Numbers& each) {
        return each.element == element.name && each.attribute == attribute;
      });
      if (numbers == std::end(kNumbers)) continue;
      const auto found = Parse(text);
      if (!found || found->size() != numbers->count)
        Fail(element, "{}: <{} {}=\"{}\">: write {}, without a unit and with a decimal point", owner_,
             element.name, attribute, Excerpt(text),
             numbers->count == 1
                 ? "one number"
                 : fmt::format("{} numbers with blanks between", numbers->count == 3 ? "three" : "four"));
      for (const double number : *found)
        if (!(std::abs(number) <= numbers->largest))
          Fail(element,
               "{}: <{} {}=\"{}\">: the absolute value must be at most {}; check that the unit is an SI unit",
               owner_, element.name, attribute, Excerpt(text), numbers->largest);
    }
    for (const Element& child : element.children) CheckNumbers(child);
  }

  Eigen::Vector3d Vector(const Element& element, std::string_view attribute, double standard) const {
    return Eigen::Vector3d(Read(element, attribute, {standard, standard, standard}).data());
  }

  /// The pose by the <origin> in an element.
  Eigen::Isometry3d PoseOf(const Element& element) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const Element* origin = element.Child("origin");
    if (origin == nullptr) return T;
    T.translation() = Vector(*origin, "xyz", 0);
    const Eigen::Vector3d half = Vector(*origin, "rpy", 0) / 2;  // roll, pitch, yaw
    const double cr = std::cos(half[0]), sr = std::sin(half[0]), cp = std::cos(half[1]),
                 sp = std::sin(half[1]), cy = std::cos(half[2]), sy = std::sin(half[2]);
    const Eigen::Quaterniond q(cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy,
                               cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy);
    const double norm = std::sqrt(q.x() * q.x() + q.y() * q.y() + q.z() * q.z() + q.w() * q.w());
    T.linear() = Eigen::Quaterniond(q.w() / norm, q.x() / norm, q.y() / norm, q.z() / norm)
                     .normalized()
                     .toRotationMatrix();
    return T;
  }

  RigidInertia ReadInertial(const Element& inertial) const {
    const Element *mass = inertial.Child("mass"), *inertia = inertial.Child("inertia");
    if (mass == nullptr || (*mass)["value"].empty())
      Fail(inertial, "{}: its <inertial> has no mass; write <mass value=\"...\"/>, in kg", owner_);
    if (inertia == nullptr)
      Fail(inertial, "{}: its <inertial> has no inertia; write <inertia ixx=\"...\" .../>, in kg m^2",
           owner_);
    const auto entry = [&](const char* name) {
      if ((*inertia)[name].empty())
        Fail(*inertia, "{}: its <inertia> has no {}; write all six attributes, also those that are 0", owner_,
             name);
      return Read(inertia, name);
    };
    const double xx = entry("ixx"), xy = entry("ixy"), xz = entry("ixz"), yy = entry("iyy"),
                 yz = entry("iyz"), zz = entry("izz");
    Eigen::Matrix3d I;
    I << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    const Eigen::Isometry3d T = PoseOf(inertial);
    return RigidInertia{Read(mass, "value"), Eigen::Vector3d::Zero(), I}.In(T.linear(), T.translation());
  }

  /// The colour of a material; none without one, or if it is a texture.
  std::optional<std::array<float, 3>> ColourOf(const Element& material) const {
    const Element *color = material.Child("color"), *texture = material.Child("texture");
    if (color == nullptr || (*color)["rgba"].empty() ||
        (texture != nullptr && !(*texture)["filename"].empty()))
      return {};
    const auto rgba = Parse((*color)["rgba"]);
    if (!rgba || rgba->size() != 4) return {};  // CheckNumbers refuses it
    const auto in_range = [](double part) { return part >= 0 && part <= 1; };
    if (!std::ranges::all_of(*rgba, in_range)) return {};
    return std::array{static_cast<float>((*rgba)[0]), static_cast<float>((*rgba)[1]),
                      static_cast<float>((*rgba)[2])};
  }

  /// The shape of a <visual> or <collision>; none if it has no geometry that is read.
  std::optional<UrdfShape> ReadShape(const Element& element) {
    using Kind = UrdfShape::Kind;
    const Element* geometry = element.Child("geometry");
    if (geometry == nullptr || geometry->children.empty()) return {};
    const Element& what = geometry->children[0];
    UrdfShape shape;
    shape.pose = PoseOf(element);
    if (what.name == "mesh" && !what["filename"].empty()) {
      shape.mesh = what["filename"];
      shape.scale = Vector(what, "scale", 1);
    } else if (what.name == "sphere" || what.name == "cylinder") {
      shape.kind = what.name == "sphere" ? Kind::kSphere : Kind::kCylinder;
      shape.radius = Read(&what, "radius");
      shape.length = Read(&what, "length");
    } else if (what.name == "box") {
      shape.kind = Kind::kBox;
      shape.edges = Vector(what, "size", 0);
    } else {
      return {};
    }
    const Element* material = element.Child("material");
    if (element.name != "visual" || material == nullptr) return shape;
    // A material with a name has the colour of its first definition.
    const std::string& name = (*material)["name"];
    shape.colour = ColourOf(*material);
    if (name.empty()) return shape;
    const auto known = materials_.find(name);
    if (known != materials_.end())
      shape.colour = known->second;
    else if (!material->children.empty())
      materials_.emplace(name, shape.colour);
    return shape;
  }

  UrdfLink ReadLink(const Element& element) {
    UrdfLink link{.name = element["name"],
                  .line = element.line,
                  .inertia = {},
                  .visuals = {},
                  .collisions = {},
                  .joints = {}};
    if (const Element* inertial = element.Child("inertial")) link.inertia = ReadInertial(*inertial);
    for (const Element& child : element.children) {
      if (child.name != "visual" && child.name != "collision") continue;
      if (std::optional<UrdfShape> shape = ReadShape(child))
        (child.name == "visual" ? link.visuals : link.collisions).push_back(std::move(*shape));
    }
    return link;
  }

  UrdfJoint::Type TypeOf(const Element& joint) const {
    using Type = UrdfJoint::Type;
    constexpr std::pair<std::string_view, Type> kTypes[] = {
        {"fixed", Type::kFixed},         {"revolute", Type::kRevolute}, {"continuous", Type::kContinuous},
        {"prismatic", Type::kPrismatic}, {"floating", Type::kFloating}, {"planar", Type::kPlanar}};
    for (const auto& [name, type] : kTypes)
      if (joint["type"] == name) return type;
    Fail(joint,
         "{} has the type '{}'; the types of a URDF are fixed, revolute, continuous, prismatic, floating and "
         "planar",
         owner_, Excerpt(joint["type"]));
  }

  UrdfJoint ReadJoint(const Element& element) const {
    UrdfJoint joint{.name = element["name"],
                    .line = element.line,
                    .type = TypeOf(element),
                    .parent = {},
                    .child = {},
                    .limits = {},
                    .mimic = {}};
    const auto link = [&](const char* end) -> std::string {
      const Element* at = element.Child(end);
      if (at == nullptr || (*at)["link"].empty())
        Fail(element, "{} has no {}; write <{} link=\"...\"/> with the name of a link", owner_, end, end);
      return (*at)["link"];
    };
    joint.parent = link("parent");
    joint.child = link("child");
    joint.pose = PoseOf(element);
    if (const Element* axis = element.Child("axis")) joint.axis = Vector(*axis, "xyz", 0);
    const Element* limit = element.Child("limit");
    if (limit != nullptr || joint.type == UrdfJoint::Type::kRevolute ||
        joint.type == UrdfJoint::Type::kPrismatic)
      joint.limits = {Read(limit, "lower"), Read(limit, "upper"), Read(limit, "effort"),
                      Read(limit, "velocity")};
    if (const Element* mimic = element.Child("mimic")) {
      if ((*mimic)["joint"].empty())
        Fail(*mimic, "{}: its <mimic> names no joint; write <mimic joint=\"...\"/>", owner_);
      joint.mimic = {(*mimic)["joint"], Read(mimic, "multiplier", 1), Read(mimic, "offset")};
    }
    const Element* dynamics = element.Child("dynamics");
    joint.damping = Read(dynamics, "damping");
    joint.friction = Read(dynamics, "friction");
    return joint;
  }

  template <class... Args>
  [[noreturn]] void Fail(const UrdfJoint& at, fmt::format_string<Args...> format, Args&&... args) const {
    FailAt(file_.name, at.line, format, std::forward<Args>(args)...);
  }

  /// Makes a tree of the links.
  void Connect() {
    for (const auto& named : file_.joints) {
      const std::string& name = named.first;
      const UrdfJoint& joint = named.second;
      const auto find = [&](const std::string& link) -> UrdfLink& {
        const auto at = file_.links.find(link);
        if (at == file_.links.end())
          Fail(joint, "joint '{}' names the link '{}', which does not exist; correct the name", name, link);
        return at->second;
      };
      UrdfLink &parent = find(joint.parent), &child = find(joint.child);
      if (child.parent_joint != nullptr)
        Fail(joint,
             "the link '{}' has two parent joints, '{}' and '{}', which close a loop; the links must form a "
             "tree: remove one of the joints",
             joint.child, child.parent_joint->name, name);
      child.parent_joint = &joint;
      child.parent = &parent;
      parent.joints.push_back(&joint);
    }
    RefuseRings();
    for (const auto& [name, link] : file_.links) {
      if (link.parent != nullptr) continue;
      if (file_.root != nullptr)
        FailAt(file_.name, link.line,
               "the links '{}' and '{}' have no parent; the links must form a tree, connect them by a joint",
               file_.root->name, name);
      file_.root = &link;
    }
    if (file_.root == nullptr) file_.Fail("not a valid URDF: it has no links; give the robot's URDF");
  }

  void RefuseRings() const {
    std::map<const UrdfLink*, const UrdfLink*> walk_of;  // start of the first walk that visited the link
    for (const auto& [name, start] : file_.links) {
      for (const UrdfLink* link = &start; link->parent != nullptr; link = link->parent) {
        const auto [at, is_new] = walk_of.emplace(link, &start);
        if (is_new) continue;
        if (at->second == &start) FailRing(*link);
        break;
      }
    }
  }

  [[noreturn]] void FailRing(const UrdfLink& start) const {
    std::vector<const UrdfJoint*> ring;
    const UrdfLink* link = &start;
    do {
      ring.push_back(link->parent_joint);
      link = link->parent;
    } while (link != &start);
    const auto first = std::min_element(ring.begin(), ring.end(),
                                        [](const auto* a, const auto* b) { return a->name < b->name; });
    std::rotate(ring.begin(), first, ring.end());
    std::string names;
    for (const UrdfJoint* joint : ring)
      names += fmt::format("{}'{}'", names.empty() ? "" : ", ", joint->name);
    Fail(*ring[0], "the joints {} form a closed loop; the links must form a tree, remove one", names);
  }

  UrdfFile& file_;
  std::string owner_;  ///< the enclosing link, joint or material, for messages
  std::map<std::string, std::optional<std::array<float, 3>>> materials_;
  std::map<std::string, std::vector<std::size_t>> unread_;  ///< lines of each kind of element
};

std::string ReadBytes(const std::filesystem::path& path, const UrdfFile& file) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) file.Fail("this is a directory; give the path of a URDF");
  std::ifstream in = OpenInput(path);
  if (!in.is_open())
    file.Fail("the file cannot be read: {}; give the path of a URDF, relative to the robot's YAML file",
              std::filesystem::exists(path, error) ? "not a readable file" : "no such file");
  std::string text;
  for (char part[1 << 16]; text.size() <= kMaxBytes && in;
       text.append(part, static_cast<std::size_t>(in.gcount())))
    in.read(part, sizeof(part));
  if (text.size() > kMaxBytes)
    file.Fail("the file exceeds the limit of {} bytes; check that it is the right file", kMaxBytes);
  return text;
}

}  // namespace

double UrdfJoint::Neutral() const {
  const bool has_range = type != Type::kContinuous && limits && limits->lower < limits->upper;
  return has_range ? std::clamp(0.0, limits->lower, limits->upper) : 0;
}

Eigen::Isometry3d UrdfJoint::Moved(double position) const {
  const Eigen::Vector3d direction = axis.normalized();
  if (slides()) return Eigen::Isometry3d(Eigen::Translation3d(position * direction));
  return Eigen::Isometry3d(Eigen::AngleAxisd(position, direction));
}

std::optional<double> LockedAt(const UrdfJoint& joint, const LockedJoints& locked) {
  const auto at = locked.find(joint.name);
  if (at != locked.end()) return at->second;
  if (!joint.mimic || joint.mimic->joint == joint.name) return {};
  const auto leader = locked.find(joint.mimic->joint);
  if (leader == locked.end()) return {};
  return joint.mimic->multiplier * leader->second + joint.mimic->offset;
}

const UrdfLink* UrdfFile::FindLink(std::string_view link) const {
  const auto at = links.find(link);
  return at == links.end() ? nullptr : &at->second;
}

const UrdfJoint* UrdfFile::FindJoint(std::string_view joint) const {
  const auto at = joints.find(joint);
  return at == joints.end() ? nullptr : &at->second;
}

const UrdfLink& UrdfFile::FloatingLink() const {
  const UrdfLink* link = root;
  while (!link->inertia && link->joints.size() == 1 && link->joints[0]->type == UrdfJoint::Type::kFloating)
    link = &ChildOf(*link->joints[0]);
  return *link;
}

std::string UrdfFile::PlaceOf(const std::string& what) const {
  static const std::regex kName(R"((link|joint) '([^']{1,200})')", std::regex::icase);
  for (auto at = std::sregex_iterator(what.begin(), what.end(), kName); at != std::sregex_iterator(); ++at) {
    const bool is_link = std::tolower(at->str(1).front()) == 'l';
    if (const UrdfLink* link = is_link ? FindLink(at->str(2)) : nullptr)
      return fmt::format("{}:{}", name, link->line);
    if (const UrdfJoint* joint = is_link ? nullptr : FindJoint(at->str(2)))
      return fmt::format("{}:{}", name, joint->line);
  }
  return name;
}

UrdfFile ReadUrdfFile(const std::filesystem::path& path) {
  UrdfFile file{.name = path.string(), .robot = {}, .links = {}, .joints = {}, .unread = {}};
  const Element robot = ParseXml(ReadBytes(path, file), file.name);
  file.robot = robot["name"];
  UrdfReader(robot, file);
  return file;
}

}  // namespace tenon::internal
