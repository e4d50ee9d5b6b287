#include <tenon/systems/files/output_file.h>
#include <tenon/systems/report/internal/browser.h>

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <sstream>

namespace tenon::internal {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr const char* kChromium = "chromium";
constexpr int kPatience = 600;  // seconds for one answer: only a browser that hangs takes longer

}  // namespace

bool Browser::IsInstalled() {
  const char* path = std::getenv("PATH");
  std::istringstream directories(path == nullptr ? "" : path);
  for (std::string directory; std::getline(directories, directory, ':');)
    if (access((fs::path(directory) / kChromium).c_str(), X_OK) == 0) return true;
  return false;
}

Browser::Browser(const std::vector<std::string>& more_arguments) {
  std::string profile = (fs::temp_directory_path() / "tenon_browser_XXXXXX").string();
  if (mkdtemp(profile.data()) == nullptr)
    throw OutputError("cannot create a directory for the profile of chromium: is the disk full?");
  profile_ = profile;

  std::vector<std::string> arguments{kChromium,
                                     "--headless=new",
                                     "--remote-debugging-pipe",
                                     "--user-data-dir=" + profile,
                                     "--disable-quic",
                                     "--no-first-run",
                                     "--disable-background-networking",
                                     "--disable-component-update",
                                     "--disable-sync",
                                     "--disable-breakpad",
                                     "--disable-dev-shm-usage",
                                     "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
                                     "--use-gl=angle",
                                     "--use-angle=swiftshader",
                                     "--enable-unsafe-swiftshader"};
  if (geteuid() == 0) arguments.emplace_back("--no-sandbox");  // root has no sandbox
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  int to[2], from[2];
  if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0)
    throw OutputError("cannot create a pipe to chromium");
  process_ = fork();
  if (process_ == 0) {
    setpgid(0, 0);
    // The browser reads commands from descriptor 3 and answers on 4; move ours out of the way first.
    const int commands = fcntl(to[0], F_DUPFD, 10), answers = fcntl(from[1], F_DUPFD, 10);
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    dup2(commands, 3);
    dup2(answers, 4);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  close(to[0]);
  close(from[1]);
  to_ = to[1];
  from_ = from[0];
  signal(SIGPIPE, SIG_IGN);

  try {
    const Json target = Call("Target.createTarget", {{"url", "about:blank"}});
    const Json attached =
        Call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}});
    session_ = attached.at("sessionId");
    for (const char* domain : {"Page", "Runtime", "Log", "Network"}) Call(std::string(domain) + ".enable");
    Resize(1400, 900);
  } catch (...) {
    Stop();
    throw;
  }
}

Browser::~Browser() {
  Stop();
}

/// The process group holds the browser's helpers, too.
void Browser::Stop() {
  kill(-process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  close(to_);
  close(from_);
  std::error_code ignored;
  fs::remove_all(profile_, ignored);
}

Json Browser::Receive() {
  for (;;) {
    if (const std::size_t end = received_.find('\0'); end != std::string::npos) {
      Json message = Json::parse(received_.substr(0, end));
      received_.erase(0, end + 1);
      return message;
    }
    pollfd waiting{from_, POLLIN, 0};
    const int ready = poll(&waiting, 1, kPatience * 1000);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) throw OutputError("chromium does not answer");
    std::array<char, 65536> buffer;
    const ssize_t size = read(from_, buffer.data(), buffer.size());
    if (size <= 0)
      throw OutputError("chromium ended; check whether it starts: chromium --headless about:blank");
    received_.append(buffer.data(), static_cast<std::size_t>(size));
  }
}

void Browser::Note(const Json& event) {
  const std::string method = event.value("method", "");
  const Json params = event.value("params", Json::object());
  if (method == "Page.loadEventFired") loaded_ = true;
  if (method == "Runtime.exceptionThrown") complaints_.push_back(params.at("exceptionDetails").dump());
  if (method == "Runtime.consoleAPICalled") {
    const std::string type = params.at("type");
    const std::string text = params.at("args").dump();
    // Dygraphs 2.2 warns of curves that leave a plot with limits.
    const bool leaves = text.find("points out of Y bounds") != text.npos;
    if (!leaves && (type == "error" || type == "warning" || type == "assert")) complaints_.push_back(text);
  }
  if (method == "Log.entryAdded") {
    const std::string level = params.at("entry").at("level");
    if (level == "error" || level == "warning") complaints_.push_back(params.at("entry").at("text"));
  }
  if (method == "Network.requestWillBeSent") {
    const std::string url = params.at("request").at("url");
    if (!url.starts_with("data:") && !url.starts_with("blob:")) requests_.push_back(url);
  }
}

Json Browser::Call(const std::string& method, Json params) {
  Json message{{"id", ++last_id_}, {"method", method}, {"params", std::move(params)}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump() + '\0';
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t size = write(to_, text.data() + sent, text.size() - sent);
    if (size <= 0)
      throw OutputError("chromium ended; check whether it starts: chromium --headless about:blank");
    sent += static_cast<std::size_t>(size);
  }
  for (;;) {
    const Json answer = Receive();
    if (answer.value("id", 0) == last_id_) {
      if (answer.contains("error")) throw OutputError(method + ": " + answer["error"].dump());
      return answer.at("result");
    }
    Note(answer);
  }
}

void Browser::Resize(int width, int height) {
  Call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

void Browser::Prefer(const std::string& color_scheme) {
  const Json feature{{"name", "prefers-color-scheme"}, {"value", color_scheme}};
  Call("Emulation.setEmulatedMedia", {{"features", Json::array({feature})}});
}

void Browser::Open(const fs::path& file) {
  std::string url = "file://";
  for (const char c : fs::absolute(file).string()) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = std::isalnum(byte) != 0 || std::string_view("/-_.~").find(c) != std::string_view::npos;
    url += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  Navigate(url);
}

void Browser::Navigate(const std::string& url) {
  loaded_ = false;
  Call("Page.navigate", {{"url", url}});
  while (!loaded_) Note(Receive());
}

Json Browser::Evaluate(const std::string& expression) {
  const Json answer =
      Call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (answer.contains("exceptionDetails")) throw OutputError(answer["exceptionDetails"].dump());
  return answer.at("result").value("value", Json());
}

void Browser::Click(double x, double y) {
  for (const char* type : {"mouseMoved", "mousePressed", "mouseReleased"}) Mouse(type, x, y);
}

void Browser::Mouse(const std::string& type, double x, double y) {
  Call("Input.dispatchMouseEvent",
       {{"type", type}, {"x", x}, {"y", y}, {"button", "left"}, {"clickCount", 1}});
}

void Browser::Press(const std::string& key, bool shift) {
  for (const char* type : {"rawKeyDown", "keyUp"}) Key(type, key, shift);
}

void Browser::Key(const std::string& type, const std::string& key, bool shift) {
  Call("Input.dispatchKeyEvent", {{"type", type}, {"key", key}, {"modifiers", shift ? 8 : 0}});
}

std::string Browser::Screenshot() {
  return Call("Page.captureScreenshot", {{"format", "png"}}).at("data");
}

}  // namespace tenon::internal
