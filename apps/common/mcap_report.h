#pragma once

#include <filesystem>

namespace tenon::apps {

/// Writes report.html and signals.csv of an MCAP file into a directory: all numbers of the messages that
/// systems/ros2/messages.h describes, sampled at 100 Hz. Says on stderr which topics have other types, which
/// messages are refused, and where a damaged or truncated file ends. Returns the exit code. Throws
/// ParameterError for a file without messages to show.
int ReportMcap(const std::filesystem::path& file, const std::filesystem::path& out);

}  // namespace tenon::apps
