#pragma once

#include <tenon/systems/framework/types/errors.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace tenon::fuzz {

/// Runs `call` on an input. It may be refused; what else is thrown is not caught and ends the fuzzer, and so
/// does a refusal that does not name the place: `place` has to be in its text.
template <class Call>
int Try(std::string_view place, const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    if (std::string_view(error.what()).find(place) != std::string_view::npos) return 0;
    std::fprintf(stderr, "a refusal without '%.*s': %s\n", static_cast<int>(place.size()), place.data(),
                 error.what());
    std::abort();
  }
  return 0;
}

}  // namespace tenon::fuzz
