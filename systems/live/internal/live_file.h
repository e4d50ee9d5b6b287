#pragma once

#include <tenon/systems/live/live_recording.h>

#include <filesystem>
#include <fstream>
#include <vector>

namespace tenon::internal {

/// Sets the values of an entry, one after the other; throws what Context::SetDoubles throws, and Error for an
/// unknown path.
void ApplyEntry(Context& context, const LiveEntry& entry);

/// Writes a recording as the run goes on: after every entry the file is whole.
class LiveFile {
 public:
  /// Nothing is written without a name. Throws OutputError.
  LiveFile(std::filesystem::path file, std::uint64_t seed);
  void Add(LiveEntry entry);
  /// Forgets what was set at `time` [s] and later.
  void DropFrom(double time);
  void End(double time, bool tick);
  const std::vector<LiveEntry>& entries() const { return recording_.entries; }

 private:
  void Rewrite();
  void Line(const std::string& text);
  std::filesystem::path file_;
  std::ofstream out_;
  LiveRecording recording_;
};

}  // namespace tenon::internal
