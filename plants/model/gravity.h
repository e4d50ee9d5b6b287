#pragma once

namespace tenon {

inline constexpr double kGravity = 9.81;  ///< standard gravity, rounded as in Morlando 2023 [m/s^2]

}  // namespace tenon
