#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tenon::testing {

/// A headless Chromium without network, driven over a pipe by the DevTools protocol. A new one for each test:
/// it starts from an empty profile, and the destructor ends it.
class Browser {
 public:
  static bool IsInstalled();

  /// Throws std::runtime_error if it does not start, as do all members if it does not answer.
  explicit Browser(const std::vector<std::string>& more_arguments = {});
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Opens a file in a window of 1400 x 900 and waits until it is loaded.
  void Open(const std::filesystem::path& file);
  /// The value of a JavaScript expression; a promise is awaited. Throws with the text of an exception.
  nlohmann::json Evaluate(const std::string& expression);
  /// Moves the mouse to a place in the window, presses and releases its left button.
  void Click(double x, double y);
  /// Saves what is to be seen as PNG.
  void Screenshot(const std::filesystem::path& file);

  /// Errors and warnings on the console, and exceptions, so far.
  const std::vector<std::string>& complaints() const { return complaints_; }
  /// Everything that the page asked for, the page included; data that lies in the page itself is left out.
  const std::vector<std::string>& requests() const { return requests_; }

 private:
  nlohmann::json Call(const std::string& method, nlohmann::json params = nlohmann::json::object());
  nlohmann::json Receive();
  void Note(const nlohmann::json& event);
  void Stop();

  int to_ = -1, from_ = -1, process_ = -1;
  std::filesystem::path profile_;
  std::string received_;
  std::string session_;
  int last_id_ = 0;
  bool loaded_ = false;
  std::vector<std::string> complaints_, requests_;
};

}  // namespace tenon::testing
