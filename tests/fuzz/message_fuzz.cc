// Bytes as a message of a signal: JSON by UDP.

#include <tenon/systems/network/internal/json.h>
#include <tenon/systems/simulation.h>

namespace {

enum class Phase { kStance, kSwing };

/// Elements of each kind that a message stores in a different way.
struct Signal {
  bool on = false;
  std::int8_t small = 0;
  std::uint64_t large = 0;
  Phase phase = Phase::kStance;
  tenon::Vec<3> force = tenon::Vec<3>::Zero();
  std::vector<double> weights = {1, 2};
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(2, 3);
  static tenon::FieldList Fields() {
    return {{"on", &Signal::on},          {"small", &Signal::small}, {"large", &Signal::large},
            {"phase", &Signal::phase},    {"force", &Signal::force}, {"points", &Signal::points},
            {"weights", &Signal::weights}};
  }
  bool operator==(const Signal&) const = default;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using tenon::internal::TypeInfoOf;
  static const Signal kModel;
  static tenon::internal::JsonReader reader("signal", TypeInfoOf<Signal>(), &kModel, {"signal"});

  Signal signal;
  double time = 0;
  if (!reader.Read({reinterpret_cast<const char*>(data), size}, &time, &signal).empty() &&
      !(signal == kModel))
    std::abort();  // a refused message changes nothing
  return 0;
}
