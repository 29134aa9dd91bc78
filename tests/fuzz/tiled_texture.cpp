// Tiled files of textures, patched: what a damaged cache of them may hold.
#include <array>
#include <fstream>
#include <iterator>

#include "fuzz/fuzz_target.h"
#include "pbrt/image/image.h"
#include "pbrt/image/tile_cache.h"

namespace lacquer::fuzz {
namespace {

constexpr Int2 kImageSize{16, 10};

class GreyRows final : public PyramidSource {
  public:
    Int2 Resolution() const override { return kImageSize; }
    int NumChannels() const override { return 1; }
    const float* Row(int) override { return row_.data(); }
    float EdgeValue(Int2, int) const override { return 0; }
    float Lowest() const override { return 0; }

  private:
    std::array<float, kImageSize.x> row_{};
};

const TiledLayout& Layout() {
    static const TiledLayout layout(
        kImageSize,
        {.format = PixelFormat::Byte, .encoding = {ColorEncoding::Kind::SRGB, 1}, .numChannels = 1}, "grey");
    return layout;
}

std::string TilesOfGrey() {
    const InputFolder folder;
    const std::string path = folder.Path() + "/grey.tif";
    GreyRows rows;
    WriteTiledFile(path, Layout(), rows, WrapMode::Repeat);
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

// A file that is none is made anew; what cannot be read of one is told once the image is done.
void TiledTexture(std::string_view bytes) {
    static const std::string tiles = TilesOfGrey();
    const InputFile input(Patched(tiles, bytes));
    TileCache cache;
    const auto image = cache.Open(input.Path(), "grey");
    if (!image) return;
    for (int level = 0; level < image->Layout().NumLevels(); ++level) {
        const bool hadFailed = cache.HasFailed();
        const uint8_t* texel = image->Texel(level, {0, 0});
        Require(hadFailed || !cache.HasFailed() || texel[0] == 0, "what cannot be read is zero");
    }
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "tiled_texture", TiledTexture);

}  // namespace lacquer::fuzz
