// Cryptomatte [Friedman and Jones 2015], specification 1.2.0: mattes of objects and materials by their names,
// several to a pixel.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/film/id_counts.h"
#include "pbrt/image/image.h"

namespace lacquer {

/// MurmurHash3, x86, 32 bits, seed 0 [Appleby 2011].
uint32_t MurmurHash3(std::string_view bytes);
/// The id of a name: its hash, with the lowest bit of the exponent flipped where the number as a float would
/// be denormal, infinite or NaN.
uint32_t CryptomatteId(std::string_view name);
/// The metadata prefix of a layer: "cryptomatte/" and the first seven hex digits of its name's id, and "/".
std::string CryptomattePrefix(std::string_view layer);
/// {"name":"1a2b3c4d",...}
std::string CryptomatteManifest(std::span<const std::string> names);

/// A layer of ranks: pairs of id and coverage, two to a group of channels CryptoObject00.r, .g, .b, .a.
class CryptomatteLayer {
  public:
    static constexpr int kMaxRanks = 16;
    /// Ranks come in pairs, the channels of a group.
    static bool CanHave(int ranks) { return ranks >= 2 && ranks <= kMaxRanks && ranks % 2 == 0; }
    /// @param name   "CryptoObject" or "CryptoMaterial" for compositors to find
    /// @param names  of what IdCounts' ids 0, 1, ... stand for
    /// @param ranks  ids a pixel, as CanHave() has them
    CryptomatteLayer(std::string name, std::vector<std::string> names, int ranks);

    std::vector<std::string> Channels() const;
    /// The channels of one pixel: coverage is count over samples, zeros follow the last id.
    void Develop(std::span<const IdCount> ranked, double samples, float* out) const;
    /// name, hash, conversion, manifest.
    void AddMetadata(Metadata* metadata) const;

  private:
    std::string name_;
    std::vector<std::string> names_;
    std::vector<float> ids_;
    int ranks_;
};

}  // namespace lacquer
