#include "pbrt/bxdfs/tensor_file.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <span>

namespace lacquer {
namespace {

constexpr std::string_view kMagic("tensor_file\0", 12);
constexpr size_t kMaxFile = size_t(4) << 30;
/// Measured materials have ten fields of at most five dimensions.
constexpr uint32_t kMaxFields = 1000;
constexpr uint16_t kMaxDimensions = 16;

// Types as the file numbers them.
constexpr int kUInt8 = 1, kFloat32 = 10, kNumTypes = 12;
constexpr const char* kTypeNames[kNumTypes] = {"nothing", "u8",  "i8",  "u16", "i16", "u32",
                                               "i32",     "u64", "i64", "f16", "f32", "f64"};
constexpr size_t kTypeSizes[kNumTypes] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};

/// Reads numbers one after another; says where the file ends too early.
class Cursor {
  public:
    Cursor(std::string_view bytes, const TensorFile& file) : bytes_(bytes), file_(file) {}
    size_t Offset() const { return at_; }
    std::string_view Take(size_t size, std::string_view what) {
        if (size > bytes_.size() - at_)
            file_.Fail("", fmt::format("the file ends at byte {} within {}", bytes_.size(), what));
        at_ += size;
        return bytes_.substr(at_ - size, size);
    }
    template <class T>
    T Number(std::string_view what) {
        T value;
        std::memcpy(&value, Take(sizeof(T), what).data(), sizeof(T));
        return value;
    }

  private:
    std::string_view bytes_;
    const TensorFile& file_;
    size_t at_ = 0;
};

std::string ShapeText(std::span<const size_t> shape) { return fmt::format("{}", fmt::join(shape, " x ")); }

}  // namespace

void TensorFile::Fail(std::string_view field, const std::string& message) const {
    const std::string where = field.empty() ? "" : fmt::format("field \"{}\": ", Excerpt(field));
    throw SceneError(loc_, fmt::format("\"{}\": {}{}", path_, where, message));
}

TensorFile::TensorFile(const std::string& path, const FileLoc& loc)
    : path_(path), loc_(loc), file_(ReadFileBytes(path, loc, {kMaxFile})) {
    const std::string_view bytes = file_.View();
    if (!bytes.starts_with(kMagic))
        Fail("", "the file does not begin with \"tensor_file\"; expected a measured BRDF (.bsdf)");
    Cursor cursor(bytes, *this);
    cursor.Take(kMagic.size(), "its head");
    const int major = cursor.Number<uint8_t>("its head"), minor = cursor.Number<uint8_t>("its head");
    if (major != 1) Fail("", fmt::format("version {}.{} of the format; expected 1.0", major, minor));
    const uint32_t numFields = cursor.Number<uint32_t>("its head");
    if (numFields > kMaxFields)
        Fail("", fmt::format("byte 14: {} fields; expected at most {}", numFields, kMaxFields));

    for (uint32_t i = 0; i < numFields; ++i) {
        const std::string what = fmt::format("the description of field {} of {}", i + 1, numFields);
        Field field;
        const size_t start = cursor.Offset();
        field.name = cursor.Take(cursor.Number<uint16_t>(what), what);
        const uint16_t dimensions = cursor.Number<uint16_t>(what);
        field.type = cursor.Number<uint8_t>(what);
        const uint64_t offset = cursor.Number<uint64_t>(what);
        if (field.type < 1 || field.type >= kNumTypes)
            Fail(field.name, fmt::format("unknown type {} at byte {}", field.type, start));
        if (dimensions < 1 || dimensions > kMaxDimensions)
            Fail(field.name, fmt::format("{} dimensions at byte {}; expected 1 to {}", dimensions, start,
                                         kMaxDimensions));
        // The number of values, as far as it can fit into the file.
        field.numValues = 1;
        for (int d = 0; d < dimensions; ++d) {
            const uint64_t size = cursor.Number<uint64_t>(what);
            if (size < 1) Fail(field.name, fmt::format("dimension {} at byte {} is 0", d + 1, start));
            if (size > bytes.size() / field.numValues)
                Fail(field.name,
                     fmt::format("its data, described at byte {}, is larger than the file", start));
            field.numValues *= size;
            field.shape.push_back(size);
        }
        const size_t size = field.numValues * kTypeSizes[field.type];
        if (offset > bytes.size() || size > bytes.size() - offset)
            Fail(field.name, fmt::format("{} bytes at offset {} lie outside of the file, which has {}", size,
                                         offset, bytes.size()));
        field.offset = offset;
        fields_.push_back(std::move(field));
    }
}

const TensorFile::Field& TensorFile::Find(std::string_view name, int type, size_t dimensions) const {
    for (const Field& field : fields_) {
        if (field.name != name) continue;
        if (field.type != type || field.shape.size() != dimensions)
            Fail(name,
                 fmt::format("{} of type {}; expected {} of type {}", ShapeText(field.shape),
                             kTypeNames[field.type],
                             dimensions == 1 ? "one dimension" : fmt::format("{} dimensions", dimensions),
                             kTypeNames[type]));
        return field;
    }
    Fail(name, "is missing");
}

FloatTensor TensorFile::Floats(std::string_view name, size_t dimensions) const {
    const Field& field = Find(name, kFloat32, dimensions);
    FloatTensor tensor{field.shape, std::vector<float>(field.numValues)};
    std::memcpy(tensor.values.data(), file_.data.get() + field.offset, field.numValues * sizeof(float));
    for (size_t i = 0; i < field.numValues; ++i)
        if (!std::isfinite(tensor.values[i]))
            Fail(name, fmt::format("value {} at byte {} is not finite", i + 1, field.offset + 4 * i));
    return tensor;
}

std::string_view TensorFile::Bytes(std::string_view name) const {
    const Field& field = Find(name, kUInt8, 1);
    return file_.View().substr(field.offset, field.numValues);
}

}  // namespace lacquer
