// What tests of the readers of single formats have in common: a file, and that two readers see the same
// image.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "pbrt/image/image_library.h"

namespace lacquer {

/// One file, named for the test.
class ImageFileTest : public testing::Test {
  protected:
    explicit ImageFileTest(const std::string& extension)
        : path_(std::filesystem::temp_directory_path() /
                ("lacquer-" + extension + "-" +
                 testing::UnitTest::GetInstance()->current_test_info()->name() + "." + extension)) {}
    void TearDown() override { std::filesystem::remove(path_); }
    template <class Bytes>
    void Write(const Bytes& bytes) const {
        std::ofstream(path_, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    }
    std::filesystem::path path_;
};

/// All but the attributes.
inline void ExpectSameLayout(const ImageContents& a, const ImageContents& b) {
    EXPECT_EQ(a.resolution, b.resolution);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.isDeep, b.isDeep);
    EXPECT_EQ(a.origin, b.origin);
    EXPECT_EQ(a.fullOrigin, b.fullOrigin);
    EXPECT_EQ(a.fullResolution, b.fullResolution);
    EXPECT_EQ(a.tileRows, b.tileRows);
    EXPECT_EQ(a.channels, b.channels);
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.channelTypes, b.channelTypes);
}

}  // namespace lacquer
