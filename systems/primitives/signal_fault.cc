#include <tenon/systems/primitives/signal_fault.h>

#include <fmt/format.h>

namespace tenon::internal {
namespace {

bool Means(const std::string& name, const std::string& element) {
  return element == name || element.starts_with(name + ".");
}

std::string NamesOf(const std::vector<Element>& elements) {
  std::vector<std::string> names;
  for (const Element& element : elements) names.push_back(element.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::vector<std::size_t> FindElements(const std::vector<Element>& elements,
                                      const std::vector<std::string>& names, bool real_only) {
  std::vector<bool> chosen(elements.size(), names.empty());
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      if (!Means(name, elements[i].name)) continue;
      if (real_only && elements[i].name == name && !elements[i].is_real) {
        throw ParameterError(fmt::format(
            "'{}' is not a real number, as this kind of fault requires: choose another element, or "
            "drop_out, stuck, late or lost",
            name));
      }
      found = chosen[i] = true;
    }
    if (!found) {
      throw ParameterError(fmt::format("the signal has no element '{}': it has {}", name,
                                       elements.size() < 2 ? "but one, give none" : NamesOf(elements)));
    }
  }
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < elements.size(); ++i)
    if (chosen[i] && (elements[i].is_real || !real_only)) indices.push_back(i);
  if (indices.empty()) {
    throw ParameterError(
        "the signal has no number that this kind of fault could change: choose stuck, late or lost, "
        "or set the size of `initial` if it is known only at run time");
  }
  return indices;
}

void CheckCount(std::size_t found, std::size_t expected) {
  if (found == expected) return;
  throw RunError(
      fmt::format("u has {} numbers, but `initial` has {}: give them the same size", found, expected));
}

}  // namespace tenon::internal
