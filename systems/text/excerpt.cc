#include <tenon/systems/text/excerpt.h>

#include <fmt/format.h>
#include <utf8.h>

namespace tenon::internal {
namespace {

std::string Escaped(std::string_view text, int max_characters, bool keep_lines) {
  std::string excerpt;
  int characters = 0;
  const char* bad = utf8::find_invalid(text.begin(), text.end());
  for (const char* at = text.begin(); at != text.end(); ++at) {
    const char c = *at;
    const auto byte = static_cast<unsigned char>(c);
    const bool is_text = at != bad;
    const bool continues = is_text && (byte & 0xC0) == 0x80;  // belongs to the character of the previous byte
    if (!continues && ++characters > max_characters) return excerpt + "…";
    if (!is_text) {
      excerpt += fmt::format("\\x{:02x}", byte);
      bad = utf8::find_invalid(at + 1, text.end());
    } else if (c == '\n' && !keep_lines) {
      excerpt += "\\n";
    } else if (byte == 0xC2 && static_cast<unsigned char>(at[1]) < 0xA0) {
      excerpt += fmt::format("\\x{:02x}", static_cast<unsigned char>(*++at));  // U+0080 to U+009F
    } else if ((byte < 0x20 && c != '\n') || byte == 0x7F) {
      excerpt += fmt::format("\\x{:02x}", byte);
    } else {
      excerpt += c;
    }
  }
  return excerpt;
}

}  // namespace

std::string Excerpt(std::string_view text) {
  return Escaped(text, 80, false);
}

std::string Printable(std::string_view message) {
  return Escaped(message, 4000, true);
}

}  // namespace tenon::internal
