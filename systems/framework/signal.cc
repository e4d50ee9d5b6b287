#include <tenon/systems/framework/signal.h>

namespace tenon::internal {
namespace {

/// The `index`-th entry of a comma-separated list, trimmed; empty if there is none.
std::string ListEntry(const std::string& list, std::size_t index) {
  std::size_t begin = 0;
  for (; index > 0; --index) {
    begin = list.find(',', begin);
    if (begin == std::string::npos) return "";
    ++begin;
  }
  const std::size_t end = std::min(list.find(',', begin), list.size());
  const std::size_t first = list.find_first_not_of(' ', begin);
  if (first == std::string::npos || first >= end) return "";
  const std::size_t last = list.find_last_not_of(' ', end - 1);
  return list.substr(first, last - first + 1);
}

}  // namespace

std::string ElementName(const Spec& spec, Eigen::Index row, Eigen::Index col, Eigen::Index rows,
                        Eigen::Index cols) {
  if (cols > 1) return std::to_string(row) + "_" + std::to_string(col);
  if (const std::string name = ListEntry(spec.elements, static_cast<std::size_t>(row)); !name.empty()) {
    return name;
  }
  if (rows == 3) return std::string(1, "xyz"[row]);
  return std::to_string(row);
}

std::string ElementUnit(const Spec& spec, std::size_t index) {
  if (spec.units.find(',') == std::string::npos) return spec.units;
  return ListEntry(spec.units, index);
}

void Archive::Write(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  bytes_.insert(bytes_.end(), bytes, bytes + size);
}

void Archive::Read(void* data, std::size_t size) {
  if (size > bytes_.size() - cursor_) {
    throw RunError("the snapshot is cut short: " + std::to_string(bytes_.size()) + " bytes, more are needed");
  }
  std::memcpy(data, bytes_.data() + cursor_, size);
  cursor_ += size;
}

}  // namespace tenon::internal
