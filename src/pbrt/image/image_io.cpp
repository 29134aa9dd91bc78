// Knows OpenImageIO, as tile_cache.cpp does, and nothing else.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <stdexcept>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "pbrt/core/temporary_file.h"
#include "pbrt/image/file_damage.h"
#include "pbrt/image/half.h"
#include "pbrt/image/image.h"
#include "pbrt/image/image_file.h"

namespace lacquer {

namespace {

namespace fs = std::filesystem;

/// A message of the library on one line, without trailing blanks.
std::string OneLine(const std::string& message) {
    std::string line;
    for (char c : message) {
        const bool blank = std::iscntrl(static_cast<unsigned char>(c)) || c == ' ';
        if (!blank)
            line += c;
        else if (!line.empty() && line.back() != ' ')
            line += ' ';
    }
    while (!line.empty() && line.back() == ' ') line.pop_back();
    return line.empty() ? "the data are incomplete or make no sense" : line;
}

// ---- Reading ----

/// First bytes of the file. Errors: FileError.
std::string ReadStart(const std::string& path, const FileLoc& loc) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) throw FileError(path, "there is no such file", loc);
    // Pipes and devices might never end.
    if (status.type() != fs::file_type::regular) throw FileError(path, "is not a regular file", loc);
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) throw FileError(path, fmt::format("cannot be opened: {}", std::strerror(errno)), loc);
    std::string start(32, '\0');
    file.read(start.data(), std::streamsize(start.size()));
    start.resize(size_t(file.gcount()));
    return start;
}

/// OpenImageIO's name of the file's format by its first bytes, or by its extension for Targa files, which
/// have no mark; empty for anything else. Readers of other formats get no chance with bytes that may be meant
/// to break them.
std::string FormatOf(const std::string& start, const std::string& extension) {
    struct Magic {
        size_t offset;
        std::string bytes;
        const char* format;
    };
    static const std::vector<Magic> magics = {
        {0, "\x89PNG\r\n\x1a\n", "png"},
        {0, "\x76\x2f\x31\x01", "openexr"},
        {0, "\xff\xd8\xff", "jpeg"},
        {0, "GIF8", "gif"},
        {0, "BM", "bmp"},
        {0, "#?", "hdr"},
        {0, "PF", "pnm"},
        {0, "Pf", "pnm"},
        {0, "P6", "pnm"},
        {0, "P5", "pnm"},
        {0, "P3", "pnm"},
        {0, "P2", "pnm"},
        {0, std::string("II*\0", 4), "tiff"},
        {0, std::string("MM\0*", 4), "tiff"},
        {8, "WEBP", "webp"},
    };
    // A Targa file may begin with any byte.
    if (extension == "tga") return "targa";
    for (const Magic& m : magics)
        if (start.size() >= m.offset + m.bytes.size() &&
            start.compare(m.offset, m.bytes.size(), m.bytes) == 0)
            return m.format;
    return "";
}

}  // namespace

class ImageFile::Reader {
  public:
    Reader(const std::string& path, ColorEncoding encoding, const FileLoc& loc, bool wasRead)
        : path_(path), loc_(loc), encoding_(encoding) {
        Open(wasRead);
        CheckLimits();
        CheckBytes(NativeType().size());
        ChooseChannels();
        header_.resolution = {spec_.width, spec_.height};
        header_.colorSpace = &ColorSpace::SRGB();
        SetFormat();
        MakeTable();
        for (const OIIO::ParamValue& p : spec_.extra_attribs) ReadAttribute(p);
        ReadColorSpace();
    }

    const ImageHeader& Header() const { return header_; }

    Image Read() {
        CheckBytes(sizeof(float));
        Image image(header_.resolution, header_.channels);
        image.format = header_.format;
        image.encoding = header_.encoding;
        image.SetColorSpace(header_.colorSpace);
        image.metadata = std::move(metadata_);
        image.dataWindow = {
            Int2(spec_.x - spec_.full_x, spec_.y - spec_.full_y),
            Int2(spec_.x - spec_.full_x + spec_.width, spec_.y - spec_.full_y + spec_.height)};
        image.fullResolution = {spec_.full_width, spec_.full_height};
        CheckPixels();
        float* const pixels = image.Pixels().data();
        const auto readAll = [&](OIIO::TypeDesc type, void* data) {
            return input_->read_image(0, 0, 0, spec_.nchannels, type, data);
        };
        ReadAs(spec_.height, readAll, pixels);
        return image;
    }

