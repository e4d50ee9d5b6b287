#include <tenon/systems/framework/internal/excerpt.h>

#include <fmt/format.h>

namespace tenon::internal {

std::string Excerpt(std::string_view text) {
  constexpr int kMaxCharacters = 80;
  std::string excerpt;
  int characters = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool continues = (byte & 0xC0) == 0x80;  // the character of the byte before
    if (!continues && ++characters > kMaxCharacters) return excerpt + "…";
    if (c == '\n') {
      excerpt += "\\n";
    } else if (byte < 0x20 || byte == 0x7F) {
      excerpt += fmt::format("\\x{:02x}", byte);
    } else {
      excerpt += c;
    }
  }
  return excerpt;
}

}  // namespace tenon::internal
