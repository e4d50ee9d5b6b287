#include <tenon/plants/robots/internal/mesh_import.h>
#include <tenon/plants/robots/internal/xml_elements.h>
#include <tenon/systems/text/text.h>

namespace tenon::internal {
namespace {

constexpr std::size_t kMaxColladaDepth = 100;  // maximal nesting of elements

class ColladaCheck {
 public:
  explicit ColladaCheck(std::string_view text) {
    if (text.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw std::runtime_error("it is too large");
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &OnStart, &OnEnd);
    XML_SetCharacterDataHandler(parser_.get(), &OnText);
    XML_SetStartDoctypeDeclHandler(parser_.get(), &OnDoctype);
    const bool parsed =
        XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), XML_TRUE) == XML_STATUS_OK;
    if (failure_.empty() && !parsed) Fail(XML_ErrorString(XML_GetErrorCode(parser_.get())));
    if (!failure_.empty()) throw std::runtime_error(failure_);
    for (const Accessor& accessor : accessors_) {
      const auto array = arrays_.find(accessor.array);
      if (array == arrays_.end() || accessor.end > array->second)
        throw std::runtime_error(fmt::format("line {}: an accessor reads {} numbers of an array that has {}",
                                             accessor.line, accessor.end,
                                             array == arrays_.end() ? 0 : array->second));
    }
  }

 private:
  struct Accessor {
    std::string array;
    double end;  // number of the last element plus 1
    std::size_t line;
  };

  void Fail(const std::string& why) {
    if (!failure_.empty()) return;
    failure_ = fmt::format("line {}: {}", LineOf(parser_.get()), why);
    XML_StopParser(parser_.get(), XML_FALSE);
  }
  static std::string Attribute(const char** attributes, std::string_view name) {
    for (; *attributes != nullptr; attributes += 2)
      if (name == attributes[0]) return attributes[1];
    return {};
  }
  static void OnStart(void* self, const char* name, const char** attributes) {
    static_cast<ColladaCheck*>(self)->Start(name, attributes);
  }
  void Start(std::string_view name, const char** attributes) {
    if (++depth_ > kMaxColladaDepth)
      return Fail(fmt::format("elements are nested deeper than {}", kMaxColladaDepth));
    array_ = nullptr;
    if (name == "float_array") {
      array_ = &arrays_["#" + Attribute(attributes, "id")];
      *array_ = 0;
      in_number_ = false;
    } else if (name == "accessor") {
      const auto number = [&](const char* key, double otherwise) {
        const std::string text = Attribute(attributes, key);
        return text.empty() ? otherwise : NumberIn<std::uint32_t>(text).value_or(1e18);
      };
      accessors_.push_back({Attribute(attributes, "source"),
                            number("offset", 0) + number("count", 0) * number("stride", 1),
                            LineOf(parser_.get())});
    }
  }
  static void OnEnd(void* self, const char*) {
    auto& check = *static_cast<ColladaCheck*>(self);
    --check.depth_;
    check.array_ = nullptr;
  }
  static void OnText(void* self, const char* text, int size) {
    auto& check = *static_cast<ColladaCheck*>(self);
    if (check.array_ == nullptr) return;
    for (const char c : std::string_view(text, static_cast<std::size_t>(size))) {
      const bool blank = c == ' ' || c == '\n' || c == '\t' || c == '\r';
      if (!blank && !check.in_number_) *check.array_ += 1;
      check.in_number_ = !blank;
    }
  }
  static void OnDoctype(void* self, const char*, const char*, const char*, int) {
    static_cast<ColladaCheck*>(self)->Fail("a document type, which may define entities, is not allowed");
  }

  std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser_{
      XML_ParserCreate(nullptr), &XML_ParserFree};
  std::string failure_;
  std::size_t depth_ = 0;
  std::map<std::string, double> arrays_;  // numbers of elements by reference
  double* array_ = nullptr;               // the open array
  bool in_number_ = false;
  std::vector<Accessor> accessors_;
};

}  // namespace

void CheckCollada(std::string_view text) {
  const ColladaCheck check(text);
}

}  // namespace tenon::internal
