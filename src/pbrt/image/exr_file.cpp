#include "pbrt/image/exr_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

#include <Imath/ImathBox.h>
#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfCompressionAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFloatVectorAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTileDescription.h>
#include <OpenEXR/ImfVecAttribute.h>
#include <fmt/format.h>
#include <glm/gtc/type_ptr.hpp>

#include "pbrt/image/half.h"
#include "pbrt/image/operations.h"

namespace lacquer {

namespace {

// ---- Names ----

/// Names of attributes as images of any format have them, and as OpenEXR's standard has them.
constexpr std::pair<std::string_view, std::string_view> kStandardNames[] = {
    {"DateTime", "capDate"},
    {"ImageDescription", "comments"},
    {"Copyright", "owner"},
    {"PixelAspectRatio", "pixelAspectRatio"},
};

std::string NameInImage(std::string_view name) {
    for (const auto& [inImage, inFile] : kStandardNames)
        if (name == inFile) return std::string(inImage);
    return std::string(name);
}

std::string NameInFile(std::string_view name) {
    for (const auto& [inImage, inFile] : kStandardNames)
        if (name == inImage) return std::string(inFile);
    return std::string(name);
}

/// What the library itself keeps in the header beside the size.
bool IsStructure(std::string_view name) {
    for (const char* structural : {"channels", "dataWindow", "displayWindow", "lineOrder", "tiles", "type",
                                   "name", "version", "chunkCount", "maxSamplesPerPixel", "preview"})
        if (name == structural) return true;
    return false;
}

/// Lossless ones come first.
constexpr std::pair<std::string_view, Imf::Compression> kCompressions[] = {
    {"none", Imf::NO_COMPRESSION},   {"rle", Imf::RLE_COMPRESSION},   {"zips", Imf::ZIPS_COMPRESSION},
    {"zip", Imf::ZIP_COMPRESSION},   {"piz", Imf::PIZ_COMPRESSION},   {"pxr24", Imf::PXR24_COMPRESSION},
    {"b44", Imf::B44_COMPRESSION},   {"b44a", Imf::B44A_COMPRESSION}, {"dwaa", Imf::DWAA_COMPRESSION},
    {"dwab", Imf::DWAB_COMPRESSION},
};
constexpr size_t kNumLossless = 5;

/// Where the library finds one channel of rows, whose pixels have the values of all channels after each
/// other.
template <class Value>
Imf::Slice SliceOf(Imf::PixelType type, const Value* first, const ImageContents& contents, int row,
                   int rows) {
    const size_t pixel = sizeof(Value) * contents.channels.size();
    return Imf::Slice::Make(type, first, {contents.origin.x, contents.origin.y + row}, contents.resolution.x,
                            rows, pixel, pixel * size_t(contents.resolution.x));
}

// ---- Reading ----

template <class Value>
std::vector<float> Floats(const Value& value) {
    static_assert(sizeof value % sizeof(float) == 0);
    std::vector<float> floats(sizeof value / sizeof(float));
    std::memcpy(floats.data(), &value, sizeof value);
    return floats;
}

/// Empty for types that nobody asks for.
std::optional<MetadataValue> ValueOf(const Imf::Attribute& attribute) {
    const auto as = [&]<class T>(std::type_identity<T>) -> const T* {
        const auto* typed = dynamic_cast<const Imf::TypedAttribute<T>*>(&attribute);
        return typed ? &typed->value() : nullptr;
    };
    if (const auto* value = as(std::type_identity<int>{})) return *value;
    if (const auto* value = as(std::type_identity<float>{})) return *value;
    if (const auto* value = as(std::type_identity<std::string>{})) return *value;
    if (const auto* value = as(std::type_identity<Imf::FloatVector>{})) return *value;
    if (const auto* value = as(std::type_identity<Imath::V2f>{})) return Floats(*value);
    if (const auto* value = as(std::type_identity<Imath::V3f>{})) return Floats(*value);
    if (const auto* value = as(std::type_identity<Imath::M33f>{})) return Floats(*value);
    if (const auto* value = as(std::type_identity<Imf::Chromaticities>{})) return Floats(*value);
    if (const auto* value = as(std::type_identity<Imath::M44f>{})) {
        // Rows of the row-vector convention are columns one after the other.
        return glm::mat4(glm::make_mat4((*value)[0]));
    }
    if (const auto* value = as(std::type_identity<Imf::Compression>{}))
        for (const auto& [name, compression] : kCompressions)
            if (compression == *value) return std::string(name);
    return std::nullopt;
}

/// Colours and alpha come first in a layer, in this order.
size_t RankOf(std::string_view channel, std::string_view layer) {
    constexpr std::array<std::string_view, 4> kFirst = {"R", "G", "B", "A"};
    const std::string_view name = channel.substr(layer.empty() ? 0 : layer.size() + 1);
    return size_t(std::find(kFirst.begin(), kFirst.end(), name) - kFirst.begin());
}

std::vector<std::string> OrderedChannels(const Imf::ChannelList& list) {
    std::vector<std::string> names;
    for (auto it = list.begin(); it != list.end(); ++it) names.emplace_back(it.name());
    std::stable_sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
        const std::string_view layerA = LayerOfChannel(a), layerB = LayerOfChannel(b);
        if (layerA != layerB) return layerA < layerB;
        return RankOf(a, layerA) < RankOf(b, layerB);
    });
    return names;
}

