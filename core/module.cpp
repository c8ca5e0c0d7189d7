#include "core/module.h"

#include <dlfcn.h>

#include <map>
#include <mutex>

#include "core/error.h"
#include "core/files.h"

namespace crowdbench {

void* module_symbol(const std::string& name, const std::string& symbol, const std::string& purpose) {
  static std::mutex mutex;
  static std::map<std::string, void*> loaded;
  const std::scoped_lock lock(mutex);
  void*& handle = loaded[name];
  if (!handle) {
    const auto path = program_directory() / fmt::format("crowdbench_{}.so", name);
    handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
      const char* reason = ::dlerror();
      throw Error(
          path.filename().string(),
          fmt::format("{} needs this module, which cannot be loaded ({})", purpose, reason ? reason : "unknown reason"),
          "use a full build (./run build) instead of the bundle");
    }
  }
  void* address = ::dlsym(handle, symbol.c_str());
  if (!address) throw Error(fmt::format("crowdbench_{}.so", name), "has no " + symbol, "rebuild with ./run build");
  return address;
}

}  // namespace crowdbench
