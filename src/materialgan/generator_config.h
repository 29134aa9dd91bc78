// The shape of a StyleGAN2 generator [Karras et al. 2020] of maps, and the names of its tensors.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

namespace lacquer::materialgan {

/// Configuration F with skip connections, in the layout of the published network of [Guo et al. 2020b].
struct GeneratorConfig {
    static constexpr int kMinResolution = 8, kMaxResolution = 1024, kMaxMaps = 1024, kMaxLatent = 4096;

    int resolution = 64;        ///< texels along an edge; a power of two in [8, 1024]
    int mapsMax = 128;          ///< feature maps at the coarsest resolutions
    int mapsBase = 2048;        ///< feature maps times resolution at the finest ones
    int latentSize = 128;       ///< numbers of z and of a column of w
    int mappingLayers = 4;      ///< from z to w
    double lrMultiplier = 0.1;  ///< of the mapping: its weights are stored divided by it
    /// What channel 5 of generated maps is clamped to.
    std::array<double, 2> roughnessRange{-1, 1};

    int NumFeatureMaps(int res) const;
    /// Styled layers: one at 4 x 4, two at each resolution above.
    int NumLayers() const;
    /// Columns of w+: one for each styled layer, and the last one's colours have their own.
    int NumColumns() const { return NumLayers() + 1; }
    /// 4, 8, ..., resolution.
    std::vector<int> Resolutions() const;
    /// Edge of the noise map of each styled layer: 4, 8, 8, 16, 16, ...
    std::vector<int> NoiseResolutions() const;

    /// As in the metadata of a file, and back. @param path  of the file, for messages
    /// Errors of FromMetadata: FileError for what lacks, is no number, out of range, or an empty range.
    std::map<std::string, std::string> ToMetadata() const;
    static GeneratorConfig FromMetadata(const std::map<std::string, std::string>& metadata,
                                        const std::string& path);
    bool operator==(const GeneratorConfig&) const = default;
};

inline constexpr const char* kGeneratorFormat = "lacquer-stylegan2";

struct TensorSpec {
    std::string name;
    std::vector<size_t> shape;
};
/// All parameters of mapping and synthesis, in a fixed order. Noise maps and statistics are not among them.
std::vector<TensorSpec> GeneratorTensors(const GeneratorConfig& config);

/// "synthesis.layer3", "synthesis.output1", "mapping.dense0".
std::string LayerName(int layer);
std::string OutputName(int output);
std::string DenseName(int layer);
/// The mean of w, and the fixed noise map of a layer: 1 x 1 x res x res.
inline constexpr const char* kMeanW = "truncation.w_avg";
/// Standard deviation of each number of w (ours; optional).
inline constexpr const char* kDeviationW = "truncation.w_std";
std::string FixedNoiseName(int layer);

}  // namespace lacquer::materialgan