/// Corner and size. Windows may claim more than an int counts.
std::pair<Int2, Int2> WindowOf(const Imath::Box2i& box) {
    const auto size = [](int min, int max) {
        constexpr int64_t kMost = 1 << 30;  // more than any image may have
        return int(std::clamp(int64_t(max) - min + 1, int64_t(0), kMost));
    };
    return {{box.min.x, box.min.y}, {size(box.min.x, box.max.x), size(box.min.y, box.max.y)}};
}

ImageContents ContentsOf(const Imf::Header& header) {
    ImageContents contents;
    std::tie(contents.origin, contents.resolution) = WindowOf(header.dataWindow());
    std::tie(contents.fullOrigin, contents.fullResolution) = WindowOf(header.displayWindow());
    contents.isDeep = header.hasType() && Imf::isDeepData(header.type());
    if (header.hasTileDescription()) contents.tileRows = int(header.tileDescription().ySize);
    contents.channels = OrderedChannels(header.channels());
    for (const std::string& name : contents.channels) {
        const Imf::Channel& channel = header.channels()[name];
        if (channel.xSampling != 1 || channel.ySampling != 1)
            throw std::runtime_error(
                fmt::format("channel \"{}\" has fewer samples than pixels, which is not supported", name));
        contents.channelTypes.push_back(channel.type == Imf::HALF ? ValueType::Half : ValueType::Float);
    }
    const std::vector<ValueType>& types = contents.channelTypes;
    const bool anyFloat = std::find(types.begin(), types.end(), ValueType::Float) != types.end();
    contents.type = anyFloat ? ValueType::Float : ValueType::Half;
    if (std::adjacent_find(types.begin(), types.end(), std::not_equal_to<>()) == types.end())
        contents.channelTypes.clear();
    for (auto it = header.begin(); it != header.end(); ++it)
        if (!IsStructure(it.name()))
            if (std::optional<MetadataValue> value = ValueOf(it.attribute()))
                contents.attributes.emplace_back(NameInImage(it.name()), std::move(*value));
    return contents;
}

class ExrReader : public ImageReader {
  public:
    explicit ExrReader(const std::string& path)
        : file_(path.c_str(), 0), contents_(ContentsOf(file_.header(0))) {}

    const ImageContents& Contents() const override { return contents_; }

    void Read(ValueType type, void* values) override { ReadRows(0, contents_.resolution.y, type, values); }

    void ReadRows(int begin, int end, ValueType type, void* values) override {
        if (type != ValueType::Float) throw std::logic_error("EXR files are read as floats");
        // Buffers of whole rows are made here rather than before anybody has looked at the size.
        if (!part_) part_.emplace(file_, 0);
        Imf::FrameBuffer buffer;
        for (size_t c = 0; c < contents_.channels.size(); ++c)
            buffer.insert(contents_.channels[c], SliceOf(Imf::FLOAT, static_cast<float*>(values) + c,
                                                         contents_, begin, end - begin));
        part_->setFrameBuffer(buffer);
        part_->readPixels(contents_.origin.y + begin, contents_.origin.y + end - 1);
    }

  private:
    Imf::MultiPartInputFile file_;
    ImageContents contents_;
    std::optional<Imf::InputPart> part_;
};

// ---- Writing ----

class BytesStream : public Imf::OStream {
  public:
    BytesStream() : Imf::OStream("memory") {}
    void write(const char* bytes, int count) override {
        if (bytes_.size() < position_ + size_t(count)) bytes_.resize(position_ + size_t(count));
        std::memcpy(bytes_.data() + position_, bytes, size_t(count));
        position_ += size_t(count);
    }
    uint64_t tellp() override { return position_; }
    void seekp(uint64_t position) override { position_ = size_t(position); }
    std::vector<unsigned char> Take() { return std::move(bytes_); }

  private:
    std::vector<unsigned char> bytes_;
    size_t position_ = 0;
};

/// Adds an attribute of the type that its name or its size asks for.
struct InsertInto {
    Imf::Header* header;
    std::string name;

