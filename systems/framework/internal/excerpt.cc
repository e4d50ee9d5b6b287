#include <tenon/systems/framework/internal/excerpt.h>

#include <fmt/format.h>

#include <cstddef>

namespace tenon::internal {

std::string Excerpt(std::string_view text) {
  constexpr int kMaxCharacters = 80;
  std::string excerpt;
  int characters = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const auto byte = static_cast<unsigned char>(c);
    const bool continues = (byte & 0xC0) == 0x80;  // the character of the byte before
    if (!continues && ++characters > kMaxCharacters) return excerpt + "…";
    if (c == '\n') {
      excerpt += "\\n";
    } else if (byte == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0) {
      excerpt += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[++i]));  // U+0080 to U+009F
    } else if (byte < 0x20 || byte == 0x7F) {
      excerpt += fmt::format("\\x{:02x}", byte);
    } else {
      excerpt += c;
    }
  }
  return excerpt;
}

}  // namespace tenon::internal
