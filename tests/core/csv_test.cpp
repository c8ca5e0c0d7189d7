#include "core/csv.h"

#include <gtest/gtest.h>

namespace crowdbench {
namespace {

TEST(Csv, FieldsAreQuotedWhereReadersWouldTakeThemApart) {
  EXPECT_EQ(csv_field(""), "");
  EXPECT_EQ(csv_field("cannot tell"), "cannot tell");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("say \"a\""), "\"say \"\"a\"\"\"");
  EXPECT_EQ(csv_field("two\nlines"), "\"two\nlines\"");
  EXPECT_EQ(csv_field(" a"), "\" a\"");
  EXPECT_EQ(csv_field("a\t"), "\"a\t\"");
}

}  // namespace
}  // namespace crowdbench
