#pragma once

#include <vector>

namespace tenon::internal {

/// Returns the UDP sockets of this process that share their port with other programs, as LCM's do.
std::vector<int> SharedUdpSockets();

/// Lets the kernel drop what is no datagram of LCM before LCM 1.3.1 reads it: LCM trusts the sizes in a
/// datagram and writes fragments beyond their message. A datagram passes if its channel ends within 63
/// characters and its fragment lies within the message, which has at most 256 MiB.
void DropMalformedDatagrams(int socket);

}  // namespace tenon::internal
