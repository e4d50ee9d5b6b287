#include <tenon/apps/common/columns.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

#include <algorithm>

namespace tenon::apps {

namespace logged {

LoggedPart PartOf(const Source& port) {
  return {port.path(), port.spec().elements};
}

LoggedPart MemberOf(const LoggedPart& part, const internal::TypeInfo& type, std::size_t offset,
                    const internal::TypeInfo& member) {
  const auto field = std::ranges::find_if(
      type.fields, [&](const Field& each) { return each.offset == offset && &each.type() == &member; });
  if (field == type.fields.end())
    throw BuildError(
        fmt::format("'{}' has no column for a member of {} that its Fields() lacks: describe the "
                    "member, or read another one",
                    part.name, TypeName(type)));
  return {part.name + "." + field->name, field->elements};
}

LoggedPart ItemOf(const LoggedPart& part, std::size_t item) {
  // The items of a list have the names that a log gives them.
  const std::vector<double> list(item + 1);
  const std::vector<Element> items =
      internal::ListElements(internal::TypeInfoOf<std::vector<double>>(), &list, Spec("", "", part.items));
  return {part.name + "." + items.back().name, ""};
}

std::vector<std::size_t> Columns(const std::vector<std::string>& names, const std::string& signal) {
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == signal || names[i].starts_with(signal + ".")) columns.push_back(i);
  if (columns.empty()) throw Error(fmt::format("the log has no signal '{}'", signal));
  return columns;
}

std::size_t Column(const std::vector<std::string>& names, const std::string& signal) {
  return Columns(names, signal).front();
}

}  // namespace logged
}  // namespace tenon::apps
