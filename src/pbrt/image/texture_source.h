// What a texture takes from an image, and images that are read row by row for it.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pbrt/image/image_file.h"
#include "pbrt/image/pyramid.h"

namespace lacquer {

/// Goes once over all pixels of an image, and finds out which channels a texture needs.
class TextureSurvey {
  public:
    explicit TextureSurvey(std::vector<std::string> channels);
    /// @param pixels  `count` of them, with all channels of the image
    void AddPixels(const float* pixels, size_t count);
    /// Indices of one channel, or of R, G and B, or of these and A. An alpha of 1 everywhere is left out:
    /// then float textures take the mean of R, G and B; of a grey image one channel is left, which gives the
    /// same numbers from a third of the memory. Errors: SceneError at `loc` about `path` for an image of
    /// other channels, and for pixels that are not finite.
    std::vector<int> UsedChannels(const std::string& path, const FileLoc& loc) const;
    /// The smallest value of all channels.
    float Lowest() const { return lowest_; }

  private:
    void AddValues(std::span<const float> values);

    std::vector<std::string> channels_;
    int r_, g_, b_, a_;  // indices, -1 where there is none
    bool isOpaque_ = true, isGrey_ = true, isFinite_ = true;
    float lowest_;
};

/// The rows of an image file for a pyramid, never more than some at a time; the file is read twice.
class FileSource final : public PyramidSource {
  public:
    /// Goes over the file for the first time. @param advance  called for each row of both times
    /// Errors: those of ImageFile::ReadRows and TextureSurvey; SceneError if the file changes meanwhile.
    FileSource(const std::string& path, ColorEncoding encoding, const FileLoc& loc,
               std::function<void()> advance);
    Int2 Resolution() const override { return header_.resolution; }
    int NumChannels() const override { return int(channels_.size()); }
    const float* Row(int y) override;
    float EdgeValue(Int2 p, int channel) const override;
    float Lowest() const override { return lowest_; }
    const ImageHeader& Header() const { return header_; }

  private:
    /// Rows at hand: all channels of some rows in succession.
    struct Band {
        int begin = 0, end = 0;
        std::vector<float> values;
    };
    void ReadBand(int begin);
    void KeepEdges(int y, const float* row);

    std::string path_;
    ColorEncoding encoding_;
    FileLoc loc_;
    std::function<void()> advance_;
    std::unique_ptr<ImageFile> file_;
    ImageHeader header_;
    Band band_;
    std::vector<int> channels_;
    float lowest_ = 0;
    std::vector<float> row_;
    /// All channels: of the outermost rows, from the top; and of the outermost columns of each row, from the
    /// left.
    std::vector<float> edgeRows_, edgeColumns_;
};

}  // namespace lacquer
