#include "pbrt/film/cryptomatte.h"

#include <fmt/format.h>

#include <bit>

#include "pbrt/core/check.h"
#include "pbrt/film/manifest.h"

namespace lacquer {

uint32_t MurmurHash3(std::string_view bytes) {
    constexpr uint32_t c1 = 0xcc9e2d51, c2 = 0x1b873593;
    const auto byte = [&](size_t i) { return uint32_t(static_cast<unsigned char>(bytes[i])); };
    const auto scramble = [&](uint32_t k) { return std::rotl(k * c1, 15) * c2; };
    uint32_t h = 0;
    const size_t whole = bytes.size() / 4 * 4;
    for (size_t i = 0; i < whole; i += 4) {
        h ^= scramble(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
        h = std::rotl(h, 13) * 5 + 0xe6546b64;
    }
    uint32_t tail = 0;
    for (size_t i = whole; i < bytes.size(); ++i) tail |= byte(i) << (8 * (i - whole));
    h ^= scramble(tail);
    h ^= uint32_t(bytes.size());
    h = (h ^ h >> 16) * 0x85ebca6b;
    h = (h ^ h >> 13) * 0xc2b2ae35;
    return h ^ h >> 16;
}

uint32_t CryptomatteId(std::string_view name) {
    const uint32_t hash = MurmurHash3(name), exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

std::string CryptomattePrefix(std::string_view layer) {
    return "cryptomatte/" + fmt::format("{:08x}", CryptomatteId(layer)).substr(0, 7) + "/";
}

std::string CryptomatteManifest(std::span<const std::string> names) {
    return JsonManifest(names, [&](size_t i) { return fmt::format("\"{:08x}\"", CryptomatteId(names[i])); });
}

CryptomatteLayer::CryptomatteLayer(std::string name, std::vector<std::string> names, int ranks)
    : name_(std::move(name)), names_(std::move(names)), ranks_(ranks) {
    LACQUER_CHECK(CanHave(ranks));
    for (const std::string& n : names_) ids_.push_back(std::bit_cast<float>(CryptomatteId(n)));
}

std::vector<std::string> CryptomatteLayer::Channels() const {
    std::vector<std::string> channels;
    for (int group = 0; group < ranks_ / 2; ++group)
        for (const char component : {'r', 'g', 'b', 'a'})
            channels.push_back(fmt::format("{}{:02}.{}", name_, group, component));
    return channels;
}

void CryptomatteLayer::Develop(std::span<const IdCount> ranked, double samples, float* out) const {
    for (size_t rank = 0; rank < size_t(ranks_); ++rank) {
        const bool seen = rank < ranked.size();
        *out++ = seen ? ids_[size_t(ranked[rank].id)] : 0.f;
        *out++ = seen ? float(ranked[rank].count / samples) : 0.f;
    }
}

void CryptomatteLayer::AddMetadata(Metadata* metadata) const {
    const std::string prefix = CryptomattePrefix(name_);
    (*metadata)[prefix + "name"] = name_;
    (*metadata)[prefix + "hash"] = std::string("MurmurHash3_32");
    (*metadata)[prefix + "conversion"] = std::string("uint32_to_float32");
    (*metadata)[prefix + "manifest"] = CryptomatteManifest(names_);
}

}  // namespace lacquer
