#include <tenon/systems/framework/block/distribution.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/internal/fnv1a.h>

#include <fmt/core.h>

#include <bit>

namespace tenon {
namespace {

std::uint64_t SplitMix64(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

std::uint64_t Hash(std::string_view text) {
  internal::Fnv1a hash;
  hash.Add(text);
  return hash.value();
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed) {
  for (std::uint64_t& word : state_) word = SplitMix64(seed);
}

RandomStream::RandomStream(std::uint64_t seed, std::string_view path)
    : RandomStream(SplitMix64(seed) ^ Hash(path)) {}

std::uint64_t RandomStream::Next() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double RandomStream::Uniform() {
  return static_cast<double>(Next() >> 11) * 0x1.0p-53;
}

double RandomStream::Uniform(double low, double high) {
  return low + (high - low) * Uniform();
}

double RandomStream::Normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double a, b, square;
  do {
    a = Uniform(-1, 1);
    b = Uniform(-1, 1);
    square = a * a + b * b;
  } while (square >= 1 || square == 0);
  const double scale = std::sqrt(-2 * std::log(square) / square);
  spare_ = b * scale;
  has_spare_ = true;
  return a * scale;
}

std::optional<Distribution> Distribution::Named(std::string_view name,
                                                const std::array<double, 2>& parameters) {
  if (name == "uniform") return Distribution(Kind::kUniform, name, parameters);
  if (name == "normal") return Distribution(Kind::kNormal, name, parameters);
  if (name == "lognormal") return Distribution(Kind::kLognormal, name, parameters);
  return {};
}

void Distribution::Validate() const {
  const auto& [first, second] = parameters_;
  if (kind_ == Kind::kUniform && first > second)
    throw ParameterError(fmt::format("{}: [{}, {}]: give the lower bound first", name_, first, second));
  if (kind_ != Kind::kUniform && second < 0)
    throw ParameterError(
        fmt::format("{}: [{}, {}]: the second number is the standard deviation and must not be negative",
                    name_, first, second));
}

double Distribution::Draw(RandomStream& random) const {
  const auto& [first, second] = parameters_;
  if (kind_ == Kind::kUniform) return random.Uniform(first, second);
  const double value = first + second * random.Normal();
  return kind_ == Kind::kNormal ? value : std::exp(value);
}

}  // namespace tenon
