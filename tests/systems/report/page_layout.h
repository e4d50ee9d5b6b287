#pragma once

#include <tenon/tests/systems/report/browser.h>

#include <string>
#include <vector>

namespace tenon::testing {

/// Faults in the layout of the page that the browser shows, in windows of 1280 x 800 and of 1600 x 900
/// pixels. Empty if, in both,
///
///   - the page does not scroll sideways, and no text of the header, of a button or of a table is cut off;
///   - panels that stand side by side, or below each other, fill their row, do not overlap, and none is a
///   sliver;
///   - the replay, the plots and the slices fit into what holds them;
///   - a table of several runs scrolls in its own box and keeps the names of figures and runs in sight;
///   - nothing is blank in a screenshot.
std::vector<std::string> LayoutFaults(Browser& browser);

}  // namespace tenon::testing
