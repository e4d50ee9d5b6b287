// Bytes as a message of a signal: text as JSON by UDP, and the difference to a valid message as LCM.

#include <tenon/systems/network/internal/json_reader.h>
#include <tenon/systems/network/internal/lcm_type.h>
#include <tenon/systems/simulation.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace {

enum class Phase { kStance, kSwing };
constexpr auto EnumNames(Phase) {
  return std::array{tenon::Named{Phase::kStance, "stance"}, tenon::Named{Phase::kSwing, "swing"}};
}

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
  static const tenon::internal::LcmType kType(TypeInfoOf<Signal>());
  static const std::vector<char> kGood = [] {
    std::vector<char> message;
    const Signal signal;
    kType.Encode(0, &signal, message);
    return message;
  }();
  static const Signal kModel;
  static tenon::internal::JsonReader reader("signal", TypeInfoOf<Signal>(), &kModel, {"signal"});

  Signal signal;
  double time = 0;
  if (!reader.Read({reinterpret_cast<const char*>(data), size}, &time, &signal).empty() &&
      !(signal == kModel))
    std::abort();  // a refused message changes nothing

  // The first byte is the size relative to that of the valid message.
  std::vector<char> message = kGood;
  if (size > 0) message.resize(kGood.size() + static_cast<std::size_t>(std::max<int>(data[0] % 16 - 8, -8)));
  for (std::size_t i = 1; i < std::min(size, message.size()); ++i)
    message[i - 1] ^= static_cast<char>(data[i]);
  signal = kModel;
  if (!kType.Decode(message, &time, &signal).empty() && !(signal == kModel)) std::abort();
  return 0;
}
