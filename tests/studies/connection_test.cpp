// What a client of the study's server may take of it: parts of files, bytes, and time.
#include "studies/server/module/connection.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <thread>

#include "studies/server/module/byte_range.h"

namespace crowdbench::studies::http {
namespace {
using std::chrono::milliseconds;

TEST(ByteRange, IsAlwaysWithinTheFile) {
  const auto is = [](const char* text, uint64_t bytes, uint64_t offset, uint64_t length) {
    const std::optional<ByteRange> found = byte_range(text, bytes);
    return found && found->offset == offset && found->length == length;
  };
  EXPECT_TRUE(is("bytes=2-5", 10, 2, 4));
  EXPECT_TRUE(is("bytes=0-", 10, 0, 10));
  EXPECT_TRUE(is("bytes=9-9", 10, 9, 1));
  EXPECT_TRUE(is("bytes=-3", 10, 7, 3));
  EXPECT_TRUE(is("bytes=-99", 10, 0, 10));
  EXPECT_TRUE(is("bytes=2-99999999999999999999999", 10, 2, 8));
  for (const char* text :
       {"bytes=10-", "bytes=10-12", "bytes=5-2", "bytes=-0", "bytes=", "bytes=-", "bytes=a-b", "bytes=1-2,4-5",
        "bytes=0-,0-", "bytes= 1-2", "bytes=--3", "bytes=-3-5", "lines=1-2", "", "bytes=99999999999999999999999-"})
    EXPECT_FALSE(byte_range(text, 10)) << text;
  EXPECT_FALSE(byte_range("bytes=0-", 0));
  EXPECT_FALSE(byte_range("bytes=-1", 0));
}

class ConnectionTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends_), 0); }
  void TearDown() override {
    for (const int end : ends_)
      if (end >= 0) ::close(end);
  }
  void say(const std::string& text) const {
    ASSERT_EQ(::send(ends_[1], text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  // All that can be read, until there is no more or no more is taken.
  static std::string heard(Connection& connection) {
    std::string out;
    char part[100];
    for (ssize_t got = 0; (got = connection.read(part, sizeof part)) > 0;) out.append(part, static_cast<size_t>(got));
    return out;
  }
  int ends_[2] = {-1, -1};
};

TEST_F(ConnectionTest, TakesSoManyBytesAndNoMore) {
  Connection connection(ends_[0], {.most_received = 5000, .pause = milliseconds(20)});
  say(std::string(9000, 'x'));
  EXPECT_EQ(heard(connection).size(), 5000U);
  EXPECT_FALSE(connection.is_readable());
}

TEST_F(ConnectionTest, EndsWhereTheOtherEnds) {
  Connection connection(ends_[0], {.most_received = 5000});
  say("GET /");
  ::shutdown(ends_[1], SHUT_WR);
  EXPECT_EQ(heard(connection), "GET /");
  char byte = 0;
  EXPECT_EQ(connection.read(&byte, 1), 0);
}

// A byte now and then never pauses, and does not make the request's time longer.
TEST_F(ConnectionTest, WhoSaysLittleAtATimeIsNotWaitedForWithoutEnd) {
  const auto from = std::chrono::steady_clock::now();
  Connection connection(ends_[0], {.most_received = 5000, .pause = milliseconds(100), .request = milliseconds(300)});
  std::jthread dripping([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      ::send(ends_[1], "a", 1, MSG_NOSIGNAL);
      std::this_thread::sleep_for(milliseconds(10));
    }
  });
  EXPECT_GT(heard(connection).size(), 2U);
  const auto took = std::chrono::steady_clock::now() - from;
  EXPECT_GE(took, milliseconds(250));
  EXPECT_LT(took, milliseconds(2000));
}

TEST_F(ConnectionTest, WhoTakesNothingOrLittleIsGivenUp) {
  const std::string answer(1 << 20, 'x');
  const auto written = [&](Connection& connection) {
    size_t sum = 0;
    while (sum < answer.size()) {
      const ssize_t put = connection.write(answer.data() + sum, answer.size() - sum);
      if (put <= 0) break;
      sum += static_cast<size_t>(put);
    }
    return sum;
  };
  Connection none(ends_[0], {.write_pause = milliseconds(50)});
  EXPECT_LT(written(none), answer.size());
  // A little now and then: slower than is granted.
  std::jthread taking([this](const std::stop_token& stop) {
    char part[1000];
    while (!stop.stop_requested()) {
      ::recv(ends_[1], part, sizeof part, MSG_DONTWAIT);
      std::this_thread::sleep_for(milliseconds(5));
    }
  });
  Connection slow(
      ends_[0],
      {.write_pause = milliseconds(1000), .write_grace = milliseconds(100), .write_bytes_per_second = 10 << 20});
  EXPECT_LT(written(slow), answer.size());
}

}  // namespace
}  // namespace crowdbench::studies::http
