#pragma once

#include <cstdint>
#include <string_view>

namespace tenon::internal {

/// FNV-1a hash of 64 bits (Fowler, Noll, Vo). Texts that differ in a single byte have different hashes.
class Fnv1a {
 public:
  constexpr void Add(std::string_view text) {
    for (const char c : text) value_ = (value_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  constexpr std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace tenon::internal
