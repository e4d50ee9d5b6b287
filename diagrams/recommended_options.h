#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/simulation/simulator_options.h>

#include <array>
#include <cstdint>
#include <string>

namespace tenon {

class CdprLoop;
class QuadrupedStand;
class QuadrupedWalk;
class QuadrupedWorld;

/// @file
/// How the shipped diagrams are integrated. The scenarios of the apps take their defaults from here, so a
/// program that uses these options runs a case as its app does, bit by bit:
///
///     auto& walk = builder.Add<QuadrupedWalk>("loop", params);
///     Simulator simulator(builder.Build(), RecommendedOptions(walk));

/// Seed of the random streams, of the recommended options and of a scenario that gives none.
inline constexpr std::uint64_t kRecommendedSeed = 1;

/// Explicit Runge-Kutta methods: kErk of order 2 to 5 and kStabilized of 2 and 3, see Method. By default a
/// walk takes 3.7 (A1) to 5 (B2) evaluations per ms and is within 0.03 mm of the exact motion for 6 s;
/// stabilized, with absolute tolerances of 1e-3, 1e-1 and 1e-5, it takes 3.0 and is within 0.08 mm.
enum class LeggedIntegrator { kRungeKutta, kStabilized };
constexpr auto EnumNames(LeggedIntegrator) {
  return std::array{Named{LeggedIntegrator::kRungeKutta, "runge_kutta"},
                    Named{LeggedIntegrator::kStabilized, "stabilized"}};
}

/// How a diagram with a QuadrupedWorld is integrated. Defaults: the recommendation of QuadrupedPlant.
struct LeggedIntegration {
  LeggedIntegrator method = LeggedIntegrator::kRungeKutta;  ///< stabilized for longer steps
  int order = 2;                                            ///< of the method; 2 or 3 if stabilized
  double rtol = 1e-2;                                       ///< relative tolerance
  double atol_position = 1e-4;  ///< absolute tolerance of positions and angles [m, rad]
  double atol_velocity = 1e-2;  ///< absolute tolerance of their rates [m/s, rad/s]
  double atol_bristles = 1e-6;  ///< absolute tolerance of the bristles of the feet [m]

  static FieldList Fields() {
    return {{"method", &LeggedIntegration::method},
            {"order", &LeggedIntegration::order},
            {"rtol", &LeggedIntegration::rtol},
            {"atol_position", &LeggedIntegration::atol_position},
            {"atol_velocity", &LeggedIntegration::atol_velocity},
            {"atol_bristles", &LeggedIntegration::atol_bristles}};
  }
  void Validate() const;  ///< throws ParameterError
  /// For a diagram in which this is the path of the QuadrupedPlant, as of "loop.world.plant".
  SimulatorOptions Options(const std::string& plant) const;
};

/// How a CdprLoop is integrated. The defaults take one step per millisecond on D1; the platform is then 3
/// micrometres off a run with order 5 and rtol 1e-9 after 20 s.
struct CdprIntegration {
  int order = 2;       ///< of the Runge-Kutta method
  double rtol = 1e-3;  ///< relative tolerance
  double atol = 1e-5;  ///< absolute tolerance

  static FieldList Fields() {
    return {{"order", &CdprIntegration::order},
            {"rtol", &CdprIntegration::rtol},
            {"atol", &CdprIntegration::atol}};
  }
  void Validate() const;  ///< throws ParameterError
  SimulatorOptions Options() const;
};

SimulatorOptions RecommendedOptions(const QuadrupedWorld& world);
SimulatorOptions RecommendedOptions(const QuadrupedStand& stand);
SimulatorOptions RecommendedOptions(const QuadrupedWalk& walk);
SimulatorOptions RecommendedOptions(const CdprLoop& loop);

}  // namespace tenon
