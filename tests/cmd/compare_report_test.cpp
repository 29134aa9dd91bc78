// The page of `lacquer compare`: what is put into it can be read back, and nothing in it breaks out or loads.
// tests/report looks at the page in a browser.
#include "cmd/compare/report.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>

#include "cmd/page_checks.h"
#include "cmd/page_parts.h"
#include "pbrt/image/half.h"

namespace lacquer::cmd::compare_report_test {
namespace {

/// RFC 4648, and nothing but letters of it.
std::string FromBase64(const std::string& text) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    uint32_t bits = 0;
    int numBits = 0;
    for (const char c : text) {
        if (c == '=') break;
        bits = bits << 6 | uint32_t(letters.find(c));
        if ((numBits += 6) >= 8) bytes += char(bits >> (numBits -= 8) & 0xff);
    }
    return bytes;
}

std::string Inflated(const std::string& bytes, size_t size) {
    std::string out(size, '\0');
    uLongf length = uLong(size);
    EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(out.data()), &length,
                         reinterpret_cast<const Bytef*>(bytes.data()), uLong(bytes.size())),
              Z_OK);
    EXPECT_EQ(length, size);
    return out;
}

/// Value of a channel of a pixel as PixelsForPage lays it out.
float PageValue(const std::string& bytes, size_t numPixels, size_t pixel, size_t channel) {
    const size_t i = channel * numPixels + pixel;
    return HalfToFloat(uint16_t(uint8_t(bytes[i]) << 8 | uint8_t(bytes[bytes.size() / 2 + i])));
}

Image MakeImage(Int2 resolution, std::vector<std::string> channels, float scale) {
    Image image(resolution, std::move(channels));
    for (size_t i = 0; i < image.Pixels().size(); ++i) image.Pixels()[i] = scale * float(i + 1);
    return image;
}

nlohmann::ordered_json MakeResults(const std::string& name) {
    return {{"schema", "lacquer-compare-1"},
            {"scene", name},
            {"command", "lacquer compare " + name},
            {"rmse", 0.1234567890123456789}};
}

