#include <tenon/systems/network/internal/lcm_filter.h>
#include <tenon/systems/text/parse_number.h>

#include <lcm/lcm.h>
#include <linux/filter.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <system_error>

namespace tenon::internal {
namespace {

// Places in a datagram, which the kernel passes with its UDP header [bytes]. A small message is one datagram:
// magic number, sequence number, channel, data. Others are divided: magic number, sequence number, size of
// the message, offset of this fragment, number of this fragment, number of fragments, data; the first
// fragment has the channel before its data.
constexpr std::uint32_t kMagic = 8, kSmallChannel = 16;
constexpr std::uint32_t kSize = 16, kOffset = 20, kNumber = 24, kFragments = 26, kDivided = 28;
constexpr std::uint32_t kSmall = 0x4c433032, kLarge = 0x4c433033;  // "LC02", "LC03"

/// Writes a program for the kernel's packet filter, which has an accumulator A and an index X. A load beyond
/// the end of the datagram drops it.
class Filter {
 public:
  void Do(unsigned code, std::uint32_t k = 0) {
    program_.push_back(BPF_STMT(static_cast<std::uint16_t>(code), k));
  }
  /// Drops the datagram if the comparison of A holds.
  void DropIf(unsigned comparison, std::uint32_t k = 0) {
    program_.push_back(BPF_JUMP(static_cast<std::uint16_t>(BPF_JMP | comparison), k, 0, 1));
    Drop();
  }
  void Drop() { Do(BPF_RET | BPF_K, 0); }
  void Pass() { Do(BPF_RET | BPF_K, 1 << 18); }
  /// Skips what `body` writes unless A is `k`.
  template <class Body>
  void If(std::uint32_t k, const Body& body) {
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, k, 1, 0));
    const std::size_t jump = program_.size();
    Do(BPF_JMP | BPF_JA);
    body();
    program_[jump].k = static_cast<std::uint32_t>(program_.size() - jump - 1);
  }
  /// Sets X to the size of a channel with its terminating zero, or drops the datagram.
  void MeasureChannel(std::uint32_t at) {
    std::vector<std::size_t> jumps;
    for (std::uint32_t i = 0; i <= LCM_MAX_CHANNEL_NAME_LENGTH; ++i) {
      Do(BPF_LD | BPF_B | BPF_ABS, at + i);
      If(0, [&] {
        Do(BPF_LDX | BPF_IMM, i + 1);
        jumps.push_back(program_.size());
        Do(BPF_JMP | BPF_JA);
      });
    }
    Drop();
    for (const std::size_t jump : jumps)
      program_[jump].k = static_cast<std::uint32_t>(program_.size() - jump - 1);
  }
  void AttachTo(int socket) {
    const sock_fprog program{static_cast<unsigned short>(program_.size()), program_.data()};
    ::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);
  }

 private:
  std::vector<sock_filter> program_;
};

}  // namespace

std::vector<int> SharedUdpSockets() {
  std::vector<int> sockets;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", ignored)) {
    const int file = NumberIn<int>(entry.path().filename().string()).value_or(-1);
    const auto option = [file](int name) {
      int value = 0;
      socklen_t size = sizeof value;
      return ::getsockopt(file, SOL_SOCKET, name, &value, &size) == 0 ? value : 0;
    };
    if (option(SO_TYPE) == SOCK_DGRAM && option(SO_REUSEADDR) != 0) sockets.push_back(file);
  }
  return sockets;
}

void DropMalformedDatagrams(int socket) {
  Filter filter;
  filter.Do(BPF_LD | BPF_W | BPF_ABS, kMagic);
  filter.If(kSmall, [&] {
    filter.MeasureChannel(kSmallChannel);
    filter.Pass();
  });
  filter.If(kLarge, [&] {
    constexpr std::uint32_t kEnd = 0;  // where the filter keeps the end of the fragment
    filter.Do(BPF_LD | BPF_H | BPF_ABS, kFragments);
    filter.Do(BPF_MISC | BPF_TAX);
    filter.Do(BPF_LD | BPF_H | BPF_ABS, kNumber);
    filter.DropIf(BPF_JGE | BPF_X);
    filter.Do(BPF_LDX | BPF_IMM, 0);
    filter.If(0, [&] { filter.MeasureChannel(kDivided); });
    // The data's size is that of the datagram without what comes before it.
    filter.Do(BPF_LD | BPF_W | BPF_LEN);
    filter.Do(BPF_ALU | BPF_SUB | BPF_K, kDivided);
    filter.Do(BPF_ALU | BPF_SUB | BPF_X);
    filter.Do(BPF_MISC | BPF_TAX);
    filter.Do(BPF_LD | BPF_W | BPF_ABS, kOffset);
    filter.DropIf(BPF_JGT | BPF_K, LCM_MAX_MESSAGE_SIZE);
    filter.Do(BPF_ALU | BPF_ADD | BPF_X);
    filter.Do(BPF_ST, kEnd);
    filter.Do(BPF_LD | BPF_W | BPF_ABS, kSize);
    filter.DropIf(BPF_JGT | BPF_K, LCM_MAX_MESSAGE_SIZE);
    filter.Do(BPF_MISC | BPF_TAX);
    filter.Do(BPF_LD | BPF_MEM, kEnd);
    filter.DropIf(BPF_JGT | BPF_X);
    filter.Pass();
  });
  filter.Drop();
  filter.AttachTo(socket);
}

}  // namespace tenon::internal
