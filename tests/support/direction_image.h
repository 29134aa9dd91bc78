// Normal maps of one normal.
#pragma once

#include <filesystem>
#include <string>

#include "pbrt/image/image.h"
#include "support/statistics.h"

namespace lacquer::test {

/// An image of one colour that says a direction; removed with the object.
class DirectionImage {
  public:
    explicit DirectionImage(Vec3 direction)
        : path_((std::filesystem::temp_directory_path() /
                 ("lacquer-direction-" + std::to_string(SeedOf(FullTestName())) + ".exr"))
                    .string()) {
        Image image({2, 2}, {"R", "G", "B"});
        for (int i = 0; i < 12; ++i) image.Pixels()[size_t(i)] = 0.5f * direction[i % 3] + 0.5f;
        WriteImage(image, path_);
    }
    ~DirectionImage() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    std::string Parameter(const std::string& name) const {
        return "\"string " + name + "\" \"" + path_ + "\" ";
    }

  private:
    std::string path_;
};

}  // namespace lacquer::test
