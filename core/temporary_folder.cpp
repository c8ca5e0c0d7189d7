#include "core/temporary_folder.h"

#include <cstdlib>
#include <system_error>

#include "core/error.h"

namespace crowdbench {
namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder(const std::string& name) {
  std::string made = (fs::temp_directory_path() / ("crowdbench-" + name + "-XXXXXX")).string();
  if (::mkdtemp(made.data()) == nullptr)
    throw Error(fs::temp_directory_path().string(), "no folder can be made there",
                "set TMPDIR to one that is writable");
  path_ = made;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace crowdbench
