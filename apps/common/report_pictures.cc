#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/tenon_report.h>
#include <tenon/systems/report/internal/browser.h>
#include <tenon/systems/report/internal/run_log.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

#include <cctype>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using internal::Browser;

constexpr int kMostFrames = 100'000;

struct Size {
  int width, height;
};

Size SizeOf(const std::string& text, Size standard) {
  if (text.empty()) return standard;
  const std::size_t x = text.find('x');
  const auto width = internal::NumberIn<int>(text.substr(0, x));
  const auto height = internal::NumberIn<int>(x == text.npos ? "" : text.substr(x + 1));
  const auto fits = [](std::optional<int> length) { return length && *length >= 100 && *length <= 4000; };
  if (!fits(width) || !fits(height))
    throw ParameterError(
        fmt::format("--size {}: write WIDTHxHEIGHT in pixels from 100 to 4000, such as 1280x720", text));
  return {*width, *height};
}

void CheckOptions(const ReportPictures& pictures) {
  const bool film = !pictures.video.empty() || !pictures.frames.empty();
  if (int(!pictures.video.empty()) + int(!pictures.frames.empty()) + int(!pictures.svg.empty()) +
          int(pictures.frame.has_value()) !=
      1)
    throw ParameterError("--video, --frames, --svg and --frame exclude each other: give one of them");
  if (!film && (pictures.from || pictures.to || pictures.fps || pictures.speed))
    throw ParameterError("--from, --to, --fps and --speed belong to --video or --frames: omit them");
  const auto check = [](const char* option, const fs::path& file, const std::vector<std::string>& endings) {
    if (std::ranges::count(endings, file.extension().string()) == 0)
      throw ParameterError(fmt::format("{} {}: name a file that ends in {}", option, file.string(),
                                       fmt::join(endings, " or ")));
    // Do not draw for minutes and then fail.
    if (!fs::is_directory(fs::absolute(file).parent_path()))
      throw OutputError(fmt::format("cannot write '{}': there is no directory '{}'", file.string(),
                                    fs::absolute(file).parent_path().string()));
  };
  if (!pictures.video.empty()) check("--video", pictures.video, {".webm"});
  if (pictures.frame) check("--frame", pictures.frame->second, {".svg", ".png"});
}

/// Returns the bytes of a data: URL in base64.
std::string BytesOf(const std::string& url) {
  return internal::DecodeBase64(url.substr(url.find(',') + 1));
}

/// Returns a file name with the number of the picture and letters, digits and underscores of its title.
std::string FileName(std::size_t number, const std::string& title) {
  std::string name;
  for (const char c : title) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-';
    if (plain || (!name.empty() && name.back() != '_')) name += plain ? c : '_';
  }
  name = name.substr(0, 80);
  if (name.ends_with('_')) name.pop_back();
  return fmt::format("{:02}_{}.svg", number, name);
}

/// The replay of a page as a sequence of pictures at a fixed rate.
class Film {
 public:
  Film(Browser& browser, const ReportPictures& pictures, double duration) : browser_(browser) {
    const Size size = SizeOf(pictures.size, {1280, 720});
    const double from = pictures.from.value_or(0), to = pictures.to.value_or(duration);
    if (!(from >= 0 && from < to && to <= duration))
      throw ParameterError(
          fmt::format("--from {} --to {}: the times must increase and lie in the run, from 0 to {} s", from,
                      to, duration));
    const double fps = pictures.fps.value_or(30), speed = pictures.speed.value_or(1);
    if ((to - from) / speed * fps > kMostFrames)
      throw ParameterError(fmt::format("--fps {} --speed {}: more than {} pictures; film a shorter time", fps,
                                       speed, kMostFrames));
    const Json options{{"width", size.width}, {"height", size.height}, {"fps", fps},
                       {"speed", speed},      {"from", from},          {"to", to}};
    count_ = browser.Evaluate(fmt::format("(window.movie = tenonReport.movie({})).count", options.dump()));
  }