    void CheckPixels() const {
        if (const std::string damage = PixelDamage(path_, format_); !damage.empty())
            Damaged("the image is damaged: " + damage);
    }

    int RowsAtOnce() const { return spec_.tile_height > 0 ? spec_.tile_height : 16; }

    void ReadRows(int begin, int end, float* values) {
        const auto readRows = [&](OIIO::TypeDesc type, void* data) {
            const int yBegin = spec_.y + begin, yEnd = spec_.y + end;
            if (spec_.tile_width == 0)
                return input_->read_scanlines(0, 0, yBegin, yEnd, 0, 0, spec_.nchannels, type, data);
            return input_->read_tiles(0, 0, spec_.x, spec_.x + spec_.width, yBegin, yEnd, 0, 1, 0,
                                      spec_.nchannels, type, data);
        };
        ReadAs(end - begin, readRows, values);
    }

  private:
    [[noreturn]] void Damaged(const std::string& problem) const {
        throw SceneError(loc_, fmt::format("{}: {}", path_, problem));
    }
    [[noreturn]] void DamagedByLibrary() const {
        Damaged(
            fmt::format("the image is damaged: {}", OneLine(input_ ? input_->geterror() : OIIO::geterror())));
    }

    void Open(bool wasRead) {
        // OpenImageIO's own check against files that claim to be enormous; it is per process.
        [[maybe_unused]] static const bool limited =
            OIIO::attribute("limits:imagesize_MB", int(kMaxImageBytes >> 20)) &&
            OIIO::attribute("limits:channels", kMaxImageChannels);
        start_ = ReadStart(path_, loc_);
        if (start_.empty()) Damaged("the image file is empty");
        format_ = FormatOf(start_, ExtensionOf(path_));
        if (!format_.empty()) input_ = OIIO::ImageInput::create(format_);
        if (!input_)
            Damaged(
                "this is not an image of a known kind (PNG, EXR, JPEG, TGA, BMP, GIF, HDR, PFM, PPM, TIFF)");
        if (const std::string damage = wasRead ? "" : FileDamage(path_, format_); !damage.empty())
            Damaged("the image is damaged: " + damage);
        OIIO::ImageSpec hints;
        hints["oiio:UnassociatedAlpha"] = 1;  // colours as they are in the file
        input_->threads(1);
        bool success = false;
        try {
            success = input_->open(path_, spec_, hints);
        } catch (const std::exception& e) {
            Damaged(fmt::format("the image is damaged: {}", OneLine(e.what())));
        }
        if (!success) DamagedByLibrary();
    }

    void CheckLimits() const {
        if (spec_.deep) Damaged("deep images are not supported");
        if (spec_.depth > 1) Damaged("volume images are not supported");
        if (spec_.width < 1 || spec_.height < 1 || spec_.nchannels < 1) Damaged("the image has no pixels");
        if (spec_.width > kMaxImageSide || spec_.height > kMaxImageSide)
            Damaged(fmt::format("the image has {} x {} pixels; the limit is {} a side", spec_.width,
                                spec_.height, kMaxImageSide));
        if (spec_.nchannels > kMaxImageChannels)
            Damaged(fmt::format("the image has {} channels; the limit is {}", spec_.nchannels,
                                kMaxImageChannels));
        for (const int64_t start :
             {int64_t(spec_.x), int64_t(spec_.y), int64_t(spec_.full_x), int64_t(spec_.full_y)})
            if (std::abs(start) > (1 << 28)) Damaged("the image's data window is out of range");
    }

    /// @param valueBytes  of each value in memory
    void CheckBytes(size_t valueBytes) const {
        const size_t bytes =
            size_t(spec_.width) * size_t(spec_.height) * size_t(spec_.nchannels) * valueBytes;
        if (bytes > kMaxImageBytes)
            Damaged(
                fmt::format("the image has {} x {} pixels in {} channels and takes {} MiB; the limit is {}",
                            spec_.width, spec_.height, spec_.nchannels, bytes >> 20, kMaxImageBytes >> 20));
    }

