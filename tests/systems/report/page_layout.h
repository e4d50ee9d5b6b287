#pragma once

#include <tenon/tests/systems/report/browser.h>

namespace tenon::testing {

/// Faults in the layout of the page that the browser shows, in windows of 1280 x 800 and of 1600 x 900
/// pixels. Empty if, in both,
///
///   - the page does not scroll sideways, and no text of the header, of a button or of a table is cut off;
///   - panels that stand side by side, or below each other, fill their row, do not overlap, and none is a
///   sliver;
///   - the replay, the plots and the slices fit into their panels;
///   - a table of several runs scrolls in its own box and keeps the names of figures and runs in sight;
///   - nothing is blank in a screenshot.
std::vector<std::string> LayoutFaults(Browser& browser);

/// The visible controls of the page that have no name for a screen reader, as HTML.
nlohmann::json UnnamedControls(Browser& browser);

/// The data in a page that a report wrote.
nlohmann::json DataOf(const std::filesystem::path& file);

}  // namespace tenon::testing
