#include "pbrt/image/safetensors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "pbrt/core/check.h"
#include "pbrt/core/json_number.h"
#include "pbrt/core/output_file.h"
#include "pbrt/image/half.h"

namespace lacquer {
namespace {

constexpr size_t kMaxTensorHeader = size_t(16) << 20, kMaxTensorFile = size_t(4) << 30;
/// Far more than tensors have; and a header has three levels.
constexpr size_t kMaxDimensions = 16;
constexpr int kMaxHeaderDepth = 8;

/// Errors: FileError.
nlohmann::json ParseTensorHeader(std::string_view text, const std::string& path) {
    using Event = nlohmann::json::parse_event_t;
    std::set<std::string> names;
    // Every level takes many times the memory of its bracket. Of two tensors of one name one would be lost.
    const auto check = [&](int depth, Event event, nlohmann::json& parsed) {
        if (depth > kMaxHeaderDepth)
            throw FileError(path, "is no file of tensors (safetensors): its header is nested too deeply");
        if (event == Event::key && depth == 1 && !names.insert(parsed.get<std::string>()).second)
            throw FileError(path, fmt::format("has tensor \"{}\" twice", Excerpt(parsed.get<std::string>())));
        return true;
    };
    auto header = nlohmann::json::parse(text, check, /*allow_exceptions=*/false);
    if (!header.is_object())
        throw FileError(path, "is no file of tensors (safetensors): its header is not JSON");
    return header;
}

}  // namespace

std::string TensorShapeText(std::span<const size_t> shape) {
    std::string text;
    for (const size_t n : shape) text += fmt::format("{}{}", text.empty() ? "" : " x ", n);
    return text;
}

SafetensorsFile::SafetensorsFile(const std::string& path) : path_(path) {
    const ReadLimits limits{.maxBytes = kMaxTensorFile};
    // The header first, since files of gigabytes that are something else are not worth their memory.
    std::string head = ReadFirstBytes(path, {}, sizeof(uint64_t));
    const bool isZipped = head.starts_with("\x1f\x8b");
    if (isZipped) {
        bytes_ = ReadFileBytes(path, {}, limits);
        head = bytes_.View().substr(0, sizeof(uint64_t));
    }
    std::error_code ignored;  // then it is too short
    const size_t size = isZipped ? bytes_.size : size_t(std::filesystem::file_size(path, ignored));
    const size_t length = HeaderLength(head, size), begin = sizeof(uint64_t) + length;
    head = isZipped ? std::string(bytes_.View().substr(0, begin)) : ReadFirstBytes(path, {}, begin);
    if (head.size() < begin) throw FileError(path, "changed while it was read");
    ReadHeader(std::string_view(head).substr(sizeof(uint64_t)), size - begin);
    if (!isZipped) bytes_ = ReadFileBytes(path, {}, limits);
    if (bytes_.size != size) throw FileError(path, "changed while it was read");
    numbers_ = bytes_.View().substr(begin);
}

size_t SafetensorsFile::HeaderLength(std::string_view start, size_t numBytes) const {
    uint64_t length = 0;
    if (start.size() < sizeof length || numBytes < sizeof length)
        throw FileError(path_, "is too short for a file of tensors (safetensors)");
    std::memcpy(&length, start.data(), sizeof length);
    if (length > kMaxTensorHeader)
        throw FileError(
            path_, fmt::format("is no file of tensors (safetensors): its header would have {} bytes, and "
                               "the limit is {}",
                               length, kMaxTensorHeader));
    if (length > numBytes - sizeof length)
        throw FileError(path_, fmt::format("is cut off: its header has {} bytes, and {} are there", length,
                                           numBytes - sizeof length));
    return size_t(length);
}

void SafetensorsFile::ReadHeader(std::string_view text, size_t numBytes) {
    const auto header = ParseTensorHeader(text, path_);
    for (const auto& [name, value] : header.items()) {
        if (name != "__metadata__") {
            entries_.emplace(name, ReadEntry(name, value, numBytes));
            continue;
        }
        if (!value.is_object()) continue;
        for (const auto& [key, said] : value.items())
            if (said.is_string()) metadata_.emplace(key, said.get<std::string>());
    }
    CheckPlaces(numBytes);
}

SafetensorsFile::Entry SafetensorsFile::ReadEntry(const std::string& name, const nlohmann::json& value,
                                                  size_t numBytes) const {
    Entry entry;
    try {
        entry.type = value.at("dtype").get<std::string>();
        entry.shape = WholeNumbers<size_t>(value.at("shape"));
        const auto& offsets = value.at("data_offsets");
        entry.begin = WholeNumber<size_t>(offsets.at(0));
        entry.end = WholeNumber<size_t>(offsets.at(1));
    } catch (const nlohmann::json::exception&) {
        throw FileError(path_,
                        fmt::format("says of tensor \"{}\" not what one needs: dtype, shape and data_offsets",
                                    Excerpt(name)));
    }
    if (entry.shape.size() > kMaxDimensions)
        throw FileError(path_, fmt::format("has tensor \"{}\" of {} dimensions, and the limit is {}",
                                           Excerpt(name), entry.shape.size(), kMaxDimensions));
    if (entry.begin > entry.end || entry.end > numBytes)
        throw FileError(path_, fmt::format("has tensor \"{}\" in bytes {} to {} of {}", Excerpt(name),
                                           entry.begin, entry.end, numBytes));
    return entry;
}

void SafetensorsFile::CheckPlaces(size_t numBytes) const {
    std::vector<const std::pair<const std::string, Entry>*> ordered;
    size_t end = 0;
    for (const auto& named : entries_) {
        if (named.second.begin < named.second.end) ordered.push_back(&named);
        end = std::max(end, named.second.end);
    }
    std::ranges::sort(ordered, {}, [](const auto* named) { return named->second.begin; });
    for (size_t i = 1; i < ordered.size(); ++i)
        if (ordered[i]->second.begin < ordered[i - 1]->second.end)
            throw FileError(path_, fmt::format("has tensors \"{}\" and \"{}\" in the same bytes",
                                               Excerpt(ordered[i - 1]->first), Excerpt(ordered[i]->first)));
    if (end < numBytes)
        throw FileError(path_,
                        fmt::format("has {} bytes behind its tensors, which end at {}", numBytes - end, end));
}

const SafetensorsFile::Entry& SafetensorsFile::Find(const std::string& name) const {
    const auto found = entries_.find(name);
    if (found == entries_.end()) throw FileError(path_, fmt::format("has no tensor \"{}\"", name));
    return found->second;
}

std::vector<std::string> SafetensorsFile::Names() const {
    std::vector<std::string> names;
    for (const auto& [name, entry] : entries_) names.push_back(name);
    return names;
}

std::vector<float> SafetensorsFile::Read(const std::string& name, std::span<const size_t> shape) const {
    const Entry& entry = Find(name);
    if (!std::ranges::equal(entry.shape, shape))
        throw FileError(path_, fmt::format("has tensor \"{}\" of shape {}, and {} is needed", name,
                                           TensorShapeText(entry.shape), TensorShapeText(shape)));
    const bool isHalf = entry.type == "F16";
    if (!isHalf && entry.type != "F32")
        throw FileError(path_, fmt::format("has tensor \"{}\" of type {}; known are F32 and F16", name,
                                           Excerpt(entry.type)));
    // No more than there are bytes, so that products of sizes cannot wrap around.
    const size_t bytesEach = isHalf ? 2 : 4, numThere = (entry.end - entry.begin) / bytesEach;
    size_t count = 1;
    for (const size_t n : shape) count = n > 0 && count > numThere / n ? numThere + 1 : count * n;
    if (entry.end - entry.begin != count * bytesEach)
        throw FileError(path_,
                        fmt::format("has {} bytes of tensor \"{}\" of shape {} and type {}",
                                    entry.end - entry.begin, name, TensorShapeText(shape), entry.type));
    std::vector<float> values = Decode(entry, count);
    if (!std::ranges::all_of(values, [](float v) { return std::isfinite(v); }))
        throw FileError(path_, fmt::format("has tensor \"{}\" with numbers that are not finite", name));
    return values;
}

std::vector<float> SafetensorsFile::Decode(const Entry& entry, size_t count) const {
    std::vector<float> values(count);
    const char* from = numbers_.data() + entry.begin;
    if (entry.type == "F32") {
        if (count > 0) std::memcpy(values.data(), from, 4 * count);
        return values;
    }
    for (size_t i = 0; i < count; ++i) {
        uint16_t half;
        std::memcpy(&half, from + 2 * i, 2);
        values[i] = HalfToFloat(half);
    }
    return values;
}

void WriteSafetensors(const std::string& path, std::span<const NamedTensor> tensors,
                      const std::map<std::string, std::string>& metadata, bool half) {
    const size_t bytesEach = half ? 2 : 4;
    nlohmann::ordered_json header;
    if (!metadata.empty()) header["__metadata__"] = metadata;
    size_t end = 0;
    for (const NamedTensor& tensor : tensors) {
        size_t count = 1;
        for (const size_t n : tensor.shape) count *= n;
        LACQUER_CHECK(count == tensor.values.size());
        const size_t begin = end;
        end += count * bytesEach;
        header[tensor.name] = {
            {"dtype", half ? "F16" : "F32"}, {"shape", tensor.shape}, {"data_offsets", {begin, end}}};
    }
    std::string text = header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    // Numbers start at a multiple of eight bytes, for readers that map the file into memory.
    text.append((8 - text.size() % 8) % 8, ' ');
    const uint64_t length = text.size();
    OutputFile file(path);
    file.Write(std::string_view(reinterpret_cast<const char*>(&length), sizeof length));
    file.Write(text);
    for (const NamedTensor& tensor : tensors) {
        if (!half) {
            file.Write(std::string_view(reinterpret_cast<const char*>(tensor.values.data()),
                                        4 * tensor.values.size()));
            continue;
        }
        std::vector<uint16_t> halves(tensor.values.size());
        std::ranges::transform(tensor.values, halves.begin(), FloatToHalf);
        file.Write(std::string_view(reinterpret_cast<const char*>(halves.data()), 2 * halves.size()));
    }
    file.Finish();
}

}  // namespace lacquer