    /// Which channels of the file are kept, in which order, and under which names.
    void ChooseChannels() {
        const int n = spec_.nchannels;
        if (format_ == "openexr" || format_ == "tiff") {
            for (const char* name : {"R", "G", "B", "A"}) KeepChannel(name);
            for (const std::string& name : spec_.channelnames) KeepChannel(name);
            return;
        }
        // As in pbrt, alpha survives only where a PNG has colours with alpha (colour type 6); palettes with
        // transparent entries, grey with alpha, and all other formats lose it.
        constexpr size_t kColorType = 25;
        const bool alpha =
            n >= 4 && format_ == "png" && start_.size() > kColorType && start_[kColorType] == 6;
        header_.channels = n < 3 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
        if (alpha) header_.channels.push_back("A");
        source_.resize(header_.channels.size());
        std::iota(source_.begin(), source_.end(), 0);
    }
    void KeepChannel(const std::string& name) {
        if (std::find(header_.channels.begin(), header_.channels.end(), name) != header_.channels.end())
            return;
        const auto it = std::find(spec_.channelnames.begin(), spec_.channelnames.end(), name);
        if (it == spec_.channelnames.end()) return;
        header_.channels.push_back(name);
        source_.push_back(int(it - spec_.channelnames.begin()));
    }

    void SetFormat() {
        const bool isPng = format_ == "png";
        const auto type = OIIO::TypeDesc::BASETYPE(spec_.format.basetype);
        if (type == OIIO::TypeDesc::UINT8) {
            header_.format = PixelFormat::Byte;
            header_.encoding = isPng ? encoding_ : ColorEncoding{ColorEncoding::Kind::SRGB, 1};
        } else if ((type == OIIO::TypeDesc::UINT16 && isPng) || type == OIIO::TypeDesc::HALF) {
            header_.format = PixelFormat::Half;
        }
        for (const OIIO::TypeDesc& t : spec_.channelformats)
            if (t != OIIO::TypeHalf && header_.format == PixelFormat::Half)
                header_.format = PixelFormat::Float;
    }

    /// The type in which the file's values are read.
    OIIO::TypeDesc NativeType() const {
        if (spec_.format == OIIO::TypeUInt8) return OIIO::TypeUInt8;
        return format_ == "png" ? OIIO::TypeUInt16 : OIIO::TypeFloat;
    }

    /// Linear values of the integers of a file.
    void MakeTable() {
        if (NativeType() == OIIO::TypeUInt8) {
            const std::array<float, 256> table = header_.encoding.ByteTable();
            table_.assign(table.begin(), table.end());
        } else if (NativeType() == OIIO::TypeUInt16) {
            table_.resize(1 << 16);
            for (size_t i = 0; i < table_.size(); ++i) table_[i] = encoding_.ToLinear(float(i) / 65535);
        }
    }

    /// Reads `rows` rows by read(type, data) and decodes them.
    template <class ReadNative>
    void ReadAs(int rows, const ReadNative& read, float* out) {
        const OIIO::TypeDesc type = NativeType();
        if (type == OIIO::TypeUInt8)
            ReadAndDecode<uint8_t>(
                type, rows, read, [&](uint8_t v) { return table_[v]; }, out);
        else if (type == OIIO::TypeUInt16)
            ReadAndDecode<uint16_t>(
                type, rows, read, [&](uint16_t v) { return table_[v]; }, out);
        else if (IsIdentity())
            CheckedRead(type, read, out);
        else
            ReadAndDecode<float>(
                type, rows, read, [](float v) { return v; }, out);
    }

    bool IsIdentity() const {
        for (size_t i = 0; i < source_.size(); ++i)
            if (source_[i] != int(i)) return false;
        return int(source_.size()) == spec_.nchannels;
    }

    template <class ReadNative>
    void CheckedRead(OIIO::TypeDesc type, const ReadNative& read, void* data) {
        bool success = false;
        try {
            success = read(type, data);
        } catch (const std::exception& e) {
            Damaged(fmt::format("the image is damaged: {}", OneLine(e.what())));
        }
        // Some readers report damage only by their message.
        if (!success || input_->has_error()) DamagedByLibrary();
    }

