// Bytes as the inside of a snapshot, below a header that fits: what a checksum lets through is safe to read.

#include <tenon/systems/framework/types/internal/fnv1a.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/systems/primitives/state_space.h>
#include <tenon/systems/simulation.h>
#include <tenon/tests/fuzz/refusals.h>

namespace {

constexpr std::size_t kHeader = 32, kSize = 16, kChecksum = 24;  // where they lie [bytes]

void Put(std::uint64_t value, std::size_t at, std::vector<std::byte>& bytes) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

enum class Mode { kRest, kRun };

/// One state of each kind that a snapshot stores in a way of its own.
class Kinds final : public tenon::LeafSystem<void> {
 public:
  tenon::DiscreteState<Mode> mode{this, "mode"};
  tenon::DiscreteState<bool> on{this, "on"};
  tenon::DiscreteState<std::string> text{this, "text"};
  tenon::DiscreteState<std::optional<double>> maybe{this, "maybe"};
  tenon::DiscreteState<std::vector<tenon::Vec<3>>> list{this, "list"};
  tenon::DiscreteState<Eigen::MatrixXd> matrix{this, "matrix"};
  tenon::ContinuousState<Eigen::VectorXd> x{this, "x", Eigen::VectorXd::Ones(3)};
  tenon::TimeDerivative<Eigen::VectorXd> dx{x, tenon::Uses(x),
                                            [](const Eigen::VectorXd& x) -> Eigen::VectorXd { return -x; }};
};

std::shared_ptr<const tenon::Diagram> MakeDiagram() {
  tenon::DiagramBuilder builder;
  builder.Add<Kinds>("kinds");
  auto& noise = builder.Add<tenon::WhiteNoise<double>>("noise", {});
  auto& delay = builder.Add<tenon::SampleDelay<double>>("delay", {.samples = 3});
  auto& integrator = builder.Add<tenon::Integrator<double>>("integrator", {});
  builder.Connect(noise.y, delay.u);
  builder.Connect(delay.y, integrator.u);
  return builder.Build();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto kDiagram = MakeDiagram();
  static const std::vector<std::byte> kGood = [] {
    tenon::Simulator simulator(kDiagram);
    simulator.RunTo(0.01);
    return simulator.context().Save();
  }();
  // The input is the difference to a good one, byte by byte; it may be longer.
  std::vector<std::byte> bytes = kGood;
  bytes.resize(std::max(bytes.size(), kHeader + size));
  for (std::size_t i = 0; i < size; ++i) bytes[kHeader + i] ^= static_cast<std::byte>(data[i]);
  tenon::internal::Fnv1a checksum;
  checksum.Add({reinterpret_cast<const char*>(bytes.data()) + kHeader, bytes.size() - kHeader});
  Put(bytes.size() - kHeader, kSize, bytes);
  Put(checksum.value(), kChecksum, bytes);
  return tenon::fuzz::Try("", [&] {
    const auto context = kDiagram->CreateContext();
    context->Restore(bytes);
    context->EvalTimeDerivatives();
    context->Save();
  });
}
