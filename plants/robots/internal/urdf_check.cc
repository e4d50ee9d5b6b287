#include <tenon/plants/robots/internal/urdf_check.h>
#include <tenon/plants/robots/internal/xml_line.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/text/excerpt.h>
#include <tenon/systems/text/parse_number.h>

#include <expat.h>
#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tenon::internal {
namespace {

constexpr std::size_t kMaxDepth = 32;  // maximal nesting of elements; a URDF needs five or six
constexpr std::size_t kMaxAttributes =
    32;  // maximal number of attributes of an element; a URDF needs four or five
constexpr std::size_t kMaxLinks = 1000;
constexpr std::size_t kMaxName = 80;  // [bytes]

/// Attributes that hold numbers, the count of numbers, and their largest plausible absolute value.
struct Numbers {
  std::string_view element, attribute;
  int count;
  double largest = HUGE_VAL;
};
constexpr Numbers kNumbers[] = {
    {"mass", "value", 1, 1e6},  {"inertia", "ixx", 1, 1e9}, {"inertia", "ixy", 1, 1e9},
    {"inertia", "ixz", 1, 1e9}, {"inertia", "iyy", 1, 1e9}, {"inertia", "iyz", 1, 1e9},
    {"inertia", "izz", 1, 1e9}, {"origin", "xyz", 3, 100},  {"origin", "rpy", 3, 1e3},
    {"axis", "xyz", 3, 1e3},    {"limit", "lower", 1},      {"limit", "upper", 1},
    {"limit", "effort", 1},     {"limit", "velocity", 1},   {"sphere", "radius", 1},
    {"cylinder", "radius", 1},  {"cylinder", "length", 1},  {"box", "size", 3},
    {"mesh", "scale", 3},       {"color", "rgba", 4},
};

/// Parses finite numbers separated by blanks; empty if the text holds anything else.
std::optional<std::vector<double>> ReadNumbers(std::string_view text) {
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

class Check {
 public:
  Check(const std::string& text, const std::string& file) : file_(file) {
    if (text.size() > kMaxUrdfBytes)
      throw ParameterError(
          fmt::format("{}: the file exceeds the limit of {} bytes; check that it is the right file", file,
                      kMaxUrdfBytes));
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &OnStart, &OnEnd);
    XML_SetStartDoctypeDeclHandler(parser_.get(), &OnDoctype);
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
      Fail(1, "the file is in UTF-16; save it as UTF-8");
    const std::size_t first = text.find_first_not_of("\xef\xbb\xbf \t\r\n");  // after a byte order mark
    if (first == text.npos || text[first] != '<')
      Fail(1, "the file is not XML, as a URDF is, but perhaps a mesh; give the path of a URDF");
    const bool parsed =
        XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), XML_TRUE) == XML_STATUS_OK;
    if (failure_) std::rethrow_exception(failure_);
    if (!parsed)
      Fail(Line(), "not a valid URDF: {}; correct the XML", XML_ErrorString(XML_GetErrorCode(parser_.get())));
    RefuseRings();
  }

  CheckedUrdf Take(std::string text) {
    for (auto at = missing_.rbegin(); at != missing_.rend(); ++at) text.insert(at->first, at->second);
    return {std::move(lines_), std::move(text)};
  }

 private:
  struct Joint {
    std::string name, parent, child, type;
    std::size_t line;
    bool has_limit = false;
  };

  template <class... Args>
  [[noreturn]] void Fail(std::size_t line, fmt::format_string<Args...> format, Args&&... args) const {
    throw ParameterError(
        fmt::format("{}:{}: {}", file_, line, fmt::format(format, std::forward<Args>(args)...)));
  }
  std::size_t Line() const { return LineOf(parser_.get()); }

  // Exceptions must not pass through the parser, which is written in C.
  static void OnStart(void* self, const char* name, const char** attributes) {
    Try(self, [=](Check& check) { check.Start(name, attributes); });
  }
  static void OnEnd(void* self, const char*) {
    Try(self, [](Check& check) { check.End(); });
  }
  static void OnDoctype(void* self, const char*, const char*, const char*, int) {
    Try(self, [](Check& check) {
      check.Fail(check.Line(),
                 "the file has a DOCTYPE, which a URDF does not need; remove it and its entities");
    });
  }
  static void Try(void* self, const auto& handle) {
    auto& check = *static_cast<Check*>(self);
    if (check.failure_) return;  // the parser may call again after a failure
    try {
      handle(check);
    } catch (...) {
      check.failure_ = std::current_exception();
      XML_StopParser(check.parser_.get(), XML_FALSE);
    }
  }

