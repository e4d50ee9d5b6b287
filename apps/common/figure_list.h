#pragma once

#include <tenon/apps/common/command_line.h>

namespace tenon::apps {

/// Value of --figure that stands for the list of all figures.
inline constexpr const char* kListFigures = "list";

/// One of several runs that a figure compares.
struct FigureRun {
  std::string name;
  std::string scenario;          ///< empty: that of the figure
  std::vector<std::string> set;  ///< changes to the scenario, as for --set

  static FieldList Fields() {
    return {Required("name", &FigureRun::name), {"scenario", &FigureRun::scenario}, {"set", &FigureRun::set}};
  }
};

/// A figure of the thesis: a scenario, and the plots or the picture that show it.
struct ThesisFigure {
  std::string number;  ///< number in the thesis, "2.5"
  std::string app;     ///< app of its scenario
  std::string title;
  std::string thesis;  ///< result that the thesis reports
  std::string scenario;
  std::vector<std::string> set;    ///< changes to the scenario, as for --set
  std::vector<FigureRun> runs;     ///< compared runs; empty: one run
  std::vector<Plot> plots;         ///< contents of the report
  std::vector<double> pictures_s;  ///< times of pictures of the replay

  static FieldList Fields() {
    return {Required("number", &ThesisFigure::number),
            Required("app", &ThesisFigure::app),
            Required("title", &ThesisFigure::title),
            Required("thesis", &ThesisFigure::thesis),
            Required("scenario", &ThesisFigure::scenario),
            {"set", &ThesisFigure::set},
            {"runs", &ThesisFigure::runs},
            {"plots", &ThesisFigure::plots},
            Field("pictures_s", &ThesisFigure::pictures_s).AtLeast(0)};
  }
};

/// Reads a shipped list of figures, or a file. Throws ParameterError.
std::vector<ThesisFigure> LoadFigures(const std::string& name);

/// Lists the figures of an app, or runs the scenario of the figure that the command line names and saves its
/// plots and pictures as files, if Chromium is installed, beside the report. Returns the exit code of the
/// runs. Throws ParameterError with the list for an unknown number.
int RunFigure(const ScenarioApp& app, const CommonArguments& arguments);

}  // namespace tenon::apps
