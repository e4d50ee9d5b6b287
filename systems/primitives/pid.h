#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct PidParams {
  T kp = internal::Filled<T>(1);  ///< [u_unit / y_unit]
  T ki = internal::Filled<T>(0);  ///< [u_unit / (y_unit s)]
  T kd = internal::Filled<T>(0);  ///< [u_unit s / y_unit]
  double filter_time = 0.01;      ///< time constant of the derivative filter [s]; 0 for no filter
  double ref_weight = 1;          ///< weight of ref in the derivative, 0 to 1
  T lower = internal::Filled<T>(-std::numeric_limits<double>::infinity());  ///< lower limit of u [u_unit]
  T upper = internal::Filled<T>(std::numeric_limits<double>::infinity());   ///< upper limit of u [u_unit]
  Rate rate = Hz(1000);
  std::string y_unit = "";    ///< unit of ref and y
  std::string u_unit = "";    ///< unit of the output
  std::string elements = "";  ///< names of the elements of ref, y and u
  void Validate() const {
    Demand(internal::Everywhere([](double low, double high) { return low <= high; }, lower, upper),
           "lower must not exceed upper, in any element");
  }
};

/// Memory of the controller between ticks.
template <class T>
struct PidMemory {
  T integral = internal::Filled<T>(0);
  internal::FilteredDifference<T> derivative = {};
  static FieldList Fields() {
    return {{"integral", &PidMemory::integral}, {"derivative", &PidMemory::derivative}};
  }
};

/// A sampled PID controller with filtered derivative, saturated output and anti-windup, element by element.
/// With e = ref - y, h the period and Tf = filter_time:
///
///     v[n] = kp e[n] + I[n] + kd d[n],   u[n] = min(max(v[n], lower), upper)
///     I[n + 1] = I[n] + h ki e[n],   I[0] = 0,   unless v[n] is saturated and h ki e[n] increases the excess
///     d[n] = (Tf d[n - 1] + w[n] - w[n - 1]) / (Tf + h),   d[0] = 0,   w = ref_weight ref - y
///
/// This anti-windup is clamping, or conditional integration; unlike back-calculation it has no gain to choose
/// (Åström and Hägglund, "PID Controllers: Theory, Design, and Tuning", ISA 1995, chapter 3). Use a
/// ref_weight of 1 for smooth references, and 0 for references with steps, whose derivative would be an
/// impulse. I has the units of u, so a change of ki during a run does not make u jump.
///
/// T is double or Vec<N>. Feedthrough at its ticks. Throws ParameterError if a gain is not finite, if
/// filter_time is negative, if ref_weight is not from 0 to 1, or if a lower limit exceeds its upper one.
template <internal::DoubleOrMatrix T = double>
class Pid final : public LeafSystem<PidParams<T>> {
 public:
  using LeafSystem<PidParams<T>>::LeafSystem;
  using LeafSystem<PidParams<T>>::params;
  using Memory = PidMemory<T>;
  InputPort<T> ref{this, {"ref", params.y_unit, params.elements}};
  InputPort<T> y{this, {"y", params.y_unit, params.elements}};
  Parameter<T> kp{this,
                  {"kp", "", params.elements},
                  params.kp,
                  "proportional gain, unit of u / unit of y",
                  Range().Finite()};
  Parameter<T> ki{this,
                  {"ki", "", params.elements},
                  params.ki,
                  "integral gain, unit of u / (unit of y s)",
                  Range().Finite()};
  Parameter<T> kd{this,
                  {"kd", "", params.elements},
                  params.kd,
                  "derivative gain, unit of u s / unit of y",
                  Range().Finite()};
  Parameter<double> filter_time{this,
                                {"filter_time", "s"},
                                params.filter_time,
                                "time constant of the derivative filter",
                                Range().AtLeast(0)};
  Parameter<double> ref_weight{this, "ref_weight", params.ref_weight, "weight of ref in the derivative",
                               Range().Between(0, 1)};
  Parameter<T> lower{this, {"lower", params.u_unit, params.elements}, params.lower, "limit of u"};
  Parameter<T> upper{this, {"upper", params.u_unit, params.elements}, params.upper, "limit of u"};
  DiscreteState<Memory> memory{this, "memory"};

 private:
  Shared<internal::FilteredDifference<T>> derivative_{
      this, "derivative", Uses(memory, ref, y, ref_weight, filter_time),
      [this](const Memory& m, const T& r, const T& y_now, double b, double tau) {
        return m.derivative.Next(b * r - y_now, tau, params.rate.period());
      }};
  Shared<T> unlimited_{
      this, "unlimited", Uses(memory, ref, y, derivative_, kp, kd),
      [](const Memory& m, const T& r, const T& y_now, const internal::FilteredDifference<T>& derivative,
         const T& kp_now, const T& kd_now) -> T {
        const auto sum = [](double integral, double r_i, double y_i, double d, double kp_i, double kd_i) {
          return kp_i * (r_i - y_i) + integral + kd_i * d;
        };
        return internal::Elementwise(sum, m.integral, r, y_now, derivative.d, kp_now, kd_now);
      }};

 public:
  OutputPort<T> u{this,
                  {"u", params.u_unit, params.elements},
                  Sampled{params.rate},
                  Uses(unlimited_, lower, upper),
                  [](const T& v, const T& low, const T& high) -> T {
                    const auto limit = [](double v_i, double least, double most) {
                      return std::clamp(v_i, least, most);
                    };
                    return internal::Elementwise(limit, v, low, high);
                  }};
  Update<Memory> next{
      memory, Sampled{params.rate}, Uses(memory, ref, y, derivative_, unlimited_, ki, lower, upper),
      [this](const Memory& m, const T& r, const T& y_now, const internal::FilteredDifference<T>& derivative,
             const T& unlimited, const T& ki_now, const T& low, const T& high) -> Memory {
        const auto integrate = [h = params.rate.period()](double integral, double r_i, double y_i, double v,
                                                          double ki_i, double least, double most) {
          const double rise = ki_i * (r_i - y_i);
          const bool winds_up = (v > most && rise > 0) || (v < least && rise < 0);
          return winds_up ? integral : integral + h * rise;
        };
        return {internal::Elementwise(integrate, m.integral, r, y_now, unlimited, ki_now, low, high),
                derivative};
      }};
};

}  // namespace tenon
