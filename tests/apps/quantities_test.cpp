#include "quantities.h"

#include <string>

#include <gtest/gtest.h>

#include "arete/core/error.h"

#include "method_flags.h"

namespace arete::app {
namespace {

TEST(Quantities, Bytes) {
  Bytes bytes;
  for (const auto& [text, count] : {std::pair<const char*, std::size_t>{"4096", 4096},
                                    {"1K", 1024},
                                    {"512M", std::size_t{512} << 20U},
                                    {"1.5GiB", std::size_t{3} << 29U}}) {
    SCOPED_TRACE(text);
    EXPECT_TRUE(parse(text, bytes));
    EXPECT_EQ(bytes.count, count);
  }
  for (const char* text : {"", "M", "2gb", "-1M", "0", "1X", "1M2", "inf", "nan", "1e30"}) {
    SCOPED_TRACE(text);
    EXPECT_FALSE(parse(text, bytes));
  }
}

TEST(Quantities, FrameSize) {
  FrameSize size;
  EXPECT_TRUE(parse("640x360", size));
  EXPECT_EQ(size.width, 640);
  EXPECT_EQ(size.height, 360);
  for (const char* text : {"", "640", "640x", "x360", "0x1", "640x-1", "640x360x1", "99999x1"}) {
    SCOPED_TRACE(text);
    EXPECT_FALSE(parse(text, size));
  }
}

TEST(Quantities, Tolerance) {
  Tolerance tolerance;
  EXPECT_TRUE(parse("0.5", tolerance));
  EXPECT_DOUBLE_EQ(tolerance.pixels(720), 0.5);
  EXPECT_TRUE(parse("0.25%", tolerance));
  EXPECT_DOUBLE_EQ(tolerance.pixels(720), 1.8);
  for (const char* text : {"", "0", "-1", "1px", "%", "inf"}) {
    SCOPED_TRACE(text);
    EXPECT_FALSE(parse(text, tolerance));
  }
}

TEST(Quantities, ForPeople) {
  EXPECT_EQ(bytes_text(512), "512 B");
  EXPECT_EQ(bytes_text(1536), "1.5 KiB");
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1234567), "1,234,567");
}

TEST(MethodFlags, SettingsGoToTheirMethod) {
  const MethodFlags flags{"65", {"literal=1", "smooth.speed=2", "merge.x=a=b"}};
  EXPECT_EQ(params_of(flags, "smooth"),
            (lod::Params{{"patch", "65"}, {"literal", "1"}, {"speed", "2"}}));
  EXPECT_EQ(params_of(flags, "merge"), (lod::Params{{"literal", "1"}, {"x", "a=b"}}));
  EXPECT_THROW(params_of({"", {"literal"}}, "merge"), Error);
}

TEST(MethodFlags, ListsAreInTheTablesOrder) {
  const auto all = method_list("all");
  ASSERT_GE(all.size(), 2U);
  EXPECT_EQ(method_list(all[1] + "," + all[0] + "," + all[1]),
            (std::vector<std::string>{all[0], all[1]}));
  EXPECT_THROW(method_list("nonesuch"), Error);
  EXPECT_THROW(method_list(""), Error);
}

}  // namespace
}  // namespace arete::app
