#include <tenon/plants/robots/internal/xml_elements.h>
#include <tenon/systems/text/text.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <type_traits>

namespace tenon::internal {
namespace {

constexpr std::size_t kMaxDepth = 32;          // nesting of elements; a URDF needs five or six
constexpr std::size_t kMaxElements = 200'000;  // of links, joints and materials
constexpr std::size_t kMaxAttributes = 32;     // of an element; a URDF needs four or five
constexpr std::size_t kMaxName = 200;          // [bytes]

/// Parses a file of XML into its elements, without those that extend a URDF, such as <gazebo>.
class Parser {
 public:
  explicit Parser(const std::string& file) : file_(file) {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &OnStart, &OnEnd);
    XML_SetStartDoctypeDeclHandler(parser_.get(), &OnDoctype);
  }

  Element Parse(const std::string& text) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
      FailAt(file_, 1, "the file is in UTF-16; save it as UTF-8");
    const std::size_t first = text.find_first_not_of("\xef\xbb\xbf \t\r\n");  // after a byte order mark
    if (first == text.npos || text[first] != '<')
      FailAt(file_, 1, "the file is not XML, as a URDF is, but perhaps a mesh; give the path of a URDF");
    const bool parsed =
        XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), XML_TRUE) == XML_STATUS_OK;
    if (failure_) std::rethrow_exception(failure_);
    if (!parsed)
      Fail("not a valid URDF: {}; correct the XML", XML_ErrorString(XML_GetErrorCode(parser_.get())));
    return std::move(root_);
  }

 private:
  template <class... Args>
  [[noreturn]] void Fail(fmt::format_string<Args...> format, Args&&... args) const {
    FailAt(file_, LineOf(parser_.get()), format, std::forward<Args>(args)...);
  }

  // Exceptions must not pass through the parser, which is written in C.
  static void OnStart(void* self, const char* name, const char** attributes) {
    Try(self, [=](Parser& parser) { parser.Start(name, attributes); });
  }
  static void OnEnd(void* self, const char*) {
    Try(self, [](Parser& parser) {
      --parser.depth_;
      if (parser.open_.size() > parser.depth_) parser.open_.pop_back();
    });
  }
  static void OnDoctype(void* self, const char*, const char*, const char*, int) {
    Try(self, [](Parser& parser) {
      parser.Fail("the file has a DOCTYPE, which a URDF does not need; remove it and its entities");
    });
  }
  static void Try(void* self, const auto& handle) {
    auto& parser = *static_cast<Parser*>(self);
    if (parser.failure_) return;  // the library may call again after a failure
    try {
      handle(parser);
    } catch (...) {
      parser.failure_ = std::current_exception();
      XML_StopParser(parser.parser_.get(), XML_FALSE);
    }
  }

  void Start(std::string_view name, const char** attributes) {
    if (depth_ >= kMaxDepth) Fail("elements are nested deeper than {} levels; check the file", kMaxDepth);
    const std::size_t depth = depth_++;
    if (depth == 0) CheckRoot(name);
    if (open_.size() < depth) return;  // within an element of another program
    if (name.starts_with("xacro:"))
      Fail(
          "this is a xacro file; expand its macros first: xacro {} -o {} (xacro is part of ROS; without ROS: "
          "pipx install xacro)",
          file_, FreeName());
    if (++count_ > kMaxElements) Fail("there are more than {} elements; check the file", kMaxElements);
    Element element{std::string(name), LineOf(parser_.get())};
    Element& added =
        depth == 0 ? root_ = std::move(element) : open_.back()->children.emplace_back(std::move(element));
    if (depth == 1 && name != "link" && name != "joint" && name != "material") return;
    for (const char** at = attributes; *at != nullptr; at += 2) added.attributes.emplace_back(at[0], at[1]);
    if (added.attributes.size() > kMaxAttributes)
      Fail("an element has {} attributes, but at most {} are allowed", added.attributes.size(),
           kMaxAttributes);
    for (const char* text : {"name", "link", "type"})  // these appear in messages
      if (const std::size_t bytes = added[text].size(); bytes > kMaxName)
        Fail("the {} of an element has {} bytes, but at most {} are allowed", text, bytes, kMaxName);
    open_.push_back(&added);
  }

  /// The name of a URDF beside the file that does not exist.
  std::string FreeName() const {
    const std::filesystem::path path = file_;
    const std::string stem = path.stem().stem().string();
    std::filesystem::path free = path;
    std::error_code error;
    for (int i = 1; i == 1 || std::filesystem::exists(free, error); ++i)
      free.replace_filename(i == 1 ? stem + ".urdf" : fmt::format("{}_{}.urdf", stem, i));
    return free.string();
  }

  /// Refuses files of other formats by their first element.
  void CheckRoot(std::string_view element) const {
    if (element == "robot") return;
    const std::string_view format = element == "mujoco"    ? "an MJCF file of MuJoCo"
                                    : element == "sdf"     ? "an SDF file of Gazebo"
                                    : element == "COLLADA" ? "a mesh"
                                                           : "no URDF";
    Fail("the file is {}: its first element is <{}>, that of a URDF is <robot>; give the robot's URDF",
         format, Excerpt(element));
  }

  const std::string& file_;
  std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser_{
      XML_ParserCreate(nullptr), &XML_ParserFree};
  Element root_{};
  std::vector<Element*> open_;  ///< open elements, without those of other programs and within these
  std::size_t depth_ = 0;       ///< number of all open elements
  std::size_t count_ = 0;
  std::exception_ptr failure_;
};

}  // namespace

const std::string& Element::operator[](std::string_view attribute) const {
  static const std::string kNone;
  const auto at = std::ranges::find(attributes, attribute, &std::pair<std::string, std::string>::first);
  return at == attributes.end() ? kNone : at->second;
}

const Element* Element::Child(std::string_view child) const {
  const auto at = std::ranges::find(children, child, &Element::name);
  return at == children.end() ? nullptr : &*at;
}

Element ParseXml(const std::string& text, const std::string& file) {
  return Parser(file).Parse(text);
}

}  // namespace tenon::internal
