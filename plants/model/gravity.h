#pragma once

namespace tenon {

inline constexpr double kGravity = 9.81;  ///< of the earth, as the thesis rounds it [m/s^2]

}  // namespace tenon
