#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace tenon::internal {

/// A headless Chromium that reaches this machine alone, driven over a pipe by the DevTools protocol. It
/// starts from an empty profile, and the destructor ends it.
class Browser {
 public:
  /// Whether the PATH has the program `chromium`.
  static bool IsInstalled();

  /// Throws OutputError if it does not start, as do all members if it does not answer.
  explicit Browser(const std::vector<std::string>& more_arguments = {});
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Sets the size of the window, initially 1400 x 900.
  void Resize(int width, int height);
  /// Sets the preferred colour scheme: "light" or "dark".
  void Prefer(const std::string& color_scheme);
  /// Opens a file and waits until it is loaded.
  void Open(const std::filesystem::path& file);
  /// Opens an address such as "http://127.0.0.1:8080" and waits until it is loaded.
  void Navigate(const std::string& url);
  /// The value of a JavaScript expression; a promise is awaited. Throws with the text of an exception.
  nlohmann::json Evaluate(const std::string& expression);
  /// Moves the mouse to a place in the window, presses and releases its left button.
  void Click(double x, double y);
  /// One step of a press or a drag: type is "mousePressed", "mouseMoved" with the left button down, or
  /// "mouseReleased".
  void Mouse(const std::string& type, double x, double y);
  /// Half of a press: type is "rawKeyDown" or "keyUp".
  void Key(const std::string& type, const std::string& key, bool shift = false);
  /// Presses a key, called as in KeyboardEvent.key.
  void Press(const std::string& key, bool shift = false);
  /// The visible page, as PNG in base64.
  std::string Screenshot();

  /// Errors and warnings on the console, and exceptions, so far.
  const std::vector<std::string>& complaints() const { return complaints_; }
  /// Addresses of all requests of the page, the page included, except data: and blob: addresses.
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

}  // namespace tenon::internal
