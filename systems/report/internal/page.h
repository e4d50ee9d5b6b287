#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tenon::internal {

/// Throws RunError with the Debian package to install if three.js or Dygraphs is missing.
void CheckPageParts();

/// Version of the data in a page of runs; it changes whenever Report::Read cannot read earlier pages.
inline constexpr int kPageFormat = 2;

/// Returns the JSON data of a page. Throws std::out_of_range if there are none.
std::string_view DataOf(std::string_view page);

enum class PageKind { kRun, kCampaign, kVolume };

/// Returns the page: the template with style, libraries, data and scripts inserted. Throws RunError.
std::string MakePage(const std::string& title, std::string data_json, PageKind kind = PageKind::kRun);

/// Writes the page. Throws RunError and OutputError.
void WritePage(const std::filesystem::path& file, const std::string& title, std::string data_json,
               PageKind kind = PageKind::kRun);

}  // namespace tenon::internal