    template <class Native, class ReadNative, class Decode>
    void ReadAndDecode(OIIO::TypeDesc type, int rows, const ReadNative& read, const Decode& decode,
                       float* out) {
        std::vector<Native> native(size_t(spec_.width) * size_t(rows) * size_t(spec_.nchannels));
        CheckedRead(type, read, native.data());
        for (size_t i = 0; i < native.size(); i += size_t(spec_.nchannels))
            for (int c : source_) *out++ = decode(native[i + size_t(c)]);
    }

    void ReadColorSpace() {
        const auto it = metadata_.find("chromaticities");
        if (it == metadata_.end()) return;
        const auto* values = std::get_if<std::vector<float>>(&it->second);
        if (!values || values->size() != 8) return;
        if (const ColorSpace* space = ColorSpace::FromChromaticities(values->data()))
            header_.colorSpace = space;
    }

    void ReadAttribute(const OIIO::ParamValue& p) {
        const std::string name = p.name().string();
        const OIIO::TypeDesc type = p.type();
        if (type == OIIO::TypeInt) {
            metadata_[name] = *static_cast<const int*>(p.data());
        } else if (type == OIIO::TypeUInt16 || type == OIIO::TypeUInt32) {
            metadata_[name] = p.get_int();  // what cameras write of themselves
        } else if (type == OIIO::TypeFloat) {
            metadata_[name] = *static_cast<const float*>(p.data());
        } else if (type == OIIO::TypeString) {
            metadata_[name] = p.get_string();
        } else if (type == OIIO::TypeMatrix44) {
            glm::mat4 m;
            std::memcpy(&m, p.data(), sizeof m);
            metadata_[name] = m;
        } else if (type.basetype == OIIO::TypeDesc::FLOAT) {
            const auto* values = static_cast<const float*>(p.data());
            metadata_[name] =
                std::vector<float>(values, values + type.numelements() * size_t(type.aggregate));
        }
    }

    std::string path_;
    FileLoc loc_;
    ColorEncoding encoding_;
    std::string start_, format_;
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
    ImageHeader header_;
    Metadata metadata_;
    std::vector<int> source_;  // where each kept channel is in the file
    std::vector<float> table_;
};

namespace {

// ---- Writing ----

/// Formats whose files hold floats; all others get 8-bit values.
bool HoldsFloats(const std::string& extension) {
    return extension == "exr" || extension == "tif" || extension == "tiff" || extension == "hdr";
}

/// Channels that a format takes: all of them, or the colours, or one.
std::vector<int> WrittenChannels(const Image& image, const OIIO::ImageOutput& output,
                                 const std::string& extension) {
    std::vector<int> channels(static_cast<size_t>(image.NumChannels()));
    std::iota(channels.begin(), channels.end(), 0);
    if (output.supports("nchannels")) return channels;
    const bool wantsColor = extension == "hdr" || extension == "gif";
    if (image.NumChannels() < 3) return wantsColor ? std::vector<int>{0, 0, 0} : std::vector<int>{0};
    const bool alpha = output.supports("alpha") && image.NumChannels() >= 4 && image.Channels()[3] == "A";
    channels.resize(alpha ? 4 : 3);
    return channels;
}

/// Interleaved gradient noise [Jimenez 2014] in (-1/2, 1/2): neighbouring pixels get well-spread offsets, so
/// that rounding errors average out locally.
float Dither(int x, int y, int c) {
    const double phase = 0.06711056 * (x + 37 * c) + 0.00583715 * (y + 17 * c);
    const double value = 52.9829189 * (phase - std::floor(phase));
    return float(0.998 * (value - std::floor(value) - 0.5));
}

/// 8-bit sRGB values; alpha stays linear.
std::vector<uint8_t> EncodeBytes(const Image& image, const std::vector<int>& channels) {
    const ColorEncoding srgb{ColorEncoding::Kind::SRGB, 1};
    const Int2 resolution = image.Resolution();
    const ColorSpace* space = image.ColorSpace();
    const bool convert = space && space != &ColorSpace::SRGB() && channels.size() >= 3;
    std::vector<uint8_t> bytes;
    bytes.reserve(size_t(resolution.x) * size_t(resolution.y) * channels.size());
    std::vector<float> values(channels.size());
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x) {
            for (size_t i = 0; i < channels.size(); ++i) values[i] = image.Get({x, y}, channels[i]);
            if (convert) {
                const RGB rgb = ColorSpace::SRGB().ToRGB(space->ToXYZ({values[0], values[1], values[2]}));
                for (size_t i = 0; i < 3; ++i) values[i] = rgb[int(i)];
            }
            for (size_t i = 0; i < channels.size(); ++i) {
                const float v = std::isnan(values[i]) ? 0.f : std::clamp(values[i], 0.f, 1.f);
                const bool isAlpha = image.Channels()[size_t(channels[i])] == "A";
                const float code = isAlpha ? 255 * v : 255 * srgb.FromLinear(v) + Dither(x, y, int(i));
                bytes.push_back(uint8_t(std::clamp(std::floor(code + 0.5f), 0.f, 255.f)));
            }
        }
    return bytes;
}

