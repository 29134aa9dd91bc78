#include "pbrt/core/json_number.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace lacquer::test::json_number_test {
namespace {

using Json = nlohmann::ordered_json;

TEST(JsonNumber, WholeNumbersInRangeAreTaken) {
    EXPECT_EQ(WholeNumber<int>(Json::parse("-7")), -7);
    EXPECT_EQ(WholeNumber<int>(Json::parse("2147483647")), std::numeric_limits<int>::max());
    EXPECT_EQ(WholeNumber<uint64_t>(Json::parse("18446744073709551615")),
              std::numeric_limits<uint64_t>::max());
    EXPECT_EQ(WholeNumbers<int>(Json::parse("[1, 2]")), (std::vector<int>{1, 2}));
}

TEST(JsonNumber, AllElseIsAnErrorAsOfTheLibrary) {
    for (const char* text :
         {"2147483648", "-2147483649", "1e99", "1.0", "\"1\"", "null", "true", "[1]", "{}"})
        EXPECT_THROW(WholeNumber<int>(Json::parse(text)), nlohmann::json::exception) << text;
    EXPECT_THROW(WholeNumber<uint64_t>(Json::parse("-1")), nlohmann::json::exception);
    EXPECT_THROW(WholeNumbers<int>(Json::parse("3")), nlohmann::json::exception);
    EXPECT_THROW(WholeNumbers<int>(Json::parse("[1, 2.5]")), nlohmann::json::exception);
}

}  // namespace
}  // namespace lacquer::test::json_number_test
