#include <tenon/apps/common/real_time.h>
#include <tenon/systems/simulation/real_time_thread.h>

#include <fmt/core.h>
#include <sys/utsname.h>

#include <fstream>

namespace tenon::apps {
namespace {

std::string LineOf(const char* path) {
  std::string line;
  std::getline(std::ifstream(path) >> std::ws, line);
  return line;
}

RealTimeStatistics KeepPace(double hz, double duration) {
  DiagramBuilder builder;
  const auto& clock = builder.AddFunction("clock", Uses(builder.time), [](double t) { return t; });
  Simulator simulator(builder.Build(), {.real_time_rate = 1});
  simulator.AddLog(Hz(hz), {&clock});
  simulator.RunTo(duration);
  return simulator.real_time();
}

}  // namespace

void SetTimes(const std::string& name, const TimeQuantiles& times, Summary& summary) {
  std::vector<std::pair<std::string, std::optional<double>>> quantiles;
  for (const auto& [quantile, share] : {std::pair{"p50", 0.5}, {"p99", 0.99}, {"p999", 0.999}, {"max", 1.0}})
    quantiles.emplace_back(quantile, Microseconds(times.Quantile(share)));
  std::string histogram;
  long before = 0;
  for (const int limit : times.kLimits) {
    const long below = times.Below(1e-6 * limit);
    if (below > before) histogram += fmt::format("{} below {} us, ", below - before, limit);
    before = below;
  }
  summary.Set(name + "_us", quantiles);
  summary.Set(name + "_histogram", histogram + fmt::format("{} above", times.count() - before));
}

void SetRealTime(const RealTimeStatistics& statistics, Summary& summary) {
  summary.Set("ticks_missed", static_cast<double>(statistics.missed));
  summary.Set("tick_late_max_s", statistics.worst_lateness);
  SetTimes("tick_late", statistics.lateness, summary);
  SetTimes("tick_compute", statistics.compute, summary);
}

std::pair<std::string, bool> ExamineRealTime(double duration) {
  const RealTimeThread thread;
  std::vector<std::string> remedies = thread.refused();
  std::string text;
  bool holds = remedies.empty();
  const auto add = [&](const char* name, const std::string& value) {
    text += fmt::format("{:<28} {}\n", name, value);
  };
  utsname kernel{};
  uname(&kernel);
  const std::string version = kernel.version;
  add("kernel", fmt::format("{} {}", kernel.release, version));
  if (version.find("PREEMPT_RT") == version.npos && version.find("PREEMPT RT") == version.npos)
    remedies.emplace_back(
        "this kernel is not made for real time: `sudo apt-get install linux-image-rt-amd64` bounds the "
        "lateness under load");
  const std::string isolated = LineOf("/sys/devices/system/cpu/isolated");
  add("isolated processors", isolated.empty() ? "none" : isolated);
  if (isolated.empty())
    remedies.emplace_back(
        "other programs use the processor of the thread of control: add isolcpus=N, with the number of the "
        "last processor, to GRUB_CMDLINE_LINUX in /etc/default/grub, call `sudo update-grub` and restart");
  const std::string governor = LineOf("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  add("frequency governor", governor.empty() ? "none" : governor);
  if (!governor.empty() && governor != "performance")
    remedies.emplace_back(
        "processors wake up at a low frequency: `sudo cpupower frequency-set -g performance`");
  add("real-time thread",
      thread.refused().empty() ? "permitted, with a processor and locked memory" : "refused in part");
  add("load", LineOf("/proc/loadavg"));
  for (const int hz : {500, 1000}) {
    const RealTimeStatistics pace = KeepPace(hz, duration);
    holds = holds && pace.missed == 0;
    const auto late = [&](double share) { return 1e6 * pace.lateness.Quantile(share).value_or(0); };
    add(fmt::format("{} Hz: late [us]", hz).c_str(),
        fmt::format("median {:.0f}, 99 % {:.0f}, 99.9 % {:.0f}, at most {:.0f}; {} of {} ticks missed",
                    late(0.5), late(0.99), late(0.999), 1e6 * pace.worst_lateness, pace.missed, pace.ticks));
  }
  for (const std::string& remedy : remedies) text += "- " + remedy + "\n";
  text += holds ? "This machine can hold real time at its present load.\n"
                : "This machine cannot hold real time.\n";
  return {text, holds};
}

}  // namespace tenon::apps
