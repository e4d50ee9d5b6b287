#pragma once

#include <tenon/systems/live/live_recording.h>

#include <nlohmann/json.hpp>

#include <fstream>

namespace tenon::internal {

/// Sets the values of an entry in order. Throws as Context::SetDoubles does, and Error for an unknown path.
void ApplyEntry(Context& context, const LiveEntry& entry);

/// Reads a seed. Throws std::out_of_range unless it is an integer from 0 to 2^64 - 1.
inline std::uint64_t ReadSeed(const nlohmann::ordered_json& json) {
  if (!json.is_number_unsigned())
    throw std::out_of_range("a seed must be an integer from 0 to 18446744073709551615");
  return json.get<std::uint64_t>();
}

/// Writes a recording during the run; the file is complete after every entry.
class LiveFile {
 public:
  /// Writes nothing if the name is empty. Throws OutputError.
  LiveFile(std::filesystem::path file, std::uint64_t seed);
  void Add(LiveEntry entry);
  /// Removes the entries at `time` [s] and later.
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
