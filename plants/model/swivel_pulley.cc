#include <tenon/plants/model/swivel_pulley.h>

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

StraightLead LeadStraight(double radius, const Vec<3>& span_W) {
  const double x = std::hypot(span_W[0], span_W[1]);
  const PulleyContact contact = LeaveStraight(radius, x, -span_W[2]);
  const Vec<2> exit = ExitPoint(radius, contact.wrap);
  const Vec<3> outwards = Vec<3>(-span_W[0], -span_W[1], 0) / x;
  const Vec<3> away = std::sin(contact.wrap) * outwards + Vec<3>(0, 0, std::cos(contact.wrap));
  return {contact, outwards, exit[0] * outwards + Vec<3>(0, 0, exit[1]), -away,
          radius * contact.wrap + contact.free_length};
}

}  // namespace tenon