/// The chosen channels as floats; with `half`, finite values stay finite.
std::vector<float> EncodeFloats(const Image& image, const std::vector<int>& channels, bool half) {
    std::vector<float> values;
    values.reserve(image.Pixels().size() / size_t(image.NumChannels()) * channels.size());
    std::vector<bool> isHalf;
    for (const std::string& name : image.Channels())
        isHalf.push_back(half && !image.floatChannels.contains(name));
    for (size_t i = 0; i < image.Pixels().size(); i += size_t(image.NumChannels()))
        for (int c : channels) {
            const float v = image.Pixels()[i + size_t(c)];
            const bool limit = isHalf[size_t(c)] && std::isfinite(v);
            values.push_back(limit ? std::clamp(v, -kMaxHalf, kMaxHalf) : v);
        }
    return values;
}

void AddMetadata(const Image& image, OIIO::ImageSpec* spec) {
    for (const auto& [name, value] : image.metadata) {
        if (const auto* i = std::get_if<int>(&value)) spec->attribute(name, *i);
        if (const auto* f = std::get_if<float>(&value)) spec->attribute(name, *f);
        if (const auto* s = std::get_if<std::string>(&value)) spec->attribute(name, *s);
        // Columns in memory one after the other are the rows that the row-vector convention asks for.
        if (const auto* m = std::get_if<glm::mat4>(&value)) spec->attribute(name, OIIO::TypeMatrix44, m);
        if (const auto* v = std::get_if<std::vector<float>>(&value); v && !v->empty())
            spec->attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, int(v->size())), v->data());
    }
    if (image.HasRGB() && image.ColorSpace() && !image.metadata.contains("chromaticities"))
        spec->attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8),
                        image.ColorSpace()->Chromaticities());
}

OIIO::ImageSpec MakeSpec(const Image& image, const std::vector<int>& channels, OIIO::TypeDesc type) {
    OIIO::ImageSpec spec(image.Resolution().x, image.Resolution().y, int(channels.size()), type);
    for (size_t i = 0; i < channels.size(); ++i) {
        spec.channelnames[i] = image.Channels()[size_t(channels[i])];
        if (spec.channelnames[i] == "A") spec.alpha_channel = int(i);
        const bool isFloat = image.floatChannels.contains(spec.channelnames[i]);
        if (type == OIIO::TypeHalf && !image.floatChannels.empty())
            spec.channelformats.push_back(isFloat ? OIIO::TypeFloat : OIIO::TypeHalf);
    }
    if (!image.dataWindow.IsEmpty()) {
        spec.x = image.dataWindow.min.x;
        spec.y = image.dataWindow.min.y;
    }
    if (image.fullResolution.x > 0 && image.fullResolution.y > 0) {
        spec.full_width = image.fullResolution.x;
        spec.full_height = image.fullResolution.y;
    }
    spec["compression"] = "zip";
    spec["oiio:UnassociatedAlpha"] = 1;
    return spec;
}

using Bytes = std::vector<unsigned char>;

