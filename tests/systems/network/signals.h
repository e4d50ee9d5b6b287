#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon::test {

enum class Phase : std::uint8_t { kStance, kSwing };

struct Leg {
  Phase phase = Phase::kStance;
  Vec<3> p_W = Vec<3>::Zero();
  static FieldList Fields() { return {{"phase", &Leg::phase}, {"p_W", &Leg::p_W, "m"}}; }
  bool operator==(const Leg&) const = default;
};

/// Members of every type of constant size that a signal can hold.
struct Everything {
  bool on = false;
  float heat = 0;
  std::int8_t i8 = 0;
  std::int16_t i16 = 0;
  int i32 = 0;
  std::int64_t i64 = 0;
  std::uint16_t u16 = 0;
  std::uint32_t u32 = 0;
  std::uint64_t u64 = 0;
  Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();
  std::array<double, 2> pair{};
  std::array<Leg, 2> legs{};
  static FieldList Fields() {
    return {{"on", &Everything::on},    {"heat", &Everything::heat, "K"}, {"i8", &Everything::i8},
            {"i16", &Everything::i16},  {"i32", &Everything::i32},        {"i64", &Everything::i64},
            {"u16", &Everything::u16},  {"u32", &Everything::u32},        {"u64", &Everything::u64},
            {"A", &Everything::A, "N"}, {"pair", &Everything::pair},      {"legs", &Everything::legs}};
  }
  bool operator==(const Everything&) const = default;
};

inline Everything Extreme() {
  Everything e;
  e.on = true;
  e.heat = 0.1f;
  e.i8 = -128;
  e.i16 = -32768;
  e.i32 = std::numeric_limits<int>::min();
  e.i64 = std::numeric_limits<std::int64_t>::min();
  e.u16 = 65535;
  e.u32 = std::numeric_limits<std::uint32_t>::max();
  e.u64 = std::numeric_limits<std::uint64_t>::max();
  e.A << 1, 0.1, 1e-300, -2.5e17, 1.0 / 3, 5e-324;
  e.pair = {std::numeric_limits<double>::max(), 9007199254740993.0};
  e.legs[1] = {Phase::kSwing, {1, 2, 1e23}};
  return e;
}

/// Members whose sizes are known at run time only.
struct Cloud {
  Eigen::VectorXd weights;
  Eigen::MatrixXd basis;
  std::vector<Vec<3>> points;
  std::vector<Leg> legs;
  std::optional<double> radius;
  std::string text;
  static FieldList Fields() {
    return {{"weights", &Cloud::weights}, {"basis", &Cloud::basis},   {"points", &Cloud::points, "m"},
            {"legs", &Cloud::legs},       {"radius", &Cloud::radius}, {"text", &Cloud::text}};
  }
};

inline Cloud SomeCloud() {
  Cloud cloud;
  cloud.weights = Vec<2>(1, 2);
  cloud.basis.resize(2, 3);
  cloud.basis << 1, 2, 3, 4, 5, 6;
  cloud.points = {{1, 2, 3}, {4, 5, 6}};
  cloud.legs.resize(1);
  cloud.radius = 0.5;
  cloud.text = "not sent";
  return cloud;
}

}  // namespace tenon::test
