#include <tenon/systems/report/internal/page_parts.h>
#include <tenon/systems/report/internal/report_json.h>
#include <tenon/systems/version.h>

#include <fmt/core.h>

#include <fstream>

namespace tenon::internal {
namespace {

namespace fs = std::filesystem;

struct Part {
  const char* slot;
  const char* file;
  const char* package;
};
constexpr Part kParts[] = {
    {"dygraph.css", "dygraphs/dygraph.min.css", "libjs-dygraphs"},
    {"dygraph.js", "dygraphs/dygraph.min.js", "libjs-dygraphs"},
    {"three.js", "three/three.min.js", "libjs-three"},
    {"OrbitControls.js", "three/examples/js/controls/OrbitControls.js", "libjs-three"},
};

fs::path FindPart(const Part& part) {
  const char* own = std::getenv("TENON_JAVASCRIPT_DIR");
  const fs::path file = fs::path(own != nullptr ? own : TENON_JAVASCRIPT_DIR) / part.file;
  if (!fs::exists(file)) {
    throw OutputError(fmt::format(
        "a report needs '{}', which does not exist: apt-get install {}, or set TENON_JAVASCRIPT_DIR to the "
        "directory that contains it",
        file.string(), part.package));
  }
  return file;
}

/// Removes the line that names a source map, because the map is not available to the page.
std::string ReadPart(const Part& part) {
  std::ifstream in(FindPart(part), std::ios::binary);
  std::string text, line;
  while (std::getline(in, line)) {
    if (line.find("# sourceMappingURL=") == std::string::npos) text += line + '\n';
  }
  return text;
}

void ReplaceAll(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

}  // namespace

std::string_view DataOf(std::string_view page) {
  constexpr std::string_view kOpen = R"(<script type="application/json" id="data">)";
  const std::size_t open = page.find(kOpen);
  if (open == page.npos) throw std::out_of_range("no page of ours");
  page.remove_prefix(open + kOpen.size());
  return page.substr(0, page.find("</script>"));
}

void CheckPageParts() {
  for (const Part& part : kParts) FindPart(part);
}

std::string MakePage(const std::string& title, std::string data_json, PageKind kind) {
  ReplaceAll(data_json, "</", "<\\/");  // so that the data cannot end its script element
  ReplaceAll(data_json, "<!--", "<\\u0021--");
  std::string escaped_title = title;
  ReplaceAll(escaped_title, "&", "&amp;");
  ReplaceAll(escaped_title, "<", "&lt;");

  std::string out;
  // Placeholders of the template have the form {{name}}.
  std::string_view rest = kPageHtml, scripts = kRunJs;
  if (kind == PageKind::kCampaign) rest = kCampaignHtml, scripts = kCampaignJs;
  if (kind == PageKind::kVolume) rest = kVolumeHtml, scripts = kVolumeJs;
  for (std::size_t open; (open = rest.find("{{")) != std::string_view::npos;) {
    out += rest.substr(0, open);
    const std::size_t close = rest.find("}}", open);
    const std::string_view slot = rest.substr(open + 2, close - open - 2);
    rest.remove_prefix(close + 2);
    if (slot == "title") out += escaped_title;
    if (slot == "version") out += Version();
    if (slot == "report.css") out += kPageCss;
    if (slot == "scripts") out += scripts;
    if (slot == "data") out += data_json;
    for (const Part& part : kParts) {
      if (slot == part.slot) out += ReadPart(part);
    }
  }
  out += rest;
  return out;
}

void WritePage(const fs::path& file, const std::string& title, std::string data_json, PageKind kind) {
  WriteFile(file, MakePage(title, std::move(data_json), kind));
}

}  // namespace tenon::internal