// Expat 2.9 deprecates functions that do not suit files above 2 GiB; a URDF has at most kMaxUrdfBytes.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  std::size_t Byte() const {
    return static_cast<std::size_t>(XML_GetCurrentByteIndex(parser_.get()));
  }
#pragma GCC diagnostic pop

  void End() {
    const bool inertial = foreign_ == 0 && open_.size() == 3 && open_.back() == "inertial";
    if (inertial && !has_mass_)
      Fail(Line(), "{}: its <inertial> has no mass; write <mass value=\"...\"/>, in kg", owner_);
    if (inertial && !has_inertia_)
      Fail(Line(), "{}: its <inertial> has no inertia; write <inertia ixx=\"...\" .../>, in kg m^2", owner_);
    open_.pop_back();
    if (foreign_ > open_.size()) foreign_ = 0;
    if (open_.size() == 1) EndOfOwner();
  }

  void EndOfOwner() {
    if (!in_joint_ || joints_.back().has_limit) return;
    const std::string& type = joints_.back().type;
    if (type == "revolute" || type == "prismatic")
      missing_.emplace_back(Byte(), R"(<limit effort="0" velocity="0"/>)");
  }

  void Start(std::string_view element, const char** attributes) {
    if (open_.size() >= kMaxDepth)
      Fail(Line(), "elements are nested deeper than {} levels; check the file", kMaxDepth);
    const auto attribute = [&](std::string_view name) -> std::string {
      for (const char** at = attributes; *at != nullptr; at += 2) {
        if (name == *at) return at[1];
      }
      return "";
    };
    if (open_.empty()) CheckRoot(element);
    if (open_.size() == 1 && element != "link" && element != "joint" && element != "material" &&
        !element.starts_with("xacro:"))
      foreign_ = 2;
    if (foreign_ != 0) {
      in_joint_ = false;
      open_.emplace_back(element);
      return;
    }
    if (element.starts_with("xacro:"))
      Fail(Line(), "this is a xacro file; expand its macros first: xacro {} > {}.urdf", file_, StemOf(file_));
    std::size_t count = 0;
    for (const char** at = attributes; *at != nullptr; at += 2) ++count;
    if (count > kMaxAttributes)
      Fail(Line(), "an element has {} attributes, but at most {} are allowed", count, kMaxAttributes);
    for (const char* name : {"name", "link", "type"})  // these appear in messages
      if (const std::size_t bytes = attribute(name).size(); bytes > kMaxName)
        Fail(Line(), "the {} of an element has {} bytes, but at most {} are allowed", name, bytes, kMaxName);
    if (element == "inertial") has_mass_ = has_inertia_ = false;
    if (element == "inertia" && open_.size() == 3 && open_.back() == "inertial") {
      has_inertia_ = true;
      for (const char* name : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"})
        if (attribute(name).empty())
          Fail(Line(), "{}: its <inertia> has no {}; write all six attributes, also those that are 0", owner_,
               name);
    }
    if (element == "mass" && !attribute("value").empty()) has_mass_ = true;
    if (open_.size() == 1) {
      if (element == "link" && ++links_ > kMaxLinks)
        Fail(Line(), "there are more than {} links; check the file", kMaxLinks);
      in_joint_ = element == "joint";
      owner_ = fmt::format("{} '{}'", Excerpt(element), Excerpt(attribute("name")));
      if ((element == "link" || element == "joint") && attribute("name").empty())
        Fail(Line(), "a {} has no name; give each one a unique name", element);
      if (element == "link" || element == "joint")
        lines_.emplace(fmt::format("{} {}", element, attribute("name")), Line());
      if (element == "joint") joints_.push_back({attribute("name"), "", "", attribute("type"), Line()});
    } else if (open_.size() == 2 && open_.back() == "joint") {
      if (element == "parent") joints_.back().parent = attribute("link");
      if (element == "child") joints_.back().child = attribute("link");
      if (element == "limit") {
        joints_.back().has_limit = true;
        for (const char* name : {"effort", "velocity"}) {
          if (attribute(name).empty())
            missing_.emplace_back(Byte() + std::string_view("<limit").size(), fmt::format(" {}=\"0\"", name));
        }
      }
    }
    for (const char** at = attributes; *at != nullptr; at += 2) CheckNumbers(element, at[0], at[1]);
    open_.emplace_back(element);
  }

  /// Refuses files of other formats by their first element.
  void CheckRoot(std::string_view element) const {
    if (element == "robot") return;
    const std::string_view format = element == "mujoco"    ? "an MJCF file of MuJoCo"
                                    : element == "sdf"     ? "an SDF file of Gazebo"
                                    : element == "COLLADA" ? "a mesh"
                                                           : "no URDF";
    Fail(Line(),
         "the file is {}: its first element is <{}>, that of a URDF is <robot>; give the robot's URDF",
         format, Excerpt(element));
  }

  void CheckNumbers(std::string_view element, std::string_view attribute, std::string_view text) const {
    for (const Numbers& numbers : kNumbers) {
      if (numbers.element != element || numbers.attribute != attribute) continue;
      const auto found = ReadNumbers(text);
      if (!found || static_cast<int>(found->size()) != numbers.count)
        Fail(Line(), "{}: <{} {}=\"{}\">: write {}, without a unit and with a decimal point", owner_, element,
             attribute, Excerpt(text),
             numbers.count == 1
                 ? "one number"
                 : fmt::format("{} numbers with blanks between", numbers.count == 3 ? "three" : "four"));
      for (const double number : *found) {
        if (!(std::abs(number) <= numbers.largest))
          Fail(Line(),
               "{}: <{} {}=\"{}\">: the absolute value must be at most {}; check that the unit is an SI unit",
               owner_, element, attribute, Excerpt(text), numbers.largest);
      }
    }
  }

  void RefuseRings() const {
    std::map<std::string_view, std::size_t> above;  // index of the parent joint by link
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      if (joints_[i].child.empty()) continue;  // reported by urdfdom
      const auto [at, is_new] = above.emplace(joints_[i].child, i);
      if (!is_new)
        Fail(joints_[i].line,
             "the link '{}' has two parent joints, '{}' and '{}'; the links must form a tree, remove one",
             joints_[i].child, joints_[at->second].name, joints_[i].name);
    }
    std::vector<std::size_t> walk_of(joints_.size(),
                                     joints_.size());  // start of the first walk that visited the joint
    for (std::size_t start = 0; start < joints_.size(); ++start) {
      for (std::size_t i = start; walk_of[i] == joints_.size();) {
        walk_of[i] = start;
        const auto found = above.find(joints_[i].parent);
        if (found == above.end()) break;
        i = found->second;
        if (walk_of[i] == start) FailRing(i, above);
      }
    }
  }

  [[noreturn]] void FailRing(std::size_t start, const std::map<std::string_view, std::size_t>& above) const {
    std::string names;
    std::size_t i = start;
    do {
      names += fmt::format("{}'{}'", names.empty() ? "" : ", ", joints_[i].name);
      i = above.at(joints_[i].parent);
    } while (i != start);
    Fail(joints_[start].line, "the joints {} form a loop; the links must form a tree, remove one", names);
  }

  static std::string StemOf(const std::string& file) {
    const std::string name = file.substr(file.find_last_of('/') + 1);
    return name.substr(0, name.find('.'));
  }

  const std::string& file_;
  std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser_{
      XML_ParserCreate(nullptr), &XML_ParserFree};
  std::vector<std::string> open_;                ///< open elements
  std::size_t foreign_ = 0;                      ///< depth of an element such as <gazebo>, which is skipped
  std::string owner_;                            ///< the enclosing link or joint, for messages
  bool in_joint_ = false;                        ///< whether the enclosing element is a joint
  bool has_mass_ = false, has_inertia_ = false;  ///< elements of the current <inertial>
  std::size_t links_ = 0;
  std::vector<Joint> joints_;
  std::vector<std::pair<std::size_t, std::string>>
      missing_;  ///< texts to insert for urdfdom, with their offsets [bytes]
  UrdfLines lines_;
  std::exception_ptr failure_;
};

}  // namespace

CheckedUrdf CheckUrdf(const std::string& text, const std::string& file) {
  return Check(text, file).Take(text);
}

}  // namespace tenon::internal
