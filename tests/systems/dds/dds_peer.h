#pragma once

#include <tenon/systems/dds/dds.h>

#include <dds/dds.h>
#include <gtest/gtest.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <exception>

namespace tenon::test {

/// A domain on this machine, which tests that run at the same time do not share.
const DdsLink kOwnLink{.domain = 20 + getpid() % 200, .interface = "lo"};

/// A second participant in the domain that a block of this process has joined, in the role of another
/// program.
class DdsPeer {
 public:
  DdsPeer(const std::string& topic, const dds_topic_descriptor_t& descriptor)
      : participant_(dds_create_participant(static_cast<dds_domainid_t>(kOwnLink.domain), nullptr, nullptr)) {
    const dds_entity_t made = dds_create_topic(participant_, &descriptor, topic.c_str(), nullptr, nullptr);
    writer_ = dds_create_writer(participant_, made, nullptr, nullptr);
    EXPECT_GT(writer_, 0);
  }
  ~DdsPeer() { dds_delete(participant_); }
  DdsPeer(const DdsPeer&) = delete;
  DdsPeer& operator=(const DdsPeer&) = delete;

  /// Sends a message; a reader in this process has it on return. `time` is that of the sender's clock [s].
  void Send(const void* message, double time) const {
    EXPECT_EQ(dds_write_ts(writer_, message, static_cast<dds_time_t>(time * 1e9)), DDS_RETCODE_OK);
  }

 private:
  dds_entity_t participant_, writer_ = 0;
};

/// Runs a function in a second process, for at most a minute; this process must not have joined DDS before.
class SecondProcess {
 public:
  explicit SecondProcess(const std::function<void()>& body) : child_(fork()) {
    if (child_ != 0) return;
    alarm(60);  // ends a process that hangs
    try {
      body();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "second process: %s\n", error.what());
      _exit(1);
    }
    _exit(0);
  }
  ~SecondProcess() {
    if (child_ <= 0) return;
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  SecondProcess(const SecondProcess&) = delete;
  SecondProcess& operator=(const SecondProcess&) = delete;

  void Signal(int signal) const { kill(child_, signal); }
  /// Waits for its end; true if its function returned.
  bool Succeeds() {
    int status = 1;
    waitpid(child_, &status, 0);
    child_ = 0;
    return status == 0;
  }

 private:
  pid_t child_;
};

/// Repeats a step until it returns true; false after ten seconds.
inline bool Within10s(const std::function<bool()>& step) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < end)
    if (step()) return true;
  return false;
}

}  // namespace tenon::test
