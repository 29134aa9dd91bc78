#include "pbrt/image/png_file.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <deque>
#include <exception>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

namespace lacquer {

namespace {

/// Keywords of texts as images of any format have them, and as the PNG specification has them (11.3.4.2).
constexpr std::pair<std::string_view, std::string_view> kKeywords[] = {
    {"Artist", "Author"},
    {"DocumentName", "Title"},
    {"ImageDescription", "Description"},
};
/// Longer texts are left out; files of many chunks may have more of them than there is memory.
constexpr size_t kMaxText = size_t(1) << 20;
constexpr png_uint_32 kMaxKeptChunks = 32;
constexpr double kMetresPerInch = 0.0254;

bool AreEqualButForCase(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

/// What is wrong, as libpng says it.
[[noreturn]] void OnError(png_structp png, png_const_charp message) {
    *static_cast<std::string*>(png_get_error_ptr(png)) = message;
    png_longjmp(png, 1);
}
void OnWarning(png_structp, png_const_charp) {}

/// What libpng has of a file; who makes it frees it.
struct Handles {
    Handles() = default;
    Handles(const Handles&) = delete;
    Handles& operator=(const Handles&) = delete;

    /// Calls libpng, which leaves its functions by a jump where something is wrong: `calls` may hold nothing
    /// that has to be destroyed. Errors: std::runtime_error with what is wrong.
    template <class Calls>
    void Try(const Calls& calls) {
        if (!info) throw std::runtime_error("there is no memory for libpng");
        if (setjmp(png_jmpbuf(png)) != 0) throw std::runtime_error(problem);
        calls();
    }

    png_structp png = nullptr;
    png_infop info = nullptr;
    std::string problem;  ///< set by OnError
};

// ---- Reading ----

/// A file that is read, closed and freed whatever happens.
struct OpenFile : Handles {
    explicit OpenFile(const std::string& path) : file(std::fopen(path.c_str(), "rb")) {
        if (!file) throw std::runtime_error(std::strerror(errno));
        png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &problem, OnError, OnWarning);
        info = png ? png_create_info_struct(png) : nullptr;
    }
    ~OpenFile() {
        png_destroy_read_struct(&png, &info, nullptr);
        std::fclose(file);
    }

    std::FILE* file;
};

class Reader : public ImageReader {
  public:
    explicit Reader(const std::string& path) : in_(path) {
        in_.Try([&] {
            png_init_io(in_.png, in_.file);
            png_set_chunk_cache_max(in_.png, kMaxKeptChunks);
            png_read_info(in_.png, in_.info);
            png_set_expand(in_.png);
            if constexpr (std::endian::native == std::endian::little) png_set_swap(in_.png);
            numPasses_ = png_set_interlace_handling(in_.png);
            png_read_update_info(in_.png, in_.info);
        });
        Describe();
    }

    const ImageContents& Contents() const override { return contents_; }
    /// Whether there are notes that only OpenImageIO understands.
    bool HasNotesOfCameras() const { return hasNotesOfCameras_; }

    void Read(ValueType type, void* values) override { ReadRows(0, contents_.resolution.y, type, values); }

    void ReadRows(int begin, int end, ValueType type, void* values) override {
        if (type != contents_.type) throw std::invalid_argument("PNG files are read as what they are");
        auto* bytes = static_cast<unsigned char*>(values);
        if (begin < nextRow_) throw std::logic_error("rows of PNG files are read in their order, and once");
        if (numPasses_ > 1) {
            if (interlaced_.empty()) ReadInterlaced();
            std::copy(interlaced_.data() + rowBytes_ * size_t(begin),
                      interlaced_.data() + rowBytes_ * size_t(end), bytes);
            return;
        }
        in_.Try([&] {
            for (; nextRow_ < begin; ++nextRow_) png_read_row(in_.png, bytes, nullptr);
            for (; nextRow_ < end; ++nextRow_, bytes += rowBytes_) png_read_row(in_.png, bytes, nullptr);
        });
    }

  private:
    /// Each pass over the rows adds pixels to those of the passes before.
    void ReadInterlaced() {
        std::vector<unsigned char> image(rowBytes_ * size_t(contents_.resolution.y));
        in_.Try([&] {
            for (int pass = 0; pass < numPasses_; ++pass)
                for (int y = 0; y < contents_.resolution.y; ++y)
                    png_read_row(in_.png, image.data() + rowBytes_ * size_t(y), nullptr);
        });
        interlaced_ = std::move(image);
    }

