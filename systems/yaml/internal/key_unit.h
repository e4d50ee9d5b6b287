#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace tenon::internal {

/// A key without its unit, and that: `inertia_kg_m2` is "inertia" in "kg_m2".
std::pair<std::string_view, std::string_view> SplitUnit(std::string_view key);

/// The unit that a key carries, as one writes it: "kg m^2" of inertia_kg_m2; "m/s", "1/s"; empty if none.
std::string UnitOfKey(std::string_view key);

}  // namespace tenon::internal
