#include <tenon/systems/framework/block/distribution.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

namespace tenon {

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
