// Text as the recording of a live run.

#include <tenon/systems/live/live_recording.h>
#include <tenon/tests/fuzz/refusals.h>
#include <tenon/tests/fuzz/scratch.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tenon::fuzz::Scratch kScratch;
  const std::string file = kScratch.Write("live.jsonl", {reinterpret_cast<const char*>(data), size});
  return tenon::fuzz::Try(file, [&] { tenon::LiveRecording::Read(file); });
}
