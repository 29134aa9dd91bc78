// What tools do to whole images. Colours are R, G, B, or Y where an image is grey; other channels, metadata
// and the data window stay unless it says otherwise.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer {

/// "layer" of a channel "layer.X"; empty if it has none.
std::string_view LayerOfChannel(std::string_view channel);

/// Indices of R, G and B, or of Y alone; empty where an image has neither.
std::vector<int> ColorChannels(const Image& image);
/// Luminance of a pixel, in the colour space of the image; of a grey one its Y, and of one without colours
/// the mean of the channels.
float LuminanceAt(const Image& image, Int2 p);

/// Replaces every colour by a function of it; grey is a colour of three equal components, of which the first
/// counts. False if the image has no colours.
bool MapColors(Image* image, const std::function<RGB(RGB)>& function);

/// Upside down; the data window keeps its place.
void FlipY(Image* image);
/// Each pixel `n` times in both directions. Windows are scaled along. @param n  >= 1
Image RepeatPixels(const Image& image, int n);
/// Pixels of a luminance above `threshold` become the median of their 3 x 3 neighbourhood, each channel for
/// itself. Returns how many.
int64_t Despike(Image* image, float threshold);

struct BloomOptions {
    float level = 0;     ///< pixels of which some colour exceeds it shine around
    int width = 15;      ///< of the blur [pixels]; iterations make it wider
    float scale = 0.3f;  ///< of the light around, all iterations together
    int iterations = 5;  ///< blurs of blurs
};
/// Adds light around bright pixels, as lenses do: what exceeds the level, blurred by a Gaussian `iterations`
/// times, each blur with the same weight. Returns the number of bright pixels. The blur is separable: cost
/// O(pixels x width), of a width that ends at the sides of the image.
int64_t Bloom(Image* image, const BloomOptions& options);

/// Pastes parts of one frame, by their data windows, into an image of the whole frame; where parts overlap,
/// the later one counts. Pixels that no part has are 0.
struct Assembly {
    Image image;
    int64_t missing = 0, overlapping = 0;  ///< pixels
};
/// @param parts  at least one, of one frame and with the same channels
Assembly Assemble(std::span<const Image> parts);

/// The middle of every nth strip from every nth image: vertical strips of equal width, the first from the
/// first image. @param images  of one size and with the same channels, at least one and at most as many as
/// columns
Image Strips(std::span<const Image> images);

/// x and y of the normals of a normal map [0,1]^3, times `scale`, made unit again. @param image  with R, G, B
void ScaleNormals(Image* image, float scale);

}  // namespace lacquer