    void Describe() {
        constexpr std::array<const char*, 4> kColors = {"R", "G", "B", "A"}, kGreys = {"Y", "A"};
        const int numChannels = png_get_channels(in_.png, in_.info);
        const auto& names = numChannels < 3 ? kGreys : kColors;
        contents_.channels.assign(names.begin(), names.begin() + numChannels);
        contents_.type = png_get_bit_depth(in_.png, in_.info) == 16 ? ValueType::UInt16 : ValueType::UInt8;
        contents_.resolution = {int(png_get_image_width(in_.png, in_.info)),
                                int(png_get_image_height(in_.png, in_.info))};
        contents_.fullResolution = contents_.resolution;
        rowBytes_ = png_get_rowbytes(in_.png, in_.info);
        // Zero where there are none, or none in pixels.
        contents_.origin = {png_get_x_offset_pixels(in_.png, in_.info),
                            png_get_y_offset_pixels(in_.png, in_.info)};
        hasNotesOfCameras_ = png_get_valid(in_.png, in_.info, PNG_INFO_eXIf) != 0;
        DescribeTexts();
        DescribeDate();
        DescribePixelSize();
    }
    void DescribeTexts() {
        png_textp texts = nullptr;
        int numTexts = 0;
        png_get_text(in_.png, in_.info, &texts, &numTexts);
        for (int i = 0; i < numTexts; ++i) {
            std::string name = texts[i].key;
            for (const auto& [inImage, inFile] : kKeywords)
                if (AreEqualButForCase(name, inFile)) name = inImage;
            hasNotesOfCameras_ |=
                AreEqualButForCase(name, "XML:com.adobe.xmp") || name.starts_with("Raw profile type");
            const std::string_view text = texts[i].text ? texts[i].text : "";
            if (!name.empty() && text.size() <= kMaxText)
                contents_.attributes.emplace_back(name, std::string(text));
        }
    }
    void DescribeDate() {
        png_timep t = nullptr;
        if (png_get_tIME(in_.png, in_.info, &t) && t)
            contents_.attributes.emplace_back(
                "DateTime", fmt::format("{:04}:{:02}:{:02} {:02}:{:02}:{:02}", t->year, t->month, t->day,
                                        t->hour, t->minute, t->second));
    }

    void DescribePixelSize() {
        png_uint_32 x = 0, y = 0;
        int unit = PNG_RESOLUTION_UNKNOWN;
        if (!png_get_pHYs(in_.png, in_.info, &x, &y, &unit) || x == 0 || y == 0) return;
        const double scale = unit == PNG_RESOLUTION_METER ? kMetresPerInch : 1;
        contents_.attributes.emplace_back("ResolutionUnit", unit == PNG_RESOLUTION_METER ? "inch" : "none");
        contents_.attributes.emplace_back("XResolution", float(x * scale));
        contents_.attributes.emplace_back("YResolution", float(y * scale));
        contents_.attributes.emplace_back("PixelAspectRatio", float(y) / float(x));
    }

    OpenFile in_;
    ImageContents contents_;
    size_t rowBytes_ = 0;
    int numPasses_ = 1, nextRow_ = 0;
    bool hasNotesOfCameras_ = false;
    std::vector<unsigned char> interlaced_;
};

// ---- Writing ----

/// A file in memory, freed whatever happens.
struct NewFile : Handles {
    NewFile() {
        png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &problem, OnError, OnWarning);
        info = png ? png_create_info_struct(png) : nullptr;
    }
    ~NewFile() { png_destroy_write_struct(&png, &info); }

    std::vector<unsigned char> bytes;
};

void Append(png_structp png, png_bytep data, size_t size) {
    auto* bytes = static_cast<std::vector<unsigned char>*>(png_get_io_ptr(png));
    bool hasMemory = true;
    try {
        bytes->insert(bytes->end(), data, data + size);
    } catch (const std::exception&) {
        hasMemory = false;
    }
    if (!hasMemory) png_error(png, "there is no memory for the file");
}

/// Attributes that say how another file is stored, or that a PNG file has in other ways.
bool IsText(std::string_view name) {
    for (const char* other : {"compression", "planarconfig", "DateTime", "ResolutionUnit"})
        if (name == other) return false;
    // A keyword is more than blanks.
    const auto isPrintable = [](unsigned char c) { return c > ' ' && c < 127; };
    return !name.starts_with("oiio:") && std::any_of(name.begin(), name.end(), isPrintable);
}

template <class Value>
const Value* ValueOf(const ImageContents& contents, std::string_view name) {
    for (const auto& [known, value] : contents.attributes)
        if (known == name) return std::get_if<Value>(&value);
    return nullptr;
}

/// What a file says beside its pixels, as libpng wants it: texts point to their characters.
class Notes {
  public:
    explicit Notes(const ImageContents& contents) {
        for (const auto& [name, value] : contents.attributes)
            if (const auto* text = std::get_if<std::string>(&value))
                if (IsText(name) && text->size() <= kMaxText) AddText(name, *text);
        SetDate(contents);
        SetPixelSize(contents);
    }
    /// Calls libpng, so that it may leave by a jump.
    void Write(png_structp png, png_infop info) const {
        if (!texts_.empty()) png_set_text(png, info, texts_.data(), int(texts_.size()));
        if (hasDate_) png_set_tIME(png, info, &date_);
        if (perUnitX_ > 0) png_set_pHYs(png, info, perUnitX_, perUnitY_, unit_);
    }

