#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

namespace tenon::internal {

/// Size of the C struct that idlc makes of a message: its texts are pointers, its lists dds_sequence_t.
std::size_t SizeOfC(const TypeInfo& type);

/// Writes a signal as this struct to the beginning of `memory`, which it resizes. The texts and lists of
/// numbers stay those of the signal, which must exist as long as the struct.
void WriteC(const TypeInfo& type, const void* signal, std::vector<char>& memory);

/// Reads such a struct. Lists keep their lengths: returns an empty text, or the name of the first list whose
/// length is another one, with both lengths. The signal is then incomplete.
std::string ReadC(const TypeInfo& type, const void* message, void* signal);

}  // namespace tenon::internal
