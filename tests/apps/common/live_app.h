#pragma once

#include <tenon/tests/apps/run_app.h>

#include <httplib.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <regex>

namespace tenon::test {

using Json = nlohmann::json;

/// An app that runs live while a test talks to it.
struct LiveAppTest : AppTest {
  /// Starts the app and waits for its address.
  void Start(const std::string& command) {
    // If the test fails, timeout(1) ends the app.
    pipe_ = popen(("exec timeout 240 " + command + " </dev/null 2>&1").c_str(), "r");
    ASSERT_NE(pipe_, nullptr);
    char line[256];
    ASSERT_NE(std::fgets(line, sizeof(line), pipe_), nullptr);
    std::cmatch port;
    ASSERT_TRUE(std::regex_search(line, port, std::regex("(http://127.0.0.1:(\\d+))/"))) << line;
    address = port[1];
    client_ = std::make_unique<httplib::Client>("127.0.0.1", std::stoi(port[2]));
  }
  Json Command(const std::string& json) {
    const auto answer = client_->Post("/command?client=test", json, "application/json");
    return answer ? Json::parse(answer->body) : Json();
  }
  int End() {
    char text[4096];
    while (std::fread(text, 1, sizeof(text), pipe_) > 0) {
    }
    return WEXITSTATUS(pclose(pipe_));
  }
  /// Replays the recording and expects the signals of the live run, bit for bit.
  void ExpectSameReplay(const std::string& command) const {
    const Result replay = RunCommand(command + " --replay " + (out / "live.jsonl").string() + " --out " +
                                     (out / "again").string());
    EXPECT_EQ(replay.exit_code, 0) << replay.text;
    EXPECT_FALSE(Signals().empty());
    EXPECT_EQ(Signals(), ReadText(out / "again" / "signals.csv"));
  }

  std::string address;

 private:
  std::FILE* pipe_ = nullptr;
  std::unique_ptr<httplib::Client> client_;
};

}  // namespace tenon::test
