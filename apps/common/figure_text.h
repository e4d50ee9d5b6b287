#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tenon::apps {

/// Figures by name with their values as text, as Summary::Flat gives them.
using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// A figure as a terminal shows it.
struct FigureText {
  std::string key;  ///< as in summary.json: foot_error_max_m
  /// Its values by name, of legs or of axes; a single value has an empty name.
  NamedTexts values;
  std::string unit = {};   ///< stands behind the values; empty for a text
  std::string limit = {};  ///< stands at the end of the line
};

/// A number of four significant digits, without exponent from 0.0001 to 10 million; whole numbers have all
/// their digits. What is not finite is "-".
std::string NumberText(double value);

/// "foot_error_max_m.front_left" and its neighbours become one figure, numbers NumberText, empty texts "-".
std::vector<FigureText> FigureTexts(const NamedTexts& flat);

/// A line for each figure. Those with a value for each leg come last, as tables with a column for each leg.
std::string FigureLines(const std::vector<FigureText>& figures);

/// A line for each figure of several runs, with a column for each run, under its name. Runs that do not fit
/// into 120 columns follow below. Long texts are cut.
std::string FigureColumns(const std::vector<std::pair<std::string, NamedTexts>>& runs);

}  // namespace tenon::apps
