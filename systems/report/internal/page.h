#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tenon::internal {

/// Throws RunError that names the Debian package if three.js or Dygraphs is not where it should be.
void CheckPageParts();

/// Of the data in the page of runs; another number for each change that Report::Read cannot read.
inline constexpr int kPageFormat = 2;

/// The data that a page holds as JSON; throws std::out_of_range if there are none.
std::string_view DataOf(std::string_view page);

enum class PageKind { kRun, kCampaign, kVolume };

/// The page: our template with style, libraries, data and our scripts put in. Throws RunError.
std::string MakePage(const std::string& title, std::string data_json, PageKind kind = PageKind::kRun);

/// Writes it.
void WritePage(const std::filesystem::path& file, const std::string& title, std::string data_json,
               PageKind kind = PageKind::kRun);

}  // namespace tenon::internal
