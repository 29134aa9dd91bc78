#include "pbrt/lights/light_image.h"

#include <fmt/format.h>

#include "pbrt/image/image_cache.h"

namespace lacquer {

void RequireFinitePixels(const Params& params, const std::string& filename, const Image& image,
                         int channels) {
    const Int2 size = image.Resolution();
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < channels; ++c)
                if (!std::isfinite(image.Get({x, y}, c)))
                    params.Fail("filename",
                                fmt::format("{}: pixel ({}, {}) is not a finite number", filename, x, y));
}

std::shared_ptr<const Image> ReadLightImage(const LightArgs& args) {
    const Params& params = args.params;
    const std::string filename = params.GetString("filename", "");
    if (filename.empty())
        params.Fail("filename", fmt::format("{} needs \"string filename\"", params.Owner()));
    std::shared_ptr<const Image> image =
        ImageParam(params, "filename", ColorEncoding{ColorEncoding::Kind::SRGB}, args.textures);
    RequireFinitePixels(params, filename, *image, image->NumChannels());
    return image;
}

}  // namespace lacquer
