#include "pbrt/image/png_file.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
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

/// Calls libpng, which leaves its functions by a jump where something is wrong: `calls` may hold nothing that
/// has to be destroyed. Errors: std::runtime_error with `problem`, which OnError has set.
template <class Calls>
void Try(png_structp png, const std::string& problem, const Calls& calls) {
    if (setjmp(png_jmpbuf(png)) != 0) throw std::runtime_error(problem);
    calls();
}

// ---- Reading ----

/// A file that is read, closed and freed whatever happens.
struct OpenFile {
    explicit OpenFile(const std::string& path) : file(std::fopen(path.c_str(), "rb")) {
        if (!file) throw std::runtime_error(std::strerror(errno));
        png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &problem, OnError, OnWarning);
        info = png ? png_create_info_struct(png) : nullptr;
    }
    ~OpenFile() {
        png_destroy_read_struct(&png, &info, nullptr);
        std::fclose(file);
    }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;

    template <class Calls>
    void Try(const Calls& calls) {
        lacquer::Try(png, problem, calls);
    }

    std::FILE* file;
    png_structp png = nullptr;
    png_infop info = nullptr;
    std::string problem;
};

class Reader : public ImageReader {
  public:
    explicit Reader(const std::string& path) : in_(path) {
        if (!in_.info) throw std::runtime_error("there is no memory for libpng");
        in_.Try([&] {
            png_init_io(in_.png, in_.file);
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
        interlaced_.resize(rowBytes_ * size_t(contents_.resolution.y));
        in_.Try([&] {
            for (int pass = 0; pass < numPasses_; ++pass)
                for (int y = 0; y < contents_.resolution.y; ++y)
                    png_read_row(in_.png, interlaced_.data() + rowBytes_ * size_t(y), nullptr);
        });
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
    }
    void DescribeTexts() {
        png_textp texts = nullptr;
        int numTexts = 0;
        png_get_text(in_.png, in_.info, &texts, &numTexts);
        for (int i = 0; i < numTexts; ++i) {
            std::string name = texts[i].key;
            for (const auto& [inImage, inFile] : kKeywords)
                if (AreEqualButForCase(name, inFile)) name = inImage;
            hasNotesOfCameras_ |= name == "XML:com.adobe.xmp" || name.starts_with("Raw profile type");
            contents_.attributes.emplace_back(name, std::string(texts[i].text ? texts[i].text : ""));
        }
    }
    void DescribeDate() {
        png_timep t = nullptr;
        if (png_get_tIME(in_.png, in_.info, &t) && t)
            contents_.attributes.emplace_back(
                "DateTime", fmt::format("{:04}:{:02}:{:02} {:02}:{:02}:{:02}", t->year, t->month, t->day,
                                        t->hour, t->minute, t->second));
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
struct NewFile {
    NewFile() {
        png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &problem, OnError, OnWarning);
        info = png ? png_create_info_struct(png) : nullptr;
        if (!info) throw std::runtime_error("there is no memory for libpng");
    }
    ~NewFile() { png_destroy_write_struct(&png, &info); }
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    png_structp png = nullptr;
    png_infop info = nullptr;
    std::string problem;
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

/// The texts of a file, as libpng wants them: pointers to their characters.
class Texts {
  public:
    explicit Texts(const ImageContents& contents) {
        for (const auto& [name, value] : contents.attributes)
            if (const auto* text = std::get_if<std::string>(&value)) Add(name, *text);
    }
    const std::vector<png_text>& All() const { return texts_; }

  private:
    void Add(std::string_view name, const std::string& text) {
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
    std::vector<png_text> texts_;
    std::deque<std::string> keys_;  // which stay where they are
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
    const Texts texts(contents);
    const auto width = png_uint_32(contents.resolution.x), height = png_uint_32(contents.resolution.y);
    NewFile out;
    Try(out.png, out.problem, [&] {
        png_set_write_fn(out.png, &out.bytes, Append, nullptr);
        png_set_IHDR(out.png, out.info, width, height, 8, kTypes[numChannels], PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB_gAMA_and_cHRM(out.png, out.info, PNG_sRGB_INTENT_PERCEPTUAL);
        if (contents.origin != Int2(0))
            png_set_oFFs(out.png, out.info, contents.origin.x, contents.origin.y, PNG_OFFSET_PIXEL);
        if (!texts.All().empty())
            png_set_text(out.png, out.info, texts.All().data(), int(texts.All().size()));
        png_write_info(out.png, out.info);
        for (png_uint_32 y = 0; y < height; ++y)
            png_write_row(out.png, const_cast<unsigned char*>(values) + y * width * numChannels);
        png_write_end(out.png, out.info);
    });
    return std::move(out.bytes);
}

}  // namespace lacquer
