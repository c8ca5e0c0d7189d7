// SHA-256's compression of whole blocks by the processor's own instructions, several times as fast as any other code.
#pragma once
#include <cstddef>
#include <cstdint>

namespace crowdbench {

// Whether this processor has the instructions.
bool has_sha256_instructions();

// Takes `blocks` blocks of 64 bytes each into the eight words of the state. Only where has_sha256_instructions().
void compress_sha256(uint32_t* state, const uint8_t* data, size_t blocks);

}  // namespace crowdbench
