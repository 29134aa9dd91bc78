// Where `--display-server` looks for a viewer.
#include "cmd/render/display.h"

#include <gtest/gtest.h>

namespace lacquer::cmd::display_test {
namespace {

void ExpectAddress(const std::string& text, const std::string& host, const std::string& port) {
    const auto address = DisplayAddress::Parse(text);
    ASSERT_TRUE(address) << text;
    EXPECT_EQ(address->host, host) << text;
    EXPECT_EQ(address->port, port) << text;
}

TEST(DisplayAddress, HostAndPort) {
    ExpectAddress("localhost:14158", "localhost", "14158");
    ExpectAddress("10.0.0.2:1", "10.0.0.2", "1");
    ExpectAddress("viewer.example:65535", "viewer.example", "65535");
}

TEST(DisplayAddress, ThePortOfTevWhereNoneIsGiven) {
    ExpectAddress("localhost", "localhost", "14158");
    ExpectAddress("[::1]", "::1", "14158");
    ExpectAddress("fe80::2", "fe80::2", "14158");
}

TEST(DisplayAddress, BracketsAroundIPv6) { ExpectAddress("[::1]:8000", "::1", "8000"); }

TEST(DisplayAddress, WhatIsNone) {
    for (const char* text : {"", ":1", "a:", "a:b", "a:0", "a:65536", "a:-1", "a:1x", "a:999999", "[::1",
                             "[::1]2", "[::1]:", "[]:1"})
        EXPECT_FALSE(DisplayAddress::Parse(text)) << text;
}

}  // namespace
}  // namespace lacquer::cmd::display_test
