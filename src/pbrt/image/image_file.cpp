// Reading of image files: what may be meant to break a reader is found before OpenEXR, libpng or OpenImageIO
// sees it.
#include "pbrt/image/image_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numeric>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "pbrt/core/error.h"
#include "pbrt/image/exr_file.h"
#include "pbrt/image/file_damage.h"
#include "pbrt/image/image_library.h"
#include "pbrt/image/png_file.h"

namespace lacquer {

namespace {

namespace fs = std::filesystem;

/// Of the pixels in the full frame.
constexpr int64_t kMaxOffset = int64_t(1) << 28;

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
        CheckBytes(SizeOf(NativeType()));
        ChooseChannels();
        header_.resolution = contents_.resolution;
        header_.colorSpace = &ColorSpace::SRGB();
        SetFormat();
        MakeTable();
        for (const auto& [name, value] : contents_.attributes) metadata_[name] = value;
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
        const Int2 corner = contents_.origin - contents_.fullOrigin;
        image.dataWindow = {corner, corner + contents_.resolution};
        image.fullResolution = contents_.fullResolution;
        CheckPixels();
        float* const pixels = image.Pixels().data();
        ReadAs(
            contents_.resolution.y, [&](ValueType type, void* data) { input_->Read(type, data); }, pixels);
        return image;
    }

    void CheckPixels() const {
        if (const std::string damage = PixelDamage(path_, format_); !damage.empty())
            Damaged("the image is damaged: " + damage);
    }

    int RowsAtOnce() const { return contents_.tileRows > 0 ? contents_.tileRows : 16; }

    void ReadRows(int begin, int end, float* values) {
        const auto read = [&](ValueType type, void* data) { input_->ReadRows(begin, end, type, data); };
        ReadAs(end - begin, read, values);
    }

  private:
    [[noreturn]] void Damaged(const std::string& problem) const {
        throw SceneError(loc_, fmt::format("{}: {}", path_, problem));
    }
    /// Runs what asks the library.
    template <class Function>
    void Ask(const Function& ask) const {
        try {
            ask();
        } catch (const std::exception& e) {
            Damaged(fmt::format("the image is damaged: {}", OneLine(e.what())));
        }
    }

    void Open(bool wasRead) {
        start_ = ReadStart(path_, loc_);
        if (start_.empty()) Damaged("the image file is empty");
        format_ = FormatOf(start_, ExtensionOf(path_));
        if (format_.empty()) DamagedAsUnknown();
        if (const std::string damage = wasRead ? "" : FileDamage(path_, format_); !damage.empty())
            Damaged("the image is damaged: " + damage);
        Ask([&] {
            input_ = format_ == "openexr" ? OpenExr(path_) : format_ == "png" ? OpenPng(path_) : nullptr;
        });
        if (!input_) {
            const ImageLibrary& library = LoadImageLibrary();
            Ask([&] { input_ = library.Open(format_, path_); });
        }
        if (!input_) DamagedAsUnknown();
        contents_ = input_->Contents();
    }
    [[noreturn]] void DamagedAsUnknown() const {
        Damaged("this is not an image of a known kind (PNG, EXR, JPEG, TGA, BMP, GIF, HDR, PFM, PPM, TIFF)");
    }

    void CheckLimits() const {
        const Int2 size = contents_.resolution;
        if (contents_.isDeep) Damaged("deep images are not supported");
        if (contents_.depth > 1) Damaged("volume images are not supported");
        if (size.x < 1 || size.y < 1 || NumStored() < 1) Damaged("the image has no pixels");
        if (size.x > kMaxImageSide || size.y > kMaxImageSide)
            Damaged(fmt::format("the image has {} x {} pixels; the limit is {} a side", size.x, size.y,
                                kMaxImageSide));
        if (NumStored() > size_t(kMaxImageChannels))
            Damaged(
                fmt::format("the image has {} channels; the limit is {}", NumStored(), kMaxImageChannels));
        for (const Int2 start : {contents_.origin, contents_.fullOrigin})
            if (std::abs(int64_t(start.x)) > kMaxOffset || std::abs(int64_t(start.y)) > kMaxOffset)
                Damaged("the image's data window is out of range");
    }

    /// @param valueBytes  of each value in memory
    void CheckBytes(size_t valueBytes) const {
        const size_t bytes =
            size_t(contents_.resolution.x) * size_t(contents_.resolution.y) * NumStored() * valueBytes;
        if (bytes > kMaxImageBytes)
            Damaged(
                fmt::format("the image has {} x {} pixels in {} channels and takes {} MiB; the limit is {}",
                            contents_.resolution.x, contents_.resolution.y, NumStored(), bytes >> 20,
                            kMaxImageBytes >> 20));
    }