/// Portable float map: a line each of kind, size and byte order, then rows from the bottom. OpenImageIO 2.4
/// reads but does not write it.
Bytes EncodePfm(const Image& image) {
    const Int2 resolution = image.Resolution();
    const int channels = image.NumChannels() >= 3 ? 3 : 1;
    constexpr bool isLittle = std::endian::native == std::endian::little;
    const std::string head = fmt::format("{}\n{} {}\n{}\n", channels == 3 ? "PF" : "Pf", resolution.x,
                                         resolution.y, isLittle ? "-1.0" : "1.0");
    Bytes bytes(head.begin(), head.end());
    for (int y = resolution.y - 1; y >= 0; --y)
        for (int x = 0; x < resolution.x; ++x)
            for (int c = 0; c < channels; ++c) {
                const auto value =
                    std::bit_cast<std::array<unsigned char, sizeof(float)>>(image.Get({x, y}, c));
                bytes.insert(bytes.end(), value.begin(), value.end());
            }
    return bytes;
}

/// All other formats. Errors: FileError about `path`.
Bytes EncodeByLibrary(const Image& image, const std::string& extension, const std::string& path, bool half) {
    // Convert the pixels.
    const auto output = OIIO::ImageOutput::create(extension);
    if (!output) throw FileError(path, OneLine(OIIO::geterror()));
    const bool isFloat = HoldsFloats(extension);
    const std::vector<int> channels = WrittenChannels(image, *output, extension);
    const OIIO::TypeDesc type = !isFloat ? OIIO::TypeUInt8 : half ? OIIO::TypeHalf : OIIO::TypeFloat;
    OIIO::ImageSpec spec = MakeSpec(image, channels, type);
    AddMetadata(image, &spec);
    spec["oiio:ColorSpace"] = isFloat ? "Linear" : "sRGB";
    const std::vector<float> floats = isFloat ? EncodeFloats(image, channels, half) : std::vector<float>();
    const std::vector<uint8_t> codes = isFloat ? std::vector<uint8_t>() : EncodeBytes(image, channels);

    // Compress them in memory: on a full disk, some of the libraries report success and others end the
    // process.
    OIIO::Filesystem::IOVecOutput memory;
    bool success = false;
    std::string problem;
    try {
        output->threads(1);
        success = output->set_ioproxy(&memory) && output->open(path, spec) &&
                  (isFloat ? output->write_image(OIIO::TypeDesc::FLOAT, floats.data())
                           : output->write_image(OIIO::TypeDesc::UINT8, codes.data()));
        success = output->close() && success;
        if (!success) problem = output->geterror();
    } catch (const std::exception& e) {
        success = false;
        problem = e.what();
    }
    if (!success) throw FileError(path, fmt::format("cannot be written: {}", OneLine(problem)));
    return std::move(memory.buffer());
}

/// Errors: FileError about `path`.
void WriteBytes(const Bytes& bytes, const std::string& name, const std::string& path) {
    errno = 0;
    std::ofstream file(name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    file.close();
    if (!file) throw FileError(path, fmt::format("cannot be written: {}", std::strerror(errno)));
}

/// Extensions whose writers exist in this OpenImageIO, in alphabetical order.
std::vector<std::string> FindWritableExtensions() {
    // Other writers than these are not offered: some display images or swallow them, some (ICO in version
    // 2.4) corrupt memory.
    constexpr std::pair<const char*, const char*> kKnown[] = {
        {"bmp", "bmp"},   {"exr", "openexr"}, {"gif", "gif"},  {"hdr", "hdr"},
        {"jpeg", "jpeg"}, {"jpg", "jpeg"},    {"pfm", "pnm"},  {"png", "png"},
        {"ppm", "pnm"},   {"tga", "targa"},   {"tif", "tiff"}, {"tiff", "tiff"},
    };
    const std::string formats = "," + std::string(OIIO::get_string_attribute("output_format_list")) + ",";
    std::vector<std::string> extensions;
    for (const auto& [extension, format] : kKnown)
        if (formats.find("," + std::string(format) + ",") != std::string::npos)
            extensions.emplace_back(extension);
    return extensions;
}

// ---- Resizing ----

/// `edge` of an image `from` pixels long, where it lies when that is `to` pixels long.
int ScaledEdge(int edge, int from, int to) { return int(std::lround(double(edge) * to / from)); }

Int2 Scaled(Int2 p, Int2 from, Int2 to) {
    return {ScaledEdge(p.x, from.x, to.x), ScaledEdge(p.y, from.y, to.y)};
}

}  // namespace

