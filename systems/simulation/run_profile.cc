#include <tenon/systems/simulation/run_profile.h>

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <map>

namespace tenon {

std::vector<RunProfile::Entry> RunProfile::Blocks() const {
  std::map<std::string, Entry> blocks;
  for (const Entry& each : calculations) {
    // "d/dt x" and "next x" contain no dot, so the last dot ends the path of the block.
    const std::string path = each.path.substr(0, each.path.rfind('.'));
    Entry& block = blocks[path];
    block.path = path;
    block.calls += each.calls;
    block.seconds += each.seconds;
  }
  std::vector<Entry> sorted;
  for (auto& [path, block] : blocks) sorted.push_back(std::move(block));
  std::ranges::stable_sort(sorted, std::greater<>(), &Entry::seconds);
  return sorted;
}

std::string RunProfile::Text() const {
  constexpr std::size_t kRows = 20;
  const auto part = [&](double seconds) { return total > 0 ? 100 * seconds / total : 0.0; };
  double computed = 0;
  for (const Entry& each : calculations) computed += each.seconds;
  std::string text = fmt::format("{:.3f} s, of these\n", total);
  const std::pair<const char*, double> parts[] = {{"calculations", computed},
                                                  {"integrator", integrator},
                                                  {"ticks: schedule, updates, checks", ticks},
                                                  {"logs", logs},
                                                  {"waiting for the clock", waiting}};
  for (const auto& [name, seconds] : parts) text += fmt::format("  {:5.1f} %  {}\n", part(seconds), name);
  const auto list = [&](const char* title, const std::vector<Entry>& entries) {
    text += fmt::format("{}\n", title);
    for (std::size_t i = 0; i < std::min(entries.size(), kRows); ++i) {
      const Entry& each = entries[i];
      text +=
          fmt::format("  {:5.1f} %  {:>10} calls  {:8.3f} us each  {}\n", part(each.seconds), each.calls,
                      each.calls > 0 ? 1e6 * each.seconds / static_cast<double>(each.calls) : 0.0, each.path);
    }
  };
  list("blocks", Blocks());
  list("calculations", calculations);
  return text;
}

}  // namespace tenon
