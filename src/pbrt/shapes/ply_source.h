// The values of a PLY file one after another, from text or from binary data of either byte order.
#pragma once

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "pbrt/shapes/ply_header.h"

namespace lacquer {

/// Binary values; `Swap` if the byte order is not this machine's (little-endian).
template <bool Swap>
class PlyBinarySource {
  public:
    PlyBinarySource(std::string_view bytes, const PlyHeader& header, const PlyContext& context)
        : begin_(bytes.data()),
          p_(bytes.data() + header.size),
          end_(bytes.data() + bytes.size()),
          context_(context) {}

    float Float(PlyType type) {
        if (type == PlyType::Float32) return Load<float>();
        if (type == PlyType::Float64) return float(Load<double>());
        return float(Integer(type));
    }
    /// Errors: SceneError for a float that is no whole number.
    int64_t Integer(PlyType type) {
        switch (type) {
            case PlyType::Int8:
                return Load<int8_t>();
            case PlyType::UInt8:
                return Load<uint8_t>();
            case PlyType::Int16:
                return Load<int16_t>();
            case PlyType::UInt16:
                return Load<uint16_t>();
            case PlyType::Int32:
                return Load<int32_t>();
            case PlyType::UInt32:
                return Load<uint32_t>();
            case PlyType::Float32:
                return Whole(double(Load<float>()));
            case PlyType::Float64:
                break;
        }
        return Whole(Load<double>());
    }
    void Skip(PlyType type, int64_t count) {
        if (count > int64_t(size_t(end_ - p_) / PlyTypeSize(type))) FailTruncated();
        p_ += size_t(count) * PlyTypeSize(type);
    }
    [[noreturn]] void Fail(const std::string& message) const {
        context_.FailAtByte(size_t(p_ - begin_), message);
    }

  private:
    template <class T>
    T Load() {
        if (size_t(end_ - p_) < sizeof(T)) FailTruncated();
        char bytes[sizeof(T)];
        std::memcpy(bytes, p_, sizeof(T));
        if constexpr (Swap) std::reverse(bytes, bytes + sizeof(T));
        p_ += sizeof(T);
        return std::bit_cast<T>(bytes);
    }
    int64_t Whole(double value) const {
        if (!(std::abs(value) < 1e15) || value != std::floor(value))
            Fail("a fraction where a whole number is expected");
        return int64_t(value);
    }
    [[noreturn]] void FailTruncated() const { Fail("the data ends too early; the header declares more"); }

    const char *begin_, *p_, *end_;
    const PlyContext& context_;
};

/// Values in text, separated by white space of any kind. Types only matter for integers.
class PlyTextSource {
  public:
    PlyTextSource(std::string_view bytes, const PlyHeader& header, const PlyContext& context)
        : begin_(bytes.data()),
          p_(bytes.data() + header.size),
          end_(bytes.data() + bytes.size()),
          context_(context) {}

    float Float(PlyType /*type*/) {
        NextToken();
        float value = 0;
        const auto [end, error] = std::from_chars(p_, end_, value);
        if (error == std::errc() && AtSeparator(end)) {
            p_ = end;
            return value;
        }
        return float(Double());
    }
    int64_t Integer(PlyType /*type*/) {
        NextToken();
        int64_t value = 0;
        const auto [end, error] = std::from_chars(p_, end_, value);
        if (error == std::errc() && AtSeparator(end)) {
            p_ = end;
            return value;
        }
        const double real = Double();
        if (!(std::abs(real) < 1e15) || real != std::floor(real))
            Fail("a fraction where a whole number is expected");
        return int64_t(real);
    }
    void Skip(PlyType /*type*/, int64_t count) {
        for (int64_t i = 0; i < count; ++i) {
            NextToken();
            while (!AtSeparator(p_)) ++p_;
        }
    }
    /// At the line of the last value.
    [[noreturn]] void Fail(const std::string& message) const {
        // Lines end with LF, or with CR alone where there is no LF.
        const auto lines = std::count(begin_, p_, '\n');
        context_.FailAtLine(1 + (lines > 0 ? lines : std::count(begin_, p_, '\r')), message);
    }

  private:
    static bool IsSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
    bool AtSeparator(const char* p) const { return p == end_ || IsSpace(*p); }
    void NextToken() {
        while (p_ != end_ && IsSpace(*p_)) ++p_;
        if (p_ == end_) Fail("the data ends too early; the header declares more");
        if (*p_ == '+') ++p_;
    }
    // The slow way, for what is rare: numbers beyond the range of float and text that is no number.
    double Double() {
        const char* end = p_;
        while (!AtSeparator(end)) ++end;
        const std::string token(p_, size_t(std::min<ptrdiff_t>(end - p_, 100)));
        char* parsed = nullptr;
        const double value = std::strtod(token.c_str(), &parsed);
        if (token.empty() || *parsed != '\0') Fail("\"" + Printable(token.substr(0, 40)) + "\" is no number");
        p_ = end;
        return value;
    }
    static std::string Printable(std::string text) {
        for (char& c : text)
            if (c < ' ' || c > '~') c = '?';
        return text;
    }

    const char *begin_, *p_, *end_;
    const PlyContext& context_;
};

}  // namespace lacquer
