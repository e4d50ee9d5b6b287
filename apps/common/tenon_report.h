#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

namespace tenon::apps {

/// The pictures that a command line requests from a report. Exactly one of the first four is given.
struct ReportPictures {
  std::string video{};                                    ///< .webm file
  std::string frames{};                                   ///< directory of a PNG sequence
  std::string svg{};                                      ///< directory of all plots or drawings
  std::optional<std::pair<double, std::string>> frame{};  ///< time [s], and an .svg or .png file
  std::string size{};                  ///< "WIDTHxHEIGHT" in pixels; empty: 1280x720, of plots 600x300
  std::optional<double> from{}, to{};  ///< of the run [s]; default: the whole run
  std::optional<double> fps{};         ///< frames per second of the video; default: 30
  std::optional<double> speed{};       ///< seconds of the run per second of the video; default: 1

  bool any() const { return !video.empty() || !frames.empty() || !svg.empty() || frame.has_value(); }
};

/// Draws the pictures in a headless Chromium from a page of a run or of a campaign, which is a file or is
/// report.html in a directory. Each file appears under its name when it is complete. Returns an exit code;
/// SIGINT and SIGTERM end the work after the picture that is being drawn. Throws ParameterError for options
/// that do not fit together or do not fit the page, for a page without the scripts of this version, and if
/// Chromium is missing; OutputError if Chromium fails or a file cannot be written.
int DrawPictures(const std::filesystem::path& report, const ReportPictures& pictures);

/// Writes report.html and signals.csv of an MCAP file into a directory: all numbers of the messages that
/// systems/ros2/messages.h describes, sampled at 100 Hz. Says on stderr which topics have other types, which
/// messages are refused, and where a damaged or truncated file ends. Returns the exit code. Throws
/// ParameterError for a file without messages to show.
int ReportMcap(const std::filesystem::path& file, const std::filesystem::path& out);

}  // namespace tenon::apps
