#include "pbrt/image/safetensors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "pbrt/core/check.h"
#include "pbrt/core/json_number.h"
#include "pbrt/core/output_file.h"
#include "pbrt/image/half.h"

namespace lacquer {
namespace {

constexpr size_t kMaxTensorHeader = size_t(16) << 20, kMaxTensorFile = size_t(4) << 30;

}  // namespace

std::string TensorShapeText(std::span<const size_t> shape) {
    std::string text;
    for (const size_t n : shape) text += fmt::format("{}{}", text.empty() ? "" : " x ", n);
    return text;
}

SafetensorsFile::SafetensorsFile(const std::string& path)
    : path_(path), bytes_(ReadFileBytes(path, {}, {.maxBytes = kMaxTensorFile})) {
    const std::string_view all = bytes_.View();
    uint64_t length = 0;
    if (all.size() < sizeof length) throw FileError(path, "is too short for a file of tensors (safetensors)");
    std::memcpy(&length, all.data(), sizeof length);
    if (length > kMaxTensorHeader)
        throw FileError(
            path, fmt::format("is no file of tensors (safetensors): its header would have {} bytes, and "
                              "the limit is {}",
                              length, kMaxTensorHeader));
    if (length > all.size() - sizeof length)
        throw FileError(path, fmt::format("is cut off: its header has {} bytes, and {} are there", length,
                                          all.size() - sizeof length));
    numbers_ = all.substr(sizeof length + size_t(length));
    ReadHeader(all.substr(sizeof length, size_t(length)));
}

void SafetensorsFile::ReadHeader(std::string_view text) {
    const auto header = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!header.is_object())
        throw FileError(path_, "is no file of tensors (safetensors): its header is not JSON");
    for (const auto& [name, value] : header.items()) {
        if (name == "__metadata__") {
            if (!value.is_object()) continue;
            for (const auto& [key, said] : value.items())
                if (said.is_string()) metadata_.emplace(key, said.get<std::string>());
            continue;
        }
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
    CheckPlaces();
}

void SafetensorsFile::CheckPlaces() const {
    std::vector<const std::pair<const std::string, Entry>*> ordered;
    for (const auto& named : entries_)
        if (named.second.begin < named.second.end) ordered.push_back(&named);
    std::ranges::sort(ordered, {}, [](const auto* named) { return named->second.begin; });
    for (size_t i = 1; i < ordered.size(); ++i)
        if (ordered[i]->second.begin < ordered[i - 1]->second.end)
            throw FileError(path_, fmt::format("has tensors \"{}\" and \"{}\" in the same bytes",
                                               Excerpt(ordered[i - 1]->first), Excerpt(ordered[i]->first)));
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
