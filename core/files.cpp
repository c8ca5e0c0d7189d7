#include "core/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <set>

#include "core/error.h"

namespace crowdbench {
namespace fs = std::filesystem;
namespace {

std::string reason() { return std::strerror(errno); }

struct Descriptor {
  int fd = -1;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

fs::path temporary_beside(const fs::path& target) {
  // The process id keeps two programs that write the same file apart; the extension stays last for format detection.
  return target.parent_path() /
         fmt::format(".{}.{}.part{}", target.stem().string(), ::getpid(), target.extension().string());
}

// The temporary files of this process.
struct Pending {
  std::mutex mutex;
  std::set<fs::path> files;
};
Pending& pending_files() {
  static auto* const pending = new Pending;  // outlives every static that may still write
  return *pending;
}

void require_folder(const fs::path& folder, const std::string& of) {
  std::error_code ignored;
  if (fs::is_directory(folder, ignored)) {
    if (::access(folder.c_str(), W_OK) == 0) return;
    throw Error(of, fmt::format("cannot write into the folder '{}': {}", printable(folder.string()), reason()),
                "choose a place that can be written");
  }
  if (fs::exists(folder, ignored))
    throw Error(of, fmt::format("'{}' is not a folder", printable(folder.string())), "choose another place");
  throw Error(of, fmt::format("there is no folder '{}'", printable(folder.string())),
              fmt::format("make it first (mkdir -p '{}') or choose another place", printable(folder.string())));
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

}  // namespace

std::vector<uint8_t> read_file(const fs::path& path, size_t limit) {
  Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.fd < 0) throw Error(path.string(), "cannot open: " + reason(), "check the path");
  struct stat status {};
  if (::fstat(file.fd, &status) != 0) throw Error(path.string(), "cannot read: " + reason());
  if (!S_ISREG(status.st_mode)) throw Error(path.string(), "is not a regular file", "name a file");
  const auto size = static_cast<size_t>(status.st_size);
  if (size > limit)
    throw Error(path.string(), fmt::format("is {} bytes, more than the limit of {}", size, limit),
                "use a smaller file");
  std::vector<uint8_t> bytes(size);
  size_t done = 0;
  while (done < size) {
    const ssize_t got = ::read(file.fd, bytes.data() + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(path.string(), "cannot read: " + reason());
    if (got == 0) break;
    done += static_cast<size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

std::string read_text(const fs::path& path, size_t limit) {
  const std::vector<uint8_t> bytes = read_file(path, limit);
  return {bytes.begin(), bytes.end()};
}

void write_file(const fs::path& path, const void* data, size_t size) {
  PendingFile pending(path);
  {
    Descriptor file{::open(pending.path().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)};
    if (file.fd < 0) throw Error(path.string(), "cannot create: " + reason(), "choose a place that can be written");
    const auto* bytes = static_cast<const char*>(data);
    size_t done = 0;
    while (done < size) {
      const ssize_t put = ::write(file.fd, bytes + done, size - done);
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) throw Error(path.string(), "cannot write: " + reason(), "free some space or choose another place");
      done += static_cast<size_t>(put);
    }
    const int fd = file.fd;
    file.fd = -1;
    if (::close(fd) != 0) throw Error(path.string(), "cannot write: " + reason(), "free some space");
  }
  pending.commit();
}

void write_file(const fs::path& path, std::string_view text) { write_file(path, text.data(), text.size()); }

void require_writable_file(const fs::path& path) {
  std::error_code ignored;
  const std::string shown = printable(path.string());
  if (path.empty()) throw Error("", "the file's name is empty", "name a file");
  if (path.filename().empty() || fs::is_directory(path, ignored)) throw Error(shown, "is a directory", "name a file");
  if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored))
    throw Error(shown, "is not a regular file", "name a file");
  require_folder(folder_of(path), shown);
}

void require_writable_folder(const fs::path& path) {
  std::error_code ignored;
  if (path.empty()) throw Error("", "the folder's name is empty", "name a folder");
  const fs::path bare = path.has_filename() ? path : path.parent_path();  // "maps/" is "maps"
  const std::string shown = printable(path.string());
  require_folder(fs::exists(bare, ignored) || bare.empty() ? path : folder_of(bare), shown);
}

void make_folder(const fs::path& path) {
  require_writable_folder(path);
  std::error_code error;
  fs::create_directory(path, error);
  if (error) throw Error(printable(path.string()), "cannot make the folder: " + error.message());
}

PendingFile::PendingFile(fs::path target) : target_(std::move(target)), temporary_(temporary_beside(target_)) {
  require_writable_file(target_);
  const std::scoped_lock lock(pending_files().mutex);
  pending_files().files.insert(temporary_);
}

PendingFile::~PendingFile() {
  std::error_code ignored;
  const std::scoped_lock lock(pending_files().mutex);
  pending_files().files.erase(temporary_);
  if (!committed_) fs::remove(temporary_, ignored);
}

void PendingFile::commit() {
  std::error_code error;
  const std::scoped_lock lock(pending_files().mutex);
  fs::rename(temporary_, target_, error);
  if (error) throw Error(target_.string(), "cannot put the file in place: " + error.message());
  committed_ = true;
}

void remove_pending_files() noexcept {
  Pending& pending = pending_files();
  pending.mutex.lock();  // for good
  std::error_code ignored;
  for (const fs::path& file : pending.files) fs::remove(file, ignored);
}

fs::path cache_directory() {
  if (const char* own = std::getenv("CROWDBENCH_CACHE_DIR"); own && *own) return own;
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && *xdg) return fs::path(xdg) / "crowdbench";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "crowdbench";
  return fs::temp_directory_path() / "crowdbench-cache";
}

fs::path program_directory() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::current_path() : self.parent_path();
}

}  // namespace crowdbench
