#include "renderers/gl/objects.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "core/error.h"
#include "gl_test_support.h"
#include "renderers/gl/counters.h"

namespace crowdbench::gl {
namespace {

using renderers::testing::context;

class ObjectsGl : public renderers::testing::GlTest {};
class ContextGl : public ::testing::Test {};

constexpr unsigned kRgba8 = 0x8058;
constexpr unsigned kRgba32F = 0x8814;

TEST_F(ObjectsGl, MovedFromIsZeroAndBytesAreCountedOnce) {
  const Allocated before = context().allocated();
  {
    Buffer a(context(), 1000);
    EXPECT_EQ(context().allocated().buffer_bytes, before.buffer_bytes + 1000);
    const unsigned name = a.name();
    Buffer b(std::move(a));
    EXPECT_EQ(a.name(), 0U);  // NOLINT(bugprone-use-after-move): the state is part of the contract
    EXPECT_EQ(b.name(), name);
    Buffer c(context(), 24);
    c = std::move(b);
    EXPECT_EQ(c.name(), name);
    EXPECT_EQ(context().allocated().buffer_bytes, before.buffer_bytes + 1000) << "the 24 bytes went";
    c = Buffer();
    EXPECT_EQ(context().allocated().buffer_bytes, before.buffer_bytes);
    // 5 x 3 with a whole chain: 5x3, 2x1, 1x1; 18 texels of 4 bytes, 7 layers.
    const Texture t = Texture::make_array(context(), kRgba8, 5, 3, 7);
    EXPECT_EQ(t.levels(), 3);
    EXPECT_EQ(t.bytes(), 18U * 4U * 7U);
    EXPECT_EQ(context().allocated().texture_bytes, before.texture_bytes + t.bytes());
    Texture u = Texture::make_2d(context(), kRgba32F, 2, 2);
    EXPECT_EQ(u.bytes(), 64U);
    const Texture v = std::move(u);
    EXPECT_EQ(u.name(), 0U);  // NOLINT(bugprone-use-after-move)
  }
  EXPECT_EQ(context().allocated().texture_bytes, before.texture_bytes);
  EXPECT_EQ(context().allocated().buffer_bytes, before.buffer_bytes);
}

TEST_F(ObjectsGl, BufferKeepsWhatIsWritten) {
  const std::vector<uint32_t> values = {1, 2, 3, 4};
  const Buffer buffer(context(), values);
  const uint32_t nine = 9;
  buffer.write(&nine, 4, 8);
  std::vector<uint32_t> back(4);
  buffer.read(back.data(), 16);
  EXPECT_EQ(back, (std::vector<uint32_t>{1, 2, 9, 4}));
}

TEST_F(ObjectsGl, TooLargeATextureIsAnError) {
  EXPECT_THROW((void)Texture::make_2d(context(), kRgba8, context().limits().texture_size + 1, 1), Error);
  EXPECT_THROW((void)Texture::make_array(context(), kRgba8, 4, 4, context().limits().array_layers + 1), Error);
  EXPECT_THROW((void)Texture::make_2d(context(), kRgba8, 0, 4), Error);
}

TEST_F(ObjectsGl, ADebugContextReportsAWrongCall) {
  const Buffer buffer(context(), 16);
  buffer.bind(0x1234, 0);  // no such target
  EXPECT_FALSE(context().take_debug_messages().empty());
}

TEST_F(ObjectsGl, CountsOfAKnownDraw) {
  const Texture colour = Texture::make_2d(context(), kRgba8, 64, 32);
  const Texture* const attachments[] = {&colour};
  const Framebuffer target(context(), attachments, nullptr);
  const TimerTrust trust = test_gpu_timer(context());
  if (context().is_software()) {
    EXPECT_FALSE(trust.trusted) << trust.reason;
  }
  EXPECT_GT(trust.wall_ns, 0);
  EXPECT_FALSE(trust.reason.empty());
}

TEST_F(ContextGl, ObjectsOutliveTheirContextWithoutTouchingIt) {
  std::optional<Context> own;
  own.emplace();
  Buffer buffer(*own, 64);
  Texture texture = Texture::make_2d(*own, kRgba8, 4, 4);
  own.reset();
  EXPECT_NE(buffer.name(), 0U);
  // Were these to call GL without a context, libepoxy would end the process.
  buffer = Buffer();
  Texture other = std::move(texture);
  EXPECT_EQ(buffer.name(), 0U);
  context().make_current();
}

TEST_F(ContextGl, AnObjectOfAnotherContextIsDeletedThere) {
  Context other;
  const uint64_t before = other.allocated().buffer_bytes;
  auto buffer = std::make_optional<Buffer>(other, size_t{64});
  context().make_current();
  const Buffer mine(context(), 64);
  const unsigned name = mine.name();
  buffer.reset();
  EXPECT_EQ(other.allocated().buffer_bytes, before);
  uint32_t value = 7;
  mine.write(&value, 4);  // the first context is current again, and its buffer of that name is alive
  uint32_t back = 0;
  mine.read(&back, 4);
  EXPECT_EQ(back, 7U);
  EXPECT_EQ(mine.name(), name);
}

std::string refusal(const std::string& device) {
  try {
    const Context context(ContextOptions{.device = device});
    return "no error";
  } catch (const Error& e) {
    return e.what();
  }
}

TEST_F(ContextGl, DevicesAreChosenByIndexAndRefusedByName) {
  const std::vector<Device> devices = list_devices();
  EXPECT_NE(refusal("99").find(fmt::format("{} found", devices.size())), std::string::npos) << refusal("99");
  EXPECT_NE(refusal("-1").find("is not a device"), std::string::npos);
  EXPECT_NE(refusal("fast").find("is not a device"), std::string::npos);
  EXPECT_NE(refusal("1x").find("is not a device"), std::string::npos);
  if (!devices.empty()) {
    const Context by_index(ContextOptions{.device = "0"});
    EXPECT_NE(by_index.platform().find("EGL device 0"), std::string::npos);
  }
  setenv("CROWDBENCH_DEVICE", "nonsense", 1);
  const std::string by_variable = refusal("");
  unsetenv("CROWDBENCH_DEVICE");
  EXPECT_NE(by_variable.find("CROWDBENCH_DEVICE"), std::string::npos) << by_variable;
  context().make_current();
}

}  // namespace
}  // namespace crowdbench::gl
