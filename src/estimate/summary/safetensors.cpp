#include "estimate/summary/safetensors.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "pbrt/core/json_number.h"
#include "pbrt/image/half.h"

namespace lacquer::estimate {
namespace {

constexpr size_t kMaxHeader = size_t(16) << 20, kMaxFile = size_t(4) << 30;

std::string ShapeText(std::span<const size_t> shape) {
    std::string text;
    for (const size_t n : shape) text += fmt::format("{}{}", text.empty() ? "" : " x ", n);
    return text;
}

}  // namespace

TensorFile::TensorFile(const std::string& path)
    : path_(path), bytes_(ReadFileBytes(path, {}, {.maxBytes = kMaxFile})) {
    const std::string_view all = bytes_.View();
    uint64_t length = 0;
    if (all.size() < sizeof length) throw FileError(path, "is too short for a file of tensors (safetensors)");
    std::memcpy(&length, all.data(), sizeof length);
    if (length > kMaxHeader)
        throw FileError(
            path, fmt::format("is no file of tensors (safetensors): its header would have {} bytes, and "
                              "the limit is {}",
                              length, kMaxHeader));
    if (length > all.size() - sizeof length)
        throw FileError(path, fmt::format("is cut off: its header has {} bytes, and {} are there", length,
                                          all.size() - sizeof length));
    numbers_ = all.substr(sizeof length + size_t(length));
    ReadHeader(all.substr(sizeof length, size_t(length)));
}

void TensorFile::ReadHeader(std::string_view text) {
    const auto header = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!header.is_object())
        throw FileError(path_, "is no file of tensors (safetensors): its header is not JSON");
    for (const auto& [name, value] : header.items()) {
        if (name == "__metadata__") continue;
        Entry entry;
        try {
            entry.type = value.at("dtype").get<std::string>();
            entry.shape = WholeNumbers<size_t>(value.at("shape"));
            const auto& offsets = value.at("data_offsets");
            entry.begin = WholeNumber<size_t>(offsets.at(0));
            entry.end = WholeNumber<size_t>(offsets.at(1));
        } catch (const nlohmann::json::exception&) {
            throw FileError(
                path_, fmt::format("says of tensor \"{}\" not what one needs: dtype, shape and data_offsets",
                                   Excerpt(name)));
        }
        if (entry.begin > entry.end || entry.end > numbers_.size())
            throw FileError(path_, fmt::format("has tensor \"{}\" in bytes {} to {} of {}", Excerpt(name),
                                               entry.begin, entry.end, numbers_.size()));
        entries_.emplace(name, std::move(entry));
    }
}

std::vector<float> TensorFile::Read(const std::string& name, std::span<const size_t> shape) const {
    const auto found = entries_.find(name);
    if (found == entries_.end()) throw FileError(path_, fmt::format("has no tensor \"{}\"", name));
    const Entry& entry = found->second;
    if (!std::ranges::equal(entry.shape, shape))
        throw FileError(path_, fmt::format("has tensor \"{}\" of shape {}, and {} is needed", name,
                                           ShapeText(entry.shape), ShapeText(shape)));
    const bool isHalf = entry.type == "F16";
    if (!isHalf && entry.type != "F32")
        throw FileError(path_, fmt::format("has tensor \"{}\" of type {}; known are F32 and F16", name,
                                           Excerpt(entry.type)));
    size_t count = 1;
    for (const size_t n : shape) count *= n;
    if (entry.end - entry.begin != count * (isHalf ? 2 : 4))
        throw FileError(path_, fmt::format("has {} bytes of tensor \"{}\", which needs {}",
                                           entry.end - entry.begin, name, count * (isHalf ? 2 : 4)));
    std::vector<float> values(count);
    const char* from = numbers_.data() + entry.begin;
    if (!isHalf) {
        std::memcpy(values.data(), from, 4 * count);
        return values;
    }
    for (size_t i = 0; i < count; ++i) {
        uint16_t half;
        std::memcpy(&half, from + 2 * i, 2);
        values[i] = HalfToFloat(half);
    }
    return values;
}

}  // namespace lacquer::estimate
