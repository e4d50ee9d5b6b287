#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/simulation/simulator_options.h>

namespace tenon {

class CdprLoop;
class QuadrupedPlant;
class QuadrupedStand;
class QuadrupedWalk;
class QuadrupedWorld;

/// @file
/// Options of the integrator for the shipped diagrams. They are the defaults of the apps' scenarios, so a
/// program with these options reproduces the run of an app bit by bit:
///
///     auto& walk = builder.Add<QuadrupedWalk>("loop", params);
///     Simulator simulator(builder.Build(), RecommendedOptions(walk));

/// Seed of the random streams in the recommended options, and in a scenario that gives none.
inline constexpr std::uint64_t kRecommendedSeed = 1;

/// Explicit Runge-Kutta methods: kErk of order 2 to 5 or kStabilized of order 2 or 3, see Method. With the
/// defaults, a walk takes 3.7 (A1) to 5 (B2) evaluations per ms, and stays within 0.03 mm of the exact motion
/// for 6 s. Stabilized, with absolute tolerances of 1e-3, 1e-1 and 1e-5, it takes 3.0 and stays within 0.08
/// mm.
enum class LeggedIntegrator { kRungeKutta, kStabilized };

/// Integration of a diagram with a QuadrupedWorld. The defaults are those that QuadrupedPlant recommends.
struct LeggedIntegration {
  LeggedIntegrator method = LeggedIntegrator::kRungeKutta;  ///< method; a stabilized one allows longer steps
  int order = 2;                                            ///< order of the method; 2 or 3 if stabilized
  double rtol = 1e-2;                                       ///< relative tolerance
  double atol_position = 1e-4;  ///< absolute tolerance of positions and angles [m, rad]
  double atol_velocity = 1e-2;  ///< absolute tolerance of velocities and angular rates [m/s, rad/s]
  double atol_bristles = 1e-6;  ///< absolute tolerance of the bristle deflections in the feet's friction [m]

  static FieldList Fields() {
    return {{"method", &LeggedIntegration::method},
            Field("order", &LeggedIntegration::order).Between(2, 5),
            Field("rtol", &LeggedIntegration::rtol).Between(1e-14, 0.1),
            Field("atol_position", &LeggedIntegration::atol_position).Between(1e-300, 0.1),
            Field("atol_velocity", &LeggedIntegration::atol_velocity).Between(1e-300, 0.1),
            Field("atol_bristles", &LeggedIntegration::atol_bristles).Between(1e-300, 0.1)};
  }
  void Validate() const;  ///< throws ParameterError
  /// Options for a diagram with this plant, or with a block that replaced it. Each state that this block
  /// lacks is left out; its other states get `atol_position`.
  SimulatorOptions Options(const QuadrupedPlant& plant) const;
};

/// Integration of a CdprLoop. The defaults take one step per millisecond on D1, and the platform is within 3
/// micrometres of a run with order 5 and rtol 1e-9 after 20 s.
struct CdprIntegration {
  int order = 2;       ///< order of the Runge-Kutta method
  double rtol = 1e-3;  ///< relative tolerance
  double atol = 1e-5;  ///< absolute tolerance

  static FieldList Fields() {
    return {Field("order", &CdprIntegration::order).Between(2, 5),
            Field("rtol", &CdprIntegration::rtol).Between(1e-14, 0.1),
            Field("atol", &CdprIntegration::atol).Between(1e-300, 0.1)};
  }
  SimulatorOptions Options() const;
};

SimulatorOptions RecommendedOptions(const QuadrupedWorld& world);
SimulatorOptions RecommendedOptions(const QuadrupedStand& stand);
SimulatorOptions RecommendedOptions(const QuadrupedWalk& walk);
SimulatorOptions RecommendedOptions(const CdprLoop& loop);

}  // namespace tenon