TEST(PageParts, Base64AgreesWithRfc4648) {
    // Its section 10.
    EXPECT_EQ(ToBase64(""), "");
    EXPECT_EQ(ToBase64("f"), "Zg==");
    EXPECT_EQ(ToBase64("fo"), "Zm8=");
    EXPECT_EQ(ToBase64("foo"), "Zm9v");
    EXPECT_EQ(ToBase64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(ToBase64(std::string("\x00\xff\xfe", 3)), "AP/+");
}

TEST(PageParts, DeflatedIsReadBack) {
    std::string bytes;
    for (int i = 0; i < 100000; ++i) bytes += char((int64_t(i) * i >> 7) & 0xff);
    const std::string small = Deflated(bytes);
    EXPECT_LT(small.size(), bytes.size());
    EXPECT_EQ(Inflated(small, bytes.size()), bytes);
    EXPECT_EQ(Inflated(Deflated(""), 0), "");
}

TEST(PageParts, HtmlIsEscaped) {
    EXPECT_EQ(EscapeHtml("a<b>&\"'\xc3\xa9"), "a&lt;b&gt;&amp;&quot;&#39;\xc3\xa9");
}

TEST(PageParts, JsonForAPageIsTheSameValueWithoutMarkup) {
    const nlohmann::ordered_json value = MakeResults(kHostile);
    const std::string text = JsonForPage(value);
    EXPECT_EQ(text.find_first_of("<>&"), std::string::npos);
    EXPECT_EQ(text.find("\xe2\x80\xa8"), std::string::npos);
    EXPECT_EQ(nlohmann::ordered_json::parse(text), value);
}

TEST(PageParts, JsonForAPageSurvivesBytesThatAreNotUtf8) {
    const nlohmann::ordered_json value = {{"name",
                                           "a\xff"
                                           "b"}};
    EXPECT_EQ(nlohmann::ordered_json::parse(JsonForPage(value))["name"],
              "a\xef\xbf\xbd"
              "b");
}

TEST(PageParts, PixelsKeepElevenBits) {
    const Image image = MakeImage({5, 3}, {"R", "G", "B"}, 0.0123f);
    const std::string bytes = PixelsForPage(image);
    ASSERT_EQ(bytes.size(), size_t(5 * 3 * 3 * 2));
    for (size_t i = 0; i < 15; ++i)
        for (size_t c = 0; c < 3; ++c) {
            const float exact = image.Pixels()[3 * i + c];
            // Rounding to nearest of 11 bits.
            EXPECT_NEAR(PageValue(bytes, 15, i, c), exact, exact * 0x1p-11f);
        }
}

TEST(PageParts, FinitePixelsStayFiniteAndOthersStayVisible) {
    Image image({5, 1}, {"Y"});
    image.Pixels() = {1e30f, -1e30f, NAN, INFINITY, 65504};
    const std::string bytes = PixelsForPage(image);
    EXPECT_EQ(PageValue(bytes, 5, 0, 0), kMaxHalf);
    EXPECT_EQ(PageValue(bytes, 5, 1, 0), -kMaxHalf);
    EXPECT_TRUE(std::isnan(PageValue(bytes, 5, 2, 0)));
    EXPECT_EQ(PageValue(bytes, 5, 3, 0), INFINITY);
    EXPECT_EQ(PageValue(bytes, 5, 4, 0), kMaxHalf);
}

TEST(PageParts, FurtherChannelsAreLeftOut) {
    Image image({1, 1}, {"R", "G", "B", "A", "albedo.R"});
    image.Pixels() = {1, 2, 3, 4, 5};
    EXPECT_EQ(NumPageChannels(image), 3);
    const std::string bytes = PixelsForPage(image);
    ASSERT_EQ(bytes.size(), 6u);
    EXPECT_EQ(PageValue(bytes, 1, 0, 2), 3);
}

TEST(PageParts, OtherColourSpacesBecomeLinearSrgb) {
    Image image({1, 1}, {"R", "G", "B"});
    image.Pixels() = {0.2f, 0.5f, 0.3f};
    image.SetColorSpace(ColorSpace::Find("rec2020"));
    ASSERT_NE(image.ColorSpace(), nullptr);
    const RGB expected = ColorSpace::SRGB().ToRGB(image.ColorSpace()->ToXYZ(RGB(0.2f, 0.5f, 0.3f)));
    const std::string bytes = PixelsForPage(image);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(PageValue(bytes, 1, 0, size_t(c)), expected[c], std::abs(expected[c]) * 1e-3f);
    // The colour does differ from one that nobody converted.
    EXPECT_GT(std::abs(expected[0] - 0.2f), 0.05f);
}

TEST(CompareReport, HoldsEveryImage) {
    const Image run = MakeImage({4, 3}, {"R", "G", "B"}, 0.1f), error = MakeImage({4, 3}, {"RMSE"}, 0.01f);
    const std::string page =
        MakeCompareReport(MakeResults("scene.pbrt"), {{"images/a.exr", &run}, {kHostile, &error}});
    EXPECT_EQ(Count(page, "<script type=\"text/plain\" class=\"image\""), 2u);
    const std::string first =
        "data-file=\"images/a.exr\" data-width=\"4\" data-height=\"3\" data-channels=\"3\" data-x=\"0\" "
        "data-y=\"0\">";
    EXPECT_EQ(Inflated(FromBase64(Between(page, first, "<")), 4 * 3 * 3 * 2), PixelsForPage(run));
    const std::string second =
        "data-file=\"" + EscapeHtml(kHostile) +
        "\" data-width=\"4\" data-height=\"3\" data-channels=\"1\" data-x=\"0\" data-y=\"0\">";
    EXPECT_EQ(Inflated(FromBase64(Between(page, second, "<")), 4 * 3 * 2), PixelsForPage(error));
}

TEST(CompareReport, SaysWhichPartOfTheFrameAnImageIs) {
    Image image = MakeImage({4, 3}, {"R", "G", "B"}, 1);
    image.dataWindow = {{10, 20}, {14, 23}};
    const std::string page = MakeCompareReport(MakeResults("x"), {{"a.exr", &image}});
    EXPECT_NE(page.find("data-channels=\"3\" data-x=\"10\" data-y=\"20\">"), std::string::npos);
}

TEST(CompareReport, HoldsTheResultsAsTheyAre) {
    const nlohmann::ordered_json results = MakeResults(kHostile);
    const std::string page = MakeCompareReport(results, {});
    const std::string text = Between(page, "<script type=\"application/json\" id=\"results\">", "</script>");
    EXPECT_EQ(nlohmann::ordered_json::parse(text), results);
}

TEST(CompareReport, NamesDoNotBecomeMarkup) {
    const Image image = MakeImage({2, 2}, {"R", "G", "B"}, 1);
    const std::string harmless = MakeCompareReport(MakeResults("x"), {{"x", &image}});
    const std::string hostile = MakeCompareReport(MakeResults(kHostile), {{kHostile, &image}});
    EXPECT_EQ(Count(hostile, "<script"), Count(harmless, "<script"));
    EXPECT_EQ(Count(hostile, "</script"), Count(harmless, "</script"));
    EXPECT_EQ(Count(hostile, "<!--"), Count(harmless, "<!--"));
    // A name that looks like a part of the template stays a name: one list of images, twice the name's
    // braces.
    EXPECT_EQ(Count(hostile, "class=\"image\""), 1u);
    EXPECT_NE(hostile.find("{{images}}"), std::string::npos);
}

TEST(CompareReport, LoadsNothing) {
    const Image image = MakeImage({2, 2}, {"R", "G", "B"}, 1);
    const std::string page = MakeCompareReport(MakeResults("scene.pbrt"), {{"images/a.exr", &image}});
    EXPECT_FALSE(Loads(page));
    EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(CompareReport, NegativeControlPagesThatLoadAreFound) {
    for (const char* load :
         {"<img src=\"https://example.org/a.png\">", "<script src=//example.org/a.js></script>",
          "p { background: url(http://example.org/a.png) }", "fetch('a.json')",
          "<link rel=stylesheet href=a.css>"})
        EXPECT_TRUE(Loads(load)) << load;
}

TEST(CompareReport, CarriesTheNoticesOfWhatItHolds) {
    const std::string page = MakeCompareReport(MakeResults("scene.pbrt"), {});
    EXPECT_NE(page.find("Chart.js Contributors"), std::string::npos);
    EXPECT_NE(page.find("Permission is hereby granted"), std::string::npos);
}

TEST(CompareReport, ResultsWithoutASceneStillMakeAPage) {
    EXPECT_NE(MakeCompareReport(nlohmann::ordered_json::object(), {}).find("<title>comparison"),
              std::string::npos);
}

TEST(CompareReport, AMissingImageIsAMistakeOfTheCaller) {
    EXPECT_THROW(MakeCompareReport(MakeResults("x"), {{"images/a.exr", nullptr}}), std::logic_error);
}

}  // namespace
}  // namespace lacquer::cmd::compare_report_test