    /// Which channels of the file are kept, in which order, and under which names.
    void ChooseChannels() {
        const size_t n = NumStored();
        if (format_ == "openexr" || format_ == "tiff") {
            for (const char* name : {"R", "G", "B", "A"}) KeepChannel(name);
            for (const std::string& name : contents_.channels) KeepChannel(name);
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
        const auto it = std::find(contents_.channels.begin(), contents_.channels.end(), name);
        if (it == contents_.channels.end()) return;
        header_.channels.push_back(name);
        source_.push_back(int(it - contents_.channels.begin()));
    }

    void SetFormat() {
        const bool isPng = format_ == "png";
        if (contents_.type == ValueType::UInt8) {
            header_.format = PixelFormat::Byte;
            header_.encoding = isPng ? encoding_ : ColorEncoding{ColorEncoding::Kind::SRGB, 1};
        } else if ((contents_.type == ValueType::UInt16 && isPng) || contents_.type == ValueType::Half) {
            header_.format = PixelFormat::Half;
        }
        for (const ValueType type : contents_.channelTypes)
            if (type != ValueType::Half && header_.format == PixelFormat::Half)
                header_.format = PixelFormat::Float;
    }

    /// The type in which the file's values are read.
    ValueType NativeType() const {
        if (contents_.type == ValueType::UInt8) return ValueType::UInt8;
        return format_ == "png" ? ValueType::UInt16 : ValueType::Float;
    }
    static size_t SizeOf(ValueType type) {
        return type == ValueType::UInt8 ? 1 : type == ValueType::UInt16 ? 2 : sizeof(float);
    }
    /// Channels in the file.
    size_t NumStored() const { return contents_.channels.size(); }

    /// Linear values of the integers of a file.
    void MakeTable() {
        if (NativeType() == ValueType::UInt8) {
            const std::array<float, 256> table = header_.encoding.ByteTable();
            table_.assign(table.begin(), table.end());
        } else if (NativeType() == ValueType::UInt16) {
            table_.resize(1 << 16);
            for (size_t i = 0; i < table_.size(); ++i) table_[i] = encoding_.ToLinear(float(i) / 65535);
        }
    }

    /// Reads `rows` rows by read(type, data) and decodes them.
    template <class ReadNative>
    void ReadAs(int rows, const ReadNative& read, float* out) {
        const ValueType type = NativeType();
        if (type == ValueType::UInt8)
            ReadAndDecode<uint8_t>(
                type, rows, read, [&](uint8_t v) { return table_[v]; }, out);
        else if (type == ValueType::UInt16)
            ReadAndDecode<uint16_t>(
                type, rows, read, [&](uint16_t v) { return table_[v]; }, out);
        else if (IsIdentity())
            Ask([&] { read(type, out); });
        else
            ReadAndDecode<float>(
                type, rows, read, [](float v) { return v; }, out);
    }

    bool IsIdentity() const {
        for (size_t i = 0; i < source_.size(); ++i)
            if (source_[i] != int(i)) return false;
        return source_.size() == NumStored();
    }

    template <class Native, class ReadNative, class Decode>
    void ReadAndDecode(ValueType type, int rows, const ReadNative& read, const Decode& decode, float* out) {
        std::vector<Native> native(size_t(contents_.resolution.x) * size_t(rows) * NumStored());
        Ask([&] { read(type, native.data()); });
        for (size_t i = 0; i < native.size(); i += NumStored())
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

    std::string path_;
    FileLoc loc_;
    ColorEncoding encoding_;
    std::string start_, format_;
    std::unique_ptr<ImageReader> input_;
    ImageContents contents_;
    ImageHeader header_;
    Metadata metadata_;
    std::vector<int> source_;  // where each kept channel is in the file
    std::vector<float> table_;
};

ImageFile::ImageFile(const std::string& path, ColorEncoding encoding, const FileLoc& loc, bool wasRead)
    : reader_(std::make_unique<Reader>(path, encoding, loc, wasRead)) {}
ImageFile::~ImageFile() = default;
const ImageHeader& ImageFile::Header() const { return reader_->Header(); }
Image ImageFile::Read() { return reader_->Read(); }
void ImageFile::CheckPixels() const { reader_->CheckPixels(); }
int ImageFile::RowsAtOnce() const { return reader_->RowsAtOnce(); }
void ImageFile::ReadRows(int begin, int end, float* values) { reader_->ReadRows(begin, end, values); }

}  // namespace lacquer
