#pragma once

#include <filesystem>
#include <string>

namespace tenon::internal {

/// Throws RunError that names the Debian package if three.js or Dygraphs is not where it should be.
void CheckPageParts();

enum class PageKind { kRun, kCampaign };

/// Writes the page: our template with style, libraries, data and our scripts put in. Throws RunError.
void WritePage(const std::filesystem::path& file, const std::string& title, std::string data_json,
               PageKind kind = PageKind::kRun);

}  // namespace tenon::internal