    void operator()(int value) const { header->insert(name, Imf::IntAttribute(value)); }
    void operator()(float value) const { header->insert(name, Imf::FloatAttribute(value)); }
    void operator()(const std::string& value) const { header->insert(name, Imf::StringAttribute(value)); }
    void operator()(const glm::mat4& value) const {
        Imath::M44f matrix;
        std::copy_n(glm::value_ptr(value), 16, matrix[0]);
        header->insert(name, Imf::M44fAttribute(matrix));
    }
    void operator()(const std::vector<float>& v) const {
        if (name == "chromaticities" && v.size() == 8)
            header->insert(
                name, Imf::ChromaticitiesAttribute({{v[0], v[1]}, {v[2], v[3]}, {v[4], v[5]}, {v[6], v[7]}}));
        else if (v.size() == 2)
            header->insert(name, Imf::V2fAttribute({v[0], v[1]}));
        else if (v.size() == 3)
            header->insert(name, Imf::V3fAttribute({v[0], v[1], v[2]}));
        else
            header->insert(name, Imf::FloatVectorAttribute(v));
    }
};

/// What an image came packed with stays, unless it would lose something.
void SetCompression(const MetadataValue& value, Imf::Header* header) {
    const auto* const wanted = std::get_if<std::string>(&value);
    for (size_t i = 0; wanted && i < kNumLossless; ++i)
        if (kCompressions[i].first == *wanted) header->compression() = kCompressions[i].second;
}

/// OpenImageIO's notes on a file that it has read are none of the next one's.
bool IsNoteOfReading(std::string_view name) { return name.starts_with("oiio:"); }

void AddAttributes(const ImageContents& contents, Imf::Header* header) {
    for (const auto& [name, value] : contents.attributes) {
        if (name == "compression")
            SetCompression(value, header);
        else if (!IsStructure(name) && !IsNoteOfReading(name))
            std::visit(InsertInto{header, NameInFile(name)}, value);
    }
}

Imath::Box2i BoxOf(Int2 corner, Int2 size) {
    return {{corner.x, corner.y}, {corner.x + size.x - 1, corner.y + size.y - 1}};
}

Imf::Header HeaderOf(const ImageContents& contents) {
    const Imath::Box2i data = BoxOf(contents.origin, contents.resolution);
    const bool hasFrame = contents.fullResolution.x > 0 && contents.fullResolution.y > 0;
    Imf::Header header(hasFrame ? BoxOf(contents.fullOrigin, contents.fullResolution) : data, data);
    header.compression() = Imf::ZIP_COMPRESSION;
    AddAttributes(contents, &header);
    for (size_t c = 0; c < contents.channels.size(); ++c) {
        const ValueType type = contents.channelTypes.empty() ? contents.type : contents.channelTypes[c];
        header.channels().insert(contents.channels[c],
                                 Imf::Channel(type == ValueType::Half ? Imf::HALF : Imf::FLOAT));
    }
    return header;
}

}  // namespace

std::unique_ptr<ImageReader> OpenExr(const std::string& path) { return std::make_unique<ExrReader>(path); }

std::vector<unsigned char> EncodeExr(const ImageContents& contents, const float* values) {
    constexpr int kRowsAtOnce = 64;  // of halves; floats are taken where they are
    const Imf::Header header = HeaderOf(contents);
    const size_t numChannels = contents.channels.size(), width = size_t(contents.resolution.x);
    const bool hasHalves =
        contents.type == ValueType::Half || std::ranges::count(contents.channelTypes, ValueType::Half) > 0;
    std::vector<uint16_t> halves;
    BytesStream stream;
    {
        Imf::OutputFile file(stream, header, 0);
        for (int row = 0; row < contents.resolution.y; row += kRowsAtOnce) {
            const int rows = std::min(kRowsAtOnce, contents.resolution.y - row);
            const float* const floats = values + numChannels * width * size_t(row);
            if (hasHalves) {
                halves.resize(numChannels * width * size_t(rows));
                std::transform(floats, floats + halves.size(), halves.begin(), FloatToHalf);
            }
            Imf::FrameBuffer buffer;
            for (size_t c = 0; c < numChannels; ++c) {
                const std::string& name = contents.channels[c];
                const bool isHalf = header.channels()[name].type == Imf::HALF;
                buffer.insert(name, isHalf ? SliceOf(Imf::HALF, halves.data() + c, contents, row, rows)
                                           : SliceOf(Imf::FLOAT, floats + c, contents, row, rows));
            }
            file.setFrameBuffer(buffer);
            file.writePixels(rows);
        }
    }
    return stream.Take();
}

}  // namespace lacquer