  /// Calls draw(i) for each picture. Returns the number of a signal that ended this, or 0.
  int ForEach(const std::function<void(int)>& draw) const {
    ProgressLine line;
    for (int i = 0; i < count_; ++i) {
      if (SignalGuard::caught() != 0) return SignalGuard::caught();
      draw(i);
      if (line.due()) line.Show(double(i + 1) / count_, fmt::format("picture {} of {}", i + 1, count_));
    }
    line.End(1, fmt::format("{} pictures", count_));
    return SignalGuard::caught();
  }

  std::string Png(const std::string& time) const {
    return BytesOf(browser_.Evaluate(fmt::format("movie.png({}).then(dataUrl)", time)));
  }

 private:
  Browser& browser_;
  int count_ = 0;
};

}  // namespace

int DrawPictures(const fs::path& report, const ReportPictures& pictures) {
  CheckOptions(pictures);
  const fs::path page = fs::is_directory(report) ? report / "report.html" : report;
  if (!fs::is_regular_file(page))
    throw ParameterError(
        fmt::format("there is no report '{}': name a report.html, or the directory of a run", page.string()));
  const Size plots = SizeOf(pictures.size, {600, 300});
  if (!Browser::IsInstalled())
    throw ParameterError("pictures are drawn by Chromium, which is not installed: apt-get install chromium");
  const SignalGuard guard;
  Browser browser;
  browser.Prefer("light");
  browser.Open(page);
  if (browser.Evaluate("!!(window.tenonReport || window.tenonCampaign || {}).pictures") != true)
    throw ParameterError(
        fmt::format("'{}' cannot draw pictures: it is no page of a run or a campaign, or an earlier version "
                    "of Tenon wrote "
                    "it; write it again, for example with tenon-report DIR",
                    page.string()));

  if (!pictures.svg.empty()) {
    const OutputLock directory(pictures.svg);
    const Json drawn = browser.Evaluate(
        fmt::format("(window.tenonReport || tenonCampaign).pictures({}, {})", plots.width, plots.height));
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      const fs::path file = directory.path() / FileName(i + 1, drawn[i][0]);
      WriteFile(file, drawn[i][1].get<std::string>());
      fmt::print("{}\n", file.string());
    }
    return kRan;
  }
  if (browser.Evaluate("!!window.tenonReport && tenonReport.webgl") != true)
    throw ParameterError(fmt::format("'{}' has no replay; draw its plots with --svg", page.string()));
  const double duration = browser.Evaluate("tenonReport.duration()");

  if (pictures.frame) {
    const auto& [time, file] = *pictures.frame;
    if (!(time >= 0 && time <= duration))
      throw ParameterError(
          fmt::format("--frame {}: the time must lie in the run, from 0 to {} s", time, duration));
    const Film film(browser, pictures, duration);
    const bool vector = fs::path(file).extension() == ".svg";
    WriteFile(file, vector ? browser.Evaluate(fmt::format("tenonReport.picture({})", time)).get<std::string>()
                           : film.Png(fmt::format("{}", time)));
    fmt::print("{}\n", file);
    return kRan;
  }
  const Film film(browser, pictures, duration);
  if (!pictures.frames.empty()) {
    const OutputLock directory(pictures.frames);
    const auto name = [](int i) { return fmt::format("frame_{:05}.png", i); };
    // Remove the pictures of an earlier sequence, which may be longer.
    for (int i = 0; fs::remove(directory.path() / name(i)); ++i) continue;
    const int signal = film.ForEach(
        [&](int i) { WriteFile(directory.path() / name(i), film.Png(fmt::format("movie.timeOf({})", i))); });
    if (signal != 0) return 128 + signal;
    fmt::print("{}\n", (directory.path() / name(0)).string());
    return kRan;
  }
  const int signal = film.ForEach([&](int i) { browser.Evaluate(fmt::format("movie.add({})", i)); });
  if (signal != 0) return 128 + signal;
  WriteFile(pictures.video, BytesOf(browser.Evaluate("movie.file().then(dataUrl)")));
  fmt::print("{}\n", pictures.video);
  return kRan;
}

}  // namespace tenon::apps
