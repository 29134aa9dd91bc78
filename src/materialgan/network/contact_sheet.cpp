#include "materialgan/network/contact_sheet.h"

namespace lacquer::materialgan {
namespace {

constexpr int kSheetTiles = 5, kSheetGap = 2;
constexpr double kSheetSize = 10.88, kSheetDistance = 16, kSheetPower = 1500;

/// n x 3 x (5 R) x R: what is shown of each material, from 0 to 1, as it is to be seen.
Tensor TilesOf(const Tensor& maps) {
    const Tensor stored = (maps.clamp(-1, 1) + 1) * 0.5;
    const DecodedMaps decoded = DecodeMaps(maps);
    const Tensor roughness = stored.narrow(1, 5, 1).expand({-1, 3, -1, -1});
    const Tensor photograph = RenderEncoded(maps, FlashView()).select(1, 0);
    return torch::cat(
        {stored.narrow(1, 0, 3), (decoded.normal + 1) * 0.5, roughness, stored.narrow(1, 6, 3), photograph},
        2);
}

}  // namespace

TorchViews FlashView() {
    const Tensor above = torch::tensor({{0., 0., kSheetDistance}}, torch::kFloat);
    return {above, above, torch::full({3}, kSheetPower), kSheetSize};
}

Image ContactSheet(const std::vector<Tensor>& rows) {
    const torch::NoGradGuard noGradients;
    const int size = int(rows.at(0).size(-1)), perRow = int(rows[0].size(0)), tileHeight = kSheetTiles * size;
    Image sheet({perRow * (size + kSheetGap), int(rows.size()) * (tileHeight + kSheetGap)}, {"R", "G", "B"});
    const ColorEncoding sRGB{ColorEncoding::Kind::SRGB, 1};
    for (size_t row = 0; row < rows.size(); ++row) {
        const Tensor tiles = TilesOf(rows[row]).contiguous();
        const auto values = tiles.accessor<float, 4>();
        for (int i = 0; i < perRow; ++i)
            for (int y = 0; y < tileHeight; ++y)
                for (int x = 0; x < size; ++x)
                    for (int c = 0; c < 3; ++c)
                        sheet.Set({i * (size + kSheetGap) + x, int(row) * (tileHeight + kSheetGap) + y}, c,
                                  sRGB.ToLinear(values[i][c][y][x]));
    }
    return sheet;
}

}  // namespace lacquer::materialgan
