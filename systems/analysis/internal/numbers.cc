#include <tenon/systems/analysis/internal/numbers.h>

#include <fmt/core.h>

namespace tenon::internal {
namespace {

std::string NameOf(const Source& source, const Element& element) {
  return source.path() + (element.name.empty() ? "" : "." + element.name);
}

}  // namespace

std::vector<std::string> NumberNames(const Context& context, const std::vector<const Source*>& sources) {
  std::vector<std::string> names;
  for (const Source* source : sources) {
    for (const Element& element : context.Elements(*source)) names.push_back(NameOf(*source, element));
  }
  return names;
}

Eigen::VectorXd EvalNumbers(Context& context, const std::vector<const Source*>& sources) {
  std::vector<double> values;
  for (const Source* source : sources) {
    const std::vector<double> own = context.EvalDoubles(*source);
    values.insert(values.end(), own.begin(), own.end());
  }
  return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

RealNumbers::RealNumbers(const Context& context, std::vector<const Source*> sources) {
  for (const Source* source : sources) {
    Part part{source, {}};
    for (const Element& element : context.Elements(*source)) {
      part.is_real.push_back(element.is_real);
      if (!element.is_real) continue;
      names_.push_back(NameOf(*source, element));
      units_.push_back(element.unit);
    }
    parts_.push_back(std::move(part));
  }
}

std::vector<double> RealNumbers::Eval(Context& context, const Part& part) const {
  std::vector<double> values = context.EvalDoubles(*part.source);
  if (values.size() == part.is_real.size()) return values;
  throw RunError(
      fmt::format("'{}' holds {} numbers at t = {} s, but held {} before: signals of variable size have no "
                  "derivative, omit it",
                  part.source->path(), values.size(), context.time(), part.is_real.size()));
}

Eigen::VectorXd RealNumbers::Get(Context& context) const {
  Eigen::VectorXd all(size());
  Eigen::Index next = 0;
  for (const Part& part : parts_) {
    const std::vector<double> values = Eval(context, part);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (part.is_real[i]) all[next++] = values[i];
    }
  }
  return all;
}

void RealNumbers::Set(Context& context, const Eigen::VectorXd& all) const {
  Eigen::Index next = 0;
  for (const Part& part : parts_) {
    std::vector<double> values = Eval(context, part);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (part.is_real[i]) values[i] = all[next++];
    }
    context.SetDoubles(*part.source, values);
  }
}

}  // namespace tenon::internal
