// Modules: shared objects beside the program that bring heavy libraries (OpenImageIO, FFmpeg, Draco, Assimp), loaded at
// first use.
#pragma once
#include <string>

namespace crowdbench {

// The address of `symbol` in `crowdbench_<name>.so` beside the program, loading it on the first call. Throws Error that
// says `purpose` and what to do when the module or a library that it needs is absent (it is, in a bundle).
void* module_symbol(const std::string& name, const std::string& symbol, const std::string& purpose);

}  // namespace crowdbench
