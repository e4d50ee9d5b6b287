// Text as the recording of a live run.

#include <tenon/systems/live/live_recording.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return tenon::fuzz::TryFile("live.jsonl", data, size,
                              [](const std::string& file) { tenon::LiveRecording::Read(file); });
}
