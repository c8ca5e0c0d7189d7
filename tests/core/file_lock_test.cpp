#include "core/file_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>

#include "core/error.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench {
namespace {
namespace fs = std::filesystem;

// Whether another process gets the lock; 2 with another message.
int another_gets(const fs::path& file) {
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      const FileLock lock(file);
    } catch (const Error& error) {
      ::_exit(std::string(error.what()).find("another process is measuring it") == std::string::npos ? 2 : 0);
    }
    ::_exit(1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(FileLock, IsOneProcesssAtATime) {
  const support::ScratchFolder folder;
  const fs::path file = folder.path() / "rows.sqlite";
  {
    const FileLock lock(file);
    EXPECT_EQ(another_gets(file), 0);
  }
  EXPECT_TRUE(fs::is_empty(folder.path())) << "nothing is left";
  EXPECT_EQ(another_gets(file), 1);
}

TEST(FileLock, OfAKilledProcessHoldsNothing) {
  const support::ScratchFolder folder;
  const fs::path file = folder.path() / "rows.sqlite";
  const pid_t child = ::fork();
  if (child == 0) {
    const FileLock lock(file);
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(fs::exists(file.string() + ".lock"));
  const FileLock lock(file);
  EXPECT_EQ(another_gets(file), 0);
}

TEST(FileLock, NamesTheFileThatItCannotBeMadeBeside) {
  const support::ScratchFolder folder;
  try {
    const FileLock lock(folder.path() / "none" / "rows.sqlite");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("rows.sqlite"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("No such file"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace crowdbench