  private:
    void AddText(std::string_view name, const std::string& text) {
        for (const auto& [inImage, inFile] : kKeywords)
            if (name == inImage) name = inFile;
        constexpr size_t kMaxKeyword = 79;
        keys_.emplace_back(name.substr(0, kMaxKeyword));
        // Texts other than ASCII are UTF-8, which has a chunk of its own.
        const bool isAscii = std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 128; });
        png_text entry{};
        entry.compression = isAscii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
        entry.key = keys_.back().data();
        entry.text = const_cast<char*>(text.c_str());  // libpng copies it
        (isAscii ? entry.text_length : entry.itxt_length) = text.size();
        texts_.push_back(entry);
    }
    void SetDate(const ImageContents& contents) {
        const auto* const text = ValueOf<std::string>(contents, "DateTime");
        int t[6];
        if (!text || std::sscanf(text->c_str(), "%4d:%2d:%2d %2d:%2d:%2d", &t[0], &t[1], &t[2], &t[3], &t[4],
                                 &t[5]) != 6)
            return;
        hasDate_ = t[0] >= 0 && t[1] >= 1 && t[1] <= 12 && t[2] >= 1 && t[2] <= 31 && t[3] >= 0 &&
                   t[3] <= 23 && t[4] >= 0 && t[4] <= 59 && t[5] >= 0 && t[5] <= 60;
        date_ = {png_uint_16(t[0]), png_byte(t[1]), png_byte(t[2]),
                 png_byte(t[3]),    png_byte(t[4]), png_byte(t[5])};
    }
    void SetPixelSize(const ImageContents& contents) {
        const auto *const x = ValueOf<float>(contents, "XResolution"), *const y = ValueOf<float>(
                                                                           contents, "YResolution");
        const auto* const unit = ValueOf<std::string>(contents, "ResolutionUnit");
        if (!x || !y) return;
        const bool isInch = unit && (*unit == "inch" || *unit == "in"), isCm = unit && *unit == "cm";
        const double scale = isInch ? 1 / kMetresPerInch : isCm ? 100 : 1;
        const double perUnitX = std::round(double(*x) * scale), perUnitY = std::round(double(*y) * scale);
        constexpr double kMax = 0x7fffffff;
        if (!(perUnitX >= 1 && perUnitX <= kMax && perUnitY >= 1 && perUnitY <= kMax)) return;
        perUnitX_ = png_uint_32(perUnitX);
        perUnitY_ = png_uint_32(perUnitY);
        unit_ = isInch || isCm ? PNG_RESOLUTION_METER : PNG_RESOLUTION_UNKNOWN;
    }

    std::vector<png_text> texts_;
    std::deque<std::string> keys_;  // which stay where they are
    bool hasDate_ = false;
    png_time date_{};
    png_uint_32 perUnitX_ = 0, perUnitY_ = 0;
    int unit_ = PNG_RESOLUTION_UNKNOWN;
};

}  // namespace

std::unique_ptr<ImageReader> OpenPng(const std::string& path) {
    auto reader = std::make_unique<Reader>(path);
    if (reader->HasNotesOfCameras()) return nullptr;
    return reader;
}

std::vector<unsigned char> EncodePng(const ImageContents& contents, const unsigned char* values) {
    constexpr std::array<int, 5> kTypes = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                           PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    const size_t numChannels = contents.channels.size();
    if (numChannels < 1 || numChannels > 4 || contents.type != ValueType::UInt8)
        throw std::invalid_argument("PNG files have one to four channels of bytes here");
    const Notes notes(contents);
    const auto width = png_uint_32(contents.resolution.x), height = png_uint_32(contents.resolution.y);
    NewFile out;
    out.Try([&] {
        png_set_write_fn(out.png, &out.bytes, Append, nullptr);
        png_set_IHDR(out.png, out.info, width, height, 8, kTypes[numChannels], PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB_gAMA_and_cHRM(out.png, out.info, PNG_sRGB_INTENT_PERCEPTUAL);
        if (contents.origin != Int2(0))
            png_set_oFFs(out.png, out.info, contents.origin.x, contents.origin.y, PNG_OFFSET_PIXEL);
        notes.Write(out.png, out.info);
        png_write_info(out.png, out.info);
        for (png_uint_32 y = 0; y < height; ++y)
            png_write_row(out.png, const_cast<unsigned char*>(values) + y * width * numChannels);
        png_write_end(out.png, out.info);
    });
    return std::move(out.bytes);
}

}  // namespace lacquer
