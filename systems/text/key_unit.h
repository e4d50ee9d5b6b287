#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace tenon::internal {

/// Splits a key into its stem and its unit: `inertia_kg_m2` into "inertia" and "kg_m2".
std::pair<std::string_view, std::string_view> SplitUnit(std::string_view key);

/// Returns the unit of a key in the usual notation, such as "kg m^2" for inertia_kg_m2; empty without unit.
std::string UnitOfKey(std::string_view key);

}  // namespace tenon::internal
