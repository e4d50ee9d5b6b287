#include <tenon/plants/model/swivel_pulley.h>

#include <cmath>
#include <numbers>

namespace tenon {

double WrapOf(double x, double z) {
  const double angle = std::atan2(x, z);
  return angle < -std::numbers::pi / 2 ? angle + 2 * std::numbers::pi : angle;
}

PulleyContact LeaveStraight(double radius, double x, double z) {
  const double free_length = std::sqrt((x - radius) * (x - radius) + z * z - radius * radius);
  return {WrapOf(x - radius, z) + std::atan2(radius, free_length), free_length};
}

Vec<2> ExitPoint(double radius, double wrap) {
  return {radius * (1 - std::cos(wrap)), radius * std::sin(wrap)};
}

}  // namespace tenon