Image Resize(const Image& image, Int2 resolution) {
    const Int2 from = image.Resolution();
    const int channels = image.NumChannels();
    const double bytes = double(resolution.x) * resolution.y * channels * double(sizeof(float));
    if (resolution.x < 1 || resolution.y < 1 || resolution.x > kMaxImageSide ||
        resolution.y > kMaxImageSide || bytes > double(kMaxImageBytes))
        throw std::invalid_argument(
            fmt::format("an image of {} x {} pixels is not possible; the limits are "
                        "{} pixels a side and {} MiB",
                        resolution.x, resolution.y, kMaxImageSide, kMaxImageBytes >> 20));
    Image result(resolution, image.Channels());
    const OIIO::ImageBuf source(OIIO::ImageSpec(from.x, from.y, channels, OIIO::TypeFloat),
                                const_cast<float*>(image.Pixels().data()));
    OIIO::ImageBuf target(OIIO::ImageSpec(resolution.x, resolution.y, channels, OIIO::TypeFloat),
                          result.Pixels().data());
    if (!OIIO::ImageBufAlgo::resize(target, source, "blackman-harris", 0, {}, 1))
        throw std::invalid_argument(OneLine(target.geterror()));
    const Bounds2i& window = image.dataWindow;
    if (!window.IsEmpty()) {
        result.dataWindow.min = Scaled(window.min, from, resolution);
        result.dataWindow.max = result.dataWindow.min + resolution;
    }
    result.fullResolution = Scaled(image.fullResolution, from, resolution);
    result.metadata = image.metadata;
    result.format = image.format;
    result.encoding = image.encoding;
    result.SetColorSpace(image.ColorSpace());
    return result;
}

std::string ExtensionOf(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

Image ReadImage(const std::string& path, ColorEncoding encoding, const FileLoc& loc) {
    return ImageFile(path, encoding, loc).Read();
}

ImageFile::ImageFile(const std::string& path, ColorEncoding encoding, const FileLoc& loc, bool wasRead)
    : reader_(std::make_unique<Reader>(path, encoding, loc, wasRead)) {}
ImageFile::~ImageFile() = default;
const ImageHeader& ImageFile::Header() const { return reader_->Header(); }
Image ImageFile::Read() { return reader_->Read(); }
void ImageFile::CheckPixels() const { reader_->CheckPixels(); }
int ImageFile::RowsAtOnce() const { return reader_->RowsAtOnce(); }
void ImageFile::ReadRows(int begin, int end, float* values) { reader_->ReadRows(begin, end, values); }

std::vector<std::string> WritableExtensions() {
    static const std::vector<std::string> extensions = FindWritableExtensions();
    return extensions;
}

bool CanWriteImage(const std::string& path) {
    const std::vector<std::string> extensions = WritableExtensions();
    return std::find(extensions.begin(), extensions.end(), ExtensionOf(path)) != extensions.end();
}

void WriteImage(const Image& image, const std::string& path, bool half) {
    const std::string extension = ExtensionOf(path);
    if (!CanWriteImage(path))
        throw FileError(path, fmt::format("there is no image format \"{}\" to write; known are {}", extension,
                                          fmt::join(WritableExtensions(), ", ")));
    const fs::path folder = fs::path(path).parent_path();
    std::error_code error;
    if (!folder.empty() && !fs::is_directory(folder, error))
        throw FileError(path, fmt::format("the folder {} does not exist", folder.string()));
    if (fs::is_directory(path, error)) throw FileError(path, "is a folder");

    const Bytes bytes = extension == "pfm" ? EncodePfm(image) : EncodeByLibrary(image, extension, path, half);
    TemporaryFile file(path);
    WriteBytes(bytes, file.Name(), path);
    file.Rename();
}

}  // namespace lacquer
